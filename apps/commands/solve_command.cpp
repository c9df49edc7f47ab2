#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/commands/arm_request.h"
#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/commands/goal_options.h"
#include "apps/commands/model_options.h"
#include "apps/commands/solve_batch.h"
#include "apps/document/model.h"
#include "apps/document/notes.h"
#include "apps/document/scene_file.h"
#include "apps/document/session.h"
#include "kinematics/configuration.h"
#include "solvers/lab/sweep.h"
#include "solvers/problem/goal_text.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/problem/judge.h"

namespace gelenk {
namespace {

using json = nlohmann::ordered_json;

struct Request {
  Companions files;
  std::string model = "panda", solver = "default", joint, axis, goalsFile, targets, answers = "-",
              format = "radians";
  std::vector<std::string> settings, goals;
  std::vector<double> target, start, weights;
  double tolerance = 1e-6;
  Budget budget{.maxIterations = 200, .maxSeconds = 1e9, .restarts = 50};
  bool trace = false, positionFirst = false, rods = false;

  bool degrees() const { return format == "degrees"; }
};

/// --goal takes two forms: "hand_r=0.1,1.2,0.3", and a kind of goal with its fields.
bool isOpenGoal(std::string_view text) {
  const std::string_view word = text.substr(0, text.find_first_of(" ="));
  return word.size() == text.size() || text[word.size()] == ' ';
}

/// The goals that name their kind.
std::vector<Goal> openGoals(const Request& request, const Model& model) {
  const std::shared_ptr<const Masses> masses =
      request.rods ? std::make_shared<const Masses>(rodMasses(model.skeleton)) : model.masses;
  std::vector<Goal> goals;
  for (const std::string& text : request.goals)
    if (isOpenGoal(text)) goals.push_back(goalFromText(text, model.skeleton, masses));
  return goals;
}

/// The places and orientations of joints that the options ask for.
std::vector<TypedGoal> goalsAskedFor(const Request& request, const Model& model) {
  std::vector<TypedGoal> goals;
  if (!request.goalsFile.empty()) goals = readGoals(request.goalsFile, model.skeleton);
  for (const std::string& text : request.goals)
    if (!isOpenGoal(text)) goals.push_back(parseJointGoal(text, model.skeleton));
  if (!request.target.empty()) {
    goals.push_back({.joint = effectorOf(model, request.joint)});
    putNumbers(goals.back(), request.target, "--target");
  }
  if (!request.weights.empty()) {
    if (request.weights.size() != 2 || !(request.weights[0] > 0.0) || !(request.weights[1] > 0.0))
      throw std::invalid_argument(
          "--goal-weights wants two numbers above 0: of positions and of orientations");
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

Eigen::VectorXd startOf(const Request& request, const Skeleton& skeleton, const Eigen::VectorXd& otherwise) {
  if (request.start.empty()) return otherwise;
  std::vector<double> values = request.start;
  if (const auto q = configurationFrom(skeleton, values); q && request.degrees()) {
    values.assign(q->begin(), q->end());
    const std::vector<char> angle = coordinateIsAngle(skeleton);
    for (std::size_t k = 0; k < values.size(); ++k)
      if (angle[k]) values[k] *= M_PI / 180.0;
  }
  return startConfiguration(values, skeleton, "--start");
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

bool batch(const Request& request, const Model& model, const Eigen::VectorXd& begins,
           const std::string& solver) {
  const BatchOutcome outcome = solveBatch({.skeleton = model.skeleton,
                                           .joint = effectorOf(model, request.joint),
                                           .start = startOf(request, model.skeleton, begins),
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
  const Opened opened = openDocument({.nameOrFile = request.model, .files = request.files}, Body::AsItComes);
  const Model& model = *opened.model;
  const Skeleton& skeleton = model.skeleton;
  const Eigen::VectorXd& begins = opened.document.edits.q;
  if (!request.targets.empty()) {
    sayNotes(request.model, model.notes);
    return batch(request, model, begins, chosen);
  }
  demandNoNotes(request.model, model.notes);
  const std::vector<TypedGoal> typed = goalsAskedFor(request, model);
  std::vector<Goal> goals = goalsOf(typed);
  std::vector<Goal> open = openGoals(request, model);
  if (goals.empty() && open.empty() && isScene(request.model))  // what is held and pinned in it
    open = Session(opened.model, opened.document).problem().goals;
  goals.insert(goals.end(), open.begin(), open.end());
  if (goals.empty())
    throw std::invalid_argument(
        "nothing is asked for: give --target, --goal, --goals or --targets, or a scene that holds something");
  const IkProblem problem{.skeleton = &skeleton,
                          .start = startOf(request, skeleton, begins),
                          .goals = goals,
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
                       {"goal", goalToText(problem.goals[g], skeleton)},
                       {"weight", problem.goals[g].weight},
                       {"position_error", error.position},
                       {"orientation_error", error.orientation}});
    }
    out["position_error"] = position;
    out["orientation_error"] = orientation;
    out["goals"] = std::move(goals);
  }
  out["limit_violation"] = verdict.limitViolation;
  const Counters& c = report.counters;
  out["counters"] = {{"iterations", c.iterations},         {"forward_kinematics", c.forwardKinematics},
                     {"jacobians", c.jacobians},           {"hessians", c.hessians},
                     {"factorisations", c.factorisations}, {"restarts", c.restarts}};
  out["microseconds"] = report.seconds * 1e6;
  out["notes"] = asJson(model.notes);
  if (request.trace) out["trace"] = traceOf(report);
  fmt::print("{}\n", out.dump(2));
  return solved;
}

}  // namespace

void addSolveCommand(Command& app) {
  auto request = std::make_shared<Request>();
  Command command = app.command(
      "solve", "Solve inverse-kinematics problems; print JSON or a table; exit status 0 if solved, 2 if not");
  command
      .option("--model", request->model,
              "Built-in model, file, or scene (.json), which begins in its own pose and, where no goal is "
              "given, with its own goals")
      .showDefault();
  addModelOptions(command, request->files);
  command.option("--asf", request->files.asf, "Skeleton of an AMC, or to lay a fitted skeleton on");
  command.option("--amc", request->files.amc, "Motion for the ASF skeleton, which begins in its first frame");
  command.option("--clip", request->files.clip,
                 "Which motion of a file that names several; default: the first");
  command.option("--target", request->target,
                 "X Y Z, QW QX QY QZ or X Y Z QW QX QY QZ: metres and a unit quaternion, world frame");
  command
      .option(
          "--goal", request->goals,
          "JOINT=X,Y,Z[,QW,QX,QY,QZ][:WEIGHT], or JOINT=QW,QX,QY,QZ, or a goal of any kind such as "
          "'distance joint=hand_l other=hand_r length=0.25', which also takes weight=, role= (drag, hold, "
          "pin) and priority= (repeatable)")
      .oneAtATime();
  command.flag("--rod-masses", request->rods,
               "Weigh every bone as a rod of the same mass a metre, for goals that need masses");
  command.notes("Kinds of goals and their fields, optional ones in brackets:\n" + describeGoalTypes());
  command.option("--goals", request->goalsFile, "Goals from a JSON file, see docs/lab.md");
  command.option("--axis", request->axis,
                 "Of orientations only the direction of this axis of the joint counts: x, -z, or X,Y,Z");
  command.option("--goal-weights", request->weights, "POSITION ORIENTATION: weights of the two parts")
      .count(2);
  command.flag("--position-first", request->positionFirst,
               "Where not all can be met: meet the positions, then turn as well as possible");
  command.option("--targets", request->targets,
                 "Many targets of one joint, a table (CSV) with a header x,y,z[,qw,qx,qy,qz]");
  command.option("--answers", request->answers, "Table of the answers; -: standard output").showDefault();
  command.option("--q-format", request->format, "Of angles in --start and in the answer")
      .oneOf({"radians", "degrees"})
      .showDefault();
  command.option("--set", request->settings,
                 "A parameter of the solver, such as dls.lambda=0.1 (repeatable)");
  command.option("--solver", request->solver, "Solver by name (see compare --list)").showDefault();
  command.option("--joint", request->joint,
                 "Joint that shall reach --target or --targets; default: the model's only end");
  command.option("--start", request->start, "Start configuration; default: the rest pose");
  command.option("--tolerance", request->tolerance, "Metres and radians").showDefault();
  command.option("--max-iterations", request->budget.maxIterations, "Iterations of one attempt")
      .showDefault();
  command.option("--restarts", request->budget.restarts, "Random restarts after the first attempt")
      .showDefault();
  command.option("--seed", request->budget.seed, "Seed of the restarts").showDefault();
  command.flag("--trace", request->trace, "Adds every iteration: residual, step, damping, q");
  command.run([request] {
    if (!solve(*request)) throw ExitStatus{2};
  });
}

}  // namespace gelenk
