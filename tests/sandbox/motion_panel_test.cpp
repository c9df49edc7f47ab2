#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "apps/sandbox/panel.h"
#include "apps/sandbox/replay.h"
#include "apps/sandbox/sandbox.h"
#include "apps/sandbox/sandbox_state.h"
#include "apps/sandbox/view_picture.h"
#include "kinematics/io/bvh.h"
#include "kinematics/motion/motion_clip.h"
#include "kinematics/rotation.h"
#include "skinning/gpu/offscreen_context.h"
#include "skinning/gpu/render_target.h"
#include "skinning/io/gltf.h"

namespace gelenk {
namespace {

/// An arm of two hinges whose clip turns the second one far beyond its limit.
Model swingingArm() {
  std::vector<Joint> joints{{.name = "base"},
                            {.name = "shoulder", .parent = 0},
                            {.name = "elbow", .parent = 1},
                            {.name = "hand", .parent = 2}};
  joints[1].axes = {{AxisDof::Kind::Rotation, Eigen::Vector3d::UnitZ()}};
  joints[2].parentFromZero.translation() << 0, 0.5, 0;
  joints[2].axes = {{AxisDof::Kind::Rotation, Eigen::Vector3d::UnitZ(), 0.0, 0.5}};
  joints[3].parentFromZero.translation() << 0, 0.4, 0;
  Model model{.name = "arm", .skeleton = Skeleton(joints)};
  MotionClip clip{.framesPerSecond = 30.0, .q = Eigen::MatrixXd(2, 61)};
  for (int f = 0; f <= 60; ++f) clip.q.col(f) << 0.02 * f, 0.03 * f;
  model.clip = clip;
  return model;
}

TEST(MotionPanel, PlaysTheClipAtItsOwnPaceAndNeverClampsItToLimits) {
  OffscreenContext context;
  GlDebugLog log;
  Sandbox sandbox({.model = "planar", .width = 640, .height = 480});
  sandbox.openModel(swingingArm(), {"arm"});
  ViewPicture target;
  target.resize(640, 480);
  const Model model = swingingArm();
  for (int i = 1; i <= 100; ++i) {
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
    sandbox.frame({.width = 640, .height = 480, .events = {}}, 1.0 / 60.0);
    const Frames wanted =
        forwardKinematics(model.skeleton, sample(model.skeleton, *model.clip, i / 60.0, BeyondEnd::Loop));
    for (int j = 0; j < 4; ++j)
      ASSERT_LE((sandbox.shownFrames()[j].matrix() - wanted[j].matrix()).norm(), 1e-9) << "frame " << i;
  }
  EXPECT_TRUE(sandbox.playing());
  sandbox.setPlaying(false);
  const Eigen::Matrix4d still = sandbox.shownFrames()[3].matrix();
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
  sandbox.frame({.width = 640, .height = 480, .events = {}}, 1.0 / 60.0);
  EXPECT_LE((sandbox.shownFrames()[3].matrix() - still).norm(), 1e-12);
  EXPECT_TRUE(log.messages().empty());
}

/// A sandbox without a window, driven by a replay's text.
class Driven : public ::testing::Test {
 protected:
  Driven() { target_.resize(1280, 800); }

  /// Plays the lines and `after` frames of 1/60 s more; each(i) sees every frame.
  void play(
      const std::string& lines, int after = 0, const std::function<void()>& each = [] {}) {
    Replay replay = Replay::parse("test", lines);
    InputQueue queue;
    const int frames = replay.length() + after;
    for (int i = 0; i < frames; ++i) {
      replay.play(i, sandbox_, queue);
      glBindFramebuffer(GL_FRAMEBUFFER, target_.framebuffer());
      sandbox_.frame({.width = 1280, .height = 800, .events = queue.take(sandbox_.keys())}, 1.0 / 60.0);
      each();
    }
  }
  int joint(const char* name) const { return sandbox_.session().skeleton().jointIndex(name); }
  Eigen::Vector3d shown(const char* name) const { return sandbox_.shownFrames()[joint(name)].translation(); }

  OffscreenContext context_;
  Sandbox sandbox_{{.model = "planar", .width = 1280, .height = 800}};
  ViewPicture target_;
};

/// The figure, which swings its arms, nods and steps forward; as a file too.
Model swingingFigure() {
  Model model = openModel("figure");
  const Skeleton& skeleton = model.skeleton;
  MotionClip clip{.framesPerSecond = 30.0, .q = skeleton.rest().replicate(1, 61)};
  for (int f = 0; f <= 60; ++f) {
    const double s = std::sin(2.0 * M_PI * f / 60.0);
    Eigen::VectorXd q = skeleton.rest();
    for (const char* name : {"upperarm_l", "upperarm_r", "neck_01"}) {
      const int i = skeleton.jointIndex(name);
      setJointRotation(skeleton, q, i,
                       jointRotation(skeleton, q, i) * expRotation(Eigen::Vector3d(0.2 * s, 0, 0.1 * s)));
    }
    q[2] += 0.002 * f;
    clip.q.col(f) = q;
  }
  model.clip = clip;
  return model;
}

TEST_F(Driven, GoalsAndPinsHoldWhileTheClipPlays) {
  sandbox_.openModel(swingingFigure(), {"figure"});
  play("0 do Motion frame 1\n1 show skin off\n");
  const Eigen::Vector3d hand = shown("hand_r") + Eigen::Vector3d(0.02, 0.12, 0.15), foot = shown("foot_l");
  sandbox_.session().setTarget(*sandbox_.session().findGoal("hand_r"), hand);
  sandbox_.session().setState(*sandbox_.session().findGoal("foot_l"), GoalState::Pinned);
  const MotionClip clip = *sandbox_.session().model().clip;
  double worstHand = 0.0, worstFoot = 0.0, freeArm = 0.0, moved = 0.0;
  int frame = 0;
  play("0 do Motion goals on\n0 key space\n", 118, [&] {
    ++frame;
    // Judged outside: the frames shown against the targets, and the arm that no goal holds against the clip.
    worstHand = std::max(worstHand, (shown("hand_r") - hand).norm());
    worstFoot = std::max(worstFoot, (shown("foot_l") - foot).norm());
    const Frames wanted =
        forwardKinematics(sandbox_.session().skeleton(),
                          sample(sandbox_.session().skeleton(), clip, frame / 60.0, BeyondEnd::Loop));
    const auto fromChest = [&](const Frames& frames) -> Eigen::Vector3d {
      return (frames[joint("clavicle_l")].inverse() * frames[joint("hand_l")]).translation();
    };
    freeArm = std::max(freeArm, (fromChest(sandbox_.shownFrames()) - fromChest(wanted)).norm());
    moved = std::max(
        moved, (shown("head") -
                forwardKinematics(sandbox_.session().skeleton(), clip.q.col(0))[joint("head")].translation())
                   .norm());
  });
  EXPECT_TRUE(sandbox_.playing());
  EXPECT_LE(worstHand, 1e-4);
  EXPECT_LE(worstFoot, 1e-4);
  EXPECT_LE(freeArm, 1e-6);  // joints that serve no goal keep the clip's values
  EXPECT_GE(moved, 0.05);    // and the rest of the body goes on
  RecordProperty("hand_mm", std::to_string(1e3 * worstHand));
  RecordProperty("foot_mm", std::to_string(1e3 * worstFoot));
}

TEST_F(Driven, ADraggedPoseIsKeyedAndTheClipGoesThroughIt) {
  sandbox_.openModel(swingingFigure(), {"figure"});
  play("0 do Motion frame 31\n1 show skin off\n");
  const Eigen::Vector3d before = shown("hand_r");
  play("0 drag hand_r -30 -80 12\n", 20);
  const Eigen::Vector3d dragged = shown("hand_r");
  const auto fromChest = [&]() -> Eigen::Vector3d {
    return (sandbox_.shownFrames()[joint("spine_03")].inverse() * sandbox_.shownFrames()[joint("hand_r")])
        .translation();
  };
  const Eigen::Vector3d reach = fromChest();
  EXPECT_GE((dragged - before).norm(), 0.05);
  EXPECT_FALSE(sandbox_.playing());
  play("0 do Motion key-moved\n");
  EXPECT_LE((shown("hand_r") - dragged).norm(), 1e-3);
  play("0 do Motion frame 10\n1 do Motion frame 31\n");  // the pose is the clip's own now
  EXPECT_LE((shown("hand_r") - dragged).norm(), 1e-3);
  const std::string file = ::testing::TempDir() + "gelenk_keyed.bvh";
  play("0 do Motion write " + file + "\n");
  const BvhMotion written = readBvh(file);
  EXPECT_LE(
      (forwardKinematics(written.skeleton, written.clip.q.col(30))[written.skeleton.jointIndex("hand_r")]
           .translation() -
       dragged)
          .norm(),
      1e-3);
  play("0 do Motion move-key 31 41\n1 do Motion frame 41\n");
  EXPECT_LE((fromChest() - reach).norm(), 1e-3);
  play("0 do Motion delete-key\n1 do Motion frame 31\n");
  EXPECT_LE((shown("hand_r") - before).norm(), 1e-9);
  play("0 do Motion undo\n0 do Motion undo\n1 do Motion frame 31\n");
  EXPECT_LE((shown("hand_r") - dragged).norm(), 1e-3);
  std::filesystem::remove(file);
}

/// The drag solver pulled towards the rest pose: a hand led by two pixels threw the body by a metre.
TEST_F(Driven, ADragStartsFromTheClipsPose) {
  Model model = openModel("figure");
  Eigen::VectorXd q = model.skeleton.rest();
  q[0] += 0.6, q[2] += 0.9;
  for (const char* name : {"upperarm_l", "upperarm_r", "neck_01"}) {
    const int i = model.skeleton.jointIndex(name);
    setJointRotation(model.skeleton, q, i,
                     jointRotation(model.skeleton, q, i) * expRotation(Eigen::Vector3d(0.3, 0, 0.2)));
  }
  model.clip = MotionClip{.framesPerSecond = 30.0, .q = q.replicate(1, 31)};
  model.pins.clear();
  sandbox_.openModel(model, {"figure"});
  play("0 do Motion frame 11\n", 2);
  const Eigen::Vector3d foot = shown("foot_l"), head = shown("head"), hand = shown("hand_r");
  play("0 drag hand_r 0 -3 6\n", 60);
  EXPECT_GT((shown("hand_r") - hand).norm(), 0.002);
  EXPECT_LT((shown("foot_l") - foot).norm(), 0.03);
  EXPECT_LT((shown("head") - head).norm(), 0.03);
  play("0 key r\n", 60);  // the rest pose stays where it is
  EXPECT_LT((sandbox_.session().q() - sandbox_.session().skeleton().rest()).norm(), 1e-6);
}

TEST_F(Driven, ATurnedJointIsKeyedAlone) {
  sandbox_.openModel(swingingFigure(), {"figure"});
  play(
      "0 do Motion frame 31\n1 select lowerarm_l\n2 do Motion turn 40 0 0\n4 do Motion key\n5 do Motion "
      "frame 1\n6 do Motion frame 31\n");
  const Skeleton& skeleton = sandbox_.session().skeleton();
  const Frames clip = forwardKinematics(skeleton, sandbox_.session().model().clip->q.col(30));
  EXPECT_LE((shown("lowerarm_l") - clip[joint("lowerarm_l")].translation()).norm(), 1e-9);
  EXPECT_GE((shown("hand_l") - clip[joint("hand_l")].translation()).norm(), 0.05);
  EXPECT_LE((shown("hand_r") - clip[joint("hand_r")].translation()).norm(), 1e-9);
}

TEST_F(Driven, KeysAreMovedAlongTheTimelineByTheMouse) {
  sandbox_.openModel(swingingFigure(), {"figure"});
  play("0 do Motion frame 11\n1 do Motion key hand_l\n2 do Motion frame 31\n3 do Motion key hand_l\n", 2);
  const auto keys = [&] { return nlohmann::json::parse(sandbox_.status())["panels"]["Motion"]["keys"]; };
  ASSERT_EQ(keys().size(), 2u);
  EXPECT_EQ(keys()[0]["frame"], 11);
  const double x = keys()[0]["pixel"][0], y = keys()[0]["pixel"][1],
               frame = (keys()[1]["pixel"][0].get<double>() - x) / 20.0;
  play(fmt::format("0 move {} {}\n2 press left\n3 shift-by {} 0 4\n9 release left\n", x, y, 10 * frame), 3);
  EXPECT_EQ(keys()[0]["frame"], 21);
  EXPECT_EQ(keys()[1]["frame"], 31);
  EXPECT_EQ(nlohmann::json::parse(sandbox_.status())["panels"]["Motion"]["frame"], 31);  // the playhead stays
  play(fmt::format("0 move {} {}\n2 press left\n3 shift-by {} 0 4\n9 release left\n", x, y, 5 * frame), 3);
  EXPECT_EQ(nlohmann::json::parse(sandbox_.status())["panels"]["Motion"]["frame"],
            16);  // beside a key it scrubs
}

/// Undoes after every panel's step and before the first is drawn, as the menu bar does.
class UndoAfterSteps final : public Panel {
 public:
  std::string name() const override { return "Undo"; }
  void step(Sandbox& sandbox, double) override {
    if (!std::exchange(done_, true)) undoOrRedo(sandbox, false);
  }

 private:
  bool done_ = false;
};

TEST_F(Driven, AnUndoBetweenStepAndDrawingLeavesNoFrameBeyondTheClip) {
  const Model model = swingingFigure();
  const std::string file = ::testing::TempDir() + "gelenk_longer.glb";
  writeGltf(file, model.skeleton, nullptr, {{"second", *model.clip}});
  sandbox_.openModel(model, {"figure"});
  play("0 do Motion fade " + file + " 0.5\n1 do Motion frame 107\n");
  const auto frames = [&] {
    return nlohmann::json::parse(sandbox_.status())["panels"]["Motion"]["frames"].get<int>();
  };
  ASSERT_EQ(frames(), 107);
  sandbox_.state().panels.push_back(std::make_unique<UndoAfterSteps>());
  play("", 1);  // the playhead was in frame 107 of a clip that has 61 again
  EXPECT_EQ(frames(), 61);
  std::filesystem::remove(file);
}

/// Home framed everything, whatever the help said of the first frame.
TEST_F(Driven, HomeIsTheFirstFrameWhileTheTimelineIsInFront) {
  sandbox_.openModel(swingingArm(), {"arm"});
  const auto frame = [&] {
    for (const auto& panel : sandbox_.state().panels)
      if (panel->name() == "Motion") return nlohmann::json::parse(panel->status()).at("frame").get<int>();
    return 0;
  };
  const auto isFramed = [&] {
    const Camera before = sandbox_.camera();
    sandbox_.camera().distance *= 3.0;
    play("0 key home\n", 60);
    const bool framed = std::abs(sandbox_.camera().distance / before.distance - 3.0) > 0.1;
    sandbox_.camera() = before;
    return framed;
  };
  play("0 key end\n", 1);
  EXPECT_EQ(frame(), 61);
  EXPECT_FALSE(isFramed());
  EXPECT_EQ(frame(), 1);
  play("0 key end\n1 tab Plots\n", 1);  // the inspector still shows Motion
  EXPECT_FALSE(isFramed());
  EXPECT_EQ(frame(), 1);
  play("0 key end\n1 tab Solve\n", 2);
  EXPECT_TRUE(isFramed());
  EXPECT_EQ(frame(), 61);
}

TEST_F(Driven, ASecondClipIsLaidOverAndFadedInto) {
  const Model model = swingingFigure();
  const std::string file = ::testing::TempDir() + "gelenk_second.glb";
  MotionClip raised = *model.clip;
  for (int f = 0; f < raised.frameCount(); ++f) {
    const int i = model.skeleton.jointIndex("upperarm_l");
    setJointRotation(model.skeleton, raised.q.col(f), i, expRotation(Eigen::Vector3d(1.2, 0, 0)));
  }
  writeGltf(file, model.skeleton, nullptr, {{"raised", raised}});
  sandbox_.openModel(model, {"figure"});
  play("0 do Motion layer " + file + " 1 upperarm_l\n1 do Motion frame 20\n");
  const Frames base = forwardKinematics(model.skeleton, model.clip->q.col(19)),
               layer = forwardKinematics(model.skeleton, raised.q.col(19));
  const auto arm = [&](const Frames& frames) -> Eigen::Vector3d {
    return (frames[joint("clavicle_l")].inverse() * frames[joint("hand_l")]).translation();
  };
  EXPECT_GE((arm(base) - arm(layer)).norm(), 0.1);
  EXPECT_LE((arm(sandbox_.shownFrames()) - arm(layer)).norm(), 1e-5);  // through a file in single precision
  EXPECT_LE((shown("hand_r") - base[joint("hand_r")].translation()).norm(), 1e-9);
  play("0 do Motion undo\n1 do Motion fade " + file + " 0.5\n2 do Motion frame 107\n");
  // 61 + 61 - 15 frames; the last is the second clip's last.
  EXPECT_LE((arm(sandbox_.shownFrames()) - arm(forwardKinematics(model.skeleton, raised.q.col(60)))).norm(),
            1e-5);
  EXPECT_THROW(play("0 do Motion fade no-such-file.bvh 0.5\n"), std::exception);
  EXPECT_THROW(play("0 do Motion dance\n"), std::invalid_argument);
  EXPECT_THROW(play("0 do Dance key\n"), std::invalid_argument);
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace gelenk
