#include "solvers/solutions/complete_set.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "solvers/solutions/lanes.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double turn = 2.0 * M_PI;

int conditions(TipTask task) { return task == TipTask::Pose ? 6 : task == TipTask::Axis ? 5 : 3; }

/// The arm with joints of no weight at the tip: first those that must end at zero, askew and off centre so
/// that they are in general position (where a joint slides, through a point of the last axis, so that they
/// make a wrist), then those that the task leaves free.
Skeleton padded(const Skeleton& skeleton, int tipJoint, const SerialChain& chain,
                const CompleteSetTask& task) {
  std::vector<Joint> all;
  for (int j = 0; j < skeleton.jointCount(); ++j) all.push_back(skeleton.joint(j));
  double reach = 0.0;
  for (int j = tipJoint; j >= 0; j = skeleton.parent(j)) reach += all[j].parentFromZero.translation().norm();
  reach = std::max(reach, 1e-3) / 4.0;
  Isometry3d tipFromLast = Isometry3d::Identity();
  int last = tipJoint;
  const auto append = [&](const Isometry3d& tipFromJoint, const Vector3d& axis) {
    all.push_back({.name = "no weight " + std::to_string(all.size()),
                   .parent = last,
                   .parentFromZero = tipFromLast.inverse(Eigen::Isometry) * tipFromJoint,
                   .axes = {{AxisDof::Kind::Rotation, axis, -unlimited, unlimited}}});
    last = static_cast<int>(all.size()) - 1;
    tipFromLast = tipFromJoint;
  };
  const Vector3d askew[5] = {
      {0.36, 0.48, 0.8}, {-0.6, 0.64, 0.48}, {0.48, -0.8, 0.36}, {0.8, 0.36, -0.48}, {-0.48, -0.6, 0.64}};
  const Vector3d places[5] = {{0.31, -0.17, 0.23},
                              {-0.11, 0.29, 0.37},
                              {0.23, 0.19, -0.41},
                              {-0.37, -0.31, 0.13},
                              {0.17, -0.43, -0.29}};
  Isometry3d frame = Isometry3d::Identity();
  for (int i = chain.n; i < conditions(task.task); ++i) {
    frame.translation() = chain.hasPrismatic
                              ? Vector3d(chain.lastFromTip.inverse(Eigen::Isometry).translation())
                              : Vector3d(task.pointInTip + reach * places[i - chain.n]);
    append(frame, askew[i - chain.n].normalized());
  }
  frame.translation() = task.pointInTip;
  if (task.task == TipTask::Axis) append(frame, task.axisInTip);
  if (task.task == TipTask::Position)
    for (int k = 0; k < 3; ++k) append(frame, Vector3d::Unit(k));
  // The frame asked for: that of the point, in the tip's axes.
  all.push_back(
      {.name = "asked", .parent = last, .parentFromZero = tipFromLast.inverse(Eigen::Isometry) * frame});
  return Skeleton(all);
}

SerialChain chainOf(const Skeleton& skeleton, int tipJoint, const CompleteSetTask& task) {
  const std::string reason = CompleteSet::whyNot(skeleton, tipJoint, task);
  if (!reason.empty()) throw std::invalid_argument(reason);
  return extractSerialChain(skeleton, tipJoint).chain;
}

SixJointArm armOf(const Skeleton& skeleton, int tipJoint, const SerialChain& chain,
                  const CompleteSetTask& task) {
  const Skeleton longer = padded(skeleton, tipJoint, chain, task);
  const SerialChainResult result = extractSerialChain(longer, longer.jointCount() - 1);
  if (!result.whyNot.empty()) throw std::invalid_argument(result.whyNot);
  return SixJointArm(result.chain);
}

/// The tip's point and axes, world, and how they move with each joint: the place over the arm's length, then
/// what the task asks of the orientation.
struct Motion {
  Isometry3d tip;
  Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, 8> J;
};

Motion motionOf(const SerialChain& chain, const CompleteSetTask& task, const VectorXd& q) {
  const ChainConstants& C = chain.constants;
  Motion motion;
  motion.J.resize(6, chain.n);
  std::array<Vector3d, 8> axis, origin;
  Isometry3d frame = chain.worldFromBase;
  for (int i = 0; i < chain.n; ++i) {
    Isometry3d link = Isometry3d::Identity();
    link.linear() << 1, 0, 0, 0, C.cosAlpha[i], -C.sinAlpha[i], 0, C.sinAlpha[i], C.cosAlpha[i];
    const double shift = C.d[i] + (1.0 - C.revolute[i]) * q[i];
    link.translation() = Vector3d(C.a[i], 0, 0) + link.linear().col(2) * shift;
    frame = frame * link;
    axis[i] = frame.linear().col(2);
    origin[i] = frame.translation();
    frame.rotate(Eigen::AngleAxisd(C.theta[i] + C.revolute[i] * q[i], Vector3d::UnitZ()));
  }
  motion.tip = frame * chain.lastFromTip;
  motion.tip.translation() = motion.tip * task.pointInTip;
  for (int i = 0; i < chain.n; ++i) {
    const bool turns = C.revolute[i] > 0.5;
    Vector3d turn = turns ? axis[i] : Vector3d::Zero();
    const Vector3d way = turns ? axis[i].cross(motion.tip.translation() - origin[i]) : axis[i];
    if (task.task == TipTask::Position) turn.setZero();
    if (task.task == TipTask::Axis) turn = turn.cross(motion.tip.linear() * task.axisInTip).eval();
    motion.J.col(i) << way / chain.length, turn;
  }
  return motion;
}

Singularity leastMotion(const Eigen::MatrixXd& J, int conditions) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(J, Eigen::ComputeFullV);
  const int n = static_cast<int>(J.cols());
  return {svd.singularValues()[std::min(conditions, n) - 1], svd.matrixV().col(n - 1)};
}

/// leastMotion of the joints that move what is asked for at all; `still` tells the others, bit by bit.
Singularity leastMotionOf(const Motion& motion, unsigned& still) {
  const int n = static_cast<int>(motion.J.cols());
  std::vector<int> moving;
  still = 0;
  for (int i = 0; i < n; ++i)
    if (motion.J.col(i).norm() > 1e-9)
      moving.push_back(i);
    else
      still |= 1u << i;
  if (moving.empty()) return {1.0, VectorXd::Zero(n)};
  const Singularity least =
      leastMotion(Eigen::MatrixXd(motion.J)(Eigen::all, moving), static_cast<int>(moving.size()));
  Singularity all{least.sigmaMin, VectorXd::Zero(n)};
  all.direction(moving) = least.direction;
  return all;
}

/// Whether the joints can move and leave what is asked for wherever the arm stands: axes in line, more joints
/// in a plane than it has conditions.
bool hasCurvesEverywhere(const SerialChain& chain, const CompleteSetTask& task) {
  for (int k = 1; k <= 3; ++k) {
    VectorXd q(chain.n);
    for (int i = 0; i < chain.n; ++i) q[i] = std::sin(2.0 * k + 3.0 * i + 0.5);
    unsigned still;
    if (leastMotionOf(motionOf(chain, task, q), still).sigmaMin > 1e-9) return false;
  }
  return true;
}

/// How far the task's point can be from the base at most.
double reachOf(const SerialChain& chain, const CompleteSetTask& task) {
  const ChainConstants& C = chain.constants;
  double reach = (chain.lastFromTip * task.pointInTip).norm();
  for (int i = 0; i < chain.n; ++i) {
    const double slide =
        C.revolute[i] > 0.5 ? 0.0 : std::max(std::abs(chain.lower[i]), std::abs(chain.upper[i]));
    reach += std::hypot(C.a[i], std::abs(C.d[i]) + slide);
  }
  return reach;
}

/// What is missing at the tip, in the rows of Motion.
Vector6d missing(const SerialChain& chain, const CompleteSetTask& task, const Isometry3d& target,
                 const Isometry3d& tip) {
  Vector6d r = Vector6d::Zero();
  r.head<3>() = (target.translation() - tip.translation()) / chain.length;
  if (task.task == TipTask::Pose) {
    const Eigen::AngleAxisd turn(Matrix3d(target.linear() * tip.linear().transpose()));
    r.tail<3>() = turn.angle() * turn.axis();
  }
  if (task.task == TipTask::Axis) r.tail<3>() = (target.linear() - tip.linear()) * task.axisInTip;
  return r;
}

constexpr double reachedError = 1e-11;  ///< lengths of the arm and radians

/// Levenberg and Marquardt from q; with a direction the way along it from the start is one more condition.
bool approach(const SerialChain& chain, const CompleteSetTask& task, const Isometry3d& target, VectorXd& q,
              const VectorXd* along = nullptr, double way = 0.0) {
  using Rows = Eigen::Matrix<double, 7, Eigen::Dynamic, Eigen::ColMajor, 7, 8>;
  const VectorXd start = q;
  const auto errorAt = [&](const VectorXd& at, const Motion& motion) {
    Eigen::Matrix<double, 7, 1> r;
    r << missing(chain, task, target, motion.tip), along ? way - along->dot(at - start) : 0.0;
    return r;
  };
  Motion motion = motionOf(chain, task, q);
  Eigen::Matrix<double, 7, 1> r = errorAt(q, motion);
  double damping = 1e-2;
  for (int step = 0; step < 80 && r.norm() > reachedError && damping < 1e8; ++step) {
    Rows A(7, chain.n);
    A << motion.J, along ? Eigen::RowVectorXd(along->transpose()) : Eigen::RowVectorXd::Zero(chain.n);
    Eigen::MatrixXd normal = A.transpose() * A;
    normal.diagonal().array() += damping * r.squaredNorm();
    const VectorXd next = q + normal.ldlt().solve(A.transpose() * r);
    const Motion there = motionOf(chain, task, next);
    const Eigen::Matrix<double, 7, 1> after = errorAt(next, there);
    if (after.norm() < r.norm()) {
      q = next, motion = there, r = after;
      damping *= 0.3;
    } else {
      damping *= 8.0;
    }
  }
  return r.norm() <= reachedError;
}

/// Whether the last joint turns about the very axis that the task asks for: it may stand anywhere, and the
/// pose asked for decides nothing more than the axis.
bool rollsAboutTheAxis(const SerialChain& chain, const CompleteSetTask& task) {
  if (task.task != TipTask::Axis || chain.constants.revolute[chain.n - 1] < 0.5) return false;
  const Vector3d point = chain.lastFromTip * task.pointInTip,
                 axis = chain.lastFromTip.linear() * task.axisInTip;
  return point.head<2>().norm() < 1e-9 * chain.length && axis.head<2>().norm() < 1e-9;
}

CompleteSetTask asTheArmSolvesIt(const SerialChain& chain, CompleteSetTask task) {
  if (rollsAboutTheAxis(chain, task)) task.task = TipTask::Pose;
  return task;
}

}  // namespace

std::string CompleteSet::whyNot(const Skeleton& skeleton, int tipJoint, const CompleteSetTask& task) {
  const SerialChainResult result = extractSerialChain(skeleton, tipJoint);
  if (!result.whyNot.empty()) return result.whyNot;
  const int most = conditions(task.task), n = result.chain.n;
  if (n > most)
    return "the chain has " + std::to_string(n) + " joints for " + std::to_string(most) +
           " conditions: its solutions are families, not a finite set";
  if (result.chain.hasPrismatic) try {
      armOf(skeleton, tipJoint, result.chain, task);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
  return "";
}

CompleteSet::CompleteSet(const Skeleton& skeleton, int tipJoint, const CompleteSetTask& task)
    : task_(task),
      chain_(chainOf(skeleton, tipJoint, task)),
      solved_(asTheArmSolvesIt(chain_, task)),
      arm_(armOf(skeleton, tipJoint, chain_, solved_)),
      reach_(reachOf(chain_, task)),
      mayBeBlind_(chain_.n < 6 && (chain_.hasPrismatic || hasCurvesEverywhere(chain_, task))) {}

void CompleteSet::solve(const Isometry3d& target, const Vector6d& reference, ArmSolutions& out) const {
  arm_.solve(target, reference, out);
  const int n = chain_.n, bound = conditions(solved_.task);
  if (n == 6) return;
  int kept = 0;
  for (int k = 0; k < out.count; ++k) {
    ArmSolution s = out.list[k];
    bool own = true;
    for (int i = n; i < bound; ++i) own &= std::abs(std::remainder(s.q[i], 2.0 * M_PI)) < 1e-7;
    if (!own) continue;
    s.q.tail(6 - n).setZero();
    s.free &= static_cast<unsigned char>((1u << n) - 1u);
    tellFamily(target, reference, s, out);
    if (!isThere(out, kept, s.q)) out.list[kept++] = s;
  }
  out.count = kept;
  const double away = (target.translation() - chain_.worldFromBase.translation()).norm();
  if (kept == 0 && mayBeBlind_ && away < reach_ + 1e-9 * chain_.length) search(target, reference, out);
}

/// The same arm with another turn of what is free.
bool CompleteSet::isThere(const ArmSolutions& out, int count, const Vector6d& q) const {
  for (int i = 0; i < count; ++i) {
    double apart = 0.0;
    for (int j = 0; j < chain_.n; ++j) {
      const double d = out.list[i].q[j] - q[j];
      apart = std::max(apart, std::abs(chain_.constants.revolute[j] > 0.5 ? std::remainder(d, turn) : d));
    }
    if (apart <= 1e-7) return true;
  }
  return false;
}

/// Joints that do not move what is asked for take the reference's value. Where joints can move together and
/// the target stays reached the solution is one of a curve, of which others may be missing.
void CompleteSet::tellFamily(const Isometry3d& target, const Vector6d& reference, ArmSolution& s,
                             ArmSolutions& out) const {
  constexpr double singular = 1e-6;
  const int n = chain_.n;
  unsigned still;
  const Singularity where = leastMotionOf(motionOf(chain_, task_, s.q.head(n)), still);
  for (int i = 0; i < n; ++i)
    if (still >> i & 1) s.q[i] = std::clamp(reference[i], chain_.lower[i], chain_.upper[i]);
  s.free |= static_cast<unsigned char>(still);
  s.withinLimits = true;
  for (int i = 0; i < n; ++i)
    s.withinLimits &= s.q[i] >= chain_.lower[i] - 1e-9 && s.q[i] <= chain_.upper[i] + 1e-9;
  if (where.sigmaMin > singular) return;
  for (const double way : {0.01, -0.01}) {
    VectorXd q = s.q.head(n);
    if (!approach(chain_, task_, target, q, &where.direction, way)) continue;
    for (int i = 0; i < n; ++i)
      if (std::abs(where.direction[i]) > singular) s.free |= static_cast<unsigned char>(1u << i);
    out.complete = false;
    return;
  }
}

/// Where the elimination found nothing and may be blind. One solution is looked for from the reference and
/// from places spread over the ranges.
void CompleteSet::search(const Isometry3d& target, const Vector6d& reference, ArmSolutions& out) const {
  constexpr int starts = 24;
  const int n = chain_.n;
  for (int k = 0; k < starts; ++k) {
    VectorXd q = reference.head(n);
    for (int i = 0; i < n && k > 0; ++i) {
      const double lower = std::max(chain_.lower[i], q[i] - M_PI),
                   upper = std::min(chain_.upper[i], q[i] + M_PI),
                   share = std::fmod(k * std::sqrt(i + 2.0), 1.0);
      q[i] = lower + share * std::max(upper - lower, 0.0);
    }
    if (!approach(chain_, task_, target, q)) continue;
    ArmSolution s;
    s.q.setZero();
    s.q.head(n) = q;
    s.error = missing(chain_, task_, target, motionOf(chain_, task_, q).tip).norm();
    for (int i = 0; i < n; ++i)
      if (chain_.constants.revolute[i] > 0.5)
        lanes::toNearestImage(s.q[i], chain_.lower[i], chain_.upper[i], reference[i]);
    tellFamily(target, reference, s, out);
    out.complete = false;
    if (out.count == 0 || s.withinLimits) out.list[0] = s, out.count = 1;
    if (s.withinLimits) return;
  }
}

Singularity singularity(const SerialChain& chain, const VectorXd& q) {
  return leastMotion(motionOf(chain, {}, q).J, 6);
}

Singularity CompleteSet::singularity(const VectorXd& q) const {
  return leastMotion(motionOf(chain_, task_, q).J, conditions(task_.task));
}

}  // namespace gelenk
