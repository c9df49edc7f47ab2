#include "apps/commands/solve_batch.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <span>

#include "apps/commands/goal_options.h"
#include "kinematics/configuration.h"
#include "kinematics/io/csv.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "kinematics/io/word_stream.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/problem/judge.h"
#include "solvers/serial/serial_pose.h"

namespace gelenk {
namespace {

using Clock = std::chrono::steady_clock;
using Eigen::VectorXd;

double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

/// Quaternions of length 1 to 1e-3.
bool isNearlyUnit(const Eigen::Quaterniond& q) { return std::abs(q.norm() - 1.0) < 1e-3; }

std::string_view withoutBlanks(std::string_view field) {
  const std::size_t first = field.find_first_not_of(" \t");
  return first == field.npos ? "" : field.substr(first, field.find_last_not_of(" \t") - first + 1);
}

BatchTargets readTargets(const std::string& path) {
  const std::string text = readFile(path);
  CsvReader reader(plainText(text, path));
  std::vector<std::string> fields;
  const std::string headers = "a header x,y,z or x,y,z,qw,qx,qy,qz or qw,qx,qy,qz";
  if (!reader.next(fields)) throw ParseError(path, 1, headers, "an empty file");
  std::string header;
  for (const std::string& field : fields)
    header += (header.empty() ? "" : ",") + lowerCase(withoutBlanks(field));
  BatchTargets targets;
  if (header == "x,y,z,qw,qx,qy,qz")
    targets.kind = GoalKind::Pose;
  else if (header == "qw,qx,qy,qz")
    targets.kind = GoalKind::Orientation;
  else if (header != "x,y,z")
    throw ParseError(path, 1, headers, "'" + header + "'");
  const std::size_t columns = fields.size();
  std::vector<double> numbers(columns);
  while (reader.next(fields)) {
    if (fields.size() == 1 && withoutBlanks(fields[0]).empty()) continue;  // a blank line
    if (fields.size() != columns)
      throw ParseError(path, reader.line(), std::to_string(columns) + " values",
                       std::to_string(fields.size()));
    for (std::size_t k = 0; k < columns; ++k) {
      const std::string_view word = withoutBlanks(fields[k]);
      const auto value = parseNumber(word);
      if (!value) throw ParseError(path, reader.line(), "a finite number", badNumber(word));
      numbers[k] = *value;
    }
    if (targets.kind != GoalKind::Orientation)
      targets.places.emplace_back(numbers[0], numbers[1], numbers[2]);
    if (targets.kind == GoalKind::Position) continue;
    const double* q = &numbers[columns - 4];
    Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
    if (!isNearlyUnit(turn))
      throw ParseError(path, reader.line(), "a quaternion of length 1", "one of " + exactNumber(turn.norm()));
    turn.normalize();
    targets.turns.push_back(turn);
  }
  return targets;
}

/// The chain's solver where the batch is one of poses that go through it; null where not.
std::shared_ptr<const SerialPoseSolver> lanesFor(const BatchProblem& problem, BatchMemory* memory) {
  const SolverSpec choice = solverSpec(problem.solver);
  const bool serial = choice.name == "default" || choice.entry->name.starts_with("serial-pose");
  if (!serial || problem.targets.kind != GoalKind::Pose || !choice.values.empty()) return {};
  constexpr std::size_t worthATable = 2000;  // targets: the table of starts takes some tenths of a second
  const bool table = problem.targets.count() >= worthATable;
  if (table && memory && memory->lanes && memory->joint == problem.joint) return memory->lanes;
  SerialChainResult result = extractSerialChain(problem.skeleton, problem.joint);
  if (!result.whyNot.empty()) return {};
  const auto made = std::make_shared<SerialPoseSolver>(std::move(result.chain));
  if (!table) return made;
  made->buildSeedTable();
  if (memory) *memory = {problem.joint, made};
  return made;
}

/// Poses side by side, a block at a time, which stays in the processor's caches until it is judged.
class Lanes {
 public:
  static constexpr std::size_t block = 4096;  // as solveBatch's own, so that its seeds are the same

  Lanes(const BatchProblem& problem, const Eigen::MatrixXd& starts, const SerialPoseSolver& solver)
      : problem_(problem), starts_(starts), solver_(solver) {
    const std::size_t most = std::min(block, problem.targets.count());
    poses_.assign(most, Eigen::Isometry3d::Identity());
    begins_.resize(most * solver.chain().n);
    answers_.resize(most);
  }

  /// Solves the targets from `first` on, `block` of them at most.
  void solve(std::size_t first) {
    first_ = first;
    const SerialChain& chain = solver_.chain();
    const std::size_t count = std::min(block, problem_.targets.count() - first), n = chain.n;
    for (std::size_t i = 0; i < count; ++i) {
      poses_[i].translation() = problem_.targets.places[first + i];
      poses_[i].linear() = problem_.targets.turns[first + i].toRotationMatrix();
      const double* start = startOf(first + i);
      for (std::size_t k = 0; k < n; ++k) begins_[i * n + k] = start[chain.qIndex[k]];
    }
    solver_.solveBatch(std::span(poses_).first(count), std::span(begins_).first(count * n),
                       std::span(answers_).first(count),
                       {.positionTolerance = problem_.tolerance,
                        .orientationTolerance = problem_.tolerance,
                        .restarts = std::max(problem_.budget.restarts, 1),
                        .seed = problem_.budget.seed + first,
                        .closestPose = false});
  }

  /// The answer of a target of the block.
  void get(std::size_t target, VectorXd& q) const {
    const SerialChain& chain = solver_.chain();
    q = VectorXd::Map(startOf(target), starts_.rows());
    for (int k = 0; k < chain.n; ++k) q[chain.qIndex[k]] = answers_[target - first_].q[k];
    problem_.skeleton.couple(q);
  }

 private:
  const double* startOf(std::size_t target) const {
    return starts_.data() + (starts_.cols() == 1 ? 0 : target * starts_.rows());
  }

  const BatchProblem& problem_;
  const Eigen::MatrixXd& starts_;
  const SerialPoseSolver& solver_;
  std::size_t first_ = 0;
  std::vector<Eigen::Isometry3d> poses_;
  std::vector<double> begins_;
  std::vector<KernelAnswer> answers_;
};

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

BatchTargets targetsFromRows(const double* row, std::size_t count, int width, const char* what) {
  BatchTargets out{.kind = width == 3   ? GoalKind::Position
                           : width == 4 ? GoalKind::Orientation
                                        : GoalKind::Pose};
  if (width != 4) out.places.resize(count);
  if (width != 3) out.turns.resize(count);
  for (std::size_t i = 0; i < count; ++i, row += width) {
    const auto refuse = [&](const std::string& why) {
      throw std::invalid_argument(std::string(what) + ": " + why);
    };
    double sum = 0.0;
    for (int k = 0; k < width; ++k) sum += row[k] * 0.0;
    if (sum != 0.0) refuse("number " + std::to_string(i) + " of them has entries that are not finite");
    if (width == 16) {
      using Rotation = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
      const Eigen::Matrix3d R = Eigen::Map<const Rotation, 0, Eigen::OuterStride<4>>(row);
      const Eigen::Quaterniond turn = Eigen::Quaterniond(R).normalized();
      if (!((turn.toRotationMatrix() - R).cwiseAbs().maxCoeff() < 1e-6) || row[12] != 0.0 || row[13] != 0.0 ||
          row[14] != 0.0 || row[15] != 1.0)
        refuse("matrix " + std::to_string(i) + " is no pose");
      out.turns[i] = turn;
      out.places[i] = {row[3], row[7], row[11]};
      continue;
    }
    if (width != 4) out.places[i] = Eigen::Vector3d::Map(row);
    if (width == 3) continue;
    const double* q = row + width - 4;
    const Eigen::Quaterniond turn(q[0], q[1], q[2], q[3]);
    if (!isNearlyUnit(turn))
      refuse("the quaternion of number " + std::to_string(i) + " must have length 1, not " +
             exactNumber(turn.norm()));
    out.turns[i] = turn.normalized();
  }
  return out;
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
  const auto begin = Clock::now();
  const std::shared_ptr<const SerialPoseSolver> chain = count > 0 ? lanesFor(batch, memory) : nullptr;
  std::optional<Lanes> lanes;
  if (chain) lanes.emplace(batch, starts, *chain);
  const auto solver = makeSolver(batch.solver);
  seconds += since(begin);
  bool prepared = false;
  IkProblem problem{.skeleton = &batch.skeleton,
                    .start = starts.col(0),
                    .goals = {Goal{.kind = targets.kind, .joint = batch.joint}},
                    .positionTolerance = batch.tolerance,
                    .orientationTolerance = batch.tolerance};
  Goal& goal = problem.goals[0];
  VectorXd q;
  for (std::size_t i = 0; i < count; ++i) {
    if (lanes && i % Lanes::block == 0) lanes->solve(i);
    if (!targets.places.empty()) goal.target = targets.places[i];
    if (!targets.turns.empty()) goal.orientation = targets.turns[i];
    Judgement verdict;
    if (lanes) {
      lanes->get(i, q);
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
      IkReport report = solver->solve(problem, batch.budget, TraceLevel::Off);
      answers.why[i] = report.why;
      q = std::move(report.q);
      verdict = judge(problem, q);
    }
    answers.q.col(i) = q;
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
