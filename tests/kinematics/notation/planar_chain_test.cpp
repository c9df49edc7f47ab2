#include "kinematics/notation/planar_chain.h"

#include <gtest/gtest.h>

#include "kinematics/configuration.h"
#include "kinematics/jacobian.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

PlanarChain randomChain(std::mt19937_64& random) {
  PlanarChain chain{.base = {uniform01(random), -uniform01(random)}, .lengths = {}};
  const int n = 1 + static_cast<int>(random() % 8);
  for (int i = 0; i < n; ++i) chain.lengths.push_back(uniform01(random));
  return chain;
}

VectorXd randomAngles(const PlanarChain& chain, std::mt19937_64& random) {
  VectorXd phi(chain.linkCount());
  for (double& angle : phi) angle = 8.0 * uniform01(random) - 4.0;
  return phi;
}

TEST(PlanarChain, SumsHierarchyAndSkeletonAreOneForwardKinematics) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    const PlanarChain chain = randomChain(random);
    const VectorXd phi = randomAngles(chain, random);
    const auto points = linkPoints(chain, phi);
    const auto hierarchy = hierarchicalFrames(chain, phi);
    const Frames frames = forwardKinematics(toSkeleton(chain), phi);
    ASSERT_EQ(points.size(), hierarchy.size());
    ASSERT_EQ(points.size(), frames.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
      EXPECT_LE((points[k] - hierarchy[k].translation()).norm(), 1e-12);
      EXPECT_LE((points[k] - frames[k].translation().head<2>()).norm(), 1e-12);
      EXPECT_EQ(frames[k].translation().z(), 0.0);
    }
  }
}

TEST(PlanarChain, JacobianEqualsTheSkeletonsAndCentralDifferences) {
  std::mt19937_64 random(2);
  constexpr double h = 1e-6;
  for (int i = 0; i < 200; ++i) {
    const PlanarChain chain = randomChain(random);
    const VectorXd phi = randomAngles(chain, random);
    const Eigen::Matrix2Xd D = jacobian(chain, phi);
    const Skeleton skeleton = toSkeleton(chain);
    const auto J =
        pointJacobian(skeleton, phi, forwardKinematics(skeleton, phi), skeleton.jointCount() - 1, {0, 0, 0});
    EXPECT_LE((D - J.topRows<2>()).norm(), 1e-12);
    for (int k = 0; k < chain.linkCount(); ++k) {
      const VectorXd step = h * VectorXd::Unit(chain.linkCount(), k);
      const Vector2d slope = (endEffector(chain, phi + step) - endEffector(chain, phi - step)) / (2 * h);
      EXPECT_LE((slope - D.col(k)).norm(), 1e-8);  // truncation 1e-12, rounding 1e-16 / 1e-6
    }
  }
}

TEST(PlanarChain, HasTwoDegreesOfFreedomMoreThanLinks) {
  EXPECT_EQ(degreesOfFreedom(lecturePlanarChain()), 5);
}

TEST(PlanarChain, RefusesTheWrongNumberOfAnglesAndNoLinks) {
  EXPECT_THROW(endEffector(lecturePlanarChain(), VectorXd::Zero(2)), std::invalid_argument);
  EXPECT_THROW(toSkeleton(PlanarChain{}), std::invalid_argument);
}

}  // namespace
}  // namespace gelenk
