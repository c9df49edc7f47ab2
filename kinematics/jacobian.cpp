#include "kinematics/jacobian.h"

namespace gelenk {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// Turning about the unit axis through point moves the world's origin with omega x (0 - point) = point x
/// omega.
inline void putRotation(Twists& twists, int column, const Vector3d& axis, const Vector3d& point) {
  twists.col(column).head<3>() = point.cross(axis);
  twists.col(column).tail<3>() = axis;
}

/// Calls visit(column) for every tangent dimension on the path from the joint to the root.
template <typename Visit>
inline void forEachDofAbove(const Skeleton& skeleton, int joint, Visit visit) {
  for (; joint >= 0; joint = skeleton.parent(joint))
    for (int k = 0; k < skeleton.vCount(joint); ++k) visit(skeleton.vIndex(joint) + k);
}

/// Calls visit(column of the twist, column of its source) for every follower on the path.
template <typename Visit>
inline void forEachFollowerAbove(const Skeleton& skeleton, int joint, Visit visit) {
  const std::vector<int>& followers = skeleton.followers();
  for (std::size_t k = 0; k < followers.size(); ++k)
    if (skeleton.isAncestor(followers[k], joint))
      visit(skeleton.nv() + static_cast<int>(k), skeleton.vIndex(followers[k]));
}

}  // namespace

void dofTwists(const Skeleton& skeleton, const VectorXd& q, const Frames& frames, Twists& twists) {
  const int followers = static_cast<int>(skeleton.followers().size());
  int follower = skeleton.nv();
  twists.resize(6, skeleton.nv() + followers);
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    const int axes = static_cast<int>(joint.axes.size());
    int column = joint.coupling ? follower++ : skeleton.vIndex(i);
    if (axes == 1 && !joint.ball) {  // the axis is unmoved by its own motion
      const AxisDof& dof = joint.axes[0];
      const Vector3d axis = frames[i].linear() * dof.axis;
      if (dof.kind == AxisDof::Kind::Rotation)
        putRotation(twists, column, axis, frames[i].translation());
      else
        twists.col(column) << axis, Vector3d::Zero();
      if (joint.coupling) twists.col(column) *= joint.coupling->multiplier;
      continue;
    }
    if (axes > 0) {
      Eigen::Isometry3d moved =
          joint.parent < 0 ? joint.parentFromZero : frames[joint.parent] * joint.parentFromZero;
      for (int k = 0; k < axes; ++k, ++column) {
        const AxisDof& dof = joint.axes[k];
        const Vector3d axis = moved.linear() * dof.axis;
        const double value = q[skeleton.qIndex(i) + k];
        if (dof.kind == AxisDof::Kind::Rotation) {
          putRotation(twists, column, axis, moved.translation());
          moved.linear() = (Eigen::AngleAxisd(value, axis) * moved.linear()).eval();
        } else {
          twists.col(column) << axis, Vector3d::Zero();
          moved.translation() += value * axis;
        }
      }
    }
    if (joint.ball)
      for (int k = 0; k < 3; ++k)
        putRotation(twists, column + k, frames[i].linear().col(k), frames[i].translation());
  }
}

Twists dofTwists(const Skeleton& skeleton, const VectorXd& q, const Frames& frames) {
  Twists twists;
  dofTwists(skeleton, q, frames, twists);
  return twists;
}

void pointJacobian(const Skeleton& skeleton, const Twists& twists, int joint, const Vector3d& pointInWorld,
                   Eigen::Ref<Matrix3Xd, 0, Eigen::OuterStride<>> J) {
  J.setZero();
  forEachDofAbove(skeleton, joint, [&](int k) {
    const Vector3d omega = twists.col(k).tail<3>();
    J.col(k) = twists.col(k).head<3>() + omega.cross(pointInWorld);
  });
  forEachFollowerAbove(skeleton, joint, [&](int k, int source) {
    const Vector3d omega = twists.col(k).tail<3>();
    J.col(source) += twists.col(k).head<3>() + omega.cross(pointInWorld);
  });
}

void rotationJacobian(const Skeleton& skeleton, const Twists& twists, int joint,
                      Eigen::Ref<Matrix3Xd, 0, Eigen::OuterStride<>> J) {
  J.setZero();
  forEachDofAbove(skeleton, joint, [&](int k) { J.col(k) = twists.col(k).tail<3>(); });
  forEachFollowerAbove(skeleton, joint, [&](int k, int source) { J.col(source) += twists.col(k).tail<3>(); });
}

Matrix3Xd pointJacobian(const Skeleton& skeleton, const VectorXd& q, const Frames& frames, int joint,
                        const Vector3d& pointInJoint) {
  Matrix3Xd J(3, skeleton.nv());
  pointJacobian(skeleton, dofTwists(skeleton, q, frames), joint, frames[joint] * pointInJoint, J);
  return J;
}

Eigen::Matrix<double, 6, Eigen::Dynamic> frameJacobian(const Skeleton& skeleton, const VectorXd& q,
                                                       const Frames& frames, int joint) {
  const Twists twists = dofTwists(skeleton, q, frames);
  Matrix3Xd linear(3, skeleton.nv()), angular(3, skeleton.nv());
  pointJacobian(skeleton, twists, joint, frames[joint].translation(), linear);
  rotationJacobian(skeleton, twists, joint, angular);
  Eigen::Matrix<double, 6, Eigen::Dynamic> J(6, skeleton.nv());
  J << linear, angular;
  return J;
}

}  // namespace gelenk
