#include <fmt/format.h>

#include "apps/commands/solver_colour.h"
#include "apps/python/binding.h"
#include "solvers/lab/comparison.h"
#include "solvers/lab/report.h"
#include "solvers/lab/sweep.h"

// Solvers side by side on the laboratory's frozen problem sets.

namespace gelenk::python {
namespace {

using namespace py::literals;

template <typename Value>
py::array column(const std::vector<ResultRow>& rows, Value value) {
  using Number = decltype(value(rows.front()));
  py::array_t<Number> out(static_cast<py::ssize_t>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) out.mutable_at(i) = value(rows[i]);
  return out;
}

py::list words(const std::vector<ResultRow>& rows, std::string ResultRow::*word) {
  py::list out;
  for (const ResultRow& row : rows) out.append(row.*word);
  return out;
}

py::dict columnsOf(const Results& results) {
  const std::vector<ResultRow>& rows = results.rows;
  py::dict out("set"_a = words(rows, &ResultRow::set), "solver"_a = words(rows, &ResultRow::solver));
#define GELENK_COLUMN(name, expression) \
  out[name] = column(rows, [](const ResultRow& row) { return expression; })
  GELENK_COLUMN("problem", row.problem);
  GELENK_COLUMN("frame", row.frame);
  GELENK_COLUMN("level", row.level);
  out["status"] = words(rows, &ResultRow::status);
  GELENK_COLUMN("solved", row.solved);
  GELENK_COLUMN("position_error", row.position);
  GELENK_COLUMN("orientation_error", row.orientation);
  GELENK_COLUMN("residual", row.residual);
  GELENK_COLUMN("excess", row.excess);
  GELENK_COLUMN("limit_violation", row.limitViolation);
  GELENK_COLUMN("displacement", row.displacement);
  GELENK_COLUMN("iterations", row.counters.iterations);
  GELENK_COLUMN("forward_kinematics", row.counters.forwardKinematics);
  GELENK_COLUMN("jacobians", row.counters.jacobians);
  GELENK_COLUMN("restarts", row.counters.restarts);
  GELENK_COLUMN("seconds", row.seconds);
#undef GELENK_COLUMN
  return out;
}

ReportStyle style() {
  return {
      .version = GELENK_VERSION, .commandLine = "gelenk.compare", .colour = [](const std::string& solver) {
        const Eigen::Vector3f c = solverColour(solver) * 255.0f;
        return fmt::format("#{:02x}{:02x}{:02x}", static_cast<int>(c.x() + 0.5f),
                           static_cast<int>(c.y() + 0.5f), static_cast<int>(c.z() + 0.5f));
      }};
}

/// Columns of the results, one row a solver and problem; the folder holds the same as `gelenk compare --out`.
py::dict compare(const ModelPtr& model, const std::vector<std::string>& solvers,
                 const std::vector<std::string>& sets, int problems, Seed seed, double tolerance,
                 int maxIterations, std::optional<int> restarts, const std::vector<std::string>& effectors,
                 const std::string& goal, const std::string& folder, bool report,
                 const py::object& progress) {
  if (!model) throw py::type_error("compare wants a Model");
  ComparisonPlan plan{
      .sets = sets, .solvers = {}, .problems = problems, .seed = seed.value, .tolerance = tolerance};
  plan.budget.maxIterations = maxIterations;
  plan.budget.seed = seed.value;
  if (restarts) {
    plan.budget.restarts = *restarts;
  } else {  // as `gelenk compare`: one attempt, and the restarts that solve() has
    std::vector<std::string> both;
    for (const std::string& set : plan.sets) {
      both.push_back(set);
      if (!setChoice(set).restarts) both.push_back(set + "[restarts=50]");
    }
    plan.sets = both;
  }
  plan.solvers = withParameters(solvers, {});
  validate(plan);
  if (!goal.empty() && goal != "pose" && goal != "position")
    throw std::invalid_argument("goal is 'pose' or 'position', not '" + goal + "'");
  LabModel lab = labModel(model->model().name, model->skeleton(),
                          effectors.empty() ? model->model().handles : effectors);
  if (!goal.empty()) lab.pose = goal == "pose";
  Results results;
  {
    const py::gil_scoped_release alone;
    results = runComparison(plan, lab, folder, [&](int done, int total, const std::string& what) {
      const py::gil_scoped_acquire lock;
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (!progress.is_none()) progress(done, total, what);
    });
    if (report) writeReport(folder, results, style());
  }
  py::dict checksums;
  for (const SetRow& set : results.sets) checksums[py::str(set.set)] = set.checksum;
  return py::dict("columns"_a = columnsOf(results), "checksums"_a = checksums);
}

py::list problemSets() {
  py::list out;
  for (const ProblemSetEntry& set : problemSetCatalogue())
    out.append(py::dict("name"_a = set.name, "title"_a = set.title, "levels"_a = set.levels));
  return out;
}

}  // namespace

void addLab(py::module_& m) {
  m.def("_compare", &compare);
  m.def("problem_sets", &problemSets, "The laboratory's problem sets: dicts of name, title, levels.");
}

}  // namespace gelenk::python
