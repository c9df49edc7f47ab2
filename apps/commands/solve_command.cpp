#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "apps/commands/commands.h"
#include "apps/document/model.h"
#include "kinematics/configuration.h"
#include "solvers/problem/goal_text.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/problem/judge.h"

namespace gelenk {
namespace {

using Eigen::VectorXd;
using json = nlohmann::ordered_json;

struct Request {
  std::string model = "panda", solver = "default", joint;
  std::vector<double> target, start;
  std::vector<std::string> goals;  ///< as parseGoal reads them
  double tolerance = 1e-6;
  Budget budget{.maxIterations = 200, .maxSeconds = 1e9, .restarts = 50};
  bool trace = false, rods = false;
};

/// The joint asked for, or the model's only end.
int effectorOf(const Model& model, const std::string& name) {
  if (!name.empty()) return model.skeleton.jointIndex(name);
  std::vector<int> ends;
  for (int i = 0; i < model.skeleton.jointCount(); ++i)
    if (model.skeleton.children(i).empty()) ends.push_back(i);
  if (ends.size() == 1) return ends.front();
  std::string names;
  for (int end : ends) names += (names.empty() ? "" : ", ") + model.skeleton.joint(end).name;
  throw std::invalid_argument(
      fmt::format("'{}' has several ends; choose one with --joint: {}", model.name, names));
}

Goal goalOf(const Request& request, int joint) {
  const std::vector<double>& t = request.target;
  if (t.size() != 3 && t.size() != 7)
    throw std::invalid_argument(
        fmt::format("--target wants X Y Z or X Y Z QW QX QY QZ, {} values given", t.size()));
  for (double value : t)
    if (!std::isfinite(value)) throw std::invalid_argument("--target must be finite numbers");
  Goal goal{.joint = joint, .target = {t[0], t[1], t[2]}};
  if (t.size() == 3) return goal;
  goal.kind = GoalKind::Pose;
  goal.orientation = Eigen::Quaterniond(t[3], t[4], t[5], t[6]);
  if (!(std::abs(goal.orientation.norm() - 1.0) < 1e-3))
    throw std::invalid_argument(
        fmt::format("the target's quaternion must have length 1, not {:.6g}", goal.orientation.norm()));
  goal.orientation.normalize();
  return goal;
}

VectorXd startOf(const Request& request, const Skeleton& skeleton) {
  if (request.start.empty()) return skeleton.rest();
  if (static_cast<int>(request.start.size()) != skeleton.nq())
    throw std::invalid_argument(
        fmt::format("--start needs {} values for this model, {} given", skeleton.nq(), request.start.size()));
  const VectorXd q = VectorXd::Map(request.start.data(), skeleton.nq());
  if (!q.allFinite()) throw std::invalid_argument("--start must be finite numbers");
  for (int i = 0; i < skeleton.jointCount(); ++i)
    if (skeleton.joint(i).ball && !(std::abs(ballRotation(skeleton, q, i).norm() - 1.0) < 1e-3))
      throw std::invalid_argument(
          fmt::format("the start's quaternion of '{}' must have length 1", skeleton.joint(i).name));
  return q;
}

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
  if (request.target.empty() && request.goals.empty())
    throw std::invalid_argument("solve needs --target or --goal");
  const std::shared_ptr<const Masses> masses =
      request.rods ? std::make_shared<const Masses>(rodMasses(model.skeleton)) : model.masses;
  std::vector<Goal> goals;
  if (!request.target.empty()) goals.push_back(goalOf(request, effectorOf(model, request.joint)));
  for (const std::string& text : request.goals) goals.push_back(parseGoal(text, model.skeleton, masses));
  const IkProblem problem{.skeleton = &model.skeleton,
                          .start = startOf(request, model.skeleton),
                          .goals = goals,
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
           {"joint", model.skeleton.joint(goals.front().joint).name},
           {"status", toString(report.why)},
           {"solved", solved}};
  if (!refusal.empty()) out["unsupported_because"] = refusal;
  out["solution"] = std::vector<double>(report.q.begin(), report.q.end());
  if (!verdict.goals.empty()) {
    out["position_error"] = verdict.goals[0].position;
    out["orientation_error"] = verdict.goals[0].orientation;
  }
  for (std::size_t i = 0; !request.goals.empty() && i < verdict.goals.size(); ++i)
    out["goals"].push_back({{"goal", writeGoal(problem.goals[i], model.skeleton)},
                            {"position_error", verdict.goals[i].position},
                            {"orientation_error", verdict.goals[i].orientation}});
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
  command->add_option("--target", request->target,
                      "X Y Z [QW QX QY QZ]: metres and a unit quaternion, world frame");
  command
      ->add_option(
          "--goal", request->goals,
          "A goal of any kind, such as 'distance joint=hand_l other=hand_r length=0.25'; may be given "
          "several times. Every kind takes weight=, role= (drag, hold, pin) and priority=")
      ->allow_extra_args(false);
  command->add_flag("--rod-masses", request->rods,
                    "Weigh every bone as a rod of the same mass a metre, for goals that need masses");
  command->footer("Kinds of goals and their fields, optional ones in brackets:\n" + describeGoalTypes());
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
