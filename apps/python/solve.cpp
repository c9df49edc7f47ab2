#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "apps/commands/arm_path.h"
#include "apps/commands/solve_batch.h"
#include "apps/python/goal_value.h"
#include "kinematics/configuration.h"
#include "solvers/problem/judge.h"
#include "solvers/solutions/complete_set.h"
#include "solvers/solutions/path_planner.h"
#include "solvers/tree/drag_solver.h"

// Solving: one problem, many at once, every solution, paths, and frame by frame.

namespace gelenk::python {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using namespace py::literals;

// ---- choosing a solver

/// "dls" and lambda_=0.1 or largest_step=0.5: Python's names have underscores, and one behind reserved words.
std::string solverText(const std::string& solver, const py::kwargs& parameters) {
  if (parameters.empty()) return solver;
  SolverSpec choice = solverSpec(solver);
  for (const auto& [key, value] : parameters) {
    std::string name = py::str(key);
    if (name.ends_with('_')) name.pop_back();
    std::replace(name.begin(), name.end(), '_', '-');
    if (!PyFloat_Check(value.ptr()) && !PyIndex_Check(value.ptr()))
      throw std::invalid_argument(name + ": the value of a parameter is a number");
    choice = withParameter(choice, name, vectorOf(py::make_tuple(value), 1, name.c_str())[0]);
  }
  return toText(choice);
}

Budget budgetOf(int maxIterations, int restarts, Seed seed, const std::optional<double>& maxSeconds) {
  if (maxIterations < 1) throw std::invalid_argument("max_iterations must be at least 1");
  if (restarts < 0) throw std::invalid_argument("restarts must not be negative");
  if (maxSeconds && !(*maxSeconds > 0.0)) throw std::invalid_argument("max_seconds must be above 0");
  return {.maxIterations = maxIterations,
          .maxSeconds = maxSeconds.value_or(1e9),
          .restarts = restarts,
          .seed = seed.value};
}

void demandTolerance(double tolerance) {
  if (!(tolerance > 0.0) || !std::isfinite(tolerance))
    throw std::invalid_argument("tolerance must be positive");
}

std::shared_ptr<const Masses> massesOf(const SharedModel& model, bool rods) {
  return rods ? std::make_shared<const Masses>(rodMasses(model.skeleton())) : model.model().masses;
}

// ---- one problem

/// What solve() gives: the report, and what the judge says of it.
struct Result {
  IkReport report = {};
  Judgement verdict = {};
  std::string solver = {}, unsupported = {};
  int nq = 0;

  bool solved() const { return verdict.solved && report.why != Stop::Unsupported; }
  double largest(double GoalError::*part) const {
    double most = 0.0;
    for (const GoalError& error : verdict.goals) most = std::max(most, error.*part);
    return most;
  }
};

Result solve(const ModelPtr& model, const py::object& goals, const std::string& solver,
             const py::object& joint, const py::object& start, double tolerance, int maxIterations,
             int restarts, Seed seed, const std::optional<double>& maxSeconds, bool trace, bool rods,
             const py::kwargs& parameters) {
  demandTolerance(tolerance);
  const Budget budget = budgetOf(maxIterations, restarts, seed, maxSeconds);
  Result out{.solver = solverText(solver, parameters), .nq = model->skeleton().nq()};
  const std::shared_ptr<const IkSolver> method = model->solver(out.solver);
  const IkProblem problem{
      .skeleton = &model->skeleton(),
      .start = start.is_none() ? model->pose() : configuration(model->skeleton(), start, "start"),
      .goals = goals.is_none() ? model->goals() : goalsFrom(*model, goals, joint, massesOf(*model, rods)),
      .positionTolerance = tolerance,
      .orientationTolerance = tolerance};
  if (goals.is_none() && problem.goals.empty())
    throw std::invalid_argument("nothing is asked for: the model is no scene that holds something");
  py::gil_scoped_release alone;
  out.report = method->solve(problem, budget, trace ? TraceLevel::Full : TraceLevel::Off);
  out.verdict = judge(problem, out.report.q);
  if (out.report.why == Stop::Unsupported) out.unsupported = method->whyUnsupported(problem);
  return out;
}

py::array errorsOf(const Result& r) {
  py::array_t<double> out({static_cast<py::ssize_t>(r.verdict.goals.size()), py::ssize_t{2}});
  for (std::size_t i = 0; i < r.verdict.goals.size(); ++i) {
    out.mutable_at(i, 0) = r.verdict.goals[i].position;
    out.mutable_at(i, 1) = r.verdict.goals[i].orientation;
  }
  return out;
}

py::dict countersOf(const Counters& c) {
  return py::dict("iterations"_a = c.iterations, "forward_kinematics"_a = c.forwardKinematics,
                  "jacobians"_a = c.jacobians, "hessians"_a = c.hessians,
                  "factorisations"_a = c.factorisations, "restarts"_a = c.restarts);
}

py::object traceOf(const Result& r) {
  const auto& trace = r.report.trace;
  if (trace.empty()) return py::none();
  const auto column = [&](auto value) {
    py::array_t<double> out(static_cast<py::ssize_t>(trace.size()));
    for (std::size_t i = 0; i < trace.size(); ++i) out.mutable_at(i) = value(trace[i]);
    return out;
  };
  MatrixXd q(r.nq, trace.size());
  for (std::size_t i = 0; i < trace.size(); ++i)
    q.col(i) = trace[i].q.size() == r.nq ? trace[i].q : VectorXd::Constant(r.nq, NAN);
  return py::dict("residual"_a = column([](const IterationRecord& x) { return x.residual; }),
                  "step"_a = column([](const IterationRecord& x) { return x.stepNorm; }),
                  "damping"_a = column([](const IterationRecord& x) { return x.damping; }),
                  "seconds"_a = column([](const IterationRecord& x) { return x.seconds; }),
                  "q"_a = samples(std::move(q)));
}

void addResult(py::module_& m) {
  py::class_<Result>(m, "Result", "The answer of a solve, true where it is solved. Errors are the judge's.")
      .def_property_readonly(
          "q", [](const Result& r) { return toArray(r.report.q); }, "(nq,), within limits.")
      .def_property_readonly("solved", &Result::solved,
                             "Every goal within the tolerance and all limits kept, by forward kinematics.")
      .def_property_readonly(
          "status", [](const Result& r) { return toString(r.report.why); },
          "Why the solver stopped: converged, stationary, saddle, stalled, budget, failure,\n"
          "unsupported.")
      .def_property_readonly(
          "solver", [](const Result& r) { return r.solver; }, "Text of the choice.")
      .def_property_readonly(
          "unsupported_because", [](const Result& r) { return r.unsupported; },
          "A sentence where the status is unsupported, else empty.")
      .def_property_readonly(
          "position_error", [](const Result& r) { return r.largest(&GoalError::position); },
          "Largest of all goals, metres.")
      .def_property_readonly(
          "orientation_error", [](const Result& r) { return r.largest(&GoalError::orientation); },
          "Largest of all goals, radians.")
      .def_property_readonly("goal_errors", &errorsOf, "(goals, 2): metres and radians.")
      .def_property_readonly(
          "limit_violation", [](const Result& r) { return r.verdict.limitViolation; },
          "How far the worst joint lies outside its limits, radians or metres.")
      .def_property_readonly(
          "residual", [](const Result& r) { return r.report.residual; },
          "Weighted norm, as the solver sees it.")
      .def_property_readonly(
          "counters", [](const Result& r) { return countersOf(r.report.counters); },
          "How often: iterations, forward_kinematics, jacobians, hessians, factorisations, restarts.")
      .def_property_readonly(
          "iterations", [](const Result& r) { return r.report.counters.iterations; },
          "Of all attempts together.")
      .def_property_readonly(
          "seconds", [](const Result& r) { return r.report.seconds; }, "Of the solver, on the clock.")
      .def_property_readonly(
          "trace", &traceOf,
          "None, or with trace=True a dict of arrays: residual, step, damping, seconds (k,) and\n"
          "q (k, nq); the last record of an attempt is where it ended.")
      .def("__bool__", &Result::solved)
      .def("__repr__", [](const Result& r) {
        return fmt::format("<gelenk.Result {}, {}: {:.2g} m, {:.2g} rad, {} iterations>",
                           r.solved() ? "solved" : "not solved", toString(r.report.why),
                           r.largest(&GoalError::position), r.largest(&GoalError::orientation),
                           r.report.counters.iterations);
      });
}

// ---- many targets at once

BatchTargets targetsOf(py::handle value, const char* what = "targets") {
  const Array array = numbers(value, what);
  const bool matrices = array.ndim() == 3 && array.shape(1) == 4 && array.shape(2) == 4;
  const py::ssize_t width = matrices ? 16 : array.ndim() == 2 ? array.shape(1) : 0;
  if (!matrices && width != 3 && width != 4 && width != 7)
    throw std::invalid_argument(
        fmt::format("{}: expected an array of shape (n, 3) (positions), (n, 4) (orientations), (n, 7) or "
                    "(n, 4, 4) (poses)",
                    what));
  return targetsFromRows(array.data(), array.shape(0), static_cast<int>(width), what);
}

struct BatchResult {
  BatchAnswers answers;
  double seconds = 0.0;
};

BatchResult solveBatchOf(const ModelPtr& model, const py::object& targets, const std::string& solver,
                         const py::object& joint, const py::object& start, double tolerance,
                         int maxIterations, int restarts, Seed seed, const std::optional<double>& maxSeconds,
                         const py::kwargs& parameters) {
  demandTolerance(tolerance);
  const Skeleton& skeleton = model->skeleton();
  const BatchTargets wanted = targetsOf(targets);
  BatchProblem problem{.skeleton = skeleton,
                       .joint = effector(*model, joint),
                       .starts = model->pose(),
                       .targets = wanted,
                       .solver = solverText(solver, parameters),
                       .tolerance = tolerance,
                       .budget = budgetOf(maxIterations, restarts, seed, maxSeconds)};
  if (!start.is_none()) {
    Configurations begins = configurations(skeleton, start, "start");
    if (!begins.single && begins.q.cols() != static_cast<Eigen::Index>(wanted.count()))
      throw std::invalid_argument(
          fmt::format("start: {} configurations for {} targets", begins.q.cols(), wanted.count()));
    if (begins.q.cols() > 0) problem.starts = std::move(begins.q);
  }
  py::gil_scoped_release alone;
  const auto begin = std::chrono::steady_clock::now();
  BatchMemory memory = model->batchMemory();
  BatchResult out{.answers = solveTargets(problem, nullptr, &memory)};
  model->keep(std::move(memory));
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

/// Rows of seven numbers or 4 x 4 matrices are targets of their own; other shapes could be one target.
bool areManyPoses(const py::object& goals) {
  if (!py::isinstance<py::array>(goals)) return false;
  const auto array = py::reinterpret_borrow<py::array>(goals);
  return array.ndim() == 3 || (array.ndim() == 2 && array.shape(1) == 7);
}

py::object solveAny(const ModelPtr& model, const py::object& goals, const std::string& solver,
                    const py::object& joint, const py::object& start, double tolerance, int maxIterations,
                    int restarts, Seed seed, const std::optional<double>& maxSeconds, bool trace, bool rods,
                    const py::kwargs& parameters) {
  if (!areManyPoses(goals))
    return py::cast(solve(model, goals, solver, joint, start, tolerance, maxIterations, restarts, seed,
                          maxSeconds, trace, rods, parameters));
  if (trace) throw std::invalid_argument("trace is of one problem, not of a batch");
  return py::cast(solveBatchOf(model, goals, solver, joint, start, tolerance, maxIterations, restarts, seed,
                               maxSeconds, parameters));
}

py::array_t<double> errorsOf(const BatchResult& result, double GoalError::*part) {
  const auto& errors = result.answers.error;
  py::array_t<double> out(static_cast<py::ssize_t>(errors.size()));
  std::transform(errors.begin(), errors.end(), out.mutable_data(),
                 [&](const GoalError& error) { return error.*part; });
  return out;
}

void addBatch(py::module_& m) {
  py::class_<BatchResult>(m, "BatchResult", "Answers of solve_batch, one a target.")
      .def_property_readonly(
          "q",
          [](const py::object& self) {
            const MatrixXd& q = self.cast<const BatchResult&>().answers.q;
            const py::ssize_t size = sizeof(double), nq = q.rows();
            return view({q.cols(), nq}, {nq * size, size}, q.data(), self);
          },
          "(n, nq), without a copy.")
      .def_property_readonly(
          "solved",
          [](const BatchResult& r) {
            py::array_t<bool> out(static_cast<py::ssize_t>(r.answers.solved.size()));
            std::copy(r.answers.solved.begin(), r.answers.solved.end(), out.mutable_data());
            return out;
          },
          "(n,) bool.")
      .def_property_readonly(
          "status",
          [](const BatchResult& r) {
            py::list out;
            std::map<Stop, py::str> words;
            for (const Stop why : r.answers.why)
              out.append(words.try_emplace(why, toString(why)).first->second);
            return out;
          },
          "Why the solver stopped, one a target.")
      .def_property_readonly(
          "position_error", [](const BatchResult& r) { return errorsOf(r, &GoalError::position); },
          "(n,) metres.")
      .def_property_readonly(
          "orientation_error", [](const BatchResult& r) { return errorsOf(r, &GoalError::orientation); },
          "(n,) radians.")
      .def_property_readonly(
          "seconds", [](const BatchResult& r) { return r.seconds; }, "All of them together, on the clock.")
      .def("__len__", [](const BatchResult& r) { return r.answers.solved.size(); })
      .def("__repr__", [](const BatchResult& r) {
        const auto& solved = r.answers.solved;
        return fmt::format("<gelenk.BatchResult: {} of {} solved>",
                           std::count(solved.begin(), solved.end(), 1), solved.size());
      });
}

// ---- every solution, and paths

py::dict solutions(const ModelPtr& model, const py::object& target, const py::object& joint,
                   const py::object& near, bool limits, const py::object& axis) {
  const Skeleton& skeleton = model->skeleton();
  const int tip = effector(*model, joint);
  const Goal goal = targetGoalOf(tip, target);
  if (goal.kind == GoalKind::Orientation)
    throw std::invalid_argument("target: a complete set wants a place: 3 or 7 numbers, or 4 x 4");
  CompleteSetTask task{.task = goal.kind == GoalKind::Pose ? TipTask::Pose : TipTask::Position};
  if (!axis.is_none()) {
    if (goal.kind != GoalKind::Pose)
      throw std::invalid_argument("axis needs a target with an orientation, which tells where it points");
    task.task = TipTask::Axis;
    task.axisInTip = direction(axis, "axis");
  }
  const VectorXd start = near.is_none() ? skeleton.rest() : configuration(skeleton, near, "near");
  std::optional<CompleteSet> set;
  ArmSolutions found;
  Vector6d reference = Vector6d::Zero();
  {
    py::gil_scoped_release alone;
    set.emplace(skeleton, tip, task);
    for (int i = 0; i < set->joints(); ++i) reference[i] = start[set->chain().qIndex[i]];
    set->solve(Eigen::Translation3d(goal.target) * goal.orientation, reference, found);
  }
  const int n = set->joints();
  std::vector<const ArmSolution*> list;
  for (const ArmSolution& s : found.all())
    if (!limits || s.withinLimits) list.push_back(&s);
  const auto distance = [&](const ArmSolution* s) { return (s->q.head(n) - reference.head(n)).norm(); };
  std::stable_sort(list.begin(), list.end(),
                   [&](const ArmSolution* a, const ArmSolution* b) { return distance(a) < distance(b); });
  const IkProblem problem{.skeleton = &skeleton, .start = start, .goals = {goal}};
  MatrixXd q(skeleton.nq(), list.size());
  VectorXd error(list.size()), away(list.size()), sigma(list.size());
  py::array_t<bool> within(static_cast<py::ssize_t>(list.size()));
  py::array_t<int> branch({static_cast<py::ssize_t>(list.size()), py::ssize_t{3}});
  for (std::size_t i = 0; i < list.size(); ++i) {
    VectorXd all = start;
    for (int k = 0; k < n; ++k) all[set->chain().qIndex[k]] = list[i]->q[k];
    skeleton.couple(all);
    q.col(i) = all;
    error[i] = judge(problem, all).goals[0].position;
    away[i] = distance(list[i]);
    sigma[i] = set->singularity(list[i]->q.head(n)).sigmaMin;
    within.mutable_at(i) = list[i]->withinLimits;
    branch.mutable_at(i, 0) = list[i]->shoulder;
    branch.mutable_at(i, 1) = list[i]->elbow;
    branch.mutable_at(i, 2) = list[i]->wrist;
  }
  return py::dict("q"_a = samples(std::move(q)), "position_error"_a = toArray(error),
                  "distance"_a = toArray(away), "sigma_min"_a = toArray(sigma), "within_limits"_a = within,
                  "branch"_a = branch, "complete"_a = found.complete, "class"_a = set->arm().describe(),
                  "outside_limits"_a = found.count - static_cast<int>(list.size()));
}

py::dict path(const ModelPtr& model, const py::object& poses, const py::object& joint,
              const py::object& start, double jump) {
  const Skeleton& skeleton = model->skeleton();
  const int tip = effector(*model, joint);
  const BatchTargets list = targetsOf(poses, "poses");
  if (list.kind != GoalKind::Pose) throw std::invalid_argument("poses: expected (n, 7) or (n, 4, 4)");
  std::vector<Eigen::Isometry3d> wanted;
  for (std::size_t i = 0; i < list.count(); ++i)
    wanted.push_back(Eigen::Translation3d(list.places[i]) * list.turns[i]);
  if (!(jump > 0.0) || !std::isfinite(jump)) throw std::invalid_argument("jump must be above 0");
  const VectorXd rest = start.is_none() ? skeleton.rest() : configuration(skeleton, start, "start");
  PathPlan plan;
  std::vector<int> where;
  {
    py::gil_scoped_release alone;
    const PathPlanner planner(skeleton, tip);
    VectorXd begin(planner.chain().n);
    where = planner.chain().qIndex;
    for (int k = 0; k < planner.chain().n; ++k) begin[k] = rest[where[k]];
    plan = planArmPath(planner, wanted, {.jump = jump}, start.is_none() ? nullptr : &begin);
  }
  MatrixXd q = rest.replicate(1, static_cast<Eigen::Index>(wanted.size()));
  for (std::size_t i = 0; i < plan.q.size(); ++i)
    for (std::size_t k = 0; k < where.size(); ++k) q(where[k], i) = plan.q[i][k];
  if (!skeleton.followers().empty())
    for (Eigen::Index i = 0; i < q.cols(); ++i) {
      VectorXd one = q.col(i);
      skeleton.couple(one);
      q.col(i) = one;
    }
  py::list jumps;
  for (const PathJump& one : plan.jumps) jumps.append(py::make_tuple(one.pose, one.turn, one.reason));
  return py::dict("q"_a = samples(std::move(q)), "jumps"_a = jumps, "length"_a = plan.length,
                  "largest_step"_a = plan.largestStep);
}

// ---- frame by frame

/// A DragSolver with the model that it drags.
class Drag {
 public:
  explicit Drag(ModelPtr model, bool balance) : model_(std::move(model)) {
    DragOptions options;
    if (balance) {
      if (!model_->model().masses || model_->model().soles.empty())
        throw std::invalid_argument("'" + model_->model().name + "' cannot balance: no masses or no soles");
      options.balance = BalanceOptions{.masses = model_->model().masses, .up = model_->model().up};
      for (const FootPoint& sole : model_->model().soles)
        options.balance->supports.push_back({sole.joint, sole.inJoint});
    }
    solver_.emplace(model_->skeleton(), options);
    solver_->reset(model_->pose());
  }

  void reset(const py::object& q) {
    const VectorXd begin = q.is_none() ? model_->pose() : configuration(model_->skeleton(), q);
    const std::lock_guard lock(mutex_);
    solver_->reset(begin);
  }
  py::array q() const {
    const std::lock_guard lock(mutex_);
    return toArray(solver_->q());
  }

  Result frame(const py::object& goals, const py::object& joint, bool trace) {
    IkProblem problem{.skeleton = &model_->skeleton(),
                      .start = model_->pose(),
                      .goals = goalsFrom(*model_, goals, joint, model_->model().masses)};
    problem.positionTolerance = 1e-4 * solver_->unit();
    problem.orientationTolerance = 1e-4;
    Result out{.solver = "drag", .nq = model_->skeleton().nq()};
    py::gil_scoped_release alone;
    const std::lock_guard lock(mutex_);
    out.report = solver_->frame(problem.goals, trace ? TraceLevel::Full : TraceLevel::Residuals);
    if (!trace) out.report.trace.clear();
    out.verdict = judge(problem, out.report.q);
    return out;
  }

 private:
  ModelPtr model_;
  std::optional<DragSolver> solver_;
  mutable std::mutex mutex_;  ///< never held while waiting for the interpreter
};

// ---- the catalogue

py::list solverTable() {
  py::list table;
  for (const SolverEntry& entry : solverCatalogue()) {
    py::list parameters;
    for (const Parameter& p : entry.parameters)
      parameters.append(py::dict("name"_a = p.name, "value"_a = p.value, "lower"_a = p.lower,
                                 "upper"_a = p.upper, "unit"_a = p.unit, "source"_a = p.source,
                                 "meaning"_a = p.meaning));
    table.append(py::dict("name"_a = entry.name, "title"_a = entry.title, "reference"_a = entry.reference,
                          "stochastic"_a = entry.stochastic, "parameters"_a = parameters));
  }
  return table;
}

py::dict judged(const ModelPtr& model, const py::object& goals, const py::object& q, const py::object& joint,
                double tolerance, bool rods) {
  demandTolerance(tolerance);
  const IkProblem problem{.skeleton = &model->skeleton(),
                          .start = model->pose(),
                          .goals = goalsFrom(*model, goals, joint, massesOf(*model, rods)),
                          .positionTolerance = tolerance,
                          .orientationTolerance = tolerance};
  const Judgement verdict = judge(problem, vectorOf(q, model->skeleton().nq(), "q"));
  Result out{.verdict = verdict};
  return py::dict("solved"_a = verdict.solved, "finite"_a = verdict.finite, "goal_errors"_a = errorsOf(out),
                  "limit_violation"_a = verdict.limitViolation);
}

}  // namespace

void addSolve(py::module_& m) {
  addResult(m);
  addBatch(m);
  m.def(
      "solve", &solveAny, modelArgument(), "goals"_a = py::none(), py::kw_only(), "solver"_a = "default",
      "joint"_a = py::none(), "start"_a = py::none(), "tolerance"_a = 1e-6, "max_iterations"_a = 200,
      "restarts"_a = 50, "seed"_a = 1, "max_seconds"_a = py::none(), "trace"_a = false,
      "rod_masses"_a = false,
      "One problem, begun at start (nq; default the model's pose).\n\n"
      "goals: a Goal, a text as of `gelenk solve --goal`, a target of joint, a dict of joints and targets, "
      "or\n"
      "a list of these; None: those of a scene. A target: 3 numbers a position, 4 or 3 x 3 an orientation,\n"
      "7 (x, y, z, qw, qx, qy, qz) or 4 x 4 a pose. An array (n, 7) or (n, 4, 4) is a batch: solve_batch. "
      "tolerance: metres and radians. Further keywords are the\n"
      "solver's parameters: lambda_=0.1, largest_step=0.5. The same seed gives the same bits as the "
      "program.");
  m.def(
      "solve_batch", &solveBatchOf, modelArgument(), "targets"_a, py::kw_only(), "solver"_a = "default",
      "joint"_a = py::none(), "start"_a = py::none(), "tolerance"_a = 1e-6, "max_iterations"_a = 200,
      "restarts"_a = 50, "seed"_a = 1, "max_seconds"_a = py::none(),
      "Many targets of one joint: (n, 3), (n, 4), (n, 7) or (n, 4, 4). start: (nq,) or (n, nq). Poses of a\n"
      "serial chain go through the processor's lanes side by side, as in `gelenk solve --targets`.");
  m.def(
      "solutions", &solutions, modelArgument(), "target"_a, py::kw_only(), "joint"_a = py::none(),
      "near"_a = py::none(), "limits"_a = true, "axis"_a = py::none(),
      "Every configuration of an arm of up to six revolute joints that reaches the target (3 or 7 numbers, "
      "or\n"
      "4 x 4), nearest to `near` first: a dict of q (k, nq), position_error, distance, sigma_min (k,),\n"
      "within_limits (k,), branch (k, 3), complete, class, outside_limits. axis: only this axis of the tip\n"
      "must point as the target says.");
  m.def("path", &path, modelArgument(), "poses"_a, py::kw_only(), "joint"_a = py::none(),
        "start"_a = py::none(), "jump"_a = 0.5,
        "Joint motion along two poses or more, (n, 7) or (n, 4, 4), with the fewest jumps: a dict of q (n, "
        "nq),\n"
        "jumps (pose, turn, reason), length, largest_step. ValueError where a pose has no solution within "
        "limits.\n"
        "start: the configuration before the first pose; the way from there counts, a jump on it is of pose "
        "-1.");
  m.def("judge", &judged, modelArgument(), "goals"_a, "q"_a, py::kw_only(), "joint"_a = py::none(),
        "tolerance"_a = 1e-6, "rod_masses"_a = false,
        "What is true of q, whoever proposed it: a dict of solved, finite (and quaternions\n"
        "of length 1), goal_errors (goals, 2), limit_violation.");
  m.def("solvers", &solverTable,
        "Every solver there is: dicts of name, title, reference, stochastic, parameters.");
  m.def("solver_text", &solverText, "solver"_a, "The one text for a solver and its parameters.");
  py::class_<Drag, std::shared_ptr<Drag>>(m, "DragSolver",
                                          "Drags a model frame by frame: a few steps a frame, warm from the "
                                          "last one. balance: keeps the centre of\n"
                                          "mass over the soles, where the model has both.")
      .def(py::init<ModelPtr, bool>(), modelArgument(), py::kw_only(), "balance"_a = false)
      .def("reset", &Drag::reset, "q"_a = py::none(), "Begins anew at q (nq; default the model's pose).")
      .def("frame", &Drag::frame, "goals"_a, py::kw_only(), "joint"_a = py::none(), "trace"_a = false,
           "One frame towards the goals, as solve() takes them: a Result.")
      .def_property_readonly("q", &Drag::q, "(nq,) where it stands.");
}

}  // namespace gelenk::python
