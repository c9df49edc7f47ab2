#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "apps/commands/commands.h"
#include "apps/commands/goal_options.h"
#include "apps/commands/solve_batch.h"
#include "apps/document/model.h"
#include "kinematics/configuration.h"
#include "solvers/lab/sweep.h"
#include "solvers/problem/goal_text.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/problem/judge.h"

namespace gelenk {
namespace {

using Eigen::VectorXd;
using json = nlohmann::ordered_json;

struct Request {
  std::string model = "panda", solver = "default", joint, axis, goalsFile, targets, answers = "-",
              format = "radians";
  std::vector<std::string> settings, goals;
  std::vector<double> target, start, weights;
  double tolerance = 1e-6;
  Budget budget{.maxIterations = 200, .maxSeconds = 1e9, .restarts = 50};
  bool trace = false, positionFirst = false, rodMasses = false;

  bool degrees() const { return format == "degrees"; }
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

/// Everything that the options ask for.
std::vector<TypedGoal> goalsAskedFor(const Request& request, const Model& model) {
  std::vector<TypedGoal> goals;
  if (!request.goalsFile.empty()) goals = readGoals(request.goalsFile, model.skeleton);
  for (const std::string& text : request.goals)
    if (!namesAKind(text)) goals.push_back(parseGoal(text, model.skeleton));
  if (!request.target.empty()) {
    goals.push_back({.joint = effectorOf(model, request.joint)});
    putNumbers(goals.back(), request.target, "--target");
  }
  if (goals.empty() && request.goals.empty())
    throw std::invalid_argument("nothing is asked for: give --target, --goal, --goals or --targets");
  if (!request.weights.empty()) {
    if (request.weights.size() != 2 || !(request.weights[0] > 0.0) || !(request.weights[1] > 0.0))
      throw std::invalid_argument("--weights wants two numbers above 0: of positions and of orientations");
    for (TypedGoal& goal : goals) {
      goal.positionWeight *= request.weights[0];
      goal.orientationWeight *= request.weights[1];
    }
  }
  if (!request.axis.empty())
    for (TypedGoal& goal : goals) {
      if (!goal.orientation)
        throw std::invalid_argument(
            "--axis takes the direction from an orientation: give QW QX QY QZ as well");
      goal.axis = parseAxis(request.axis);
    }
  return goals;
}

VectorXd startOf(const Request& request, const Skeleton& skeleton) {
  if (request.start.empty()) return skeleton.rest();
  if (static_cast<int>(request.start.size()) != skeleton.nq())
    throw std::invalid_argument(
        fmt::format("--start needs {} values for this model, {} given", skeleton.nq(), request.start.size()));
  VectorXd q = VectorXd::Map(request.start.data(), skeleton.nq());
  if (!q.allFinite()) throw std::invalid_argument("--start must be finite numbers");
  if (request.degrees()) {
    const std::vector<char> angle = coordinateIsAngle(skeleton);
    for (Eigen::Index k = 0; k < q.size(); ++k)
      if (angle[k]) q[k] *= M_PI / 180.0;
  }
  for (int i = 0; i < skeleton.jointCount(); ++i)
    if (skeleton.joint(i).ball && !(std::abs(ballRotation(skeleton, q, i).norm() - 1.0) < 1e-3))
      throw std::invalid_argument(
          fmt::format("the start's quaternion of '{}' must have length 1", skeleton.joint(i).name));
  return q;
}

/// Positions are met, orientations come as close as they then can: orientations weigh next to nothing, from
/// many starts, and what that leaves of the positions' error is taken away by steps of the smallest change.
IkReport positionFirst(const IkProblem& problem, const std::vector<TypedGoal>& typed, const Budget& budget) {
  constexpr double next = 1e-6;  // of the positions' weight; its bias on a position is about as many metres
  IkProblem weighted = problem, positions = problem;
  weighted.goals = goalsOf(typed, next);
  positions.goals.clear();
  for (const Goal& goal : weighted.goals)
    if (goal.kind == GoalKind::Position) positions.goals.push_back(goal);
  if (positions.goals.empty()) throw std::invalid_argument("--position-first needs a position");
  IkReport report = makeSolver("lm-gain-ratio")->solve(weighted, budget, TraceLevel::Off);
  positions.start = report.q;
  IkReport polished = makeSolver("pseudo-inverse")->solve(positions, {.maxIterations = 50}, TraceLevel::Off);
  polished.counters += report.counters;
  polished.seconds += report.seconds;
  return polished;
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

/// The configuration by joint: a number, or a list where a joint has several.
json byJoint(const Skeleton& skeleton, const std::vector<double>& q) {
  json joints = json::object();
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    const std::size_t n = joint.axes.size() + (joint.ball ? 4 : 0);
    const auto first = q.begin() + skeleton.qIndex(i);
    if (n == 1)
      joints[joint.name] = *first;
    else if (n > 1)
      joints[joint.name] = std::vector<double>(first, first + static_cast<std::ptrdiff_t>(n));
  }
  return joints;
}

bool batch(const Request& request, const Model& model, const std::string& solver) {
  const BatchOutcome outcome = solveBatch({.skeleton = model.skeleton,
                                           .joint = effectorOf(model, request.joint),
                                           .start = startOf(request, model.skeleton),
                                           .targets = request.targets,
                                           .answers = request.answers,
                                           .solver = solver,
                                           .tolerance = request.tolerance,
                                           .budget = request.budget,
                                           .degrees = request.degrees()});
  fmt::print(stderr,
             "gelenk: {} of {} targets solved in {:.3f} s, {:.0f} a second ({:.3f} s of it preparation)\n",
             outcome.solved, outcome.targets, outcome.seconds,
             outcome.targets / std::max(outcome.seconds, 1e-9), outcome.preparation);
  return outcome.solved == outcome.targets;
}

/// Prints JSON; true if solved.
bool solve(const Request& request) {
  if (!(request.tolerance > 0.0)) throw std::invalid_argument("--tolerance must be positive");
  if (request.budget.maxIterations < 1) throw std::invalid_argument("--max-iterations must be at least 1");
  if (request.budget.restarts < 0) throw std::invalid_argument("--restarts must not be negative");
  const std::string chosen = withParameters({request.solver}, request.settings).front();
  const auto solver = makeSolver(chosen);
  const Model model = openModel(request.model);
  const Skeleton& skeleton = model.skeleton;
  if (!request.targets.empty()) return batch(request, model, chosen);
  const std::vector<TypedGoal> typed = goalsAskedFor(request, model);
  std::vector<Goal> goals = goalsOf(typed);
  const auto masses = request.rodMasses ? std::make_shared<const Masses>(rodMasses(skeleton)) : model.masses;
  for (const std::string& text : request.goals)
    if (namesAKind(text)) goals.push_back(goalFromText(text, skeleton, masses));
  const IkProblem problem{.skeleton = &skeleton,
                          .start = startOf(request, skeleton),
                          .goals = std::move(goals),
                          .positionTolerance = request.tolerance,
                          .orientationTolerance = request.tolerance};
  const std::string refusal = solver->whyUnsupported(problem);
  solver->prepare(skeleton);
  IkReport report =
      solver->solve(problem, request.budget, request.trace ? TraceLevel::Full : TraceLevel::Off);
  if (request.positionFirst && !judge(problem, report.q).solved && refusal.empty())
    report = positionFirst(problem, typed, request.budget);
  const Judgement verdict = judge(problem, report.q);
  const bool solved = verdict.solved && report.why != Stop::Unsupported;

  std::vector<double> q(report.q.begin(), report.q.end());
  if (request.degrees()) {
    const std::vector<char> angle = coordinateIsAngle(skeleton);
    for (std::size_t k = 0; k < q.size(); ++k)
      if (angle[k]) q[k] *= 180.0 / M_PI;
  }
  json out{{"model", model.name}, {"solver", chosen}};
  if (typed.size() == 1) out["joint"] = skeleton.joint(typed[0].joint).name;
  out["status"] = toString(report.why);
  out["solved"] = solved;
  if (!refusal.empty()) out["unsupported_because"] = refusal;
  out["q_format"] = request.format;
  out["solution"] = q;
  out["coordinates"] = coordinateNames(skeleton);
  out["joints"] = byJoint(skeleton, q);
  if (!verdict.goals.empty()) {
    double position = 0.0, orientation = 0.0;
    json goals = json::array();
    for (std::size_t g = 0; g < verdict.goals.size(); ++g) {
      const GoalError& error = verdict.goals[g];
      position = std::max(position, error.position);
      orientation = std::max(orientation, error.orientation);
      goals.push_back({{"joint", skeleton.joint(problem.goals[g].joint).name},
                       {"kind", goalType(problem.goals[g].kind).name},
                       {"weight", problem.goals[g].weight},
                       {"position_error", error.position},
                       {"orientation_error", error.orientation}});
    }
    out["position_error"] = position;
    out["orientation_error"] = orientation;
    out["goals"] = std::move(goals);
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
      "solve", "Solve inverse-kinematics problems; print JSON or a table; exit status 0 if solved, 2 if not");
  command->add_option("--model", request->model, "Built-in model or file")->capture_default_str();
  command->add_option("--target", request->target,
                      "X Y Z, QW QX QY QZ or X Y Z QW QX QY QZ: metres and a unit quaternion, world frame");
  command->add_option("--goal", request->goals,
                      "JOINT=X,Y,Z[,QW,QX,QY,QZ][:WEIGHT], or JOINT=QW,QX,QY,QZ, or KIND FIELD=VALUE ... as "
                      "'distance joint=hand_l other=hand_r length=0.25' (repeatable)");
  command->add_flag("--rod-masses", request->rodMasses,
                    "Weigh every bone as a rod of the same mass a metre, for goals that need masses");
  command->footer(
      "Kinds of goals and their fields, optional ones in brackets; every kind takes weight=, role= "
      "(drag, hold, pin) and priority=\n" +
      describeGoalTypes());
  command->add_option("--goals", request->goalsFile, "Goals from a JSON file, see docs/lab.md");
  command->add_option("--axis", request->axis,
                      "Of orientations only the direction of this axis of the joint counts: x, -z, or X,Y,Z");
  command->add_option("--weights", request->weights, "POSITION ORIENTATION: weights of the two parts")
      ->expected(2);
  command->add_flag("--position-first", request->positionFirst,
                    "Where not all can be met: meet the positions, then turn as well as possible");
  command->add_option("--targets", request->targets,
                      "Many targets of one joint, a table (CSV) with a header x,y,z[,qw,qx,qy,qz]");
  command->add_option("--answers", request->answers, "Table of the answers; -: standard output")
      ->capture_default_str();
  command->add_option("--q-format", request->format, "Of angles in --start and in the answer")
      ->check(CLI::IsMember({"radians", "degrees"}))
      ->capture_default_str();
  command->add_option("--set", request->settings,
                      "A parameter of the solver, such as dls.lambda=0.1 (repeatable)");
  command->add_option("--solver", request->solver, "Solver by name (see compare --list)")
      ->capture_default_str();
  command->add_option("--joint", request->joint,
                      "Joint that shall reach --target or --targets; default: the model's only end");
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
