#include "kinematics/forward_kinematics.h"

#include <cmath>

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// R <- R * rotation(axis, angle). Coordinate axes, the usual case, mix two columns only.
inline void rotateColumns(Eigen::Ref<Matrix3d, 0, Eigen::OuterStride<>> R, const Vector3d& axis,
                          double angle) {
  const double s = std::sin(angle), c = std::cos(angle);
  for (int k = 0; k < 3; ++k) {
    if (std::abs(axis[k]) != 1.0) continue;
    const double sine = axis[k] * s;
    const int a = (k + 1) % 3, b = (k + 2) % 3;
    const Vector3d columnA = R.col(a);
    R.col(a) = c * columnA + sine * R.col(b);
    R.col(b) = c * R.col(b) - sine * columnA;
    return;
  }
  const Vector3d rotatedAxis = R * axis;  // Rodrigues, column by column in the rotated basis
  for (int k = 0; k < 3; ++k) {
    const Vector3d column = R.col(k);
    R.col(k) = c * column + s * rotatedAxis.cross(column) + (1.0 - c) * axis[k] * rotatedAxis;
  }
}

/// frame <- frame * motion of the joint, whose values begin at q.
inline void applyMotion(const Joint& joint, const double* q, Isometry3d& frame) {
  for (const AxisDof& dof : joint.axes) {
    if (dof.kind == AxisDof::Kind::Rotation)
      rotateColumns(frame.linear(), dof.axis, *q);
    else
      frame.translation() += *q * (frame.linear() * dof.axis);
    ++q;
  }
  if (joint.ball) {
    const Matrix3d R = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
    frame.linear() = (frame.linear() * R).eval();
  }
}

}  // namespace

void forwardKinematics(const Skeleton& skeleton, const Eigen::VectorXd& q, Frames& worldFromJoint) {
  worldFromJoint.resize(skeleton.jointCount());
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    Isometry3d& frame = worldFromJoint[i];
    if (joint.parent < 0) {
      frame = joint.parentFromZero;
    } else {
      const Isometry3d& parent = worldFromJoint[joint.parent];
      frame.linear().noalias() = parent.linear() * joint.parentFromZero.linear();
      frame.translation().noalias() = parent.linear() * joint.parentFromZero.translation();
      frame.translation() += parent.translation();
      frame.makeAffine();
    }
    applyMotion(joint, q.data() + skeleton.qIndex(i), frame);
  }
}

Frames forwardKinematics(const Skeleton& skeleton, const Eigen::VectorXd& q) {
  Frames frames;
  forwardKinematics(skeleton, q, frames);
  return frames;
}

Isometry3d jointMotion(const Skeleton& skeleton, const Eigen::VectorXd& q, int joint) {
  Isometry3d motion = Isometry3d::Identity();
  applyMotion(skeleton.joint(joint), q.data() + skeleton.qIndex(joint), motion);
  return motion;
}

Frames restFrames(const Skeleton& skeleton) { return forwardKinematics(skeleton, skeleton.rest()); }

double chainLength(const Skeleton& skeleton, int joint) {
  double length = 0.0;
  for (; skeleton.parent(joint) >= 0; joint = skeleton.parent(joint))
    length += skeleton.joint(joint).parentFromZero.translation().norm();
  return length;
}

}  // namespace gelenk
