#include "kinematics/notation/euler.h"

#include <gtest/gtest.h>

#include "tests/kinematics/random_skeleton.h"

namespace gelenk {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST(Euler, AnglesOfARotationGiveTheRotationBackInAllTwelveOrders) {
  std::mt19937_64 random(1);
  for (const EulerOrder& order : eulerOrders())
    for (int i = 0; i < 1000; ++i) {
      const Matrix3d R =
          expRotation(M_PI * uniform01(random) * testing::randomUnit(random)).toRotationMatrix();
      EXPECT_LE((rotationFromEuler(order, eulerFromRotation(order, R)) - R).norm(), 1e-13) << order.name;
    }
}

TEST(Euler, AnglesWithinTheirRangesAreRecovered) {
  std::mt19937_64 random(2);
  for (const EulerOrder& order : eulerOrders())
    for (int i = 0; i < 200; ++i) {
      Vector3d angles(6.0 * uniform01(random) - 3.0, 1.4 * (2.0 * uniform01(random) - 1.0),
                      6.0 * uniform01(random) - 3.0);
      if (order.isProper()) angles[1] = 0.1 + std::abs(angles[1]);
      EXPECT_LE((eulerFromRotation(order, rotationFromEuler(order, angles)) - angles).norm(), 1e-12)
          << order.name;
    }
}

TEST(Euler, GimbalLockKeepsTheRotationAndSetsTheThirdAngleToZero) {
  std::mt19937_64 random(3);
  for (const EulerOrder& order : eulerOrders())
    for (const double b : order.isProper() ? std::array{0.0, M_PI} : std::array{M_PI / 2, -M_PI / 2})
      for (int i = 0; i < 50; ++i) {
        const Vector3d angles(6.0 * uniform01(random) - 3.0, b, 6.0 * uniform01(random) - 3.0);
        const Matrix3d R = rotationFromEuler(order, angles);
        const Vector3d found = eulerFromRotation(order, R);
        EXPECT_LE((rotationFromEuler(order, found) - R).norm(), 1e-12) << order.name;
        EXPECT_NEAR(found[2], 0.0, 1e-9) << order.name;
        EXPECT_LE(std::abs(eulerRates(order, angles).determinant()), 1e-15) << order.name;
      }
}

TEST(Euler, RatesAreTheAngularVelocity) {
  std::mt19937_64 random(4);
  constexpr double h = 1e-6;
  for (const EulerOrder& order : eulerOrders())
    for (int i = 0; i < 20; ++i) {
      const Vector3d angles = 3.0 * testing::randomUnit(random);
      const Matrix3d E = eulerRates(order, angles);
      for (int k = 0; k < 3; ++k) {
        const Matrix3d plus = rotationFromEuler(order, angles + h * Vector3d::Unit(k));
        const Matrix3d minus = rotationFromEuler(order, angles - h * Vector3d::Unit(k));
        const Vector3d omega = logRotation(Eigen::Quaterniond(plus * minus.transpose())) / (2 * h);
        EXPECT_LE((omega - E.col(k)).norm(), 1e-8) << order.name;
      }
      const double measure = order.isProper() ? std::sin(angles[1]) : std::cos(angles[1]);
      EXPECT_NEAR(std::abs(E.determinant()), std::abs(measure), 1e-14);
    }
}

TEST(Euler, TheLecturesOrderIsXyz) {
  EXPECT_EQ(lectureEulerOrder().name, "xyz");
  const Matrix3d expected =
      (Eigen::AngleAxisd(0.1, Vector3d::UnitX()) * Eigen::AngleAxisd(0.2, Vector3d::UnitY()) *
       Eigen::AngleAxisd(0.3, Vector3d::UnitZ()))
          .toRotationMatrix();
  EXPECT_LE((rotationFromEuler(lectureEulerOrder(), {0.1, 0.2, 0.3}) - expected).norm(), 1e-15);
}

}  // namespace
}  // namespace gelenk
