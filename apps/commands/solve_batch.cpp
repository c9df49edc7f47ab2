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
std::vector<VectorXd> solveInLanes(const BatchRequest& request, const Targets& targets, const VectorXd& start,
                                   double& preparation) {
  const SolverSpec choice = solverSpec(request.solver);
  const bool serial = choice.name == "default" || choice.entry->name.starts_with("serial-pose");
  if (!serial || targets.kind != GoalKind::Pose || !choice.values.empty()) return {};
  const auto begin = Clock::now();
  SerialChainResult result = extractSerialChain(request.skeleton, request.joint);
  if (!result.whyNot.empty()) return {};
  SerialPoseSolver solver(std::move(result.chain));
  const int n = solver.chain().n, count = static_cast<int>(targets.goals.size());
  constexpr int worthATable = 2000;  // targets: the table of starts takes some tenths of a second to make
  if (count >= worthATable) solver.buildSeedTable();
  preparation = since(begin);
  std::vector<Eigen::Isometry3d> poses(count, Eigen::Isometry3d::Identity());
  std::vector<double> starts(static_cast<std::size_t>(count) * n);
  for (int i = 0; i < count; ++i) {
    poses[i].translation() = targets.goals[i].target;
    poses[i].linear() = targets.goals[i].orientation.toRotationMatrix();
    for (int k = 0; k < n; ++k) starts[static_cast<std::size_t>(i) * n + k] = start[solver.chain().qIndex[k]];
  }
  std::vector<KernelAnswer> answers(count);
  solver.solveBatch(poses, starts, answers,
                    {.positionTolerance = request.tolerance,
                     .orientationTolerance = request.tolerance,
                     .restarts = std::max(request.budget.restarts, 1),
                     .seed = request.budget.seed,
                     .closestPose = false});
  std::vector<VectorXd> all(count, start);
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < n; ++k) all[i][solver.chain().qIndex[k]] = answers[i].q[k];
    request.skeleton.couple(all[i]);
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

BatchOutcome solveBatch(const BatchRequest& request) {
  const auto begin = Clock::now();
  BatchOutcome outcome;
  const Targets targets = readTargets(request.targets, request.joint);
  const VectorXd start = projectToLimits(request.skeleton, request.start);
  IkProblem problem{.skeleton = &request.skeleton,
                    .start = start,
                    .goals = {},
                    .positionTolerance = request.tolerance,
                    .orientationTolerance = request.tolerance};
  std::vector<VectorXd> together = solveInLanes(request, targets, start, outcome.preparation);
  const auto solver = makeSolver(request.solver);
  bool prepared = false;

  const std::vector<char> angle = coordinateIsAngle(request.skeleton);
  std::vector<std::string> header{"row", "status", "solved", "position_error", "orientation_error"};
  for (std::string& name : coordinateNames(request.skeleton)) header.push_back(std::move(name));
  std::string text = csvLine(std::span<const std::string>(header));
  text.reserve(64 + 24 * (header.size() * targets.goals.size()));
  for (std::size_t i = 0; i < targets.goals.size(); ++i) {
    problem.goals.assign(1, targets.goals[i]);
    VectorXd q;
    Stop why = Stop::Converged;
    Judgement verdict;
    if (!together.empty()) {
      q = std::move(together[i]);
      verdict = judge(problem, q);
    }
    if (!verdict.solved) {  // alone, and then the closest pose
      if (!prepared) {
        const auto now = Clock::now();
        solver->prepare(request.skeleton);
        prepared = true;
        outcome.preparation += since(now);
      }
      IkReport report = solver->solve(problem, request.budget, TraceLevel::Off);
      q = std::move(report.q);
      why = report.why;
      verdict = judge(problem, q);
    }
    const bool solved = verdict.solved && why != Stop::Unsupported;
    outcome.solved += solved;
    text += std::to_string(i + 1) + ',' + toString(why) + (solved ? ",1," : ",0,");
    const GoalError error = verdict.goals.empty() ? GoalError{} : verdict.goals[0];
    text += exactNumber(error.position) + ',' + exactNumber(error.orientation);
    for (Eigen::Index k = 0; k < q.size(); ++k)
      text += ',' + exactNumber(request.degrees && angle[k] ? q[k] * 180.0 / M_PI : q[k]);
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
