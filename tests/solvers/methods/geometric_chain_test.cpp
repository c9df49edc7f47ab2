#include <gtest/gtest.h>

#include <random>

#include "kinematics/configuration.h"
#include "solvers/methods/ball_chain.h"
#include "solvers/methods/ccd.h"
#include "solvers/methods/fabrik.h"
#include "solvers/problem/judge.h"
#include "tests/solvers/random_problem.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// Unit bones along z, ball joints, a fixed tip.
Skeleton ballChain(int bones, std::optional<BallLimit> limit = {}) {
  std::vector<Joint> joints;
  for (int i = 0; i < bones; ++i) {
    Joint joint{.name = "ball" + std::to_string(i), .parent = i - 1, .ball = true, .ballLimit = limit};
    if (i > 0) joint.parentFromZero.translation().z() = 1.0;
    joints.push_back(joint);
  }
  Joint tip{.name = "tip", .parent = bones - 1};
  tip.parentFromZero.translation().z() = 1.0;
  joints.push_back(tip);
  return Skeleton(joints);
}

IkProblem reachable(const Skeleton& skeleton, std::mt19937_64& random, double tolerance) {
  const int tip = skeleton.jointCount() - 1;
  IkProblem problem{.skeleton = &skeleton, .start = randomWithinLimits(skeleton, random)};
  problem.goals = {
      {.joint = tip,
       .target = forwardKinematics(skeleton, randomWithinLimits(skeleton, random))[tip].translation()}};
  problem.positionTolerance = tolerance;
  return problem;
}

TEST(GeometricChains, UnlimitedBallsReachEveryReachablePosition) {
  for (const char* name : {"fabrik", "ball-chain", "ccd"}) {
    const auto solver = makeSolver(name);
    for (const int bones : {2, 3, 10, 40}) {
      const Skeleton skeleton = ballChain(bones);
      std::mt19937_64 random(31);
      for (int i = 0; i < 30; ++i) {
        const IkProblem problem = reachable(skeleton, random, 1e-3);
        const IkReport report =
            solver->solve(problem, {.maxIterations = 2000, .maxSeconds = 1e9}, TraceLevel::Off);
        EXPECT_TRUE(judge(problem, report.q).solved)
            << bones << " bones, problem " << i << ", " << toString(report.why);
      }
    }
  }
}

TEST(GeometricChains, OutOfReachTheChainIsStraightTowardsTheTarget) {
  const Skeleton skeleton = ballChain(5);
  std::mt19937_64 random(32);
  for (const char* name : {"fabrik", "ccd"}) {
    IkProblem problem = reachable(skeleton, random, 1e-6);
    problem.goals[0].target = Vector3d(3.0, 4.0, 12.0);  // 13 m away, 5 m long
    const IkReport report =
        makeSolver(name)->solve(problem, {.maxIterations = 20000, .maxSeconds = 1e9}, TraceLevel::Off);
    EXPECT_NEAR(judge(problem, report.q).goals[0].position, 8.0,
                1e-5);  // flat at the bottom: 1e-6 is a bend of 1e-3
    EXPECT_NE(report.why, Stop::Converged);
  }
}

TEST(GeometricChains, AStraightChainInLineWithItsTargetBends) {
  const Skeleton skeleton = ballChain(4);
  for (const char* name : {"fabrik", "ball-chain"}) {
    IkProblem problem{.skeleton = &skeleton, .start = neutral(skeleton)};
    problem.goals = {{.joint = 4, .target = Vector3d(0, 0, 2.0)}};
    problem.positionTolerance = 1e-4;
    const IkReport report =
        makeSolver(name)->solve(problem, {.maxIterations = 1000, .maxSeconds = 1e9}, TraceLevel::Off);
    EXPECT_TRUE(judge(problem, report.q).solved);
  }
}

TEST(GeometricChains, FabrikAddsNoTwistToUnlimitedBalls) {
  const Skeleton skeleton = ballChain(6);
  std::mt19937_64 random(33);
  for (int i = 0; i < 20; ++i) {
    IkProblem problem = reachable(skeleton, random, 1e-4);
    problem.start = neutral(skeleton);
    const IkReport report =
        makeFabrik()->solve(problem, {.maxIterations = 1000, .maxSeconds = 1e9}, TraceLevel::Off);
    ASSERT_TRUE(judge(problem, report.q).solved);
    for (int j = 0; j < 6;
         ++j)  // from the untwisted start every joint makes one smallest rotation: its z part is zero
      EXPECT_LT(std::abs(ballRotation(skeleton, report.q, j).z()), 1e-9);
  }
}

TEST(GeometricChains, LimitsOfSwingTwistAndHingesAreKept) {
  const BallLimit limit{
      .swingCentre = {0.1, 0.0}, .swingRadii = {0.6, 0.4}, .twistLower = -0.3, .twistUpper = 0.3};
  const Skeleton cones = ballChain(6, limit);
  const auto hinges = [](bool alternating) {
    std::vector<Joint> joints;
    for (int i = 0; i < 8; ++i) {
      Joint joint{.name = "hinge" + std::to_string(i),
                  .parent = i - 1,
                  .axes = {{.axis = alternating && i % 2 ? Vector3d::UnitX() : Vector3d::UnitY(),
                            .lower = -1.5,
                            .upper = 1.5}}};
      if (i > 0) joint.parentFromZero.translation().z() = 0.5;
      joints.push_back(joint);
    }
    Joint tip{.name = "tip", .parent = 7};
    tip.parentFromZero.translation().z() = 0.5;
    joints.push_back(tip);
    return Skeleton(joints);
  };
  const Skeleton planar = hinges(false), alternating = hinges(true);
  for (const char* name : {"fabrik", "ccd"})
    for (const Skeleton* skeleton : {&cones, &planar, &alternating}) {
      std::mt19937_64 random(34);
      int solved = 0;
      for (int i = 0; i < 50; ++i) {
        const IkProblem problem = reachable(*skeleton, random, 1e-3);
        const IkReport report = makeSolver(name)->solve(
            problem, {.maxIterations = 500, .maxSeconds = 1e9, .restarts = 3}, TraceLevel::Off);
        const Judgement verdict = judge(problem, report.q);
        EXPECT_LE(verdict.limitViolation, 1e-9);
        EXPECT_EQ(verdict.solved, report.why == Stop::Converged);
        solved += verdict.solved;
      }
      EXPECT_GE(solved, 40) << name;  // neither promises convergence with limits; both reach most
    }
}

TEST(GeometricChains, CcdReachesPosesOfHinges) {
  std::mt19937_64 random(35);
  const Skeleton arm = testing::straightChain(7);
  int solved = 0;
  for (int i = 0; i < 20; ++i) {
    const int tip = arm.jointCount() - 1;
    const Eigen::Isometry3d pose = forwardKinematics(arm, randomWithinLimits(arm, random))[tip];
    IkProblem problem{.skeleton = &arm,
                      .start = randomWithinLimits(arm, random),
                      .positionTolerance = 1e-3,
                      .orientationTolerance = 1e-3};
    problem.goals = {{.kind = GoalKind::Pose,
                      .joint = tip,
                      .target = pose.translation(),
                      .orientation = Eigen::Quaterniond(pose.linear())}};
    const IkReport report =
        makeCcd()->solve(problem, {.maxIterations = 2000, .maxSeconds = 1e9, .restarts = 5}, TraceLevel::Off);
    solved += judge(problem, report.q).solved;
  }
  EXPECT_GE(solved, 15);  // linear progress: some do not get to 1e-3 in the budget
}

}  // namespace
}  // namespace gelenk
