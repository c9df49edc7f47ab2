// Goals as a person handles them: pins that stay, mirrored goals, weights, solvers that can and cannot.
#include <gtest/gtest.h>

#include "apps/document/scene_file.h"
#include "apps/document/session.h"
#include "kinematics/notation/mannequin.h"
#include "solvers/problem/ik_solver.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

Model figure() {
  Model model{.name = "figure", .skeleton = mannequin()};
  model.handles = mannequinHandles();
  model.pins = {"foot_l", "foot_r"};
  return model;
}

void stepFrames(Session& session, int frames) {
  for (int i = 0; i < frames; ++i) session.step();
}

/// Drags the goal on a straight path, a frame at a time, and stays there.
void drag(Session& session, GoalId goal, const Vector3d& by, int frames = 20) {
  session.beginDrag(goal);
  const Vector3d start = session.goal(goal).goal.target;
  for (int i = 1; i <= frames; ++i) {
    session.moveDrag(start + by * i / frames);
    session.step();
  }
  stepFrames(session, 60);
}

/// Review 12: a hand that was pulled out of reach and pinned there pulled the feet 24.5 mm away for good. A
/// pin holds a point where it is.
TEST(Pins, ANewPinLeavesTheOldOnesWhereTheyAre) {
  for (const Vector3d& by : {Vector3d(-0.05, 0.2, 0.1), Vector3d(-1.5, 0.4, 0.4), Vector3d(0.3, 1.5, 0.9)})
    for (const bool whileDragging : {true, false}) {
      Session session(figure());
      const GoalId hand = *session.findGoal("hand_r"), foot = *session.findGoal("foot_l");
      const Vector3d stood = session.reached(foot);
      drag(session, hand, by);
      if (whileDragging) session.togglePin(hand);
      session.endDrag();
      if (!whileDragging) session.togglePin(hand);
      const Vector3d pinnedAt = session.reached(hand);
      EXPECT_EQ(session.goal(hand).state, GoalState::Pinned);
      stepFrames(session, 120);
      EXPECT_LT((session.reached(foot) - stood).norm(), 3e-4) << by.transpose() << whileDragging;
      EXPECT_LT((session.reached(hand) - pinnedAt).norm(), 2e-3) << by.transpose() << whileDragging;
    }
}

/// Review 12: the pose was mirrored, the goal that held it was not.
TEST(Mirror, GoalsGoAlong) {
  Session session(figure());
  const GoalId right = *session.findGoal("hand_r"), left = *session.findGoal("hand_l");
  drag(session, right, {-0.05, 0.25, 0.15});
  session.endDrag();
  stepFrames(session, 30);
  session.togglePin(*session.findGoal("head"));
  stepFrames(session, 5);
  const Vector3d target = session.goal(right).goal.target;
  const Vector3d knee = session.reached(*session.findGoal("calf_l_pole"));
  session.mirrorPose();
  EXPECT_EQ(session.goal(right).state, GoalState::Free);
  EXPECT_EQ(session.goal(left).state, GoalState::Held);
  EXPECT_LT((session.goal(left).goal.target - Vector3d(-target.x(), target.y(), target.z())).norm(), 1e-9);
  EXPECT_EQ(session.goal(*session.findGoal("head")).state, GoalState::Pinned);
  EXPECT_EQ(session.goal(*session.findGoal("foot_r")).state, GoalState::Pinned);
  const Eigen::VectorXd mirrored = session.q();
  stepFrames(session, 60);  // and the pose rests as it is mirrored
  EXPECT_LT(session.error(left), 1e-3);
  EXPECT_LT((session.q() - mirrored).lpNorm<Eigen::Infinity>(), 2e-2);
  EXPECT_LT(
      (session.reached(*session.findGoal("calf_r_pole")) - Vector3d(-knee.x(), knee.y(), knee.z())).norm(),
      1e-2);
  session.mirrorPose();
  EXPECT_EQ(session.goal(right).state, GoalState::Held);
  EXPECT_LT((session.goal(right).goal.target - target).norm(), 1e-9);
}

/// Review 4: Tab went through solvers that can do nothing here.
TEST(Solvers, TabSkipsThoseThatCannotDoThePresentGoals) {
  Session session(figure());
  drag(session, *session.findGoal("hand_r"), {0.0, 0.1, 0.0});
  session.endDrag();
  EXPECT_NE(session.whyUnsupported("two-link"), "");
  EXPECT_EQ(session.whyUnsupported("drag"), "");
  EXPECT_EQ(session.whyUnsupported("dls"), "");
  int tried = 0;
  do {
    session.nextSolver();
    EXPECT_EQ(session.whyUnsupported(session.solver()), "") << session.solver();
    session.step();
    EXPECT_NE(session.lastSolve().why, Stop::Unsupported) << session.solver();
  } while (session.solver() != "drag" && ++tried < 60);
  EXPECT_GT(tried, 5);
}

/// Review 4: docs/lecture/two-link.md promises two-link on the figure's hand; its feet are pinned.
TEST(Solvers, WithoutThePinsTwoLinkMovesTheHand) {
  Session session(figure());
  const GoalId hand = *session.findGoal("hand_r");
  drag(session, hand, {0.02, 0.08, 0.05});
  session.endDrag();
  ASSERT_EQ(session.whyUnsupported("two-link", Session::Pins::Freed), "");
  session.freePins();
  session.setSolver("two-link");
  session.setTarget(hand, session.reached(hand) + Vector3d(0.0, 0.03, 0.03));
  stepFrames(session, 3);
  EXPECT_LT(session.error(hand), 1e-3);
  ASSERT_TRUE(session.undo());
  EXPECT_EQ(session.goal(*session.findGoal("foot_l")).state, GoalState::Pinned);
}

/// Review 13: "at rest, 833.3 mm" never said that it is out of reach.
TEST(Solvers, OutOfReachIsToldWhereTheBodyRests) {
  Session session(figure());
  const GoalId hand = *session.findGoal("hand_r");
  const Vector3d start = session.reached(hand);
  session.setTarget(hand, start + Vector3d(-2.0, 0.6, 0.4));
  stepFrames(session, 400);
  EXPECT_FALSE(session.lastSolve().reached);
  EXPECT_TRUE(session.lastSolve().outOfReach)
      << toString(session.lastSolve().why) << " " << session.lastSolve().jointMotion;
}

/// Two hands pull one chest in two directions: the heavier goal is missed by less, and files remember it.
TEST(Weights, AHeavierGoalIsMissedByLess) {
  const auto missed = [](double weight) {
    Session session(figure());
    const GoalId right = *session.findGoal("hand_r"), left = *session.findGoal("hand_l");
    session.setTarget(right, session.reached(right) + Vector3d(-0.8, 0.1, 0.0));
    session.setTarget(left, session.reached(left) + Vector3d(0.8, 0.1, 0.0));
    session.setWeight(right, weight);
    stepFrames(session, 400);
    return session.error(right);
  };
  EXPECT_LT(missed(4.0), missed(1.0) - 0.01);
  EXPECT_GT(missed(0.25), missed(1.0) + 0.01);
}

TEST(Weights, AreKeptByFilesAndRefusedWhereTheyMakeNoSense) {
  Session session(figure());
  const GoalId hand = *session.findGoal("hand_r");
  session.setWeight(hand, 2.5);
  EXPECT_THROW(session.setWeight(hand, -1.0), std::invalid_argument);
  EXPECT_THROW(session.setWeight(hand, std::nan("")), std::invalid_argument);
  const std::string text = formatScene(session.saved(), session.model());
  const Document read = parseScene(text, "test.json", session.model());
  for (const SceneGoal& goal : read.edits.goals) EXPECT_EQ(goal.weight, goal.id == hand ? 2.5 : 1.0);
}

}  // namespace
}  // namespace gelenk
