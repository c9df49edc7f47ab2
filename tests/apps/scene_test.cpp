#include "apps/scene.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "apps/session.h"
#include "kinematics/configuration.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "kinematics/mannequin.h"

namespace gelenk {
namespace {

std::string temporary(const std::string& name) {
  return (std::filesystem::temp_directory_path() / ("gelenk_scene_" + std::to_string(getpid()) + "_" + name)).string();
}

Scene someScene(const Skeleton& skeleton) {
  std::mt19937_64 random(7);
  Scene scene;
  scene.model = {"figure", "", ""};
  scene.q = randomWithinLimits(skeleton, random);
  SceneGoal goal{.goal = {.kind = GoalKind::Pose, .name = "hand_r", .joint = skeleton.jointIndex("hand_r")}, .state = GoalState::Pinned, .handle = true};
  goal.goal.target = {0.1, 1.0 / 3.0, -1e-17};
  goal.goal.orientation = Eigen::Quaterniond(0.1, 0.2, 0.3, 0.4).normalized();
  scene.goals = {goal};
  scene.camera.azimuth = 0.1 + 0.2;  // a double that has no short decimal
  scene.camera.orthographic = true;
  scene.options.skeleton = true;
  scene.solver = "dls";
  scene.theme = Theme::Dark;
  scene.selectedJoint = "head";
  scene.panels["Motion"] = R"({"time":1.25})";
  return scene;
}

TEST(SceneFile, ReadsBackExactlyWhatWasWritten) {
  const Skeleton skeleton = mannequin();
  const Scene scene = someScene(skeleton);
  const std::string path = temporary("round.json");
  saveScene(path, scene, skeleton);
  const Scene back = loadScene(path, skeleton);
  EXPECT_EQ(back.q, scene.q);
  ASSERT_EQ(back.goals.size(), 1u);
  EXPECT_EQ(back.goals[0].goal.target, scene.goals[0].goal.target);
  EXPECT_EQ(back.goals[0].goal.orientation.coeffs(), scene.goals[0].goal.orientation.coeffs());
  EXPECT_EQ(back.goals[0].state, GoalState::Pinned);
  EXPECT_EQ(back.camera.azimuth, scene.camera.azimuth);
  EXPECT_TRUE(back.camera.orthographic);
  EXPECT_TRUE(back.options.skeleton);
  EXPECT_EQ(back.solver, "dls");
  EXPECT_EQ(back.theme, Theme::Dark);
  EXPECT_EQ(back.selectedJoint, "head");
  EXPECT_EQ(back.panels.at("Motion"), R"({"time":1.25})");
  const std::string first = readFile(path);
  saveScene(path, back, skeleton);
  EXPECT_EQ(readFile(path), first);
  std::filesystem::remove(path);
}

TEST(SceneFile, ASessionGoesOnFromItsFileAsIfNothingHadHappened) {
  Model model{.name = "figure", .skeleton = mannequin()};
  model.handles = mannequinHandles();
  model.pins = {"foot_l", "foot_r"};
  Session session(model);
  const int hand = *session.findGoal("hand_r");
  session.setTarget(hand, session.reached(hand) + Eigen::Vector3d(0.0, 0.2, 0.1));
  for (int i = 0; i < 20; ++i) session.step();
  Scene scene;
  session.store(scene);
  const std::string path = temporary("session.json");
  saveScene(path, scene, model.skeleton);
  Session other(model);
  other.restore(loadScene(path, model.skeleton));
  EXPECT_EQ(other.q(), session.q());
  EXPECT_EQ(other.error(hand), session.error(hand));
  std::filesystem::remove(path);
}

struct BadFile {
  const char* name;
  const char* from;
  const char* to;
  const char* expected;  ///< a part of the message
};

TEST(SceneFile, SaysWhatIsWrongAndWhere) {
  const Skeleton skeleton = mannequin();
  const std::string path = temporary("bad.json");
  saveScene(path, someScene(skeleton), skeleton);
  const std::string good = readFile(path);
  for (const BadFile& bad : {BadFile{"joint", "\"joint\": \"hand_r\"", "\"joint\": \"tail\"", "a joint of the model, found 'tail'"},
                             BadFile{"state", "\"state\": \"pinned\"", "\"state\": \"glued\"", "one of free, held, dragged, pinned, found 'glued'"},
                             BadFile{"format", "gelenk-scene", "other", "\"format\": \"gelenk-scene\", found other"},
                             BadFile{"version", "\"version\": 1", "\"version\": 2", "version 1, found 2"},
                             BadFile{"q", "\"q\": [", "\"q\": [1.0,", "numbers, found"},
                             BadFile{"number", "\"q\": [", "\"q\": [\"x\",", "q"},
                             BadFile{"syntax", "\"solver\": ", "\"solver\" ", "expected JSON"},
                             BadFile{"distance", "\"distance\": 4.0", "\"distance\": -4.0", "a distance above 0"}}) {
    std::string text = good;
    const auto at = text.find(bad.from);
    ASSERT_NE(at, std::string::npos) << bad.name;
    writeFile(path, text.replace(at, std::string(bad.from).size(), bad.to));
    try {
      loadScene(path, skeleton);
      ADD_FAILURE() << bad.name << " was accepted";
    } catch (const ParseError& error) {
      EXPECT_NE(std::string(error.what()).find(bad.expected), std::string::npos) << bad.name << ": " << error.what();
      EXPECT_NE(std::string(error.what()).find(path), std::string::npos);
    }
  }
  std::filesystem::remove(path);
  EXPECT_THROW(loadScene(path, skeleton), std::runtime_error);
}

}  // namespace
}  // namespace gelenk
