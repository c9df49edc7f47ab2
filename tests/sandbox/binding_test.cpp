#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/document/muscle_settings.h"
#include "apps/document/scene_file.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/io/text_file.h"
#include "skinning/io/pinocchio_weights.h"
#include "skinning/rigging/weight_paint.h"
#include "tests/sandbox/stage.h"
#include "tests/skinning/muscles/resting_arm.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// The tube around a resting arm, under the names of a limb that muscles know.
Model armModel() {
  const Skeleton plain = testing::arm(0.8);
  std::vector<Joint> joints;
  const char* names[] = {"chest", "upperarm_l", "lowerarm_l", "hand_l"};
  for (int j = 0; j < plain.jointCount(); ++j) {
    joints.push_back(plain.joint(j));
    joints.back().name = names[j];
  }
  Model model{.name = "arm", .skeleton = Skeleton(joints, plain.rest())};
  model.skin = testing::tube(plain);
  return model;
}

struct PaintStage : testing::Stage {
  int next = 0;

  PaintStage() : testing::Stage({.model = "planar", .width = 800, .height = 600}) {
    sandbox.openModel(armModel(), {"arm", "", {}});
  }
  void play(const std::string& script) {
    Replay replay = Replay::parse("test", script);
    const int length = replay.length() + 1;
    for (int i = 0; i < length; ++i, ++next) {
      replay.play(i, sandbox, queue);
      frame();
    }
  }
  const std::vector<Influences>& weights() { return sandbox.session().skin()->influences; }
  /// A vertex that the eye sees, and its pixel.
  std::pair<int, Vector2d> seenVertex() {
    const SkinnedVertices& surface = sandbox.surface();
    const Vector3d eye = sandbox.camera().eye();
    int best = 0;
    double facing = -1.0;
    for (int v = 24 * 12; v < 24 * 20; ++v)  // on the upper arm
      if (const double f = surface.normals[v].dot((eye - surface.positions[v]).normalized()); f > facing) {
        facing = f;
        best = v;
      }
    return {best, sandbox.state().toWindow(surface.positions[best]).pixel};
  }
  void musclesOn() {
    MuscleSettings muscles = *sandbox.session().edits().muscles;
    muscles.enabled = true;
    sandbox.session().setMuscles(std::make_shared<MuscleSettings>(muscles));
    play("0 move 5 5\n");
  }
  const LimbSettings& limb() { return sandbox.session().edits().muscles->limbs[0].second; }
};

std::string at(const Vector2d& pixel) { return std::to_string(pixel.x()) + " " + std::to_string(pixel.y()); }

TEST(BindingPanel, TheBrushBindsTheVertexUnderItAndDragsNothing) {
  PaintStage stage;
  stage.play("0 tab Binding\n1 select chest\n2 key b\n");
  const auto [vertex, pixel] = stage.seenVertex();
  const std::vector<Influences> before = stage.weights();
  const Eigen::VectorXd q = stage.sandbox.session().q();
  stage.play("0 move " + at(pixel) + "\n1 press left\n2 move " + at(pixel + Vector2d(1, 0)) +
             "\n3 release left\n");
  const PaintTarget chest{.joints = {0}};
  EXPECT_EQ(weightOn(before[vertex], chest), 0.0);
  EXPECT_NEAR(weightOn(stage.weights()[vertex], chest), 0.3,
              0.01);  // the default strength, at the brush's centre
  EXPECT_EQ(stage.sandbox.session().q(), q);
  for (const SceneGoal& goal : stage.sandbox.session().goals()) EXPECT_EQ(goal.state, GoalState::Free);

  stage.play("0 keydown ctrl\n1 key z\n2 keyup ctrl\n");
  EXPECT_EQ(stage.weights(), before);
  stage.play("0 keydown ctrl\n1 key y\n2 keyup ctrl\n");
  EXPECT_NE(stage.weights(), before);
  EXPECT_TRUE(stage.log.messages().empty());
}

/// The figure as it opens: feet pinned, the drag solver at work. Whatever changes the weights, the frames
/// that follow stand on the skeleton that is still there.
TEST(BindingPanel, EveryWayOfBindingTheFigureLeavesTheSolverAtWork) {
  const OffscreenContext context;
  Sandbox sandbox({.model = "figure", .width = 1280, .height = 800});
  ViewPicture target;
  target.resize(1280, 800);
  const auto play = [&](const std::string& script) {
    Replay replay = Replay::parse("test", script);
    InputQueue queue;
    for (int i = 0; i < replay.length() + 6; ++i) {
      replay.play(i, sandbox, queue);
      glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
      sandbox.frame({.width = 1280, .height = 800, .events = queue.take(sandbox.keys())}, 1.0 / 60.0);
    }
  };
  const Skeleton* skeleton = &sandbox.session().skeleton();
  std::vector<Influences> before = sandbox.session().skin()->influences;
  const auto expectChanged = [&](const char* by) {
    EXPECT_NE(sandbox.session().skin()->influences, before) << by;
    before = sandbox.session().skin()->influences;
    EXPECT_EQ(&sandbox.session().skeleton(), skeleton);
    EXPECT_TRUE(sandbox.session().lastSolve().ran);
    EXPECT_LT(sandbox.session().error(*sandbox.session().findGoal("foot_l")), 1e-3);
  };
  play("0 show skin off\n0 show shadow off\n0 show skin on\n");
  const Vector2d chest =
      sandbox.state()
          .toWindow(sandbox.session().frames()[skeleton->jointIndex("spine_03")].translation())
          .pixel;
  play("0 tab Binding\n1 select head\n2 key b\n3 move " + at(chest) + "\n5 press left\n6 move " +
       at(chest + Vector2d(6, 3)) + "\n8 release left\n");
  expectChanged("brush");
  play("0 key v\n1 move " + at(chest + Vector2d(-30, -30)) + "\n2 press left\n3 move " +
       at(chest + Vector2d(30, -30)) + "\n4 move " + at(chest + Vector2d(0, 40)) + "\n5 release left\n");
  expectChanged("lasso");
  play("0 do Binding smooth-all\n");
  expectChanged("smooth all");
  play("0 do Binding mirror +x\n");
  expectChanged("mirror");
  play("0 do Binding heat-weights\n");
  expectChanged("heat weights");
  play("0 drag hand_r -30 -60 8\n");  // with the tool on: nothing is dragged
  play("0 key v\n1 drag hand_r -30 -60 8\n");
  EXPECT_EQ(sandbox.session().goal(*sandbox.session().findGoal("hand_r")).state, GoalState::Held);
}

TEST(BindingPanel, TheLassoBindsOnlyWhatIsSeen) {
  PaintStage stage;
  stage.play("0 tab Binding\n1 select chest\n2 key v\n");
  const auto [vertex, pixel] = stage.seenVertex();
  const int opposite = vertex / 24 * 24 + (vertex + 12) % 24;
  const std::vector<Influences> before = stage.weights();
  std::string script = "0 move " + at(pixel + Vector2d(-30, -30)) + "\n1 press left\n";
  const Vector2d corners[] = {{30, -30}, {30, 30}, {-30, 30}};
  for (int i = 0; i < 3; ++i) script += std::to_string(2 + i) + " move " + at(pixel + corners[i]) + "\n";
  stage.play(script + "5 release left\n");
  const PaintTarget chest{.joints = {0}};
  EXPECT_NEAR(weightOn(stage.weights()[vertex], chest), 0.3, 1e-6);
  EXPECT_EQ(stage.weights()[opposite], before[opposite]);
}

TEST(BindingPanel, MuscleLayersFollowAndTheSceneKeepsTheWeightsExactly) {
  PaintStage stage;
  stage.musclesOn();
  stage.play("0 tab Binding\n1 select chest\n2 key b\n");
  const auto [vertex, pixel] = stage.seenVertex();
  ASSERT_NEAR(stage.sandbox.muscles()->body().vertices[vertex].weight, 1.0, 1e-12);
  stage.play("0 move " + at(pixel) + "\n1 press left\n2 release left\n");
  EXPECT_NEAR(stage.sandbox.muscles()->body().vertices[vertex].weight, 0.7, 0.01);

  const std::vector<Influences> painted = stage.weights();
  const auto model = stage.sandbox.session().sharedModel();
  const std::string saved = formatScene(stage.sandbox.document(), *model);
  stage.sandbox.openModel(armModel(), {"arm", "", {}});
  EXPECT_NE(stage.weights(), painted);
  stage.sandbox.openDocument(model, parseScene(saved, "saved.json", *model));
  stage.play("0 move 5 5\n");
  EXPECT_EQ(stage.weights(), painted);
  EXPECT_EQ(formatScene(stage.sandbox.document(), *model), saved);
  EXPECT_NEAR(stage.sandbox.muscles()->body().vertices[vertex].weight, 0.7, 0.01);
}

TEST(MusclePanel, AClickOnTheLatticeSelectsThePlaneAndADragScalesIt) {
  PaintStage stage;
  stage.musclesOn();
  stage.play("0 tab Muscles\n1 move 5 5\n");
  const LimbPose limb = stage.sandbox.limbPoses()[0];
  const int plane = 8;  // plane 2 of the second link
  const Vector2d corner = stage.sandbox.state().toWindow(limb.controlPoints(plane)[15]).pixel;
  const Vector2d centre = stage.sandbox.state().toWindow(limb.turnedPlane(plane).point(0.5, 0.5)).pixel;
  const Eigen::VectorXd q = stage.sandbox.session().q();
  const auto stretch = [&](int link, int of) {
    const MuscleState state = stage.limb().control.sculpted[link];
    return Eigen::Matrix2d(of == 2 ? state.plane2.stretch : state.plane4.stretch);
  };
  const Vector2d out = centre + 1.25 * (corner - centre);
  stage.play("0 move " + at(corner) + "\n1 press left\n2 move " + at(out) + "\n3 release left\n");
  EXPECT_LT((stretch(1, 2) - 1.25 * Eigen::Matrix2d::Identity()).norm(), 0.02);
  EXPECT_EQ(stretch(1, 4), Eigen::Matrix2d::Identity());
  EXPECT_EQ(stretch(0, 2), Eigen::Matrix2d::Identity());
  EXPECT_EQ(stage.sandbox.session().q(), q);

  // Beside the lattice a press goes to the view as before, and a connecting plane does not move.
  const auto before = stage.sandbox.session().edits().muscles;
  const Vector2d seam =
      stage.sandbox.state().toWindow(stage.sandbox.limbPoses()[0].controlPoints(6)[0]).pixel;
  stage.play("0 move " + at(seam) + "\n1 press left\n2 move " + at(seam + Vector2d(30, 30)) +
             "\n3 release left\n");
  EXPECT_EQ(stage.sandbox.session().edits().muscles, before);
  stage.play("0 keydown ctrl\n1 key z\n2 keyup ctrl\n");
  EXPECT_EQ(stretch(1, 2), Eigen::Matrix2d::Identity());
  stage.play("0 keydown ctrl\n1 key y\n2 keyup ctrl\n");
  EXPECT_LT((stretch(1, 2) - 1.25 * Eigen::Matrix2d::Identity()).norm(), 0.02);
  EXPECT_TRUE(stage.log.messages().empty());
}

TEST(MusclePanel, ADragWithShiftTurnsThePickedPlaneWithTheMouse) {
  PaintStage stage;
  stage.musclesOn();
  stage.play("0 tab Muscles\n1 move 5 5\n");
  const int plane = 8;  // plane 2 of the second link
  const auto cornerOnScreen = [&] {
    return stage.sandbox.state().toWindow(stage.sandbox.limbPoses()[0].controlPoints(plane)[15]).pixel;
  };
  const Vector2d centre =
      stage.sandbox.state().toWindow(stage.sandbox.limbPoses()[0].turnedPlane(plane).point(0.5, 0.5)).pixel;
  const Vector2d from = cornerOnScreen() - centre;
  const Vector2d turned = Eigen::Rotation2Dd(0.5) * from;
  stage.play("0 move " + at(centre + from) + "\n1 press left\n2 keydown shift\n3 move " +
             at(centre + turned) + "\n4 release left\n5 keyup shift\n");

  const auto sculpted = stage.limb().control.sculpted;
  const Eigen::Matrix2d turn = sculpted[1].plane2.stretch;
  EXPECT_LT((turn.transpose() * turn - Eigen::Matrix2d::Identity()).norm(), 1e-12);
  EXPECT_NEAR(std::abs(Eigen::Rotation2Dd(turn).angle()), 0.5, 0.02);
  EXPECT_EQ(sculpted[1].plane4.stretch, Eigen::Matrix2d::Identity());
  const Vector2d now = cornerOnScreen() - centre;  // to the mouse's side, clockwise or not
  EXPECT_GT(from.x() * now.y() - from.y() * now.x(), 0.0);
  EXPECT_TRUE(stage.log.messages().empty());
}

TEST(BindingPanel, ExportWritesThePaintedWeightsAndSaysWhereItCannot) {
  PaintStage stage;
  stage.play("0 tab Binding\n1 select chest\n2 key b\n");
  const auto [vertex, pixel] = stage.seenVertex();
  stage.play("0 move " + at(pixel) + "\n1 press left\n2 release left\n");
  const std::string path =
      (std::filesystem::temp_directory_path() / ("gelenk-export-" + std::to_string(getpid()) + ".attachment"))
          .string();
  stage.play("0 do Binding export " + path + "\n");
  EXPECT_EQ(readFile(path),
            formatPinocchioWeights(boneWeights(stage.weights(), stage.sandbox.session().skeleton())));
  std::filesystem::remove(path);
  EXPECT_GT(weightOn(stage.weights()[vertex], {.joints = {0}}), 0.0);

  const std::size_t before = stage.sandbox.state().notices.size();
  stage.play("0 do Binding export /nowhere/at/all.attachment\n");
  ASSERT_GT(stage.sandbox.state().notices.size(), before);
  EXPECT_NE(stage.sandbox.state().notices.back().words.find("/nowhere/at/all.attachment"), std::string::npos);
}

/// A file of its own, removed afterwards.
struct TemporaryScene {
  std::string path =
      (std::filesystem::temp_directory_path() / ("gelenk-binding-" + std::to_string(getpid()) + ".json"))
          .string();
  ~TemporaryScene() { std::filesystem::remove(path); }
};

/// The figure, one of its vertices bound to the root, muscles on.
std::string editedScene(Sandbox& sandbox, const std::string& path) {
  sandbox.session().changeWeights({{7, Influences{}}});
  EXPECT_TRUE(sandbox.saveSceneTo(path));
  return readFile(path);
}

TEST(BindingPanel, ASceneOfTheSameModelWithoutABindingGoesBackToTheModelsOwn) {
  const OffscreenContext context;
  Sandbox sandbox({.model = "planar", .width = 320, .height = 240});
  const TemporaryScene file;
  ASSERT_TRUE(sandbox.open("figure"));
  const std::vector<Influences> own = sandbox.session().skin()->influences;
  nlohmann::json scene = nlohmann::json::parse(editedScene(sandbox, file.path));
  EXPECT_NE(sandbox.session().skin()->influences, own);
  scene.erase("weights");
  writeFile(file.path, scene.dump());
  ASSERT_TRUE(sandbox.open(file.path));
  EXPECT_EQ(sandbox.session().skin()->influences, own);
}

TEST(BindingPanel, ASceneWithBadMusclesOrBindingChangesNothing) {
  const OffscreenContext context;
  Sandbox sandbox({.model = "planar", .width = 320, .height = 240});
  const TemporaryScene file;
  ASSERT_TRUE(sandbox.open("figure"));
  const std::string good = editedScene(sandbox, file.path);
  const std::vector<Influences> edited = sandbox.session().skin()->influences;
  const auto refused = [&](const char* entry, const char* value, const std::string& words) {
    nlohmann::json scene = nlohmann::json::parse(good);
    scene.at(nlohmann::json::json_pointer(entry)) = value;
    writeFile(file.path, scene.dump());
    ASSERT_TRUE(sandbox.open("planar"));  // something else, which must stay open
    EXPECT_FALSE(sandbox.open(file.path));
    EXPECT_EQ(sandbox.session().model().name, "planar");
    EXPECT_NE(sandbox.state().notices.back().words.find(words), std::string::npos)
        << sandbox.state().notices.back().words;
  };
  refused("/muscles/limbs/0/name", "tail", "muscles.limbs[0].name: a limb of the model: left arm");
  refused("/weights/joints/0", "tail", "weights.joints[0]: a joint of the model, found 'tail'");
  writeFile(file.path, good);
  ASSERT_TRUE(sandbox.open(file.path));
  EXPECT_EQ(sandbox.session().skin()->influences, edited);
}

}  // namespace
}  // namespace gelenk
