// Joints that follow others in the drag solver.
#include <gtest/gtest.h>

#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "solvers/problem/judge.h"
#include "solvers/tree/drag_solver.h"
#include "tests/solvers/random_problem.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// Two fingers on a palm: the left one slides as the right one does, the other way.
Skeleton gripper() {
  std::vector<Joint> joints{
      {.name = "arm", .axes = {{AxisDof::Kind::Rotation, Vector3d::UnitZ(), -2.0, 2.0}}},
      {.name = "palm", .parent = 0},
      {.name = "right", .parent = 1},
      {.name = "left", .parent = 1},
      {.name = "other", .parent = 0}};
  joints[1].parentFromZero.translation().x() = 1.0;
  joints[4].axes = {{AxisDof::Kind::Rotation, Vector3d::UnitX()}};
  for (int i : {2, 3}) joints[i].axes = {{AxisDof::Kind::Translation, Vector3d::UnitY(), -0.1, 0.1}};
  joints[2].axes[0].lower = 0.01;
  joints[3].coupling = {.source = 2, .multiplier = -1.0};
  return Skeleton(joints);
}

TEST(DragCouplings, EitherFingerClosesTheGripper) {
  const Skeleton skeleton = gripper();
  EXPECT_EQ(skeleton.nv(), 3);
  for (const int finger : {2, 3}) {
    DragSolver solver(skeleton);
    VectorXd q = skeleton.rest();
    q[skeleton.qIndex(4)] = 0.3;
    setJointValue(skeleton, q, 2, 0.08);
    solver.reset(q);
    const double side = finger == 2 ? 1.0 : -1.0;
    // Pins on both: the arm stays, what is asked of one finger happens to both.
    Goal goal{.joint = finger, .target = {1.0, 0.03 * side, 0.0}, .role = Role::Pin};
    for (int k = 0; k < 60; ++k) solver.frame({&goal, 1});
    const Frames frames = forwardKinematics(skeleton, solver.q());
    EXPECT_LE((frames[finger].translation() - goal.target).norm(), 1e-3);
    EXPECT_EQ(solver.q()[skeleton.qIndex(3)], -solver.q()[skeleton.qIndex(2)]);
    EXPECT_EQ(solver.q()[skeleton.qIndex(4)], 0.3);
  }
}

/// The source lies beside the goal's path, and so do joints above it: these stay.
TEST(DragCouplings, ASourceBesideThePathMovesWithoutWhatCarriesIt) {
  std::vector<Joint> joints{{.name = "root"},
                            {.name = "carrier", .parent = 0},
                            {.name = "source", .parent = 1},
                            {.name = "follower", .parent = 0},
                            {.name = "tip", .parent = 3}};
  for (int i : {1, 2, 3}) joints[i].axes = {{AxisDof::Kind::Rotation, Vector3d::UnitZ(), -2.0, 2.0}};
  joints[3].coupling = {.source = 2, .multiplier = 2.0, .offset = 0.5};
  joints[4].parentFromZero.translation().x() = 1.0;
  const Skeleton skeleton(joints);
  EXPECT_NEAR(skeleton.joint(2).axes[0].upper, 0.75, 1e-15);  // 2 * 0.75 + 0.5 = 2
  DragSolver solver(skeleton);
  VectorXd q = skeleton.rest();
  q[skeleton.qIndex(1)] = 0.7;
  solver.reset(q);
  Goal goal{.joint = 4, .target = {std::cos(1.5), std::sin(1.5), 0.0}};
  for (int k = 0; k < 60; ++k) solver.frame({&goal, 1});
  EXPECT_NEAR(solver.q()[skeleton.qIndex(3)], 1.5, 2e-3);
  EXPECT_NEAR(solver.q()[skeleton.qIndex(2)], 0.5, 1e-3);
  EXPECT_EQ(solver.q()[skeleton.qIndex(1)], 0.7);
}

/// A follower's limit is met by the source's, in the step as in the end.
TEST(DragCouplings, LimitsOfFollowersHold) {
  const Skeleton finger = testing::tendonFinger(true);
  std::mt19937_64 random(5);
  DragSolver solver(finger);
  for (int i = 0; i < 40; ++i) {
    Goal goal{.joint = 4, .target = 2.0 * testing::randomUnit(random)};
    for (int k = 0; k < 20; ++k) {
      solver.frame({&goal, 1});
      ASSERT_LE(limitViolation(finger, solver.q()), 1e-12);
      VectorXd coupled = solver.q();
      finger.couple(coupled);
      ASSERT_EQ(coupled, solver.q());
    }
  }
}

TEST(DragCouplings, ReachesWhatCoupledTreesReach) {
  std::mt19937_64 random(6);
  int solved = 0, count = 0;
  for (int i = 0; i < 60; ++i) {
    const Skeleton skeleton = testing::withCouplings(testing::randomSkeleton(random, 9), random);
    if (skeleton.followers().empty()) continue;
    IkProblem problem{.skeleton = &skeleton, .start = randomWithinLimits(skeleton, random)};
    const Frames there = forwardKinematics(skeleton, randomWithinLimits(skeleton, random));
    for (const int joint : {skeleton.followers()[0], skeleton.jointCount() - 1})
      problem.goals.push_back({.joint = joint, .target = there[joint].translation()});
    problem.positionTolerance = 1e-5;
    DragSolver solver(skeleton);
    const IkReport report = solver.solve(problem, {.maxIterations = 300, .restarts = 5});
    ++count;
    solved += judge(problem, report.q).solved;
  }
  ASSERT_GE(count, 40);
  EXPECT_GE(solved, count * 95 / 100) << "of " << count;
}

}  // namespace
}  // namespace gelenk
