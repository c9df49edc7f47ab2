#include "apps/document/session.h"

#include <gtest/gtest.h>

#include "apps/document/chosen_skin.h"
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
void drag(Session& session, GoalId goal, const Vector3d& by, int frames) {
  session.beginDrag(goal);
  const Vector3d start = session.goal(goal).goal.target;
  for (int i = 1; i <= frames; ++i) {
    session.moveDrag(start + by * i / frames);
    session.step();
  }
}

TEST(Session, AReachableTargetIsReachedWithinAMillimetre) {
  Session session(figure());
  const GoalId hand = *session.findGoal("hand_r");
  drag(session, hand, {-0.05, 0.25, 0.1}, 20);
  stepFrames(session, 20);
  EXPECT_LT(session.error(hand), 1e-3);
  EXPECT_LT(limitViolation(session.skeleton(), session.q()), 1e-9);
}

TEST(Session, OutOfReachTheArmIsStretchedTowardsTheTargetAndStill) {
  Session session(figure());
  const GoalId hand = *session.findGoal("hand_r");
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
  const Vector3d toTarget = (session.goal(hand).goal.target - shoulder).normalized();
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
  const GoalId hand = *session.findGoal("hand_l");
  drag(session, hand, {0.0, 0.1, 0.0}, 5);
  session.endDrag();
  EXPECT_EQ(session.goal(hand).state, GoalState::Held);
  const std::size_t count = session.goals().size();
  drag(session, session.addJointGoal(session.skeleton().jointIndex("lowerarm_r")), {0.0, 0.05, 0.0}, 5);
  EXPECT_EQ(session.goals().size(), count + 1);
  session.endDrag();
  EXPECT_EQ(session.goals().size(), count);
}

TEST(Session, APressWithoutAMoveIsNoEdit) {
  Session session(figure());
  const GoalId hand = *session.findGoal("hand_l");
  const bool couldUndo = session.canUndo();
  session.beginDrag(hand);
  stepFrames(session, 3);
  session.endDrag();
  EXPECT_EQ(session.goal(hand).state, GoalState::Free);
  EXPECT_EQ(session.canUndo(), couldUndo);
}

TEST(Session, UndoAfterAPressWithoutAMoveTakesBackTheEditBefore) {
  for (const bool held : {false, true}) {
    Session session(figure());
    const GoalId hand = *session.findGoal("hand_r"), other = *session.findGoal("hand_l");
    EXPECT_FALSE(session.canUndo());
    session.beginDrag(other);
    EXPECT_FALSE(session.undo());  // nothing was done yet
    EXPECT_FALSE(session.dragged());
    drag(session, hand, {-0.1, 0.2, 0.1}, 10);
    session.endDrag();
    if (held) session.setState(other, GoalState::Held);
    const Vector3d target = session.goal(other).goal.target;
    session.beginDrag(other);
    stepFrames(session, 3);
    EXPECT_TRUE(session.undo());
    EXPECT_EQ(session.goal(hand).state, GoalState::Free);
    EXPECT_EQ(session.goal(other).state, GoalState::Free);
    EXPECT_TRUE(session.redo());
    EXPECT_EQ(session.goal(hand).state, GoalState::Held);
    EXPECT_EQ(session.goal(other).state, held ? GoalState::Held : GoalState::Free);
    EXPECT_LT((session.goal(other).goal.target - target).norm(), held ? 1e-12 : 1.0);
    EXPECT_FALSE(session.redo());
  }
}

TEST(Session, ACancelledDragLeavesNoTrace) {
  Session session(figure());
  const GoalId hand = *session.findGoal("hand_r");
  drag(session, hand, {-0.1, 0.2, 0.1}, 10);
  session.endDrag();
  ASSERT_TRUE(session.undo());
  const Eigen::VectorXd q = session.q();
  const std::size_t count = session.goals().size();
  const GoalId elbow = session.beginDrag(JointGrip{session.skeleton().jointIndex("lowerarm_l")});
  session.moveDrag(session.reached(elbow) + Vector3d(0, 0.2, 0));
  stepFrames(session, 5);
  EXPECT_NE(session.q(), q);
  session.cancelDrag();
  EXPECT_EQ(session.q(), q);
  EXPECT_EQ(session.goals().size(), count);
  EXPECT_TRUE(session.canRedo());  // what was undone can still be had
}

TEST(Session, UndoOfADragOfTheBodyLeavesNoGoalBehind) {
  Session session(figure());
  const std::size_t count = session.goals().size();
  const GoalId elbow = session.beginDrag(JointGrip{session.skeleton().jointIndex("lowerarm_r")});
  session.moveDrag(session.reached(elbow) + Vector3d(0, 0.05, 0));
  session.step();
  session.togglePin(elbow);
  session.endDrag();
  EXPECT_EQ(session.goals().size(), count + 1);
  ASSERT_TRUE(session.undo());
  EXPECT_EQ(session.goals().size(), count);
  ASSERT_TRUE(session.redo());
  EXPECT_EQ(session.goal(elbow).state, GoalState::Pinned);
}

TEST(Session, AnIdMeansTheSameGoalOrNoneWhateverWasRemoved) {
  Session session(figure());
  const GoalId first = session.addJointGoal(session.skeleton().jointIndex("lowerarm_r")),
               second = session.addJointGoal(session.skeleton().jointIndex("lowerarm_l"));
  session.remember();
  session.removeGoal(first);
  EXPECT_EQ(session.goal(second).goal.name, "lowerarm_l");
  EXPECT_FALSE(session.hasGoal(first));
  EXPECT_THROW(session.setTarget(first, Vector3d::Zero()), std::invalid_argument);
  EXPECT_THROW(session.beginDrag(first), std::invalid_argument);
  const GoalId third = session.addJointGoal(session.skeleton().jointIndex("calf_l"));
  EXPECT_NE(third, first);
  ASSERT_TRUE(session.undo());
  EXPECT_EQ(session.goal(first).goal.name, "lowerarm_r");
  EXPECT_NE(session.addJointGoal(session.skeleton().jointIndex("calf_r")), third);
}

TEST(Session, PaintedWeightsPosesAndMusclesAreTakenBackInTheOrderTheyWereMade) {
  Session session(sleeve());
  const Skin* skin = session.skin();
  const std::vector<Influences> own = skin->influences;
  session.remember();
  session.changeWeights({{1, Influences{{2, 0, 0, 0}, {1, 0, 0, 0}}}});
  const std::vector<Influences> painted = session.skin()->influences;
  EXPECT_NE(painted, own);
  EXPECT_EQ(session.model().skin->influences, own);  // the model is as it was opened
  EXPECT_EQ(session.skin(), skin);
  session.remember();
  session.setPose(Vector3d(0.1, 0.2, 0.3));
  session.remember();
  session.setMuscles(std::make_shared<MuscleSettings>(MuscleSettings{.enabled = true}));

  EXPECT_TRUE(session.undo());
  EXPECT_EQ(session.edits().muscles, nullptr);
  EXPECT_EQ(session.q(), Vector3d(0.1, 0.2, 0.3));
  EXPECT_TRUE(session.undo());
  EXPECT_EQ(session.q(), session.skeleton().rest());
  EXPECT_EQ(session.skin()->influences, painted);
  const int version = session.weightsVersion();
  EXPECT_TRUE(session.undo());
  EXPECT_EQ(session.skin()->influences, own);
  EXPECT_GT(session.weightsVersion(), version);
  EXPECT_FALSE(session.undo());
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(session.redo());
  EXPECT_EQ(session.skin()->influences, painted);
  EXPECT_TRUE(session.edits().muscles->enabled);
  EXPECT_THROW(session.changeWeights({{6, Influences{}}}), std::invalid_argument);
}

TEST(Session, TheSolverLivesOnWhenTheWeightsChangeAndWhenTheSessionHasGone) {
  Session session(sleeve());
  const GoalId end = session.addJointGoal(3);
  session.setTarget(end, session.reached(end) + Vector3d(-0.05, 0.05, 0));
  const Skeleton* skeleton = &session.skeleton();
  session.remember();
  session.changeWeights({{0, Influences{{2, 0, 0, 0}, {1, 0, 0, 0}}}});
  EXPECT_EQ(&session.skeleton(), skeleton);
  stepFrames(session, 30);
  EXPECT_LT(session.error(end), 1e-3);
  for (const std::string& name : frameSolverNames()) {
    std::unique_ptr<FrameSolver> solver;
    IkProblem problem;
    std::shared_ptr<const Skeleton> kept;
    {
      Session gone(sleeve());
      gone.setTarget(gone.addJointGoal(3), Vector3d(0.5, 0.5, 0.0));
      solver = makeFrameSolver(name, gone.sharedSkeleton());
      problem = gone.problem();
      kept = gone.sharedSkeleton();
    }
    EXPECT_TRUE(solver->frame(problem).q.allFinite()) << name;
  }
}

TEST(Session, AnOrientationThatIsMissedIsNotReached) {
  Session session(sleeve());  // a planar arm: no joint turns about x
  const GoalId end = session.addJointGoal(3);
  session.setState(end, GoalState::Held);
  session.setOrientation(end, Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Vector3d::UnitX())) *
                                  Eigen::Quaterniond(session.frames()[3].linear()));
  stepFrames(session, 20);
  ASSERT_TRUE(session.lastSolve().ran);
  EXPECT_FALSE(session.lastSolve().reached);
  EXPECT_GT(session.lastSolve().orientationError, 0.3);
  EXPECT_NEAR(session.judged(end).orientation, session.lastSolve().orientationError, 1e-9);

  Session aiming(sleeve());
  aiming.addGoal({.kind = GoalKind::Aim, .joint = 3, .target = {1, 0, 5}, .axisInJoint = {0, 0, -1}});
  stepFrames(aiming, 20);
  EXPECT_FALSE(aiming.lastSolve().reached);
  EXPECT_GT(aiming.lastSolve().orientationError, 0.3);
}

TEST(Session, PinningWhileDraggingKeepsThePoint) {
  Session session(figure());
  const GoalId goal = session.addJointGoal(session.skeleton().jointIndex("lowerarm_r"));
  drag(session, goal, {0.0, 0.05, 0.0}, 5);
  session.togglePin(goal);
  session.endDrag();
  EXPECT_EQ(session.goal(goal).state, GoalState::Pinned);
}

TEST(Session, APointOfTheSkinFollowsByItsBlendNotByOneBone) {
  Session session(sleeve());
  const GoalId goal = session.addSurfaceGoal({.triangle = 1, .barycentric = {0.2, 0.3, 0.5}});
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

TEST(Session, APointOfTheSkinIsWhereTheMethodAndTheLayersThatAreShownHaveIt) {
  Session session(openModel("figure"));
  // A triangle in the middle of the left elbow, where methods differ.
  const int elbow = session.skeleton().jointIndex("lowerarm_l");
  const Vector3d joint = bindFrames(session.model())[elbow].translation();
  const Mesh& mesh = session.skin()->mesh;
  int triangle = 0;
  double nearest = 1e9;
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t)
    if (const double d = (mesh.positions[mesh.triangles[t][0]] - joint).norm(); d < nearest)
      nearest = d, triangle = t;
  const Vector3d share(0.2, 0.3, 0.5);
  std::vector<Vector3d> places;
  for (const char* name : {"lbs", "dqs+twist", "cor+twist", "lbs+layers=muscle"}) {
    SCOPED_TRACE(name);
    session.resetPose();
    session.removeAllGoals();
    session.chooseSkin(parseSkinChoice(name));
    const GoalId goal = session.addSurfaceGoal({.triangle = triangle, .barycentric = share});
    Eigen::VectorXd q = session.q();
    q[session.skeleton().qIndex(elbow)] = 1.5;
    session.setPose(q);
    SkinnedVertices whole;
    ChosenSkin(session.model(), *session.skin(), chosenSkin(session.document()),
               session.edits().muscles.get())
        .pose(session.frames(), &session.q(), whole);
    Vector3d expected = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) expected += share[k] * whole.positions[mesh.triangles[triangle][k]];
    EXPECT_LE((session.reached(goal) - expected).norm(), 1e-12);
    places.push_back(expected);
    drag(session, goal, {0.02, 0.03, 0.04}, 10);
    stepFrames(session, 40);
    EXPECT_LT((session.reached(goal) - session.goal(goal).goal.target).norm(), 1e-3);
    session.cancelDrag();
  }
  for (std::size_t i = 1; i < places.size(); ++i)  // the test's own premise
    EXPECT_GT((places[i] - places[0]).norm(), 5e-4) << i;
}

TEST(Session, UndoBringsBackPoseAndGoalsAndRedoRepeats) {
  Session session(figure());
  const Eigen::VectorXd before = session.q();
  const GoalId hand = *session.findGoal("hand_r");
  drag(session, hand, {-0.1, 0.2, 0.1}, 10);
  session.endDrag();
  const Eigen::VectorXd after = session.q();
  ASSERT_TRUE(session.undo());
  EXPECT_EQ(session.q(), before);
  EXPECT_EQ(session.goal(hand).state, GoalState::Free);
  ASSERT_TRUE(session.redo());
  EXPECT_EQ(session.q(), after);
  EXPECT_EQ(session.goal(hand).state, GoalState::Held);
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
  const GoalId hand = *session.findGoal("hand_r");
  session.beginDrag(hand);
  const Vector3d start = session.goal(hand).goal.target;
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
    const GoalId goal = session.addJointGoal(3);
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

/// A straight arm with its target on its own line has no slope that bends it.
TEST(Session, AStraightArmBendsTowardsATargetOnItsOwnLine) {
  std::vector<Joint> joints;
  for (int i = 0; i <= 2; ++i) {
    Joint joint{.name = "l" + std::to_string(i), .parent = i - 1};
    if (i > 0) joint.parentFromZero.translation().x() = 1.0;
    if (i < 2) joint.axes = {{AxisDof::Kind::Rotation, Vector3d::UnitZ(), -unlimited, unlimited}};
    joints.push_back(joint);
  }
  Session session(Model{.name = "straight", .skeleton = Skeleton(joints), .planar = true});
  const GoalId tip = session.addJointGoal(2);
  session.setTarget(tip, {1.2, 0.0, 0.0});
  Eigen::VectorXd before = session.q();
  double largest = 0.0;
  for (int i = 0; i < 120; ++i) {
    session.step();
    largest = std::max(largest, (session.q() - before).lpNorm<Eigen::Infinity>());
    before = session.q();
  }
  EXPECT_LT(session.error(tip), 1e-3);
  EXPECT_TRUE(session.lastSolve().reached);
  EXPECT_LT(largest, 2.0);  // eight frames of the solver in a picture, and no jump beyond them
  session.setTarget(tip, {2.5, 0.0, 0.0});  // out of reach: a minimum, where it rests
  stepFrames(session, 200);
  EXPECT_EQ(session.lastSolve().why, Stop::Stationary);
  EXPECT_LT(session.lastSolve().jointMotion, 1e-4);
}

TEST(Session, PoleTurnsTheElbowToItsSide) {
  Session session(figure());
  const GoalId hand = *session.findGoal("hand_r");
  drag(session, hand, {0.0, 0.02, 0.0}, 3);
  session.endDrag();
  const GoalId pole = *session.findGoal("lowerarm_r_pole");
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
