#include "solvers/serial/serial_pose.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "kinematics/configuration.h"
#include "kinematics/limits.h"
#include "kinematics/rotation.h"
#include "solvers/serial/same_joints.h"

namespace gelenk {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

using Clock = std::chrono::steady_clock;
using ChainMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, maxChainDofs, maxChainDofs>;
using Twist = Eigen::Matrix<double, 6, 1>;

constexpr double margin =
    0.98;  // of the tolerances: what the kernel accepts, the judge's own arithmetic accepts too

bool hasPosition(GoalKind kind) { return kind == GoalKind::Position || kind == GoalKind::Pose; }
bool hasOrientation(GoalKind kind) { return kind == GoalKind::Orientation || kind == GoalKind::Pose; }

/// The judge's error: target minus current (metres), rotation vector of target * current^-1 (radians).
struct TipError {
  Vector3d position = Vector3d::Zero(), rotation = Vector3d::Zero();
  double squared() const { return position.squaredNorm() + rotation.squaredNorm(); }
};

TipError tipError(const TipGoal& goal, const Isometry3d& worldFromTip) {
  TipError error;
  if (hasPosition(goal.kind)) error.position = goal.target - worldFromTip * goal.pointInTip;
  if (hasOrientation(goal.kind))
    error.rotation = logRotation(Eigen::Quaterniond(goal.orientation) *
                                 Eigen::Quaterniond(worldFromTip.linear()).conjugate());
  return error;
}

/// Hessian of half the squared error. J: columns of the controlled point. With e, w the errors and theta =
/// |w|, for i <= j:
///   position: Jp_i . Jp_j - e . (z_i x Jp_j)
///   rotation: z_i . z_j - 1/2 w . (z_i x z_j) + c ((w.z_i)(w.z_j) - theta^2 z_i . z_j),
///             c = (1 - (theta/2) cot(theta/2)) / theta^2, the curvature of the rotation vector.
void exactHessian(const ChainJacobian& J, const TipError& error, bool position, bool rotation,
                  ChainMatrix& H) {
  const Eigen::Index n = J.cols();
  const Vector3d &e = error.position, &w = error.rotation;
  const double theta = w.norm();
  const double c = theta > 1e-3 ? (1.0 - squaredAngleAcross(theta)) / (theta * theta) : 1.0 / 12.0;
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = 0; i <= j; ++i) {
      const Vector3d pi = J.col(i).head<3>(), pj = J.col(j).head<3>(), zi = J.col(i).tail<3>(),
                     zj = J.col(j).tail<3>();
      double h = 0.0;
      if (position) h += pi.dot(pj) - e.dot(zi.cross(pj));
      if (rotation) {
        const double zz = zi.dot(zj);
        h += zz - 0.5 * w.dot(zi.cross(zj)) + c * (w.dot(zi) * w.dot(zj) - theta * theta * zz);
      }
      H(i, j) = H(j, i) = h;
    }
}

double nearestWithin(double angle, double start, double lower, double upper) {
  const double turned = angle - 2.0 * M_PI * std::nearbyint((angle - start) / (2.0 * M_PI));
  return std::clamp(wrapInto(turned, lower, upper), lower, upper);
}

}  // namespace

struct SerialPoseSolver::Prepared {
  KernelTask task;
  KernelTarget target;
};

SerialPoseSolver::SerialPoseSolver(SerialChain chain, InstructionSet set)
    : chain_(std::move(chain)),
      scaled_(chain_.constants),
      kernel_(&serialKernel(set, chain_.n, chain_.hasPrismatic)) {
  const double perLength = 1.0 / chain_.length;
  for (int i = 0; i < chain_.n; ++i) {
    scaled_.a[i] *= perLength;
    scaled_.d[i] *= perLength;
    if (scaled_.revolute[i] != 0.0) continue;
    for (double* bound : {scaled_.lower, scaled_.upper, scaled_.seedLower, scaled_.seedUpper})
      bound[i] *= perLength;
  }
}

bool SerialPoseSolver::buildSeedTable(const SeedTableOptions& options) {
  table_ = SeedTable::build(scaled_, chain_.n, *kernel_, options);
  return table_.has_value();
}

Isometry3d SerialPoseSolver::frameAndJacobian(const ChainVector& q, ChainJacobian& J) const {
  const Isometry3d& base = chain_.worldFromBase;
  J.resize(6, chain_.n);
  Eigen::Matrix<double, 3, 4> worldFromLast;
  const Eigen::Matrix<double, 3, 4> start = base.affine();
  kernel_->frameAndJacobian(chain_.constants, start.data(), chain_.lastFromTip.translation().data(), q.data(),
                            worldFromLast.data(), J.data());
  Isometry3d tip = Isometry3d::Identity();
  tip.linear() = worldFromLast.leftCols<3>() * chain_.lastFromTip.linear();
  tip.translation() = worldFromLast.col(3);
  return tip;
}

KernelTarget SerialPoseSolver::kernelTarget(const TipGoal& goal) const {
  const Matrix3d worldFromLast = goal.orientation * chain_.lastFromTip.linear().transpose();
  const Matrix3d baseFromWorld = chain_.worldFromBase.linear().transpose();
  const Matrix3d wanted = baseFromWorld * worldFromLast;
  Vector3d point = goal.target;
  if (goal.kind == GoalKind::Pose) point -= worldFromLast * (chain_.lastFromTip * goal.pointInTip);
  point = baseFromWorld * (point - chain_.worldFromBase.translation()) / chain_.length;
  constexpr double farthest = 1e6;  // out of reach in any case, and its square still fits single precision
  if (point.norm() > farthest) point *= farthest / point.norm();
  KernelTarget target;
  for (int k = 0; k < 3; ++k) {
    target.x[k] = wanted(k, 0);
    target.y[k] = wanted(k, 1);
    target.z[k] = wanted(k, 2);
    target.p[k] = point[k];
  }
  return target;
}

/// A pose goal moves to the last frame's origin, where columns and lengths are simplest; its position
/// tolerance then shares with the lever of the rotation tolerance.
SerialPoseSolver::Prepared SerialPoseSolver::prepare(const TipGoal& goal,
                                                     const SerialPoseOptions& options) const {
  Prepared prepared;
  prepared.target = kernelTarget(goal);
  KernelTask& task = prepared.task;
  task.attemptIterations = std::clamp(options.maxIterations, 1, options.method.attemptIterations);
  task.position = hasPosition(goal.kind);
  task.orientation = hasOrientation(goal.kind);
  const Vector3d pointInLast = chain_.lastFromTip * goal.pointInTip;
  double position = margin * options.positionTolerance, rotation = margin * options.orientationTolerance;
  if (goal.kind == GoalKind::Pose) {
    const double lever = pointInLast.norm();
    if (lever > 0.0) rotation = std::min(rotation, 0.5 * position / lever);
    position -= lever * rotation;
  } else if (goal.kind == GoalKind::Position) {
    for (int k = 0; k < 3; ++k) task.point[k] = pointInLast[k] / chain_.length;
    task.hasPoint = 1;
  }
  position /= chain_.length;
  task.positionTolerance2 = position * position;
  task.orientationTolerance2 = rotation * rotation;
  return prepared;
}

/// What the race gives up on may be beyond a wall by the rounding to single precision.
void SerialPoseSolver::toLimits(double* q, const double* start) const {
  for (int i = 0; i < chain_.n; ++i) {
    if (chain_.constants.revolute[i] == 0.0) q[i] *= chain_.length;
    q[i] = chain_.wraps[i] ? nearestWithin(q[i], start[i], chain_.lower[i], chain_.upper[i])
                           : std::clamp(q[i], chain_.lower[i], chain_.upper[i]);
  }
}

/// The largest change of a dof (radians, chain lengths) between a start and a solution; infinite where there
/// is none.
double SerialPoseSolver::jump(const double* start, const KernelAnswer& found) const {
  if (!found.solved) return std::numeric_limits<double>::infinity();
  double largest = 0.0;
  for (int i = 0; i < chain_.n; ++i) {
    const double change = found.q[i] - start[i];
    largest = std::max(largest, std::abs(chain_.wraps[i] ? std::remainder(change, 2.0 * M_PI) : change));
  }
  return largest;
}

/// Starts close to one whose own descent failed or led far away: the goal is near, and so should the answer
/// be.
void SerialPoseSolver::nudge(const double* start, double most, std::uint64_t seed, LaneStarts& starts) const {
  std::uint64_t state = seed;
  for (int i = 0; i < chain_.n; ++i)
    for (int l = 0; l < kernelLanes; ++l) {
      state = state * 6364136223846793005ULL + 1442695040888963407ULL;
      const double q = start[i] + most * (2.0 * static_cast<double>(state >> 11) * 0x1p-53 - 1.0);
      starts.q[i][l] = static_cast<float>(std::clamp(q, scaled_.lower[i], scaled_.upper[i]));
    }
  starts.valid = (1 << kernelLanes) - 1;
}

/// One problem in the kernel's terms, and what was found and spent so far.
struct SerialPoseSolver::Search {
  const SerialPoseSolver& solver;
  const SerialPoseOptions& options;
  Prepared prepared;
  double start[maxChainDofs] = {};
  KernelAnswer found = {};
  Counters counters = {};

  void count(const KernelAnswer& answer) {
    counters.iterations += answer.iterations;
    counters.forwardKinematics += answer.evaluations;
    counters.jacobians += answer.iterations;
    counters.factorisations += answer.iterations;
  }

  void race(const LaneStarts& starts, int attempts, std::uint64_t seed, KernelAnswer& answer) {
    solver.kernel_->race(solver.scaled_, prepared.task, prepared.target, starts, attempts, seed, answer);
    count(answer);
    counters.restarts += answer.attempts;
  }

  bool isNear() const {
    constexpr double near2 = 0.5;  // squared error, chain lengths and radians
    return solver.kernel_->error(solver.scaled_, prepared.task, prepared.target, start) < near2;
  }

  /// The start's own descent; where it fails or leads far away, starts close to it.
  void nearStart() {
    KernelTask task = prepared.task;
    if (options.restarts == 0) task.attemptIterations = std::clamp(options.maxIterations, 1, 30);
    solver.kernel_->attempt(solver.scaled_, task, prepared.target, start, found);
    count(found);
    if (options.restarts == 0 || solver.jump(start, found) <= options.method.farJump) return;
    LaneStarts starts;
    solver.nudge(start, options.method.nudge, options.seed, starts);
    KernelAnswer other;
    race(starts, std::min(options.restarts, kernelLanes), options.seed, other);
    if (solver.jump(start, other) < solver.jump(start, found)) found = other;
  }

  /// The race: the given starts, the problem's own, then random ones, in portions to look at the clock in
  /// between.
  void anywhere(LaneStarts& starts) {
    if (starts.valid != (1 << kernelLanes) - 1) {
      const int lane = __builtin_ctz(~starts.valid);
      for (int i = 0; i < solver.chain_.n; ++i) starts.q[i][lane] = static_cast<float>(start[i]);
      starts.valid |= 1 << lane;
    }
    std::uint64_t seed = options.seed;
    Clock::time_point begin;
    for (int left = options.restarts; left > 0;) {
      const int portion = std::min(left, 64);
      race(starts, portion, seed, found);
      if (found.solved) return;
      if (left == options.restarts)
        begin = Clock::now();  // a portion takes microseconds: the clock is for those that need many
      left -= portion;
      starts.valid = 0;
      seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
      if (std::chrono::duration<double>(Clock::now() - begin).count() > options.maxSeconds) return;
    }
  }
};

SerialPoseAnswer SerialPoseSolver::solve(const TipGoal& goal, const ChainVector& wantedStart,
                                         const SerialPoseOptions& options) const {
  const int n = chain_.n;
  if (!wantedStart.allFinite() || !goal.target.allFinite() || !goal.orientation.allFinite())
    throw std::invalid_argument("the start and the goal of a solve must be finite numbers");
  ChainVector start = wantedStart;
  for (int i = 0; i < n; ++i) start[i] = std::clamp(start[i], chain_.lower[i], chain_.upper[i]);
  Search search{.solver = *this, .options = options, .prepared = prepare(goal, options)};
  for (int i = 0; i < n; ++i) {
    search.start[i] = scaled_.revolute[i] != 0.0 ? start[i] : start[i] / chain_.length;
    if (chain_.wraps[i] && std::abs(start[i]) > 100.0) search.start[i] = std::remainder(start[i], 2.0 * M_PI);
  }
  if (options.restarts == 0 || search.isNear()) search.nearStart();
  if (!search.found.solved && options.restarts > 0) {
    LaneStarts starts;
    if (table_ && goal.kind == GoalKind::Pose)
      table_->lookUp(scaled_, *kernel_, search.prepared.target, starts);
    search.anywhere(starts);
  }

  const KernelAnswer& found = search.found;
  SerialPoseAnswer answer;
  answer.q = start;
  answer.from = start;
  const bool hasPose = found.error2 < 1e299;
  if (hasPose) {
    for (int i = 0; i < n; ++i) answer.q[i] = found.q[i];
    toLimits(answer.q.data(), start.data());
  }
  if (found.solved || !options.closestPose) {
    answer.why = found.solved ? Stop::Converged : Stop::Stalled;
    if (found.solved)
      for (int i = 0; i < n; ++i)
        answer.from[i] = found.start[i] * (scaled_.revolute[i] != 0.0 ? 1.0 : chain_.length);
    reportErrors(goal, search.prepared, found, answer);
    answer.counters = search.counters;
  } else {
    const ChainVector best = answer.q;
    answer = closest(goal, start, options);
    if (hasPose) {
      SerialPoseAnswer fromBest = closest(goal, best, options);
      const auto cost = [](const SerialPoseAnswer& a) {
        return std::hypot(a.positionError, a.orientationError);
      };
      fromBest.from = best;
      if ((fromBest.why == Stop::Converged && answer.why != Stop::Converged) ||
          cost(fromBest) < 0.99 * cost(answer))
        answer = std::move(fromBest);
    }
    answer.counters += search.counters;
  }
  return answer;
}

/// The judge's errors. Of a small error the kernel's own values say the same to the last digits: the point
/// hangs on a lever.
void SerialPoseSolver::reportErrors(const TipGoal& goal, const Prepared& prepared, const KernelAnswer& found,
                                    SerialPoseAnswer& answer) const {
  if (found.solved && found.error2 < 1e-10) {
    const Vector3d e(found.e), w(found.w);
    Vector3d lever = Vector3d::Zero();  // from the last frame's origin to the point, base frame
    if (goal.kind == GoalKind::Pose) {
      Matrix3d wanted;
      wanted << Vector3d(prepared.target.x), Vector3d(prepared.target.y), Vector3d(prepared.target.z);
      lever = wanted * (chain_.lastFromTip * goal.pointInTip);
    }
    answer.positionError = (chain_.length * e + w.cross(lever)).norm();
    answer.orientationError = w.norm();
    return;
  }
  ChainJacobian J;
  const TipError error = tipError(goal, frameAndJacobian(answer.q, J));
  answer.positionError = error.position.norm();
  answer.orientationError = error.rotation.norm();
}

/// Newton on half the judge's squared error with the exact Hessian, joints at walls taken out while the slope
/// pushes them outward, a shift that grows until the step is downhill and shrinks when it is good.
SerialPoseAnswer SerialPoseSolver::closest(const TipGoal& goal, const ChainVector& start,
                                           const SerialPoseOptions& options) const {
  const int n = chain_.n;
  const bool position = hasPosition(goal.kind), rotation = hasOrientation(goal.kind);
  SerialPoseAnswer answer;
  answer.q = answer.from = start;
  answer.why = Stop::Budget;
  ChainJacobian J(6, n), moved(6, n);
  ChainMatrix H(n, n);
  const auto evaluate = [&](const ChainVector& q, ChainJacobian& jacobian) {
    const Isometry3d tip = frameAndJacobian(q, jacobian);
    const Vector3d arm = tip.linear() * goal.pointInTip;
    for (int i = 0; i < n; ++i) {
      if (position) jacobian.col(i).head<3>() += jacobian.col(i).tail<3>().cross(arm);
    }
    ++answer.counters.forwardKinematics;
    ++answer.counters.jacobians;
    return tipError(goal, tip);
  };
  const auto slopeOf = [&](const ChainJacobian& jacobian, const TipError& error) {
    Twist both;
    both << error.position, error.rotation;  // a part that is not asked for is zero
    return ChainVector(jacobian.transpose() * both);
  };
  const auto isLocked = [&](const ChainVector& q, const ChainVector& slope, int i) {
    if (chain_.wraps[i]) return false;
    return (q[i] <= chain_.lower[i] && slope[i] < 0.0) || (q[i] >= chain_.upper[i] && slope[i] > 0.0);
  };
  const auto freeSlope = [&](const ChainVector& q, const ChainVector& slope) {
    double largest = 0.0;
    for (int i = 0; i < n; ++i)
      if (!isLocked(q, slope, i)) largest = std::max(largest, std::abs(slope[i]));
    return largest;
  };
  TipError error = evaluate(answer.q, J);
  ChainVector slope = slopeOf(J, error);
  double shift = 1e-6;
  // Where no slope is left: the lowest second derivative on the joints that are not locked, and its
  // direction.
  const auto lowestCurvature = [&](bool lockTouched, ChainVector& way) {
    exactHessian(J, error, position, rotation, H);
    ++answer.counters.hessians;
    const double size = H.cwiseAbs().maxCoeff();
    for (int i = 0; i < n; ++i) {
      const bool touches =
          !chain_.wraps[i] && (answer.q[i] <= chain_.lower[i] || answer.q[i] >= chain_.upper[i]);
      if (!isLocked(answer.q, slope, i) && !(lockTouched && touches)) continue;
      H.row(i).setZero();
      H.col(i).setZero();
    }
    const Eigen::SelfAdjointEigenSolver<ChainMatrix> eigen(H);
    way = eigen.eigenvectors().col(0);
    Eigen::Index largest = 0;
    way.cwiseAbs().maxCoeff(&largest);
    if (way[largest] < 0.0) way = -way;  // the same way on every machine
    const double lowest = eigen.eigenvalues()[0];
    return lowest < -1e-7 * size ? lowest : 0.0;
  };
  /// On from a saddle to a lower place; false, and why, where this is a place to rest.
  const auto leaveSaddle = [&] {
    ChainVector way(n);
    const double curvature = lowestCurvature(false, way);
    const ChainVector from = answer.q;
    for (double length = 0.5; curvature < 0.0 && length > 1e-4; length *= 0.5) {
      double lowest = error.squared() + 0.5 * curvature * length * length;  // half of what is promised
      bool found = false;
      for (const double sign : {1.0, -1.0}) {
        ChainVector q = from + sign * length * way;
        for (int i = 0; i < n; ++i)
          if (!chain_.wraps[i]) q[i] = std::clamp(q[i], chain_.lower[i], chain_.upper[i]);
        const TipError there = evaluate(q, moved);
        if (!(there.squared() < lowest)) continue;
        lowest = there.squared();
        answer.q = q;
        found = true;
      }
      if (!found) continue;
      error = evaluate(answer.q, J);
      slope = slopeOf(J, error);
      return true;
    }
    answer.why = curvature < 0.0 && lowestCurvature(true, way) < 0.0 ? Stop::Saddle : Stop::Stationary;
    return false;
  };
  for (int iteration = 0;; ++iteration) {
    if ((!position || error.position.norm() <= margin * options.positionTolerance) &&
        (!rotation || error.rotation.norm() <= margin * options.orientationTolerance)) {
      answer.why = Stop::Converged;
      break;
    }
    if (freeSlope(answer.q, slope) < 1e-11 * (1.0 + chain_.length)) {
      if (!leaveSaddle() || iteration == options.maxIterations) break;
      ++answer.counters.iterations;
      continue;
    }
    if (iteration == options.maxIterations) break;
    ++answer.counters.iterations;
    ++answer.counters.hessians;
    exactHessian(J, error, position, rotation, H);
    bool improved = false;
    for (int trial = 0; trial < 30 && !improved; ++trial) {
      ChainMatrix A = H;
      ChainVector step = slope;
      for (int i = 0; i < n; ++i) {
        if (isLocked(answer.q, slope, i)) {
          A.row(i).setZero();
          A.col(i).setZero();
          A(i, i) = 1.0;
          step[i] = 0.0;
        } else {
          A(i, i) += shift;
        }
      }
      ++answer.counters.factorisations;
      const Eigen::LLT<ChainMatrix> factor(A);
      if (factor.info() == Eigen::Success) {
        factor.solveInPlace(step);
        const double longest = step.cwiseAbs().maxCoeff();
        if (longest > 1.5) step *= 1.5 / longest;
        ChainVector q = answer.q + step;
        for (int i = 0; i < n; ++i)
          if (!chain_.wraps[i]) q[i] = std::clamp(q[i], chain_.lower[i], chain_.upper[i]);
        const TipError there = evaluate(q, moved);
        const ChainVector slopeThere = slopeOf(moved, there);
        // Close to the bottom the cost no longer resolves; there the slope must fall instead.
        const bool resolves = std::abs(there.squared() - error.squared()) > 1e-13 * error.squared();
        improved = resolves ? there.squared() < error.squared()
                            : freeSlope(q, slopeThere) < freeSlope(answer.q, slope);
        if (improved) {
          answer.q = q;
          error = there;
          J = moved;
          slope = slopeThere;
          shift = std::max(0.1 * shift, 1e-12);
          break;
        }
      }
      shift = std::max(4.0 * shift, 1e-3 * slope.norm());
    }
    if (!improved) {
      answer.why = Stop::Stalled;
      if (freeSlope(answer.q, slope) < 1e-6 * (1.0 + chain_.length) && leaveSaddle()) continue;
      break;
    }
  }
  for (int i = 0; i < n; ++i)
    if (chain_.wraps[i]) answer.q[i] = nearestWithin(answer.q[i], start[i], chain_.lower[i], chain_.upper[i]);
  answer.positionError = error.position.norm();
  answer.orientationError = error.rotation.norm();
  return answer;
}

void SerialPoseSolver::solveBatch(std::span<const Isometry3d> worldFromTip, std::span<const double> starts,
                                  std::span<KernelAnswer> answers, const SerialPoseOptions& options) const {
  const int n = chain_.n, count = static_cast<int>(worldFromTip.size());
  if (answers.size() != worldFromTip.size() || starts.size() != worldFromTip.size() * static_cast<size_t>(n))
    throw std::invalid_argument("a batch needs one answer and n start angles for each of its targets");
  constexpr int block = 4096, most = 4;
  std::vector<KernelTarget> targets(std::min(block, count));
  std::vector<double> seeds(targets.size() * most * n);
  TipGoal goal;
  const KernelTask task = prepare(goal, options).task;
  for (int first = 0; first < count; first += block) {
    const int size = std::min(block, count - first), each = table_ ? most : 1;
    for (int i = 0; i < size; ++i) {
      goal.target = worldFromTip[first + i].translation();
      goal.orientation = worldFromTip[first + i].linear();
      targets[i] = kernelTarget(goal);
      double* row = &seeds[static_cast<size_t>(i) * each * n];
      int given = 0;
      if (table_) {
        LaneStarts looked;
        table_->lookUp(scaled_, *kernel_, targets[i], looked);
        for (int valid = looked.valid; valid && given < each; valid &= valid - 1, ++given, row += n)
          for (int k = 0; k < n; ++k) row[k] = looked.q[k][__builtin_ctz(valid)];
      }
      for (; given < each; ++given, row += n)  // where the table is short: the caller's start
        for (int k = 0; k < n; ++k)
          row[k] = starts[static_cast<size_t>(first + i) * n + k] /
                   (scaled_.revolute[k] != 0.0 ? 1.0 : chain_.length);
    }
    kernel_->batch(scaled_, task, targets.data(), size, seeds.data(), each, 1 + options.restarts,
                   options.seed + first, &answers[first]);
    for (int i = 0; i < size; ++i)
      toLimits(answers[first + i].q, &starts[static_cast<size_t>(first + i) * n]);
  }
}

namespace {

/// The solver interface around SerialPoseSolver. prepare() keeps a solver for every joint that ends a chain;
/// a solve for another skeleton, or without prepare, extracts its chain on the spot.
class SerialPose final : public IkSolver {
 public:
  SerialPose(bool withTable, const SerialPoseParameters& parameters)
      : withTable_(withTable), parameters_(parameters) {}

  void prepare(const Skeleton& skeleton) override {
    prepared_ = skeleton.joints();
    solvers_.clear();
    solvers_.resize(skeleton.jointCount());
    reasons_.assign(skeleton.jointCount(), {});
    for (int j = 0; j < skeleton.jointCount(); ++j) {
      SerialChainResult result = extractSerialChain(skeleton, j);
      reasons_[j] = result.whyNot;
      if (!result.whyNot.empty()) continue;
      solvers_[j] = std::make_unique<SerialPoseSolver>(std::move(result.chain));
      if (withTable_ && skeleton.children(j).empty()) solvers_[j]->buildSeedTable();
    }
  }

  std::string whyUnsupported(const IkProblem& problem) const override {
    if (problem.goals.size() != 1)
      return "solves exactly one goal, not " + std::to_string(problem.goals.size());
    const Goal& goal = problem.goals.front();
    if (!hasPosition(goal.kind) && !hasOrientation(goal.kind))
      return "solves position, orientation and pose goals only";
    return isPreparedFor(*problem.skeleton) ? reasons_[goal.joint]
                                            : extractSerialChain(*problem.skeleton, goal.joint).whyNot;
  }

  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const override {
    const auto begin = Clock::now();
    IkReport report;
    report.q = problem.start;
    report.why = Stop::Unsupported;
    if (problem.goals.size() != 1) return report;
    const Goal& goal = problem.goals.front();
    if (!hasPosition(goal.kind) && !hasOrientation(goal.kind)) return report;
    const SerialPoseSolver* solver = nullptr;
    std::unique_ptr<SerialPoseSolver> fresh;
    if (isPreparedFor(*problem.skeleton)) {
      solver = solvers_[goal.joint].get();
    } else {
      SerialChainResult result = extractSerialChain(*problem.skeleton, goal.joint);
      if (result.whyNot.empty()) fresh = std::make_unique<SerialPoseSolver>(std::move(result.chain));
      solver = fresh.get();
    }
    if (!solver) return report;
    run(*solver, problem, budget, trace, report);
    report.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    return report;
  }

 private:
  void run(const SerialPoseSolver& solver, const IkProblem& problem, const Budget& budget, TraceLevel trace,
           IkReport& report) const {
    const Goal& goal = problem.goals.front();
    const SerialChain& chain = solver.chain();
    TipGoal tip{.kind = goal.kind,
                .pointInTip = goal.pointInJoint,
                .target = goal.target,
                .orientation = goal.orientation.normalized().toRotationMatrix()};
    ChainVector start(chain.n);
    for (int i = 0; i < chain.n; ++i) start[i] = problem.start[chain.qIndex[i]];
    report.why = Stop::Failure;
    if (!start.allFinite() || !tip.target.allFinite() || !tip.orientation.allFinite()) return;
    report.q = projectToLimits(*problem.skeleton, problem.start);
    const SerialPoseAnswer answer = solver.solve(tip, start,
                                                 {.positionTolerance = problem.positionTolerance,
                                                  .orientationTolerance = problem.orientationTolerance,
                                                  .restarts = budget.restarts,
                                                  .maxIterations = budget.maxIterations,
                                                  .maxSeconds = budget.maxSeconds,
                                                  .seed = budget.seed,
                                                  .method = parameters_});
    for (int i = 0; i < chain.n; ++i) report.q[chain.qIndex[i]] = answer.q[i];
    problem.skeleton->couple(report.q);
    report.why = answer.why;
    report.counters = answer.counters;
    report.residual = std::sqrt(goal.weight) * std::hypot(answer.positionError, answer.orientationError);
    if (trace == TraceLevel::Off) return;
    recordPath(solver, tip, answer, problem, trace, report);
  }

  /// The inner loops keep no history: the descent that won is run again from its start, in double precision
  /// and a step longer each time.
  static void recordPath(const SerialPoseSolver& solver, const TipGoal& tip, const SerialPoseAnswer& answer,
                         const IkProblem& problem, TraceLevel trace, IkReport& report) {
    const SerialChain& chain = solver.chain();
    const double weight = std::sqrt(problem.goals.front().weight);
    VectorXd q = report.q, before = problem.start;
    const auto record = [&](const ChainVector& dofs) {
      ChainJacobian J;
      for (int i = 0; i < chain.n; ++i) q[chain.qIndex[i]] = dofs[i];
      problem.skeleton->couple(q);
      if (!report.trace.empty()) report.trace.back().stepNorm = (q - before).norm();
      before = q;
      report.trace.push_back(
          {.q = trace == TraceLevel::Full ? q : VectorXd(),
           .residual = weight * std::sqrt(tipError(tip, solver.frameAndJacobian(dofs, J)).squared())});
    };
    ChainVector start(chain.n);
    for (int i = 0; i < chain.n; ++i) start[i] = problem.start[chain.qIndex[i]];
    record(start);
    if (answer.from != start) record(answer.from);
    const bool newton = answer.why != Stop::Converged;
    for (int steps = 1; steps < 30; ++steps) {
      const SerialPoseOptions options{.restarts = 0, .maxIterations = steps, .closestPose = newton};
      const SerialPoseAnswer along =
          newton ? solver.closest(tip, answer.from, options) : solver.solve(tip, answer.from, options);
      if (along.why != Stop::Budget && along.why != Stop::Stalled) break;
      record(along.q);
    }
    record(answer.q);
  }

  bool isPreparedFor(const Skeleton& skeleton) const {
    return !prepared_.empty() && sameJoints(prepared_, skeleton.joints());
  }

  bool withTable_;
  SerialPoseParameters parameters_;
  std::vector<Joint> prepared_;
  std::vector<std::unique_ptr<SerialPoseSolver>> solvers_;
  std::vector<std::string> reasons_;
};

}  // namespace

std::unique_ptr<IkSolver> makeSerialPose(const SerialPoseParameters& parameters) {
  return std::make_unique<SerialPose>(false, parameters);
}
std::unique_ptr<IkSolver> makeSerialPoseTable(const SerialPoseParameters& parameters) {
  return std::make_unique<SerialPose>(true, parameters);
}

}  // namespace gelenk
