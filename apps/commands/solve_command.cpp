#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "apps/commands/arm_request.h"
#include "apps/commands/commands.h"
#include "apps/document/model.h"
#include "kinematics/configuration.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/problem/judge.h"

namespace gelenk {
namespace {

using json = nlohmann::ordered_json;

struct Request {
  std::string model = "panda", solver = "default", joint;
  std::vector<double> target, start;
  double tolerance = 1e-6;
  Budget budget{.maxIterations = 200, .maxSeconds = 1e9, .restarts = 50};
  bool trace = false;
};

json traceOf(const IkReport& report) {
  json list = json::array();
  for (const IterationRecord& record : report.trace)
    list.push_back({{"residual", record.residual},
                    {"step", record.stepNorm},
                    {"damping", record.damping},
                    {"q", std::vector<double>(record.q.begin(), record.q.end())}});
  return list;
}

/// Prints JSON; true if solved.
bool solve(const Request& request) {
  if (!(request.tolerance > 0.0)) throw std::invalid_argument("--tolerance must be positive");
  if (request.budget.maxIterations < 1) throw std::invalid_argument("--max-iterations must be at least 1");
  if (request.budget.restarts < 0) throw std::invalid_argument("--restarts must not be negative");
  const auto solver = makeSolver(request.solver);
  const Model model = openModel(request.model);
  const int joint = effectorOf(model, request.joint);
  const IkProblem problem{.skeleton = &model.skeleton,
                          .start = startConfiguration(request.start, model.skeleton, "--start"),
                          .goals = {targetGoal(request.target, joint)},
                          .positionTolerance = request.tolerance,
                          .orientationTolerance = request.tolerance};
  const std::string refusal = solver->whyUnsupported(problem);
  solver->prepare(model.skeleton);
  const IkReport report =
      solver->solve(problem, request.budget, request.trace ? TraceLevel::Full : TraceLevel::Off);
  const Judgement verdict = judge(problem, report.q);
  const bool solved = verdict.solved && report.why != Stop::Unsupported;
  json out{{"model", model.name},
           {"solver", request.solver},
           {"joint", model.skeleton.joint(joint).name},
           {"status", toString(report.why)},
           {"solved", solved}};
  if (!refusal.empty()) out["unsupported_because"] = refusal;
  out["solution"] = std::vector<double>(report.q.begin(), report.q.end());
  if (!verdict.goals.empty()) {
    out["position_error"] = verdict.goals[0].position;
    out["orientation_error"] = verdict.goals[0].orientation;
  }
  out["limit_violation"] = verdict.limitViolation;
  const Counters& c = report.counters;
  out["counters"] = {{"iterations", c.iterations},         {"forward_kinematics", c.forwardKinematics},
                     {"jacobians", c.jacobians},           {"hessians", c.hessians},
                     {"factorisations", c.factorisations}, {"restarts", c.restarts}};
  out["microseconds"] = report.seconds * 1e6;
  if (request.trace) out["trace"] = traceOf(report);
  fmt::print("{}\n", out.dump(2));
  return solved;
}

}  // namespace

void addSolveCommand(CLI::App& app) {
  auto request = std::make_shared<Request>();
  CLI::App* command = app.add_subcommand(
      "solve", "Solve one inverse-kinematics problem; print JSON; exit status 0 if solved, 2 if not");
  command->add_option("--model", request->model, "Built-in model or file")->capture_default_str();
  command
      ->add_option("--target", request->target,
                   "X Y Z [QW QX QY QZ]: metres and a unit quaternion, world frame")
      ->required();
  command->add_option("--solver", request->solver, "Solver by name (see compare --list)")
      ->capture_default_str();
  command->add_option("--joint", request->joint,
                      "Joint that shall reach the target; default: the model's only end");
  command->add_option("--start", request->start, "Start configuration; default: the rest pose");
  command->add_option("--tolerance", request->tolerance, "Metres and radians")->capture_default_str();
  command->add_option("--max-iterations", request->budget.maxIterations, "Iterations of one attempt")
      ->capture_default_str();
  command->add_option("--restarts", request->budget.restarts, "Random restarts after the first attempt")
      ->capture_default_str();
  command->add_option("--seed", request->budget.seed, "Seed of the restarts")->capture_default_str();
  command->add_flag("--trace", request->trace, "Adds every iteration: residual, step, damping, q");
  command->callback([request] {
    if (!solve(*request)) throw CLI::RuntimeError(2);
  });
}

}  // namespace gelenk
