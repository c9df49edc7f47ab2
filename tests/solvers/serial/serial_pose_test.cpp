#include "solvers/serial/serial_pose.h"

#include <gtest/gtest.h>

#include <random>

#include "kinematics/configuration.h"
#include "kinematics/notation/robots.h"
#include "solvers/iteration/evaluator.h"
#include "solvers/problem/judge.h"

namespace gelenk {
namespace {

using Eigen::VectorXd;

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define GELENK_SANITIZED
#endif
#endif
#ifdef GELENK_SANITIZED
constexpr int problems = 40;
#else
constexpr int problems = 1000;
#endif

IkProblem reachablePose(const Skeleton& skeleton, std::mt19937_64& random) {
  IkProblem problem{.skeleton = &skeleton};
  const int tip = skeleton.jointCount() - 1;
  const Frames frames = forwardKinematics(skeleton, randomWithinLimits(skeleton, random));
  problem.goals = {{.kind = GoalKind::Pose,
                    .joint = tip,
                    .target = frames[tip].translation(),
                    .orientation = Eigen::Quaterniond(frames[tip].linear())}};
  problem.start = randomWithinLimits(skeleton, random);
  return problem;
}

TEST(SerialPose, EveryReachablePoseOfTheRobotsIsReached) {
  const Budget budget{.maxIterations = 200, .maxSeconds = 10.0, .restarts = 4000};
  for (const Robot& robot : robots()) {
    const Skeleton skeleton = toSkeleton(robot.table());
    SCOPED_TRACE(robot.name);
    const auto solver = makeSolver("default");
    solver->prepare(skeleton);
    std::mt19937_64 random(11);
    int solved = 0;
    for (int i = 0; i < problems; ++i) {
      const IkProblem problem = reachablePose(skeleton, random);
      const IkReport report = solver->solve(problem, budget, TraceLevel::Off);
      solved += judge(problem, report.q).solved && report.why == Stop::Converged;
    }
    EXPECT_EQ(solved, problems);
  }
}

TEST(SerialPose, PositionAndOrientationAloneAreReached) {
  const auto solver = makeSolver("serial-pose");
  for (const Robot& robot : robots()) {
    SCOPED_TRACE(robot.name);
    const Skeleton skeleton = toSkeleton(robot.table());
    solver->prepare(skeleton);
    std::mt19937_64 random(12);
    for (int i = 0; i < problems / 4; ++i) {
      IkProblem problem = reachablePose(skeleton, random);
      problem.goals[0].kind = i % 2 ? GoalKind::Position : GoalKind::Orientation;
      problem.goals[0].pointInJoint = {0.01, -0.02, 0.03};
      if (problem.goals[0].kind == GoalKind::Position) {  // of the point, not of the joint's origin
        const Frames frames = forwardKinematics(skeleton, randomWithinLimits(skeleton, random));
        problem.goals[0].target = frames.back() * problem.goals[0].pointInJoint;
      }
      const IkReport report = solver->solve(problem, {.restarts = 4000}, TraceLevel::Off);
      EXPECT_TRUE(judge(problem, report.q).solved);
    }
  }
}

/// Half the squared error's slope along every dof that is not held by a limit.
double freeSlope(const IkProblem& problem, const VectorXd& q) {
  CountedEvaluator at(problem);
  at.moveTo(q);
  const VectorXd slope = at.jacobian().transpose() * at.residual();
  double largest = 0.0;
  const Skeleton& skeleton = *problem.skeleton;
  for (int j = 0; j < skeleton.jointCount(); ++j)
    for (size_t k = 0; k < skeleton.joint(j).axes.size(); ++k) {
      const AxisDof& dof = skeleton.joint(j).axes[k];
      const double value = q[skeleton.qIndex(j) + static_cast<int>(k)],
                   s = slope[skeleton.vIndex(j) + static_cast<int>(k)];
      if ((value <= dof.lower && s < 0.0) || (value >= dof.upper && s > 0.0)) continue;
      largest = std::max(largest, std::abs(s));
    }
  return largest;
}

TEST(SerialPose, OutOfReachEndsStationaryWithNoSlopeLeft) {
  const Skeleton skeleton = toSkeleton(robotTable("panda"));
  const auto solver = makeSolver("serial-pose");
  solver->prepare(skeleton);
  std::mt19937_64 random(13);
  for (int i = 0; i < problems / 10; ++i) {
    IkProblem problem = reachablePose(skeleton, random);
    problem.goals[0].target = problem.goals[0].target.normalized() * 2.0;
    for (const int restarts : {0, 50}) {
      const IkReport report = solver->solve(problem, {.restarts = restarts}, TraceLevel::Off);
      EXPECT_EQ(report.why, Stop::Stationary);
      EXPECT_LT(freeSlope(problem, report.q),
                1e-9);  // Newton converges quadratically; 1e-11 is asked for inside
      EXPECT_LE(judge(problem, report.q).limitViolation, 0.0);
    }
  }
}

TEST(SerialPose, AGoalDraggedOutOfReachMovesTheArmSmoothly) {
  const Skeleton skeleton = toSkeleton(robotTable("panda"));
  const auto solver = makeSolver("serial-pose");
  solver->prepare(skeleton);
  VectorXd q(7);
  q << 0.0, 0.3, 0.0, -1.5, 0.0, 1.9, 0.7;
  Eigen::Isometry3d tip = forwardKinematics(skeleton, q).back();
  IkProblem problem{.skeleton = &skeleton, .start = q};
  problem.goals = {{.kind = GoalKind::Pose,
                    .joint = skeleton.jointCount() - 1,
                    .orientation = Eigen::Quaterniond(tip.linear())}};
  for (int frame = 0; frame < 200; ++frame) {
    problem.goals[0].target = tip.translation() + Eigen::Vector3d(0.01 * frame, 0.0, 0.0);  // to 2 m beyond
    const IkReport report = solver->solve(problem, {.restarts = 100}, TraceLevel::Off);
    EXPECT_NE(report.why, Stop::Stalled);
    EXPECT_LT((report.q - problem.start).cwiseAbs().maxCoeff(), 0.25)
        << "frame " << frame;  // a jump to another branch is > 1
    problem.start = report.q;
  }
}

TEST(SerialPose, FullTurnsWrapAndAnglesPastAHalfTurnAreReturned) {
  // UR5: +-2 pi. The answer is the representative nearest to the start, also past pi.
  const Skeleton skeleton = toSkeleton(robotTable("ur5"));
  const auto solver = makeSolver("serial-pose");
  solver->prepare(skeleton);
  VectorXd wanted(6);
  wanted << 4.0, -1.0, 1.2, -3.9, 5.5, -6.0;
  IkProblem problem{.skeleton = &skeleton, .start = wanted + VectorXd::Constant(6, 0.05)};
  const Frames frames = forwardKinematics(skeleton, wanted);
  problem.goals = {{.kind = GoalKind::Pose,
                    .joint = skeleton.jointCount() - 1,
                    .target = frames.back().translation(),
                    .orientation = Eigen::Quaterniond(frames.back().linear())}};
  const IkReport report = solver->solve(problem, {.restarts = 100}, TraceLevel::Off);
  EXPECT_TRUE(judge(problem, report.q).solved);
  EXPECT_LT((report.q - wanted).cwiseAbs().maxCoeff(),
            1e-4);  // well conditioned: 1e-6 of error is far less than 1e-4 of angle
}

TEST(SerialPose, KernelsOfAllInstructionSetsAgree) {
  for (const Robot& robot : robots()) {
    SCOPED_TRACE(robot.name);
    const Skeleton skeleton = toSkeleton(robot.table());
    const SerialChain chain = extractSerialChain(skeleton, skeleton.jointCount() - 1).chain;
    const SerialPoseSolver baseline(chain, InstructionSet::Baseline);
    for (const InstructionSet set : {InstructionSet::Avx2, InstructionSet::Avx512}) {
      if (!isAvailable(set)) continue;
      const SerialPoseSolver other(chain, set);
      std::mt19937_64 random(14);
      int same = 0;
      const int count = problems / 2;
      for (int i = 0; i < count; ++i) {
        const IkProblem problem = reachablePose(skeleton, random);
        const Goal& goal = problem.goals[0];
        const TipGoal tip{.target = goal.target, .orientation = goal.orientation.toRotationMatrix()};
        const ChainVector start = problem.start;
        const SerialPoseAnswer a = baseline.solve(tip, start), b = other.solve(tip, start);
        EXPECT_EQ(a.why, Stop::Converged);
        EXPECT_EQ(b.why, Stop::Converged);
        same += (a.q - b.q).norm() < 1e-3;  // 1e-6 of error may be 1e-3 of angle near a singular pose
      }
      // Rounding differs by fused operations; a descent from far away that grazes a wall may then take
      // another branch.
      EXPECT_GE(same, count * 98 / 100);
    }
  }
}

TEST(SerialPose, TheFastJacobianIsTheSkeletonsOwn) {
  for (const Robot& robot : robots()) {
    SCOPED_TRACE(robot.name);
    const Skeleton skeleton = toSkeleton(robot.table());
    const int tip = skeleton.jointCount() - 1;
    std::mt19937_64 random(15);
    for (const InstructionSet set :
         {InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Avx512}) {
      if (!isAvailable(set)) continue;
      const SerialPoseSolver solver(extractSerialChain(skeleton, tip).chain, set);
      for (int i = 0; i < 20; ++i) {
        const VectorXd q = randomWithinLimits(skeleton, random);
        const Frames frames = forwardKinematics(skeleton, q);
        ChainJacobian J;
        const Eigen::Isometry3d found = solver.frameAndJacobian(q, J);
        EXPECT_LT((found.matrix() - frames[tip].matrix()).cwiseAbs().maxCoeff(),
                  1e-13);  // a dozen roundings of metres
        EXPECT_LT((J - frameJacobian(skeleton, q, frames, tip)).cwiseAbs().maxCoeff(), 1e-13);
      }
    }
  }
}

TEST(SerialPose, ABatchSolvesWhatSinglesSolve) {
  const Skeleton skeleton = toSkeleton(robotTable("panda"));
  const SerialChain chain = extractSerialChain(skeleton, skeleton.jointCount() - 1).chain;
  for (const bool table : {false, true}) {
    SerialPoseSolver solver(chain);
    if (table) {
      ASSERT_TRUE(solver.buildSeedTable({.samples = 40'000}));
    }
    std::mt19937_64 random(16);
    std::vector<Eigen::Isometry3d> targets;
    std::vector<double> starts;
    std::vector<IkProblem> all;
    for (int i = 0; i < problems; ++i) {
      all.push_back(reachablePose(skeleton, random));
      targets.push_back(Eigen::Translation3d(all[i].goals[0].target) * all[i].goals[0].orientation);
      starts.insert(starts.end(), all[i].start.begin(), all[i].start.end());
    }
    std::vector<KernelAnswer> answers(targets.size());
    solver.solveBatch(targets, starts, answers);
    for (int i = 0; i < problems; ++i)
      EXPECT_TRUE(judge(all[i], Eigen::Map<const VectorXd>(answers[i].q, 7)).solved);
  }
}

TEST(SerialPose, ADraggedGoalDoesNotMakeJointsJump) {
  for (const Robot& robot : robots()) {
    SCOPED_TRACE(robot.name);
    const Skeleton skeleton = toSkeleton(robot.table());
    const int tip = skeleton.jointCount() - 1;
    const SerialPoseSolver solver(extractSerialChain(skeleton, tip).chain);
    std::mt19937_64 random(17);
    int jumps = 0;
    for (int i = 0; i < problems; ++i) {
      IkProblem problem{.skeleton = &skeleton, .start = randomWithinLimits(skeleton, random)};
      const Eigen::Isometry3d target = forwardKinematics(skeleton, problem.start)[tip];
      for (double& q : problem.start) q += 0.15 * (2.0 * uniform01(random) - 1.0);
      problem.start = projectToLimits(skeleton, problem.start);
      problem.goals = {{.kind = GoalKind::Pose,
                        .joint = tip,
                        .target = target.translation(),
                        .orientation = Eigen::Quaterniond(target.linear())}};
      const SerialPoseAnswer answer =
          solver.solve({.target = target.translation(), .orientation = target.linear()}, problem.start);
      EXPECT_TRUE(judge(problem, answer.q).solved);
      jumps += (answer.q - problem.start).cwiseAbs().maxCoeff() > 0.5;
    }
    EXPECT_LE(jumps, problems / 1000);
  }
}

TEST(SerialPose, TheTraceLeadsFromTheStartToTheAnswer) {
  const Skeleton skeleton = toSkeleton(robotTable("panda"));
  const auto solver = makeSolver("serial-pose");
  solver->prepare(skeleton);
  std::mt19937_64 random(18);
  for (const double reach : {1.0, 3.0}) {  // a pose within reach, and three times as far away
    IkProblem problem = reachablePose(skeleton, random);
    problem.goals[0].target *= reach;
    const IkReport report = solver->solve(problem, {.restarts = 100}, TraceLevel::Full);
    ASSERT_GT(report.trace.size(), 3u);
    EXPECT_EQ(report.trace.front().q, problem.start);
    EXPECT_EQ(report.trace.back().q, report.q);
    for (const IterationRecord& record : report.trace) {
      const GoalError error = judge(problem, record.q).goals[0];
      EXPECT_NEAR(record.residual, std::hypot(error.position, error.orientation), 1e-9);
    }
    for (size_t k = 2; k < report.trace.size(); ++k)
      EXPECT_LE(report.trace[k].residual, report.trace[k - 1].residual * (1.0 + 1e-9));
  }
}

TEST(SerialPose, WhatIsNotFiniteIsRefused) {
  const Skeleton skeleton = toSkeleton(robotTable("panda"));
  const SerialPoseSolver solver(extractSerialChain(skeleton, skeleton.jointCount() - 1).chain);
  const ChainVector start = ChainVector::Zero(7);
  ChainVector bad = start;
  bad[3] = std::nan("");
  EXPECT_THROW(solver.solve({}, bad), std::invalid_argument);
  EXPECT_THROW(solver.solve({.target = {0.0, INFINITY, 0.0}}, start), std::invalid_argument);
  const SerialPoseAnswer far = solver.solve({.target = {1e200, 0.0, 0.0}}, start, {.restarts = 32});
  EXPECT_TRUE(far.q.allFinite());
  EXPECT_NE(far.why, Stop::Converged);
}

TEST(SeedTable, FirstStartsLeadToMorePosesThanRandomOnes) {
  const Skeleton skeleton = toSkeleton(robotTable("panda"));
  const SerialChain chain = extractSerialChain(skeleton, skeleton.jointCount() - 1).chain;
  SerialPoseSolver solver(chain);
  EXPECT_EQ(solver.seedTable(), nullptr);
  ASSERT_TRUE(solver.buildSeedTable({.samples = 100'000}));
  EXPECT_EQ(solver.seedTable()->bytes(), 4096 * (sizeof(SeedCell) + 1));
  EXPECT_GT(solver.seedTable()->filledCells(), 0.8);
  std::mt19937_64 random(19);
  std::vector<Eigen::Isometry3d> targets;
  std::vector<double> starts;
  for (int i = 0; i < problems; ++i) {
    const IkProblem problem = reachablePose(skeleton, random);
    targets.push_back(Eigen::Translation3d(problem.goals[0].target) * problem.goals[0].orientation);
    starts.insert(starts.end(), problem.start.begin(), problem.start.end());
  }
  const auto solvedAtOnce = [&](const SerialPoseSolver& with) {
    std::vector<KernelAnswer> answers(targets.size());
    with.solveBatch(targets, starts, answers);
    return std::count_if(answers.begin(), answers.end(),
                         [](const KernelAnswer& a) { return a.solved && a.attempts == 1; });
  };
  const auto withTable = solvedAtOnce(solver), without = solvedAtOnce(SerialPoseSolver(chain));
  std::printf("  first start leads to the pose: table %ld, random %ld of %d\n", withTable, without, problems);
  EXPECT_GT(withTable, without + problems / 10);
  EXPECT_GT(withTable, problems * 8 / 10);  // two thirds where the last joint is rolled the wrong way
}

TEST(SeedTable, ChainsThatEndInASlideHaveNone) {
  const Skeleton skeleton = toSkeleton(robotTable("panda"));
  SerialChain chain = extractSerialChain(skeleton, skeleton.jointCount() - 1).chain;
  chain.constants.revolute[chain.n - 1] = 0.0;
  chain.hasPrismatic = true;
  EXPECT_FALSE(SerialPoseSolver(chain).buildSeedTable());
}

}  // namespace
}  // namespace gelenk
