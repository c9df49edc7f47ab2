#include "kinematics/motion/motion_clip.h"

#include <gtest/gtest.h>

#include "kinematics/forward_kinematics.h"
#include "tests/kinematics/random_skeleton.h"

namespace gelenk {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

Quaterniond product(const Vector3d& a, const Vector3d& e1, const Vector3d& e2, const Vector3d& e3) {
  return expRotation(a[0] * e1) * expRotation(a[1] * e2) * expRotation(a[2] * e3);
}

TEST(EulerAngles, EveryOrderGivesTheRotationBackAndThePoseNearestToTheHint) {
  std::mt19937_64 random(3);
  const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (const auto& order : orders)
    for (int trial = 0; trial < 200; ++trial) {
      const Vector3d e1 = Vector3d::Unit(order[0]), e2 = Vector3d::Unit(order[1]),
                     e3 = Vector3d::Unit(order[2]);
      Vector3d angles(8.0 * uniform01(random) - 4.0, 8.0 * uniform01(random) - 4.0,
                      8.0 * uniform01(random) - 4.0);
      if (trial % 10 == 0) angles[1] = trial % 20 ? M_PI / 2 : -M_PI / 2;  // gimbal lock
      const Quaterniond q = product(angles, e1, e2, e3);
      const Vector3d back = eulerAngles(q, e1, e2, e3, angles);
      // The hint is the answer, so it must come back itself: away from the lock to rounding, at the lock to
      // the square root of it.
      const double tolerance = trial % 10 == 0 ? 1e-7 : 1e-11 / std::max(1e-3, std::abs(std::cos(angles[1])));
      EXPECT_LE((back - angles).norm(), tolerance) << back.transpose() << " for " << angles.transpose();
      EXPECT_LE(logRotation(q.conjugate() * product(eulerAngles(q, e1, e2, e3, Vector3d::Zero()), e1, e2, e3))
                    .norm(),
                1e-7);
    }
}

TEST(SetJointRotation, GivesBackWhatTheJointCanReachAndTheNearestOfWhatItCannot) {
  std::mt19937_64 random(5);
  Joint two{.name = "two"};
  two.axes = {{AxisDof::Kind::Rotation, Vector3d::UnitX()}, {AxisDof::Kind::Rotation, -Vector3d::UnitZ()}};
  const Skeleton skeleton({two});
  for (int trial = 0; trial < 200; ++trial) {
    VectorXd q(2);
    q << 6.0 * uniform01(random) - 3.0, 6.0 * uniform01(random) - 3.0;
    VectorXd again = q;
    ASSERT_TRUE(setJointRotation(skeleton, again, 0, jointRotation(skeleton, q, 0)));
    EXPECT_LE((again - q).norm(), 1e-12);
    // Off the joint's two dimensions: no small change of the angles comes nearer.
    const Quaterniond target = expRotation(3.0 * uniform01(random) * testing::randomUnit(random));
    VectorXd best = q;
    setJointRotation(skeleton, best, 0, target);
    const double distance = 1.0 - std::abs(jointRotation(skeleton, best, 0).dot(target));
    for (int k = 0; k < 4; ++k) {
      VectorXd moved = best;
      moved[k / 2] += k % 2 ? 1e-3 : -1e-3;
      EXPECT_GE(1.0 - std::abs(jointRotation(skeleton, moved, 0).dot(target)), distance - 1e-12);
    }
  }
}

TEST(Sample, EqualPosesHalfATurnApartInTheirAnglesStayPutInBetween) {
  Joint hip{.name = "hip"};
  for (const int a : {2, 1, 0}) hip.axes.push_back({AxisDof::Kind::Rotation, Vector3d::Unit(a)});
  const Skeleton skeleton({hip});
  MotionClip clip{.framesPerSecond = 100.0, .q = Eigen::MatrixXd(3, 2)};
  clip.q.col(0) << 0.3, 0.4, 0.5;
  clip.q.col(1) << 0.3 + M_PI, M_PI - 0.4, 0.5 - M_PI;  // the Euler flip: the same rotation
  const Quaterniond pose = jointRotation(skeleton, clip.q.col(0), 0);
  for (const double seconds : {0.001, 0.005, 0.0099}) {
    const VectorXd q = sample(skeleton, clip, seconds);
    EXPECT_LE(logRotation(pose.conjugate() * jointRotation(skeleton, q, 0)).norm(), 1e-12);
  }
}

TEST(Sample, TurnsEveryKindOfJointAtConstantSpeedAndHitsTheFrames) {
  const unsigned seed = 11;
  std::mt19937_64 random(seed);
  const Skeleton skeleton = testing::randomSkeleton(random, 12);
  MotionClip clip{.framesPerSecond = 10.0, .q = Eigen::MatrixXd(skeleton.nq(), 4)};
  for (int f = 0; f < 4; ++f) clip.q.col(f) = randomWithinLimits(skeleton, random);
  for (int f = 0; f < 4; ++f)
    EXPECT_LE((sample(skeleton, clip, 0.1 * f) - clip.q.col(f)).norm(), 1e-9) << "seed " << seed;
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    if (!joint.ball) continue;
    const Quaterniond a = jointRotation(skeleton, clip.q.col(1), i),
                      b = jointRotation(skeleton, clip.q.col(2), i);
    const Quaterniond quarter = jointRotation(skeleton, sample(skeleton, clip, 0.125), i);
    EXPECT_NEAR(logRotation(a.conjugate() * quarter).norm(), 0.25 * logRotation(a.conjugate() * b).norm(),
                1e-12);
  }
  EXPECT_LE((sample(skeleton, clip, -1.0) - clip.q.col(0)).norm(), 0.0);
  EXPECT_LE((sample(skeleton, clip, 9.0) - clip.q.col(3)).norm(), 0.0);
  EXPECT_LE((sample(skeleton, clip, 0.5, BeyondEnd::Loop) - clip.q.col(1)).norm(),
            1e-9);  // four frames a round
}

TEST(Resampled, TwiceTheRateKeepsEveryOldFrame) {
  std::mt19937_64 random(2);
  const Skeleton skeleton = testing::randomSkeleton(random, 6);
  MotionClip clip{.framesPerSecond = 30.0, .q = Eigen::MatrixXd(skeleton.nq(), 5)};
  for (int f = 0; f < 5; ++f) clip.q.col(f) = randomWithinLimits(skeleton, random);
  const MotionClip twice = resampled(skeleton, clip, 60.0);
  ASSERT_EQ(twice.frameCount(), 9);
  for (int f = 0; f < 5; ++f) {
    const Frames a = forwardKinematics(skeleton, clip.q.col(f)),
                 b = forwardKinematics(skeleton, twice.q.col(2 * f));
    for (int i = 0; i < skeleton.jointCount(); ++i) EXPECT_LE((a[i].matrix() - b[i].matrix()).norm(), 1e-9);
  }
  for (const double rate : {0.0, std::nan(""), 1e12, 1e300})  // frames that nothing could hold
    EXPECT_THROW(resampled(skeleton, clip, rate), std::invalid_argument) << rate;
}

}  // namespace
}  // namespace gelenk
