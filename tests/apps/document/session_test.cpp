#include "apps/document/session.h"

#include <gtest/gtest.h>

#include "kinematics/configuration.h"
#include "kinematics/notation/mannequin.h"
#include "kinematics/symmetry.h"
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

/// Three links of 0.3 m along x that turn about z, in a sleeve whose rings blend neighbouring joints half and
/// half.
Model sleeve() {
  std::vector<Joint> joints;
  for (int i = 0; i < 4; ++i) {
    Joint joint{.name = "j" + std::to_string(i), .parent = i - 1};
    if (i > 0) joint.parentFromZero.translation() = Vector3d(0.3, 0, 0);
    if (i < 3) joint.axes = {{AxisDof::Kind::Rotation, Vector3d::UnitZ(), -2.5, 2.5}};
    joints.push_back(joint);
  }
  Eigen::VectorXd rest(3);
  rest << 0.3, 0.4, 0.5;
  Model model{.name = "sleeve", .skeleton = Skeleton(joints, rest), .planar = true};
  const Frames frames = restFrames(model.skeleton);
  Mesh mesh;
  std::vector<Influences> influences;
  for (int i = 1; i < 3; ++i) {  // one triangle beside each inner joint
    const Vector3d at = frames[i].translation();
    const int first = static_cast<int>(mesh.positions.size());
    for (const Vector3d& offset :
         {Vector3d(0.0, 0.05, 0.05), Vector3d(0.05, 0.05, 0.05), Vector3d(0.0, 0.1, 0.05)}) {
      mesh.positions.push_back(at + offset);
      influences.push_back({{i - 1, i, 0, 0}, {0.5, 0.5, 0.0, 0.0}});
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  model.skin = bindSkin(mesh, frames, influences);
  return model;
}

void stepFrames(Session& session, int frames) {
  for (int i = 0; i < frames; ++i) session.step();
}

/// Drags the goal by a straight path of so many frames and lets it be held there.
void drag(Session& session, int goal, const Vector3d& by, int frames) {
  session.beginDrag(goal);
  const Vector3d start = session.goals()[goal].goal.target;
  for (int i = 1; i <= frames; ++i) {
    session.moveDrag(start + by * i / frames);
    session.step();
  }
}

TEST(Session, AReachableTargetIsReachedWithinAMillimetre) {
  Session session(figure());
  const int hand = *session.findGoal("hand_r");
  drag(session, hand, {-0.05, 0.25, 0.1}, 20);
  stepFrames(session, 20);
  EXPECT_LT(session.error(hand), 1e-3);
  EXPECT_LT(limitViolation(session.skeleton(), session.q()), 1e-9);
}

TEST(Session, OutOfReachTheArmIsStretchedTowardsTheTargetAndStill) {
  Session session(figure());
  const int hand = *session.findGoal("hand_r");
  drag(session, hand, {-2.0, 0.6, 0.4}, 20);
  for (int frame = 1; frame <= 240; ++frame) {
    const double motion = session.step().jointMotion;
    if (frame > 25) {
      EXPECT_LT(motion, frame > 200 ? 1e-5 : 1e-4) << "frame " << frame;
    }
  }
  const Frames& frames = session.frames();
  const Skeleton& skeleton = session.skeleton();
  const Vector3d shoulder = frames[skeleton.jointIndex("upperarm_r")].translation();
  const Vector3d elbow = frames[skeleton.jointIndex("lowerarm_r")].translation();
  const Vector3d wrist = frames[skeleton.jointIndex("hand_r")].translation();
  const Vector3d toTarget = (session.goals()[hand].goal.target - shoulder).normalized();
  EXPECT_GT(session.error(hand), 0.5);
  EXPECT_GT((wrist - shoulder).norm(), 0.98 * ((elbow - shoulder).norm() + (wrist - elbow).norm()));
  EXPECT_GT((wrist - shoulder).normalized().dot(toTarget), 0.98);
}

TEST(Session, OutOfReachInAnyDirectionThePoseComesToRest) {
  for (const Vector3d& by : {Vector3d(2, 0, 0), Vector3d(0, 0, 3), Vector3d(-1.5, 0.45, 0.7),
                             Vector3d(0, 2, 0), Vector3d(1, 0, -2)}) {
    Session session(figure());
    drag(session, *session.findGoal("hand_r"), by, 10);
    stepFrames(session, 200);
    EXPECT_LT(session.step().jointMotion, 1e-5) << by.transpose();
  }
}

TEST(Session, PinnedFeetStayWhileThePelvisIsPushedDown) {
  Session session(figure());
  drag(session, *session.findGoal("pelvis"), {0.0, -0.04, 0.0}, 25);
  stepFrames(session, 30);
  EXPECT_LT(session.error(*session.findGoal("foot_l")), 1e-3);
  EXPECT_LT(session.error(*session.findGoal("foot_r")), 1e-3);
  EXPECT_LT(session.error(*session.findGoal("pelvis")), 1e-3);
}

TEST(Session, AHandleStaysHeldAndOtherPointsLetGo) {
  Session session(figure());
  const int hand = *session.findGoal("hand_l");
  drag(session, hand, {0.0, 0.1, 0.0}, 5);
  session.endDrag();
  EXPECT_EQ(session.goals()[hand].state, GoalState::Held);
  const std::size_t count = session.goals().size();
  drag(session, session.addJointGoal(session.skeleton().jointIndex("lowerarm_r")), {0.0, 0.05, 0.0}, 5);
  EXPECT_EQ(session.goals().size(), count + 1);
  session.endDrag();
  EXPECT_EQ(session.goals().size(), count);
}

TEST(Session, APressWithoutAMoveIsNoEdit) {
  Session session(figure());
  const int hand = *session.findGoal("hand_l");
  const bool couldUndo = session.canUndo();
  session.beginDrag(hand);
  stepFrames(session, 3);
  session.endDrag();
  EXPECT_EQ(session.goals()[hand].state, GoalState::Free);
  EXPECT_EQ(session.canUndo(), couldUndo);
}

TEST(Session, PinningWhileDraggingKeepsThePoint) {
  Session session(figure());
  const int goal = session.addJointGoal(session.skeleton().jointIndex("lowerarm_r"));
  drag(session, goal, {0.0, 0.05, 0.0}, 5);
  session.togglePin(goal);
  session.endDrag();
  EXPECT_EQ(session.goals()[goal].state, GoalState::Pinned);
}

TEST(Session, APointOfTheSkinFollowsByItsBlendNotByOneBone) {
  Session session(sleeve());
  const int goal = session.addSurfaceGoal({.triangle = 1, .barycentric = {0.2, 0.3, 0.5}});
  const Vector3d before = session.reached(goal);
  drag(session, goal, {-0.1, 0.12, 0.0}, 20);
  stepFrames(session, 30);
  EXPECT_LT(session.error(goal), 1e-3);
  // The point moved in the frame of its dominant joint, so that a point fixed to that joint would have
  // missed.
  EXPECT_NEAR((session.reached(goal) - before - Vector3d(-0.1, 0.12, 0.0)).norm(), 0.0, 1e-3);
  const SkinnedVertices skinned = linearBlendSkin(*session.model().skin, session.frames());
  const Vector3d onSurface =
      0.2 * skinned.positions[3] + 0.3 * skinned.positions[4] + 0.5 * skinned.positions[5];
  EXPECT_LT((onSurface - session.reached(goal)).norm(), 1e-12);
}

TEST(Session, UndoBringsBackPoseAndGoalsAndRedoRepeats) {
  Session session(figure());
  const Eigen::VectorXd before = session.q();
  const int hand = *session.findGoal("hand_r");
  drag(session, hand, {-0.1, 0.2, 0.1}, 10);
  session.endDrag();
  const Eigen::VectorXd after = session.q();
  ASSERT_TRUE(session.undo());
  EXPECT_EQ(session.q(), before);
  EXPECT_EQ(session.goals()[hand].state, GoalState::Free);
  ASSERT_TRUE(session.redo());
  EXPECT_EQ(session.q(), after);
  EXPECT_EQ(session.goals()[hand].state, GoalState::Held);
  EXPECT_FALSE(session.redo());
}

TEST(Session, SettingThePoseTakesHeldTargetsAlong) {
  Session session(figure());
  drag(session, *session.findGoal("hand_r"), {0.0, 0.2, 0.1}, 10);
  session.endDrag();
  session.setPose(session.skeleton().rest());
  session.step();
  EXPECT_LT(difference(session.skeleton(), session.q(), session.skeleton().rest()).norm(), 1e-6);
  EXPECT_THROW(session.setPose(Eigen::VectorXd::Zero(3)), std::invalid_argument);
}

TEST(Session, MirroringTwiceIsTheIdentity) {
  Session session(figure());
  drag(session, *session.findGoal("hand_r"), {0.0, 0.2, 0.1}, 10);
  session.endDrag();
  const Eigen::VectorXd q = session.q();
  session.mirrorPose();
  EXPECT_GT(difference(session.skeleton(), session.q(), q).norm(), 0.1);
  session.mirrorPose();
  EXPECT_LT(difference(session.skeleton(), session.q(), q).norm(), 1e-12);
}

TEST(Session, AReturnFromOutOfReachIsContinuous) {
  Session session(figure());
  const int hand = *session.findGoal("hand_r");
  session.beginDrag(hand);
  const Vector3d start = session.goals()[hand].goal.target;
  double largest = 0.0;
  for (int i = 1; i <= 200; ++i) {  // 2 m out and back, 2 cm a frame
    const double s = i <= 100 ? i / 100.0 : (200 - i) / 100.0;
    session.moveDrag(start + s * Vector3d(-2.0, 0.4, 0.2));
    largest = std::max(largest, session.step().jointMotion);
  }
  EXPECT_LE(largest, 0.22);  // the drag solver's rotation budget a frame
  stepFrames(session, 30);
  EXPECT_LT(session.error(hand), 1e-3);
}

TEST(Session, EverySolverOfTheCatalogueComesNearerOrSaysWhyNot) {
  for (const std::string& name : frameSolverNames()) {
    Session session(sleeve());
    session.setSolver(name);
    const int goal = session.addJointGoal(3);
    const Vector3d target = session.reached(goal) + Vector3d(-0.05, 0.05, 0.0);
    session.setTarget(goal, target);
    const double before = session.error(goal);
    stepFrames(session, 30);
    if (session.lastSolve().why == Stop::Unsupported) {
      EXPECT_FALSE(session.lastSolve().unsupported.empty()) << name;
    } else {
      EXPECT_LT(session.error(goal), 0.5 * before) << name;
    }
    EXPECT_TRUE(session.q().allFinite()) << name;
  }
}

TEST(Session, PoleTurnsTheElbowToItsSide) {
  Session session(figure());
  const int hand = *session.findGoal("hand_r");
  drag(session, hand, {0.0, 0.02, 0.0}, 3);
  session.endDrag();
  const int pole = *session.findGoal("lowerarm_r_pole");
  const Vector3d elbowBefore = session.frames()[session.skeleton().jointIndex("lowerarm_r")].translation();
  drag(session, pole, {0.0, 0.3, 0.0}, 30);
  stepFrames(session, 60);
  const Vector3d elbowAfter = session.frames()[session.skeleton().jointIndex("lowerarm_r")].translation();
  EXPECT_GT(elbowAfter.y(), elbowBefore.y() + 0.01);
  EXPECT_LT(session.error(hand), 2e-3);
}

TEST(Session, UnknownSolversAreNamedWithThoseThatExist) {
  Session session(sleeve());
  try {
    session.setSolver("magic");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("magic"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("dls"), std::string::npos);
  }
  EXPECT_EQ(session.solver(), "drag");
}

}  // namespace
}  // namespace gelenk
