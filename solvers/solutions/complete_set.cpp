#include "solvers/solutions/complete_set.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

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
    : task_(task), chain_(chainOf(skeleton, tipJoint, task)), arm_(armOf(skeleton, tipJoint, chain_, task)) {}

void CompleteSet::solve(const Isometry3d& target, const Vector6d& reference, ArmSolutions& out) const {
  arm_.solve(target, reference, out);
  const int n = chain_.n, bound = conditions(task_.task);
  if (n == 6) return;
  int kept = 0;
  for (int k = 0; k < out.count; ++k) {
    ArmSolution s = out.list[k];
    bool own = true;
    for (int i = n; i < bound; ++i) own &= std::abs(std::remainder(s.q[i], 2.0 * M_PI)) < 1e-7;
    if (!own) continue;
    s.q.tail(6 - n).setZero();
    s.free &= static_cast<unsigned char>((1u << n) - 1u);
    for (int i = 0; i < kept && own; ++i) {  // the same arm with another turn of what is free
      double apart = 0.0;
      for (int j = 0; j < n; ++j)
        apart = std::max(apart, chain_.constants.revolute[j] > 0.5
                                    ? std::abs(std::remainder(out.list[i].q[j] - s.q[j], 2.0 * M_PI))
                                    : std::abs(out.list[i].q[j] - s.q[j]));
      own = apart > 1e-7;
    }
    if (own) out.list[kept++] = s;
  }
  out.count = kept;
}

Singularity singularity(const SerialChain& chain, const VectorXd& q) {
  const ChainConstants& C = chain.constants;
  Eigen::Matrix<double, 6, Eigen::Dynamic> J(6, chain.n);
  std::vector<Vector3d> axis, origin;
  Isometry3d frame = Isometry3d::Identity();
  for (int i = 0; i < chain.n; ++i) {
    Isometry3d link = Isometry3d::Identity();
    link.linear() << 1, 0, 0, 0, C.cosAlpha[i], -C.sinAlpha[i], 0, C.sinAlpha[i], C.cosAlpha[i];
    const double shift = C.d[i] + (1.0 - C.revolute[i]) * q[i];
    link.translation() = Vector3d(C.a[i], 0, 0) + link.linear().col(2) * shift;
    frame = frame * link;
    axis.push_back(frame.linear().col(2));
    origin.push_back(frame.translation());
    frame.rotate(Eigen::AngleAxisd(C.theta[i] + C.revolute[i] * q[i], Vector3d::UnitZ()));
  }
  const Vector3d tip = frame * chain.lastFromTip.translation();
  for (int i = 0; i < chain.n; ++i) {
    if (C.revolute[i] > 0.5)
      J.col(i) << axis[i].cross(tip - origin[i]) / chain.length, axis[i];
    else
      J.col(i) << axis[i] / chain.length, Vector3d::Zero();
  }
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(J, Eigen::ComputeFullV);
  const int rank = std::min(6, chain.n);
  return {svd.singularValues()[rank - 1], svd.matrixV().col(chain.n - 1)};
}

}  // namespace gelenk
