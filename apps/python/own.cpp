#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "apps/python/goal_value.h"
#include "kinematics/configuration.h"
#include "solvers/iteration/step_iteration.h"
#include "solvers/own_solver.h"
#include "solvers/problem/judge.h"

// One's own methods: a step rule inside the iteration that the classic methods share, or a whole solve.
// Python's functions are called with the interpreter's lock; what they raise reaches whoever asked for the
// solve.

namespace gelenk::python {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using namespace py::literals;

/// A function of the user's, and the keywords that its parameters come by. May be destroyed by any thread.
class Function {
 public:
  Function(py::object call, py::dict keywords)
      : call_(new py::object(std::move(call)), &release), keywords_(std::move(keywords)) {}

  /// With the lock held. keywords: parameter name -> Python's name, of those that the function takes.
  py::dict valuesOf(const ParameterValues& values, const std::vector<OwnSolver::OwnParameter>& all) const {
    py::dict out;
    for (const auto& p : all)
      if (keywords_.contains(p.name.c_str())) {
        const auto found = values.find(p.name);
        out[keywords_[p.name.c_str()]] = found == values.end() ? p.value : found->second;
      }
    return out;
  }
  const py::object& call() const { return *call_; }

 private:
  static void release(py::object* object) {
    const py::gil_scoped_acquire lock;
    delete object;
  }
  std::shared_ptr<py::object> call_;
  py::dict keywords_;
};

/// An own method's function with values of its parameters; shared by all solves.
struct Method {
  std::string name;
  py::object call;
  py::dict values;
  double largestStep = 0.5;

  ~Method() {
    const py::gil_scoped_acquire lock;
    call = py::object();
    values = py::dict();
    values.release().dec_ref();
  }
};
using MethodPtr = std::shared_ptr<const Method>;

// ---- step rules

/// How often the rules of this process returned a step that is not finite, by name: the iteration only stops
/// there, and gelenk.check() tells. With the interpreter's lock held.
std::map<std::string, int>& stepsNotFinite() {
  static std::map<std::string, int> times;
  return times;
}

struct PythonRule {
  using Parameters = MethodPtr;
  static constexpr bool monotone = false;
  PythonRule(const IkProblem&, const MethodPtr& method) : method_(method) {}
  double largestStep() const { return method_->largestStep; }
  double damping() const { return 0.0; }
  void step(CountedEvaluator& at, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    const py::gil_scoped_acquire lock;
    const py::object out = method_->call(matrixArray(J), toArray(r), toArray(at.q()), **method_->values);
    const Array step = numbers(out, "what the step rule returns");
    if (step.ndim() != 1 || step.shape(0) != J.cols())
      throw std::invalid_argument(
          fmt::format("the step rule '{}' must return dq of shape ({},)", method_->name, J.cols()));
    dq = VectorXd::Map(step.data(), step.size());
    if (!dq.allFinite()) ++stepsNotFinite()[method_->name];
  }

 private:
  MethodPtr method_;
};

// ---- whole solves

/// A problem as a solver of the user's sees it, while its call lasts.
class Problem {
 public:
  Problem(const IkProblem& problem, const Budget& budget)
      : problem_(&problem), budget_(budget), at_(problem) {}
  void close() { problem_ = nullptr; }
  const IkProblem& get() const {
    if (!problem_) throw std::invalid_argument("this problem's solve is over");
    return *problem_;
  }
  const Skeleton& skeleton() const { return *get().skeleton; }
  const Budget& budget() const { return budget_; }
  CountedEvaluator& at() {
    get();
    return at_;
  }
  std::vector<IterationRecord> trace;

 private:
  const IkProblem* problem_;
  Budget budget_;
  CountedEvaluator at_;
};

class PythonSolver final : public IkSolver {
 public:
  explicit PythonSolver(MethodPtr method) : method_(std::move(method)) {}
  std::string whyUnsupported(const IkProblem&) const override { return {}; }
  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel level) const override {
    const py::gil_scoped_acquire lock;
    const auto shared = std::make_shared<Problem>(problem, budget);
    struct Closing {  // whatever the script keeps of it says so from then on
      Problem& problem;
      ~Closing() { problem.close(); }
    } closing{*shared};
    const py::object out = method_->call(shared, **method_->values);
    const VectorXd q =
        vectorOf(out, problem.skeleton->nq(), ("what the solver '" + method_->name + "' returns").c_str());
    IkReport report{
        .q = q, .counters = shared->at().counters(), .seconds = shared->at().seconds(), .trace = {}};
    shared->at().moveTo(q);
    report.residual = shared->at().residual().norm();
    report.why = judge(problem, q).solved ? Stop::Converged : Stop::Stalled;
    if (level != TraceLevel::Off) report.trace = std::move(shared->trace);
    return report;
  }

 private:
  MethodPtr method_;
};

void addProblem(py::module_& m) {
  py::class_<Problem, std::shared_ptr<Problem>>(
      m, "Problem", "What a solver of one's own is asked; good until its call ends.")
      .def_property_readonly(
          "start", [](const Problem& p) { return toArray(p.get().start); }, "(nq,)")
      .def_property_readonly(
          "nq", [](const Problem& p) { return p.skeleton().nq(); }, "Length of a configuration.")
      .def_property_readonly(
          "nv", [](const Problem& p) { return p.skeleton().nv(); }, "Length of a tangent.")
      .def_property_readonly(
          "tolerance", [](const Problem& p) { return p.get().positionTolerance; }, "Metres and radians.")
      .def_property_readonly(
          "max_iterations", [](const Problem& p) { return p.budget().maxIterations; }, "Of each attempt.")
      .def_property_readonly(
          "restarts", [](const Problem& p) { return p.budget().restarts; },
          "Further attempts that are allowed.")
      .def_property_readonly(
          "seed", [](const Problem& p) { return p.budget().seed; }, "Of whatever is random.")
      .def(
          "evaluate",
          [](Problem& p, py::handle q) {
            p.at().moveTo(vectorOf(q, p.skeleton().nq(), "q"));
            return py::make_tuple(toArray(p.at().residual()), matrixArray(p.at().jacobian()));
          },
          "q"_a, "(r, J): residual target minus current (m,) and its Jacobian (m, nv), dr = -J dq; counted.")
      .def(
          "residual",
          [](Problem& p, py::handle q) {
            p.at().moveTo(vectorOf(q, p.skeleton().nq(), "q"));
            return toArray(p.at().residual());
          },
          "q"_a, "(m,); counted.")
      .def(
          "solved",
          [](const Problem& p, py::handle q) {
            return judge(p.get(), vectorOf(q, p.skeleton().nq(), "q")).solved;
          },
          "q"_a, "What the judge says.")
      .def(
          "integrate",
          [](const Problem& p, py::handle q, py::handle dq) {
            return toArray(
                projectToLimits(p.skeleton(), integrate(p.skeleton(), configuration(p.skeleton(), q),
                                                        vectorOf(dq, p.skeleton().nv(), "dq"))));
          },
          "q"_a, "dq"_a, "(nq,) q (+) dq, moved into the limits.")
      .def(
          "project",
          [](const Problem& p, py::handle q) {
            return toArray(projectToLimits(p.skeleton(), configuration(p.skeleton(), q)));
          },
          "q"_a, "(nq,) within limits.")
      .def(
          "random",
          [](const Problem& p, py::handle rng) {
            std::mt19937_64 random(seedOf(rng));
            return toArray(randomWithinLimits(p.skeleton(), random));
          },
          "rng"_a, "(nq,) uniform within limits.")
      .def(
          "count",
          [](Problem& p, double step) {
            if (!std::isfinite(step)) throw std::invalid_argument("step must be a finite number");
            ++p.at().counters().iterations;
            p.trace.push_back({.q = p.at().q(), .residual = p.at().residual().norm(), .stepNorm = step});
          },
          "step"_a = 0.0, "Counts one iteration, where it was evaluated last, and traces it.");
}

// ---- joining the catalogue

std::vector<OwnSolver::OwnParameter> parametersFrom(const py::dict& parameters) {
  std::vector<OwnSolver::OwnParameter> out;
  for (const auto& [key, value] : parameters) {
    std::string name = py::str(key);
    if (name.ends_with('_')) name.pop_back();
    std::replace(name.begin(), name.end(), '_', '-');
    const Array v = numbers(py::isinstance<py::tuple>(value) ? py::reinterpret_borrow<py::object>(value)
                                                             : py::object(py::make_tuple(value)),
                            name.c_str());
    if (v.ndim() != 1 || (v.size() != 1 && v.size() != 3))
      throw std::invalid_argument(name + ": a default, or (default, lower, upper)");
    out.push_back({.name = name,
                   .value = v.at(0),
                   .lower = v.size() == 3 ? v.at(1) : std::min(0.0, 1e3 * v.at(0)),
                   .upper = v.size() == 3 ? v.at(2) : std::max(1.0, 1e3 * v.at(0))});
  }
  return out;
}

/// keywords: parameter name -> the function's own name for it.
void addOwnSolver(const std::string& kind, const std::string& name, const py::function& function,
                  const py::dict& parameters, const py::dict& keywords, const std::string& title,
                  double largestStep, bool stochastic) {
  if (!(largestStep > 0.0)) throw std::invalid_argument("largest_step must be above 0");
  const auto table = parametersFrom(parameters);
  const auto kept = std::make_shared<Function>(function, keywords);
  const auto method = [=](const ParameterValues& values) {
    const py::gil_scoped_acquire lock;
    auto out = std::make_shared<Method>();
    out->name = name;
    out->call = kept->call();
    out->values = kept->valuesOf(values, table);
    const auto largest = values.find("largest-step");
    out->largestStep = largest != values.end() ? largest->second : largestStep;
    for (const auto& p : table)
      if (p.name == "largest-step" && largest == values.end()) out->largestStep = p.value;
    return MethodPtr(out);
  };
  OwnSolver solver{.name = name,
                   .title = title,
                   .reference = "own",
                   .parameters = table,
                   .make = {},
                   .stochastic = stochastic};
  if (kind == "step_rule")
    solver.make = [method](const ParameterValues& values) -> std::unique_ptr<IkSolver> {
      return std::make_unique<StepSolver<PythonRule>>(method(values));
    };
  else
    solver.make = [method](const ParameterValues& values) -> std::unique_ptr<IkSolver> {
      return std::make_unique<PythonSolver>(method(values));
    };
  addSolver(std::move(solver));
}

/// The stacked residual and its Jacobian, as every solver sees them.
py::tuple evaluate(const SharedModel& model, const py::object& goals, const py::object& q,
                   const py::object& joint, bool rods) {
  const auto masses =
      rods ? std::make_shared<const Masses>(rodMasses(model.skeleton())) : model.model().masses;
  const IkProblem problem{
      .skeleton = &model.skeleton(), .start = model.pose(), .goals = goalsFrom(model, goals, joint, masses)};
  CountedEvaluator at(problem);
  at.moveTo(vectorOf(q, model.skeleton().nq(), "q"));
  return py::make_tuple(toArray(at.residual()), matrixArray(at.jacobian()));
}

}  // namespace

void addOwn(py::module_& m) {
  addProblem(m);
  m.def("_add_solver", &addOwnSolver);
  m.def("_steps_not_finite", [](const std::string& name) { return stepsNotFinite()[name]; });
  m.def("evaluate", &evaluate, modelArgument(), "goals"_a, "q"_a, py::kw_only(), "joint"_a = py::none(),
        "rod_masses"_a = false,
        "(r, J): the stacked, weighted residual target minus current (m,) and its Jacobian (m, nv), dr = -J "
        "dq.");
}

}  // namespace gelenk::python
