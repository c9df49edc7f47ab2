#include "apps/document/scene.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "apps/document/session.h"
#include "kinematics/configuration.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "kinematics/notation/mannequin.h"
#include "tests/kinematics/io/bad_input.h"

namespace gelenk {
namespace {

std::string temporary(const std::string& name) {
  return (std::filesystem::temp_directory_path() / ("gelenk_scene_" + std::to_string(getpid()) + "_" + name))
      .string();
}

Scene someScene(const Skeleton& skeleton) {
  std::mt19937_64 random(7);
  Scene scene;
  scene.model = {"figure", "", ""};
  scene.q = randomWithinLimits(skeleton, random);
  SceneGoal goal{.goal = {.kind = GoalKind::Pose, .name = "hand_r", .joint = skeleton.jointIndex("hand_r")},
                 .state = GoalState::Pinned,
                 .handle = true};
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

TEST(SceneFile, SaysWhatIsWrongAndWhere) {
  const Skeleton skeleton = mannequin();
  const std::string path = temporary("bad.json");
  saveScene(path, someScene(skeleton), skeleton);
  const std::string good = readFile(path);
  std::filesystem::remove(path);
  const auto with = [&](const std::string& old, const std::string& replacement) {
    std::string text = good;
    const std::size_t at = text.find(old);
    EXPECT_NE(at, std::string::npos) << old;
    return text.replace(at, old.size(), replacement);
  };
  const std::string head = "{\"format\": \"gelenk-scene\", \"version\": 1";
  testing::expectRefused(
      {
          {"empty", "", 1, "expected JSON, found the end of the file"},
          {"cut off", good.substr(0, good.size() / 2),
           1 + static_cast<int>(std::count(good.begin(), good.begin() + good.size() / 2, '\n')),
           "expected JSON, found the end of the file"},
          {"syntax", with("\"solver\": ", "\"solver\" "),
           1 + static_cast<int>(std::count(good.begin(), good.begin() + good.find("\"solver\""), '\n')),
           "a character that does not belong there"},
          {"CRLF keeps line numbers", "{\r\n\"format\": x}\r\n", 2, "a character that does not belong there"},
          {"NaN", "{\n\"version\": NaN}", 2, "a character that does not belong there"},
          {"binary",
           std::string("\x7f"
                       "ELF\0\1",
                       6),
           1, "expected JSON"},
          {"a number too large", "{\"version\": 1e999}", 0, "numbers that a double can hold"},
          {"nested a million deep", std::string(1000000, '['), 0, "nested at most 200 deep"},
          {"a list", "[]", 0, "a Gelenk scene"},
          {"another format", with("gelenk-scene", "other"), 0, "\"format\": \"gelenk-scene\", found other"},
          {"no format", "{}", 0, "an entry \"format\", found none"},
          {"format a number", "{\"format\": 3}", 0, "format: a text, found 3"},
          {"another version", with("\"version\": 1", "\"version\": 2"), 0, "version 1, found 2"},
          {"version a fraction", with("\"version\": 1", "\"version\": 1.5"), 0,
           "version: an integer of 32 bits, found 1.5"},
          {"version too large", with("\"version\": 1", "\"version\": 4294967297"), 0,
           "version: an integer of 32 bits, found 4294967297"},
          {"no model", head + "}", 0, "an entry \"model\", found none"},
          {"model a text", head + ", \"model\": \"figure\"}", 0, "model: an object {...}, found \"figure\""},
          {"no name", head + ", \"model\": {}}", 0, "model: an entry \"name\""},
          {"no pose", head + ", \"model\": {\"name\": \"figure\"}}", 0, "an entry \"q\""},
          {"pose too long", with("\"q\": [", "\"q\": [1.0,"), 0,
           "q: " + std::to_string(skeleton.nq()) + " numbers, found " + std::to_string(skeleton.nq() + 1)},
          {"pose of words", with("\"q\": [\n  ", "\"q\": [\n  \"x\" , "), 0,
           "q: " + std::to_string(skeleton.nq()) + " numbers"},
          {"unknown joint", with("\"joint\": \"hand_r\"", "\"joint\": \"tail\""), 0,
           "joint: a joint of the model, found 'tail'"},
          {"joint in other case", with("\"joint\": \"hand_r\"", "\"joint\": \"Hand_R\""), 0,
           "found 'Hand_R'"},
          {"unknown state", with("\"state\": \"pinned\"", "\"state\": \"glued\""), 0,
           "state: one of free, held, dragged, pinned, found 'glued'"},
          {"unknown kind", with("\"kind\": \"pose\"", "\"kind\": \"wish\""), 0,
           "one of position, orientation, pose, aim, pole, posture, found 'wish'"},
          {"goals no list",
           head + ", \"model\": {\"name\": \"figure\"}, \"q\": " +
               [&] {
                 const auto at = good.find("\"q\": [") + 5;
                 return good.substr(at, good.find(']', at) + 1 - at);
               }() +
               ", \"goals\": 7}",
           0, "goals: a list [...], found 7"},
          {"handle no truth value", with("\"handle\": true", "\"handle\": \"yes\""), 0,
           "handle: true or false, found \"yes\""},
          {"distance negative", with("\"distance\": 4.0", "\"distance\": -4.0"), 0,
           "camera.distance: a distance above 0, found -4"},
          {"an orthographic number", with("\"orthographic\": ", "\"orthographic\": 1, \"x\": "), 0,
           "camera.orthographic: true or false, found 1"},
          {"show no truth value", with("\"ground\": ", "\"ground\": 0, \"x\": "), 0,
           "show.ground: true or false, found 0"},
          {"unknown theme", with("\"theme\": \"", "\"theme\": \"very "), 0, "theme: one of light, dark"},
          {"panels a list", with("\"panels\": {", "\"panels\": [], \"x\": {"), 0,
           "panels: an object {...}, found []"},
      },
      [&](const std::string& text, const std::string& file) { parseScene(text, file, skeleton); });
  EXPECT_THROW(loadScene(path, skeleton), std::runtime_error);
}

}  // namespace
}  // namespace gelenk
