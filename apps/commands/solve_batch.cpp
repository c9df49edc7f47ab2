#include "apps/commands/solve_batch.h"

#include <chrono>
#include <cstdio>

#include "apps/commands/goal_options.h"
#include "kinematics/configuration.h"
#include "kinematics/io/csv.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/problem/judge.h"
#include "solvers/serial/serial_pose.h"

namespace gelenk {
namespace {

using Clock = std::chrono::steady_clock;
using Eigen::VectorXd;

double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

struct Targets {
  GoalKind kind = GoalKind::Position;
  std::vector<Goal> goals;
};

Targets readTargets(const std::string& path, int joint) {
  const std::string text = readFile(path);
  CsvReader reader(text);
  std::vector<std::string> fields;
  if (!reader.next(fields)) throw ParseError(path, 1, "a header x,y,z or x,y,z,qw,qx,qy,qz", "an empty file");
  std::string header;
  for (const std::string& field : fields) header += (header.empty() ? "" : ",") + field;
  Targets targets;
  if (header == "x,y,z,qw,qx,qy,qz")
    targets.kind = GoalKind::Pose;
  else if (header == "qw,qx,qy,qz")
    targets.kind = GoalKind::Orientation;
  else if (header != "x,y,z")
    throw ParseError(path, 1, "a header x,y,z or x,y,z,qw,qx,qy,qz or qw,qx,qy,qz", "'" + header + "'");
  const std::size_t columns = fields.size();
  std::vector<double> numbers(columns);
  while (reader.next(fields)) {
    if (fields.size() == 1 && fields[0].empty()) continue;  // a blank line at the end
    if (fields.size() != columns)
      throw ParseError(path, reader.line(), std::to_string(columns) + " values",
                       std::to_string(fields.size()));
    for (std::size_t k = 0; k < columns; ++k) {
      const auto value = parseNumber(fields[k]);
      if (!value) throw ParseError(path, reader.line(), "a number", "'" + fields[k] + "'");
      numbers[k] = *value;
    }
    Goal goal{.kind = targets.kind, .joint = joint};
    if (targets.kind != GoalKind::Orientation) goal.target = {numbers[0], numbers[1], numbers[2]};
    if (targets.kind != GoalKind::Position) {
      const double* q = &numbers[columns - 4];
      goal.orientation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
      if (!(std::abs(goal.orientation.norm() - 1.0) < 1e-3))
        throw ParseError(path, reader.line(), "a quaternion of length 1",
                         "one of " + exactNumber(goal.orientation.norm()));
      goal.orientation.normalize();
    }
    targets.goals.push_back(std::move(goal));
  }
  return targets;
}

/// Poses of a chain side by side; q of each. Empty where the problem is not of that kind.
std::vector<VectorXd> solveInLanes(const BatchProblem& problem, const std::vector<VectorXd>& starts,
                                   double& preparation) {
  const SolverSpec choice = solverSpec(problem.solver);
  const bool serial = choice.name == "default" || choice.entry->name.starts_with("serial-pose");
  if (!serial || problem.goals.empty() || problem.goals[0].kind != GoalKind::Pose || !choice.values.empty())
    return {};
  const auto begin = Clock::now();
  SerialChainResult result = extractSerialChain(problem.skeleton, problem.joint);
  if (!result.whyNot.empty()) return {};
  SerialPoseSolver solver(std::move(result.chain));
  const int n = solver.chain().n, count = static_cast<int>(problem.goals.size());
  constexpr int worthATable = 2000;  // targets: the table of starts takes some tenths of a second to make
  if (count >= worthATable) solver.buildSeedTable();
  preparation = since(begin);
  std::vector<Eigen::Isometry3d> poses(count, Eigen::Isometry3d::Identity());
  std::vector<double> begins(static_cast<std::size_t>(count) * n);
  for (int i = 0; i < count; ++i) {
    const VectorXd& start = starts[starts.size() == 1 ? 0 : i];
    poses[i].translation() = problem.goals[i].target;
    poses[i].linear() = problem.goals[i].orientation.toRotationMatrix();
    for (int k = 0; k < n; ++k) begins[static_cast<std::size_t>(i) * n + k] = start[solver.chain().qIndex[k]];
  }
  std::vector<KernelAnswer> answers(count);
  solver.solveBatch(poses, begins, answers,
                    {.positionTolerance = problem.tolerance,
                     .orientationTolerance = problem.tolerance,
                     .restarts = std::max(problem.budget.restarts, 1),
                     .seed = problem.budget.seed,
                     .closestPose = false});
  std::vector<VectorXd> all;
  all.reserve(count);
  for (int i = 0; i < count; ++i) {
    all.push_back(starts[starts.size() == 1 ? 0 : i]);
    for (int k = 0; k < n; ++k) all[i][solver.chain().qIndex[k]] = answers[i].q[k];
    problem.skeleton.couple(all[i]);
  }
  return all;
}

}  // namespace

std::vector<std::string> coordinateNames(const Skeleton& skeleton) {
  std::vector<std::string> names;
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    const bool alone = joint.axes.size() == 1 && !joint.ball;
    for (std::size_t k = 0; k < joint.axes.size(); ++k)
      names.push_back(alone ? joint.name : joint.name + '.' + std::to_string(k + 1));
    if (joint.ball)
      for (const char* part : {".qw", ".qx", ".qy", ".qz"}) names.push_back(joint.name + part);
  }
  return names;
}

std::vector<char> coordinateIsAngle(const Skeleton& skeleton) {
  std::vector<char> angle;
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    for (const AxisDof& dof : skeleton.joint(i).axes) angle.push_back(dof.kind == AxisDof::Kind::Rotation);
    if (skeleton.joint(i).ball) angle.insert(angle.end(), 4, 0);
  }
  return angle;
}

std::vector<BatchAnswer> solveGoals(const BatchProblem& batch, double* preparation) {
  std::vector<VectorXd> starts;
  for (const VectorXd& start : batch.starts) starts.push_back(projectToLimits(batch.skeleton, start));
  const std::size_t count = batch.goals.size();
  if (starts.empty() || (starts.size() != 1 && starts.size() != count))
    throw std::invalid_argument("a batch wants one start, or one a target");
  IkProblem problem{.skeleton = &batch.skeleton,
                    .start = starts[0],
                    .goals = {},
                    .positionTolerance = batch.tolerance,
                    .orientationTolerance = batch.tolerance};
  double seconds = 0.0;
  std::vector<VectorXd> together = solveInLanes(batch, starts, seconds);
  const auto solver = makeSolver(batch.solver);
  bool prepared = false;
  std::vector<BatchAnswer> answers(count);
  for (std::size_t i = 0; i < count; ++i) {
    BatchAnswer& answer = answers[i];
    problem.goals.assign(1, batch.goals[i]);
    Judgement verdict;
    if (!together.empty()) {
      answer.q = std::move(together[i]);
      verdict = judge(problem, answer.q);
    }
    if (!verdict.solved) {  // alone, and then the closest pose
      if (!prepared) {
        const auto now = Clock::now();
        solver->prepare(batch.skeleton);
        prepared = true;
        seconds += since(now);
      }
      if (starts.size() > 1) problem.start = starts[i];
      IkReport report = solver->solve(problem, batch.budget, TraceLevel::Off);
      answer.q = std::move(report.q);
      answer.why = report.why;
      verdict = judge(problem, answer.q);
    }
    answer.solved = verdict.solved && answer.why != Stop::Unsupported;
    if (!verdict.goals.empty()) answer.error = verdict.goals[0];
  }
  if (preparation) *preparation = seconds;
  return answers;
}

BatchOutcome solveBatch(const BatchRequest& request) {
  const auto begin = Clock::now();
  BatchOutcome outcome;
  const Targets targets = readTargets(request.targets, request.joint);
  const std::vector<BatchAnswer> answers = solveGoals({.skeleton = request.skeleton,
                                                       .joint = request.joint,
                                                       .starts = {request.start},
                                                       .goals = targets.goals,
                                                       .solver = request.solver,
                                                       .tolerance = request.tolerance,
                                                       .budget = request.budget},
                                                      &outcome.preparation);
  const std::vector<char> angle = coordinateIsAngle(request.skeleton);
  std::vector<std::string> header{"row", "status", "solved", "position_error", "orientation_error"};
  for (std::string& name : coordinateNames(request.skeleton)) header.push_back(std::move(name));
  std::string text = csvLine(std::span<const std::string>(header));
  text.reserve(64 + 24 * (header.size() * answers.size()));
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const BatchAnswer& answer = answers[i];
    outcome.solved += answer.solved;
    text += std::to_string(i + 1) + ',' + toString(answer.why) + (answer.solved ? ",1," : ",0,");
    text += exactNumber(answer.error.position) + ',' + exactNumber(answer.error.orientation);
    for (Eigen::Index k = 0; k < answer.q.size(); ++k)
      text += ',' + exactNumber(request.degrees && angle[k] ? answer.q[k] * 180.0 / M_PI : answer.q[k]);
    text += '\n';
  }
  outcome.targets = static_cast<int>(targets.goals.size());
  if (request.answers == "-")
    std::fwrite(text.data(), 1, text.size(), stdout);
  else
    writeFile(request.answers, text);
  outcome.seconds = since(begin);
  return outcome;
}

}  // namespace gelenk
