#include "kinematics/rotation.h"

#include <gtest/gtest.h>

#include "tests/kinematics/random_skeleton.h"

namespace gelenk {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

TEST(Rotation, LogarithmUndoesExponentialFromZeroToPi) {
  std::mt19937_64 random(1);
  for (const double angle :
       {0.0, 1e-300, 1e-160, 1e-16, 1e-9, 1e-5, 1e-4, 0.1, 1.0, 3.0, M_PI - 1e-6, M_PI - 1e-12})
    for (int i = 0; i < 50; ++i) {
      const Vector3d w = angle * testing::randomUnit(random);
      // 1e-15: two roundings of quantities of size pi
      EXPECT_LE((logRotation(expRotation(w)) - w).norm(), 2e-15 * std::max(angle, 1e-3)) << angle;
    }
}

TEST(Rotation, LogarithmOfHalfTurnHasLengthPi) {
  for (const Vector3d& axis : {Vector3d(1, 0, 0), Vector3d(0, -1, 0), Vector3d(0.6, 0, 0.8)})
    EXPECT_NEAR((logRotation(Quaterniond(0.0, axis.x(), axis.y(), axis.z())) - M_PI * axis).norm(), 0.0,
                1e-15);
}

TEST(Rotation, OppositeQuaternionsAreOneRotation) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 100; ++i) {
    const Quaterniond q = expRotation(3.0 * uniform01(random) * testing::randomUnit(random));
    EXPECT_LE((logRotation(q) - logRotation(Quaterniond(-q.coeffs()))).norm(), 1e-15);
  }
}

TEST(Rotation, SwingTimesTwistIsTheRotation) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 1000; ++i) {
    const Quaterniond q = expRotation(M_PI * uniform01(random) * testing::randomUnit(random));
    const SwingTwist s = splitSwingTwist(q);
    EXPECT_EQ(s.swing.z(), 0.0);
    EXPECT_GE(s.swing.w(), 0.0);
    EXPECT_EQ(s.twist.x(), 0.0);
    EXPECT_LE((s.swing * s.twist).angularDistance(q), 1e-7);  // acos near 1 squares the rounding
    EXPECT_LE(((s.swing * s.twist).toRotationMatrix() - q.toRotationMatrix()).norm(), 1e-14);
    EXPECT_LE((fromSwingTwistCoordinates(swingTwistCoordinates(q)).toRotationMatrix() - q.toRotationMatrix())
                  .norm(),
              1e-13);
  }
}

TEST(Rotation, BetweenTurnsOneDirectionIntoTheOtherEvenAntiparallel) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 1000; ++i) {
    const Vector3d a = testing::randomUnit(random);
    const Vector3d b = i % 3 == 0   ? Vector3d(-a)
                       : i % 3 == 1 ? (-a + 1e-9 * testing::randomUnit(random)).normalized()
                                    : testing::randomUnit(random);
    EXPECT_LE((rotationBetween(a, b) * a - b).norm(),
              2e-7);  // near antiparallel the axis rounds at sqrt(eps)
    if (i % 3 != 1) {
      EXPECT_LE((rotationBetween(a, b) * a - b).norm(), 1e-13);
    }
  }
}

}  // namespace
}  // namespace gelenk
