#include "solvers/serial/spherical_wrist.h"

#include <gtest/gtest.h>

#include <random>

#include "kinematics/configuration.h"
#include "kinematics/notation/robots.h"
#include "solvers/problem/judge.h"

namespace gelenk {
namespace {

using Eigen::VectorXd;

SerialChain chainOf(const Skeleton& skeleton) {
  return extractSerialChain(skeleton, skeleton.jointCount() - 1).chain;
}

TEST(SphericalWrist, AllEightBranchesOfPumaAndUr5ReachThePose) {
  for (const char* name : {"puma560", "ur5"}) {
    SCOPED_TRACE(name);
    const Skeleton skeleton = toSkeleton(robotTable(name));
    const SerialChain chain = chainOf(skeleton);
    std::mt19937_64 random(21);
    for (int trial = 0; trial < 500; ++trial) {
      const VectorXd q = randomWithinLimits(skeleton, random);
      const Eigen::Isometry3d pose = forwardKinematics(skeleton, q).back();
      const auto branches = armBranches(chain, pose);
      ASSERT_EQ(branches.size(), 8u);
      double nearest = INFINITY;
      for (const ArmBranch& branch : branches) {
        double distance = 0.0;
        for (int i = 0; i < 6; ++i)
          distance = std::max(distance, std::abs(std::remainder(branch.q[i] - q[i], 2.0 * M_PI)));
        nearest = std::min(nearest, distance);
        if (!branch.exact) continue;  // UR: some shoulder and wrist choices leave the elbow too short
        const Eigen::Isometry3d reached = tipFrame(chain, branch.q);
        EXPECT_LT((reached.matrix() - pose.matrix()).cwiseAbs().maxCoeff(), 1e-9);
      }
      EXPECT_LT(
          nearest,
          1e-5);  // the configuration itself is among them; near a stretched elbow acos loses half the digits
    }
  }
}

TEST(SphericalWrist, OutOfReachIsFlaggedOnEveryBranch) {
  const Skeleton skeleton = toSkeleton(robotTable("puma560"));
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << 3.0, 0.5, 0.5;
  const auto branches = armBranches(chainOf(skeleton), pose);
  ASSERT_FALSE(branches.empty());
  for (const ArmBranch& branch : branches) {
    EXPECT_FALSE(branch.exact);
    EXPECT_TRUE(branch.q.allFinite());
  }
}

TEST(SphericalWrist, ASingularWristKeepsTheReferenceAngle) {
  const Skeleton skeleton = toSkeleton(robotTable("puma560"));
  const SerialChain chain = chainOf(skeleton);
  VectorXd q(6);
  q << 0.3, 0.4, -0.5, 0.7, 0.0, 0.2;
  const Eigen::Isometry3d pose = forwardKinematics(skeleton, q).back();
  double nearest = INFINITY;
  for (const ArmBranch& branch : armBranches(chain, pose, q)) {
    if (branch.exact) {
      EXPECT_LT((tipFrame(chain, branch.q).matrix() - pose.matrix()).cwiseAbs().maxCoeff(),
                1e-7);  // acos near 1
    }
    nearest = std::min(nearest, (branch.q - q).cwiseAbs().maxCoeff());
  }
  EXPECT_LT(nearest, 1e-5);
}

TEST(SphericalWrist, OtherArmsAreUnsupportedWithAReason) {
  for (const char* name : {"panda", "iiwa14", "scara"}) {
    const Skeleton skeleton = toSkeleton(robotTable(name));
    const auto solver = makeSphericalWrist();
    IkProblem problem{.skeleton = &skeleton, .start = neutral(skeleton)};
    problem.goals = {{.kind = GoalKind::Pose, .joint = skeleton.jointCount() - 1}};
    EXPECT_FALSE(solver->whyUnsupported(problem).empty()) << name;
    EXPECT_EQ(solver->solve(problem, {}, TraceLevel::Off).why, Stop::Unsupported) << name;
  }
}

TEST(SphericalWrist, EveryReachablePoseWithinLimitsIsSolved) {
  for (const char* name : {"puma560", "ur5"}) {
    const Skeleton skeleton = toSkeleton(robotTable(name));
    const auto solver = makeSphericalWrist();
    std::mt19937_64 random(22);
    for (int trial = 0; trial < 300; ++trial) {
      const Eigen::Isometry3d pose = forwardKinematics(skeleton, randomWithinLimits(skeleton, random)).back();
      IkProblem problem{.skeleton = &skeleton, .start = randomWithinLimits(skeleton, random)};
      problem.goals = {{.kind = GoalKind::Pose,
                        .joint = skeleton.jointCount() - 1,
                        .target = pose.translation(),
                        .orientation = Eigen::Quaterniond(pose.linear())}};
      const IkReport report = solver->solve(problem, {}, TraceLevel::Off);
      EXPECT_EQ(report.why, Stop::Converged) << name;
      EXPECT_TRUE(judge(problem, report.q).solved) << name;
    }
  }
}

}  // namespace
}  // namespace gelenk
