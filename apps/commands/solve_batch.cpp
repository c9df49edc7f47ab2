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

BatchTargets readTargets(const std::string& path) {
  const std::string text = readFile(path);
  CsvReader reader(text);
  std::vector<std::string> fields;
  if (!reader.next(fields)) throw ParseError(path, 1, "a header x,y,z or x,y,z,qw,qx,qy,qz", "an empty file");
  std::string header;
  for (const std::string& field : fields) header += (header.empty() ? "" : ",") + field;
  BatchTargets targets;
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
    if (targets.kind != GoalKind::Orientation)
      targets.places.emplace_back(numbers[0], numbers[1], numbers[2]);
    if (targets.kind == GoalKind::Position) continue;
    const double* q = &numbers[columns - 4];
    Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
    if (!(std::abs(turn.norm() - 1.0) < 1e-3))
      throw ParseError(path, reader.line(), "a quaternion of length 1", "one of " + exactNumber(turn.norm()));
    turn.normalize();
    targets.turns.push_back(turn);
  }
  return targets;
}

/// Poses of a chain side by side; answers.q of each. False where the problem is not of that kind.
bool solveInLanes(const BatchProblem& problem, const Eigen::MatrixXd& starts, BatchAnswers& out,
                  double& preparation, BatchMemory* memory) {
  const SolverSpec choice = solverSpec(problem.solver);
  const bool serial = choice.name == "default" || choice.entry->name.starts_with("serial-pose");
  if (!serial || problem.targets.kind != GoalKind::Pose || !choice.values.empty()) return false;
  const auto begin = Clock::now();
  const int count = static_cast<int>(problem.targets.count());
  constexpr int worthATable = 2000;  // targets: the table of starts takes some tenths of a second to make
  std::shared_ptr<const SerialPoseSolver> solver;
  if (count >= worthATable && memory && memory->joint == problem.joint) solver = memory->lanes;
  if (!solver) {
    SerialChainResult result = extractSerialChain(problem.skeleton, problem.joint);
    if (!result.whyNot.empty()) return false;
    const auto made = std::make_shared<SerialPoseSolver>(std::move(result.chain));
    if (count >= worthATable) {
      made->buildSeedTable();
      if (memory) *memory = {problem.joint, made};
    }
    solver = made;
  }
  preparation = since(begin);
  const SerialChain& chain = solver->chain();
  const int n = chain.n;
  std::vector<Eigen::Isometry3d> poses(count, Eigen::Isometry3d::Identity());
  std::vector<double> begins(static_cast<std::size_t>(count) * n);
  for (int i = 0; i < count; ++i) {
    poses[i].translation() = problem.targets.places[i];
    poses[i].linear() = problem.targets.turns[i].toRotationMatrix();
    const auto start = starts.col(starts.cols() == 1 ? 0 : i);
    for (int k = 0; k < n; ++k) begins[static_cast<std::size_t>(i) * n + k] = start[chain.qIndex[k]];
  }
  std::vector<KernelAnswer> answers(count);
  solver->solveBatch(poses, begins, answers,
                     {.positionTolerance = problem.tolerance,
                      .orientationTolerance = problem.tolerance,
                      .restarts = std::max(problem.budget.restarts, 1),
                      .seed = problem.budget.seed,
                      .closestPose = false});
  const bool coupled = !problem.skeleton.followers().empty();
  VectorXd q;
  for (int i = 0; i < count; ++i) {
    out.q.col(i) = starts.col(starts.cols() == 1 ? 0 : i);
    for (int k = 0; k < n; ++k) out.q(chain.qIndex[k], i) = answers[i].q[k];
    if (!coupled) continue;
    q = out.q.col(i);
    problem.skeleton.couple(q);
    out.q.col(i) = q;
  }
  return true;
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

BatchAnswers solveTargets(const BatchProblem& batch, double* preparation, BatchMemory* memory) {
  const BatchTargets& targets = batch.targets;
  const std::size_t count = targets.count();
  if (batch.starts.cols() != 1 && batch.starts.cols() != static_cast<Eigen::Index>(count))
    throw std::invalid_argument("a batch wants one start, or one a target");
  Eigen::MatrixXd starts(batch.starts.rows(), batch.starts.cols());
  for (Eigen::Index i = 0; i < starts.cols(); ++i)
    starts.col(i) = projectToLimits(batch.skeleton, batch.starts.col(i));
  BatchAnswers answers{.q = Eigen::MatrixXd(batch.skeleton.nq(), count),
                       .error = std::vector<GoalError>(count),
                       .why = std::vector<Stop>(count, Stop::Converged),
                       .solved = std::vector<char>(count)};
  double seconds = 0.0;
  const bool together = count > 0 && solveInLanes(batch, starts, answers, seconds, memory);
  const auto solver = makeSolver(batch.solver);
  bool prepared = false;
  IkProblem problem{.skeleton = &batch.skeleton,
                    .start = starts.col(0),
                    .goals = {Goal{.kind = targets.kind, .joint = batch.joint}},
                    .positionTolerance = batch.tolerance,
                    .orientationTolerance = batch.tolerance};
  Goal& goal = problem.goals[0];
  VectorXd q;
  Judgement verdict;
  for (std::size_t i = 0; i < count; ++i) {
    if (!targets.places.empty()) goal.target = targets.places[i];
    if (!targets.turns.empty()) goal.orientation = targets.turns[i];
    verdict.solved = false;
    if (together) {
      q = answers.q.col(i);
      verdict = judge(problem, q);
    }
    if (!verdict.solved) {  // alone, and then the closest pose
      if (!prepared) {
        const auto now = Clock::now();
        solver->prepare(batch.skeleton);
        prepared = true;
        seconds += since(now);
      }
      if (starts.cols() > 1) problem.start = starts.col(i);
      const IkReport report = solver->solve(problem, batch.budget, TraceLevel::Off);
      answers.why[i] = report.why;
      answers.q.col(i) = report.q;
      verdict = judge(problem, report.q);
    }
    answers.solved[i] = verdict.solved && answers.why[i] != Stop::Unsupported;
    if (!verdict.goals.empty()) answers.error[i] = verdict.goals[0];
  }
  if (preparation) *preparation = seconds;
  return answers;
}

BatchOutcome solveBatch(const BatchRequest& request) {
  const auto begin = Clock::now();
  BatchOutcome outcome;
  const BatchTargets targets = readTargets(request.targets);
  const BatchAnswers answers = solveTargets({.skeleton = request.skeleton,
                                             .joint = request.joint,
                                             .starts = request.start,
                                             .targets = targets,
                                             .solver = request.solver,
                                             .tolerance = request.tolerance,
                                             .budget = request.budget},
                                            &outcome.preparation);
  const std::vector<char> angle = coordinateIsAngle(request.skeleton);
  std::vector<std::string> header{"row", "status", "solved", "position_error", "orientation_error"};
  for (std::string& name : coordinateNames(request.skeleton)) header.push_back(std::move(name));
  std::string text = csvLine(std::span<const std::string>(header));
  text.reserve(64 + 24 * (header.size() * targets.count()));
  for (std::size_t i = 0; i < targets.count(); ++i) {
    outcome.solved += answers.solved[i];
    text += std::to_string(i + 1) + ',' + toString(answers.why[i]) + (answers.solved[i] ? ",1," : ",0,");
    text += exactNumber(answers.error[i].position) + ',' + exactNumber(answers.error[i].orientation);
    const auto q = answers.q.col(i);
    for (Eigen::Index k = 0; k < q.size(); ++k)
      text += ',' + exactNumber(request.degrees && angle[k] ? q[k] * 180.0 / M_PI : q[k]);
    text += '\n';
  }
  outcome.targets = static_cast<int>(targets.count());
  if (request.answers == "-")
    std::fwrite(text.data(), 1, text.size(), stdout);
  else
    writeFile(request.answers, text);
  outcome.seconds = since(begin);
  return outcome;
}

}  // namespace gelenk
