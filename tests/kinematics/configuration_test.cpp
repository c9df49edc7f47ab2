#include "kinematics/configuration.h"

#include <gtest/gtest.h>

#include "kinematics/forward_kinematics.h"
#include "kinematics/rotation.h"
#include "tests/kinematics/random_skeleton.h"

namespace gelenk {
namespace {

using Eigen::VectorXd;

TEST(Configuration, DifferenceUndoesIntegrate) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 200; ++i) {
    const Skeleton skeleton = testing::randomTree(random, 12, i);
    const VectorXd q = randomWithinLimits(skeleton, random);
    const VectorXd dq = VectorXd::Random(skeleton.nv());  // |rotation| < sqrt 3 < pi
    EXPECT_LE((difference(skeleton, q, integrate(skeleton, q, dq)) - dq).norm(), 1e-13);
  }
}

TEST(Configuration, RandomOnesKeepLimitsAndProjectionLeavesThemAlone) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 300; ++i) {
    const Skeleton skeleton = testing::randomTree(random, 12, i);
    const VectorXd q = randomWithinLimits(skeleton, random);
    EXPECT_LE(limitViolation(skeleton, q), 1e-12);
    EXPECT_LE(difference(skeleton, q, projectToLimits(skeleton, q)).norm(), 1e-12);
  }
}

TEST(Configuration, ProjectionReachesTheLimitsAndNoRandomLegalPointIsNearer) {
  std::mt19937_64 random(3);
  const BallLimit limit{{0.2, -0.1}, {0.9, 0.3}, -0.5, 0.4};
  const Skeleton skeleton({Joint{.name = "ball", .ball = true, .ballLimit = limit}});
  for (int i = 0; i < 300; ++i) {
    VectorXd q = neutral(skeleton);
    setBallRotation(skeleton, q, 0, expRotation(2.5 * uniform01(random) * testing::randomUnit(random)));
    const VectorXd projected = projectToLimits(skeleton, q);
    EXPECT_LE(limitViolation(skeleton, projected), 1e-12);
    const auto coordinates = [&](const VectorXd& v) {
      return swingTwistCoordinates(ballRotation(skeleton, v, 0));
    };
    const double distance = (coordinates(projected) - coordinates(q)).norm();
    for (int k = 0; k < 50; ++k)
      EXPECT_GE((coordinates(randomWithinLimits(skeleton, random)) - coordinates(q)).norm(),
                distance - 1e-12);
  }
}

TEST(Skeleton, RejectsWhatIsNoTree) {
  const auto named = [](const char* name, int parent) { return Joint{.name = name, .parent = parent}; };
  EXPECT_THROW(Skeleton(std::vector<Joint>{}), std::invalid_argument);
  EXPECT_THROW(Skeleton({named("a", 0)}), std::invalid_argument);
  EXPECT_THROW(Skeleton({named("a", -1), named("b", -1)}), std::invalid_argument);
  EXPECT_THROW(Skeleton({named("a", -1), named("b", 2), named("c", 1)}), std::invalid_argument);
  EXPECT_THROW(Skeleton({named("a", -1), named("a", 0)}), std::invalid_argument);
  Joint reversed = named("a", -1);
  reversed.axes.push_back({.lower = 1.0, .upper = -1.0});
  EXPECT_THROW(Skeleton({reversed}), std::invalid_argument);
  Joint sheared = named("a", -1);
  sheared.parentFromZero.linear()(0, 1) = 0.1;
  EXPECT_THROW(Skeleton({sheared}), std::invalid_argument);
}

}  // namespace
}  // namespace gelenk
