#include "kinematics/forward_kinematics.h"

#include <gtest/gtest.h>

#include "kinematics/jacobian.h"
#include "tests/kinematics/random_skeleton.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// The definition, written out with plain 4 x 4 products: the independent route.
Isometry3d worldFromJointByProducts(const Skeleton& skeleton, const VectorXd& q, int i) {
  const Joint& joint = skeleton.joint(i);
  Isometry3d T =
      joint.parent < 0 ? Isometry3d::Identity() : worldFromJointByProducts(skeleton, q, joint.parent);
  T = T * joint.parentFromZero;
  int at = skeleton.qIndex(i);
  for (const AxisDof& dof : joint.axes) {
    if (dof.kind == AxisDof::Kind::Rotation)
      T.rotate(Eigen::AngleAxisd(q[at], dof.axis));
    else
      T.translate(q[at] * dof.axis);
    ++at;
  }
  if (joint.ball) T.rotate(ballRotation(skeleton, q, i));
  return T;
}

TEST(ForwardKinematics, EqualsTheProductOfItsFactors) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 100; ++i) {
    const Skeleton skeleton = testing::randomTree(random, 15, i);
    const VectorXd q = randomWithinLimits(skeleton, random);
    const Frames frames = forwardKinematics(skeleton, q);
    for (int k = 0; k < skeleton.jointCount(); ++k)
      EXPECT_LE((frames[k].matrix() - worldFromJointByProducts(skeleton, q, k).matrix()).norm(), 1e-13);
  }
}

TEST(Jacobian, MatchesCentralDifferencesOnEveryKindOfJoint) {
  std::mt19937_64 random(2);
  constexpr double h = 1e-6;  // truncation h^2, rounding 1e-16 / h: both below 1e-9
  for (int i = 0; i < 50; ++i) {
    const Skeleton skeleton = testing::randomTree(random, 10, i);
    const VectorXd q = randomWithinLimits(skeleton, random);
    const Frames frames = forwardKinematics(skeleton, q);
    const int joint = skeleton.jointCount() - 1;
    const Vector3d point(0.1, -0.2, 0.3);
    const auto J = pointJacobian(skeleton, q, frames, joint, point);
    const auto JFrame = frameJacobian(skeleton, q, frames, joint);
    for (int k = 0; k < skeleton.nv(); ++k) {
      const VectorXd dq = h * VectorXd::Unit(skeleton.nv(), k);
      const Isometry3d plus = forwardKinematics(skeleton, integrate(skeleton, q, dq))[joint];
      const Isometry3d minus = forwardKinematics(skeleton, integrate(skeleton, q, -dq))[joint];
      EXPECT_LE(((plus * point - minus * point) / (2 * h) - J.col(k)).norm(), 1e-8);
      const Eigen::Quaterniond turned(plus.linear() * minus.linear().transpose());
      EXPECT_LE((logRotation(turned) / (2 * h) - JFrame.col(k).tail<3>()).norm(), 1e-8);
    }
  }
}

}  // namespace
}  // namespace gelenk
