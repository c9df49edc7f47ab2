#include "solvers/solutions/self_motion.h"

#include <gtest/gtest.h>

#include "kinematics/notation/robots.h"
#include "tests/solvers/solutions/example_arms.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::VectorXd;
using testing::apart;
using testing::chainOf;

double poseError(const SerialChain& chain, const Vector7d& q, const Isometry3d& pose) {
  return (tipFrame(chain, q).matrix() - pose.matrix()).cwiseAbs().maxCoeff();
}

TEST(SelfMotion, SlicesOfThePandaAndTheIiwaHaveClosedForms) {
  for (const char* name : {"panda", "iiwa14"}) {
    SCOPED_TRACE(name);
    const Skeleton skeleton = toSkeleton(robotTable(name));
    const SevenJointArm arm(chainOf(robotTable(name)));
    EXPECT_EQ(arm.sliceClass(), LoopClass::SphericalTriple);
    std::mt19937_64 random(41);
    for (int trial = 0; trial < 200; ++trial) {
      const VectorXd q = randomWithinLimits(skeleton, random);
      const Isometry3d pose = tipFrame(arm.chain(), q);
      SliceSolutions found;
      arm.slice(pose, q[arm.heldJoint()], Vector7d::Zero(), found);
      EXPECT_LE(found.count, 8);
      bool hit = false;
      for (const Vector7d& x : found.all()) {
        EXPECT_LT(poseError(arm.chain(), x, pose), 1e-9);
        hit |= apart(x, q) < 1e-5;
      }
      EXPECT_TRUE(hit);
    }
  }
}

TEST(SelfMotion, EveryPointOfACurveReachesThePoseAndTheCurvesClose) {
  for (const char* name : {"panda", "iiwa14"}) {
    SCOPED_TRACE(name);
    const Skeleton skeleton = toSkeleton(robotTable(name));
    const SevenJointArm arm(chainOf(robotTable(name)));
    std::mt19937_64 random(42);
    for (int trial = 0; trial < 3; ++trial) {
      const VectorXd q = randomWithinLimits(skeleton, random);
      const Isometry3d pose = tipFrame(arm.chain(), q);
      double nearest = INFINITY;
      for (const SelfMotionCurve& curve : arm.selfMotion(pose, {.limits = false})) {
        EXPECT_TRUE(curve.closed);
        ASSERT_EQ(curve.q.size(), curve.arcLength.size());
        for (size_t k = 0; k < curve.q.size(); ++k) {
          EXPECT_LT(poseError(arm.chain(), curve.q[k], pose), 1e-8);
          nearest = std::min(nearest, apart(curve.q[k], q));
          if (k == 0) continue;
          EXPECT_GE(curve.arcLength[k], curve.arcLength[k - 1]);
          EXPECT_LT((curve.q[k] - curve.q[k - 1]).norm(), 0.09);  // twice the step
        }
      }
      EXPECT_LT(nearest, 0.04);  // q lies on one of them, between two points
    }
  }
}

TEST(SelfMotion, LimitsCutTheCurvesAndKeepWhatIsWithin) {
  const Skeleton skeleton = toSkeleton(robotTable("panda"));
  const SevenJointArm arm(chainOf(robotTable("panda")));
  std::mt19937_64 random(43);
  for (int trial = 0; trial < 5; ++trial) {
    const VectorXd q = randomWithinLimits(skeleton, random);
    const Isometry3d pose = tipFrame(arm.chain(), q);
    double nearest = INFINITY;
    for (const SelfMotionCurve& piece : arm.selfMotion(pose))
      for (const Vector7d& x : piece.q) {
        EXPECT_LT(poseError(arm.chain(), x, pose), 1e-8);
        for (int i = 0; i < 7; ++i) {
          EXPECT_GE(x[i], arm.chain().lower[i] - 1e-9);
          EXPECT_LE(x[i], arm.chain().upper[i] + 1e-9);
        }
        nearest = std::min(nearest, (x - Vector7d(q)).cwiseAbs().maxCoeff());
      }
    EXPECT_LT(nearest, 0.04);
  }
}

/// The closed form against walking, which shares nothing with it but the kinematics: finer slices, shorter
/// steps.
void expectTheNearestOfABruteSearch(const DhTable& table, int trials, std::mt19937_64& random, bool limits) {
  SCOPED_TRACE(table.name);
  const Skeleton skeleton = toSkeleton(table);
  const SevenJointArm arm(chainOf(table));
  ASSERT_TRUE(arm.family());
  for (int trial = 0; trial < trials; ++trial) {
    const VectorXd q = randomWithinLimits(skeleton, random), near = randomWithinLimits(skeleton, random);
    const Isometry3d pose = tipFrame(arm.chain(), q);
    Vector7d best, brute;
    ASSERT_TRUE(arm.nearest(pose, near, best, {.limits = limits}));
    EXPECT_LT(poseError(arm.chain(), best, pose), 1e-10);
    EXPECT_LE((best - Vector7d(near)).norm(), (q - near).norm() + 1e-9);
    if (limits)
      for (int i = 0; i < 7; ++i) {
        EXPECT_GE(best[i], arm.chain().lower[i]);
        EXPECT_LE(best[i], arm.chain().upper[i]);
      }
    if (arm.nearestByWalking(pose, near, brute, {.limits = limits, .slices = 100}))
      EXPECT_LE((best - Vector7d(near)).norm(), (brute - Vector7d(near)).norm() + 1e-6);
  }
}

TEST(ShoulderFamily, TheNearestSolutionIsTheNearestOfABruteSearch) {
  std::mt19937_64 random(44);
  for (const DhTable& table : {robotTable("panda"), robotTable("iiwa14"), testing::xarm7()})
    for (const bool limits : {true, false}) expectTheNearestOfABruteSearch(table, 6, random, limits);
}

TEST(ShoulderFamily, ArmsWithAnyTwistsAndLengthsHaveTheClosedForm) {
  std::mt19937_64 random(45);
  for (int arm = 0; arm < 6; ++arm)
    expectTheNearestOfABruteSearch(testing::randomShoulderArm(random), 2, random, arm % 2 == 0);
}

/// A way from q straight to `near` that keeps the pose ends at q: nothing is nearer to a solution than
/// itself.
TEST(ShoulderFamily, ASolutionIsNearestToItself) {
  std::mt19937_64 random(46);
  for (const DhTable& table : {robotTable("panda"), robotTable("iiwa14"), testing::xarm7()}) {
    SCOPED_TRACE(table.name);
    const Skeleton skeleton = toSkeleton(table);
    const SevenJointArm arm(chainOf(table));
    for (int trial = 0; trial < 2000; ++trial) {
      const Vector7d q = randomWithinLimits(skeleton, random);
      Vector7d best;
      ASSERT_TRUE(arm.nearest(tipFrame(arm.chain(), q), q, best));
      EXPECT_LT((best - q).norm(), 1e-6) << trial;
    }
  }
}

TEST(ShoulderFamily, SamplesReachThePoseAndPassBesideEverySolution) {
  std::mt19937_64 random(47);
  for (const DhTable& table : {robotTable("panda"), robotTable("iiwa14")}) {
    const Skeleton skeleton = toSkeleton(table);
    const SevenJointArm arm(chainOf(table));
    for (int trial = 0; trial < 50; ++trial) {
      const VectorXd q = randomWithinLimits(skeleton, random);
      const Isometry3d pose = tipFrame(arm.chain(), q);
      std::vector<Vector7d> samples;
      arm.family()->sample(pose, 0.3, samples);
      double nearest = INFINITY;
      for (const Vector7d& x : samples) {
        EXPECT_LT(poseError(arm.chain(), x, pose), 1e-9);
        nearest = std::min(nearest, (x - Vector7d(q)).norm());
      }
      EXPECT_LT(nearest, 0.4);
    }
  }
}

TEST(ShoulderFamily, OtherArmsHaveNone) {
  std::mt19937_64 random(48);
  DhTable table = testing::randomShoulderArm(random);
  table.rows[2].a = 0.05;
  EXPECT_FALSE(ShoulderFamily::of(chainOf(table)));
  EXPECT_FALSE(ShoulderFamily::of(chainOf(robotTable("ur5"))));
}

TEST(SelfMotion, OtherChainsAreRefused) {
  EXPECT_THROW(SevenJointArm{chainOf(robotTable("ur5"))}, std::invalid_argument);
}

}  // namespace
}  // namespace gelenk
