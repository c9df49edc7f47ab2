#include "solvers/tree/drag_solver.h"

#include <gtest/gtest.h>

#include <optional>

#include "solvers/iteration/evaluator.h"
#include "solvers/problem/judge.h"
#include "solvers/tree/drag_solver.h"
#include "tests/kinematics/random_skeleton.h"
#include "tests/solvers/tree/drag_marks.h"

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define GELENK_SANITIZED
#endif
#endif

// The marks of the drag solver on the built-in figure, both hands and the head dragged, the feet pinned.
// Times are measured by drag_benchmark, which also prints this table over more frames.
namespace gelenk {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using marks::Figure;
using marks::Path;
using marks::quantile;
using marks::Shown;

#ifdef GELENK_SANITIZED
constexpr int pathCount = 2, pathLength = 200;
#else
constexpr int pathCount = 10, pathLength = 1000;
#endif

Path held(const Path& path, int frames) { return Path(frames, path.back()); }

class Marks : public ::testing::Test {
 protected:
  Figure figure;
  DragSolver solver{figure.skeleton};
  std::mt19937_64 random{2024};

  void expectSound(const Shown& shown) {
    EXPECT_EQ(shown.notFinite, 0);
    EXPECT_LE(shown.worstViolation, 1e-12);
  }
};

class ReachableDrag : public Marks, public ::testing::WithParamInterface<double> {};

TEST_P(ReachableDrag, FollowsItsTargetAndKeepsTheFeet) {
  const double step = GetParam(), wanted = step < 0.02 ? 1e-3 : 3e-3;
  RecordProperty("seed", 2024);
  Shown all;
  for (int i = 0; i < pathCount; ++i) {
    const Path path = marks::reachablePath(figure, random, pathLength, step);
    solver.reset(figure.start);
    all.add(marks::follow(figure, solver, path, step));
    marks::follow(figure, solver, held(path, 60), 0.0);
    EXPECT_LE(quantile(marks::follow(figure, solver, held(path, 5), 0.0).errors, 1.0), 1e-5)
        << "held, path " << i;
  }
  EXPECT_LE(quantile(all.errors, 0.99), wanted);
  EXPECT_LE(all.worstPin, 3e-4);
  EXPECT_LE(all.worstJump, 3.0);
  expectSound(all);
}
INSTANTIATE_TEST_SUITE_P(OneAndFiveCentimetresAFrame, ReachableDrag, ::testing::Values(0.01, 0.05));

class UnreachableDrag : public Marks, public ::testing::WithParamInterface<double> {};

TEST_P(UnreachableDrag, KeepsTheFeetAndTurnsNoJointFast) {
  const double step = GetParam();
  Shown all;
  for (int i = 0; i < pathCount; ++i) {
    solver.reset(figure.start);
    const Path path = marks::wildPath(figure, random, pathLength, step);
    all.add(marks::follow(figure, solver, path, step));
    marks::follow(figure, solver, held(path, 200), 0.0);
    EXPECT_LE(marks::follow(figure, solver, held(path, 10), 0.0).worstRotation, 1e-5) << "held, path " << i;
  }
  EXPECT_LE(all.worstPin, 2e-3);
  EXPECT_LE(all.worstRotation, 0.22);
  expectSound(all);
}
INSTANTIATE_TEST_SUITE_P(OneAndFiveCentimetresAFrame, UnreachableDrag, ::testing::Values(0.01, 0.05));

TEST_F(Marks, TargetsThatJumpTwoMetresDoNoHarm) {
  Path path;
  std::vector<Vector3d> targets(Figure::dragCount);
  for (int i = 0; i < pathCount * pathLength; ++i) {
    if (i % 15 == 0)
      for (int k = 0; k < Figure::dragCount; ++k) {
        const Vector3d from = i == 0 ? figure.dragged(figure.startFrames, k) : targets[k];
        Vector3d to = from + 2.0 * testing::randomUnit(random);
        if ((to - Vector3d(0, 1.2, 0)).norm() > 2.0)
          to = from + 2.0 * (Vector3d(0, 1.2, 0) - from).normalized();
        targets[k] = to;
      }
    path.push_back(targets);
  }
  const Shown shown = marks::follow(figure, solver, path, 2.0);
  expectSound(shown);
  EXPECT_LE(shown.worstRotation, 0.22);
}

TEST_F(Marks, HandFarOutsideStretchesTheArmAndRests) {
  std::vector<Goal> goals = figure.goals();
  const Vector3d from = goals[1].target, to(-1.5, 1.6, 0.8);
  for (int frame = 0; frame <= 60; ++frame) {
    goals[1].target = from + frame / 60.0 * (to - from);
    solver.frame(goals);
  }
  for (int frame = 0; frame < 25; ++frame) solver.frame(goals);
  VectorXd before = solver.q();
  for (int frame = 25; frame < 200; ++frame) {
    const VectorXd q = solver.frame(goals).q;
    EXPECT_LE(figure.largestRotation(before, q), 1e-4) << "frame " << frame;
    before = q;
  }
  for (int frame = 0; frame < 20; ++frame) {
    const VectorXd q = solver.frame(goals).q;
    EXPECT_LE(figure.largestRotation(before, q), 1e-5);
    before = q;
  }
  const Frames frames = forwardKinematics(figure.skeleton, solver.q());
  const auto at = [&](const char* name) -> Vector3d {
    return frames[figure.skeleton.jointIndex(name)].translation();
  };
  const Vector3d arm = (at("hand_r") - at("upperarm_r")).normalized(),
                 aim = (to - at("upperarm_r")).normalized();
  EXPECT_GE(arm.dot(aim), std::cos(0.15));  // stretched towards the target
  EXPECT_GE((at("hand_r") - at("upperarm_r")).norm(),
            0.99 * ((at("hand_r") - at("lowerarm_r")).norm() + (at("lowerarm_r") - at("upperarm_r")).norm()));
}

TEST_F(Marks, OutAndBackOnAReachablePathEndsInTheSamePose) {
  double worst = 0.0;
  for (int i = 0; i < pathCount; ++i) {
    solver.reset(figure.start);
    Path path = marks::reachablePath(figure, random, 100, 0.02);
    marks::follow(figure, solver, held(Path{path.front()}, 120), 0.0);
    const VectorXd begin = solver.q();
    marks::follow(figure, solver, path, 0.02);
    std::reverse(path.begin(), path.end());
    marks::follow(figure, solver, path, 0.02);
    marks::follow(figure, solver, held(path, 120), 0.0);
    worst = std::max(worst, figure.largestRotation(begin, solver.q()));
  }
  EXPECT_LE(
      worst,
      1e-3);  // both rests are within the smallest step of the same minimum, seen through its softest joint
  RecordProperty("worst", std::to_string(worst));
}

TEST_F(Marks, ColdSolvesOfFiveGoalsAllArrive) {
  const auto cold = makeDrag();
  const Skeleton& skeleton = figure.skeleton;
  for (int i = 0; i < pathCount * pathLength / 10; ++i) {
    const VectorXd pose = marks::halfRangePose(skeleton, random);
    const Frames frames = forwardKinematics(skeleton, pose);
    IkProblem problem{.skeleton = &skeleton, .start = skeleton.rest(), .positionTolerance = 1e-3};
    for (const int joint : {figure.hands[0], figure.hands[1], figure.head, figure.feet[0], figure.feet[1]})
      problem.goals.push_back({.joint = joint, .target = frames[joint].translation()});
    const IkReport report = cold->solve(problem, {}, TraceLevel::Off);
    EXPECT_TRUE(judge(problem, report.q).solved) << "problem " << i;
  }
}

TEST_F(Marks, ChangingTheDraggedPointChangesThePoseContinuously) {
  std::vector<Goal> goals = figure.goals();
  goals[0].target += Vector3d(0.1, 0.2, 0.1);
  for (int i = 0; i < 40; ++i) solver.frame(goals);
  // The user lets go of the palm and takes the elbow, then the knee, where they are.
  for (const char* name : {"lowerarm_l", "calf_r", "hand_l"}) {
    const int joint = figure.skeleton.jointIndex(name);
    const Frames frames = forwardKinematics(figure.skeleton, solver.q());
    goals[0] = {.name = "drag",
                .joint = joint,
                .pointInJoint = {0, 0, 0.02},
                .target = frames[joint] * Vector3d(0, 0, 0.02)};
    const VectorXd before = solver.q();
    solver.frame(goals);
    EXPECT_LE(figure.largestRotation(before, solver.q()), 0.06) << name;
  }
  goals.erase(goals.begin());
  const VectorXd before = solver.q();
  solver.frame(goals);
  EXPECT_LE(figure.largestRotation(before, solver.q()), 0.06) << "a goal that vanishes";
}

TEST_F(Marks, PoleTurnsTheElbowAndLeavesTheHand) {
  std::vector<Goal> goals = figure.goals();
  const int elbow = figure.skeleton.jointIndex("lowerarm_l");
  goals[0].target = {0.35, 1.25, 0.30};
  for (const Vector3d& side : {Vector3d(1.5, 1.2, 0.0), Vector3d(0.6, 0.2, -0.4)}) {
    std::vector<Goal> withPole = goals;
    withPole.push_back({.kind = GoalKind::Pole, .joint = elbow, .target = side, .weight = 0.1});
    solver.reset(figure.start);
    for (int i = 0; i < 150; ++i) solver.frame(withPole);
    const Frames frames = forwardKinematics(figure.skeleton, solver.q());
    EXPECT_LE((figure.dragged(frames, 0) - goals[0].target).norm(), 1e-4);
    Eigen::VectorXd r(1);
    goalResidual(withPole.back(), figure.skeleton, solver.q(), frames, r);
    EXPECT_LE(std::abs(r[0]), 0.02);
    const Vector3d a = frames[figure.skeleton.parent(elbow)].translation(), b = frames[elbow].translation(),
                   c = frames[figure.hands[0]].translation(), u = (c - a).normalized();
    EXPECT_GT((b - a - u * u.dot(b - a)).dot(side - a), 0.0);  // the right one of the two sides
  }
}

TEST_F(Marks, PoseAimAndOrientationGoalsAreMet) {
  std::vector<Goal> goals = figure.goals();
  const int hand = figure.hands[0];
  const Eigen::Quaterniond turned =
      Eigen::Quaterniond(figure.startFrames[hand].linear()) * expRotation({0.3, 0.2, -0.4});
  goals[0] = {.kind = GoalKind::Pose,
              .joint = hand,
              .target = figure.startFrames[hand].translation() + Vector3d(0, 0.1, 0),
              .orientation = turned};
  goals[2] = {
      .kind = GoalKind::Aim, .joint = figure.head, .target = {0.5, 1.2, 2.0}, .axisInJoint = {0, -1, 0}};
  for (int i = 0; i < 200; ++i) solver.frame(goals);
  IkProblem problem{.skeleton = &figure.skeleton, .start = figure.start, .goals = {goals[0], goals[2]}};
  const Judgement verdict = judge(problem, solver.q());
  EXPECT_LE(verdict.goals[0].position, 1e-4);
  EXPECT_LE(verdict.goals[0].orientation, 1e-3);
  EXPECT_LE(verdict.goals[1].orientation, 2e-2);  // no correction of the posture's pull on an aim
}

TEST(DragSolver, WorksAtEveryScaleAlike) {
  std::vector<double> reached;
  for (const double scale : {1.0, 300.0, 1e-3}) {
    std::vector<Joint> chain;
    for (int i = 0; i < 4; ++i) {
      Joint joint{.name = "j" + std::to_string(i), .parent = i - 1};
      joint.parentFromZero.translation() =
          i == 0 ? scale * Vector3d(0.5, 4.0, 0) : scale * Vector3d(0.5, 0, 0);
      if (i < 3) joint.axes = {{AxisDof::Kind::Rotation, Vector3d::UnitZ()}};
      chain.push_back(joint);
    }
    const Skeleton arm(chain);
    DragSolver solver(arm);
    Goal goal{.joint = 3, .target = scale * (Vector3d(0.5, 4.0, 0) + Vector3d(0.6, 0.7, 0))};
    const std::vector<Goal> goals{goal};
    VectorXd q = arm.rest();
    q << 0.3, 0.4, 0.5;
    solver.reset(q);
    for (int i = 0; i < 80; ++i) solver.frame(goals);
    EXPECT_LE((forwardKinematics(arm, solver.q())[3].translation() - goal.target).norm(), 1e-5 * scale);
    reached.push_back(solver.q()[0]);
  }
  EXPECT_NEAR(reached[0], reached[1], 1e-9);
  EXPECT_NEAR(reached[0], reached[2], 1e-9);
}

TEST(DragSolver, RandomSkeletonsStayWithinLimitsAndFiniteWhateverIsAsked) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 60; ++i) {
    const Skeleton skeleton = testing::randomSkeleton(random, 12);
    DragSolver solver(skeleton);
    solver.reset(randomWithinLimits(skeleton, random));
    for (int frame = 0; frame < 60; ++frame) {
      std::vector<Goal> goals;
      const int count = static_cast<int>(random() % 4);
      for (int k = 0; k < count; ++k) {
        Goal goal;
        goal.kind = static_cast<GoalKind>(random() % 4);
        goal.joint = static_cast<int>(random() % 12);
        goal.target = std::pow(10.0, 4.0 * uniform01(random) - 2.0) * testing::randomUnit(random);
        goal.orientation = expRotation(3.0 * testing::randomUnit(random));
        if (random() % 20 == 0) goal.target.x() = std::numeric_limits<double>::quiet_NaN();
        goal.role = random() % 2 == 0 ? Role::Drag : Role::Pin;
        goals.push_back(goal);
      }
      const IkReport& report = solver.frame(goals, TraceLevel::Full);
      ASSERT_TRUE(report.q.allFinite()) << "skeleton " << i;
      EXPECT_LE(limitViolation(skeleton, report.q), 1e-12);
      EXPECT_TRUE(std::isfinite(report.residual));
      EXPECT_EQ(static_cast<int>(report.trace.size()), report.counters.iterations);
    }
  }
}

/// At a goal that is met, the rest of a planar arm stays in the posture asked for, and leaves it for the
/// skeleton's rest pose.
TEST(DragSolver, PullsTowardsThePostureThatItIsTold) {
  std::vector<Joint> joints{{.name = "base"}};
  for (int i = 0; i < 4; ++i) {
    Joint joint{.name = "j" + std::to_string(i), .parent = i};
    joint.parentFromZero.translation() << (i == 0 ? 0.0 : 0.5), 0, 0;
    joint.axes = {{AxisDof::Kind::Rotation, Eigen::Vector3d::UnitZ()}};
    joints.push_back(joint);
  }
  joints.push_back({.name = "tip", .parent = 4});
  joints.back().parentFromZero.translation() << 0.5, 0, 0;
  const Skeleton arm(joints);
  const Eigen::Vector4d bent(1.2, -1.0, 0.8, -1.1);
  std::vector<Goal> goals{
      {.joint = 5, .target = forwardKinematics(arm, bent)[5].translation(), .role = Role::Drag}};
  const auto atRest = [&](const std::optional<Eigen::VectorXd>& posture) {
    DragSolver solver(arm);
    if (posture) solver.setPosture(*posture);
    solver.reset(bent);
    for (int frame = 0; frame < 300; ++frame) solver.frame(goals);
    return Eigen::VectorXd(solver.q());
  };
  EXPECT_LT((atRest(bent) - bent).norm(), 1e-6);
  EXPECT_GT((atRest(std::nullopt) - bent).norm(), 0.05);
  DragSolver solver(arm);
  EXPECT_THROW(solver.setPosture(Eigen::Vector3d::Zero()), std::invalid_argument);
}

TEST(DragSolver, SaysWhatIsWrongWithAGoal) {
  const Figure figure;
  DragSolver solver(figure.skeleton);
  const std::vector<Goal> unknown{{.joint = 99}};
  EXPECT_THROW(solver.frame(unknown), std::invalid_argument);
  EXPECT_THROW(solver.reset(VectorXd::Zero(3)), std::invalid_argument);
  EXPECT_THROW(DragSolver(figure.skeleton, {.stiffness = {1.0}}), std::invalid_argument);
}

}  // namespace
}  // namespace gelenk
