#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/document/surface.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/io/text_file.h"
#include "kinematics/notation/mannequin.h"
#include "skinning/bodies/mannequin_body.h"
#include "skinning/io/gltf.h"
#include "skinning/io/obj.h"
#include "tests/sandbox/stage.h"

namespace gelenk {
namespace {

using nlohmann::json;

/// A triangle in a glTF of text, without bones.
std::string stiffGltf() {
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0],
                   "max": [1, 1, 0]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
}

/// A window that a mesh without a skeleton was dropped on, in a folder of its own.
struct DroppedBody : testing::Stage {
  std::filesystem::path folder = std::filesystem::temp_directory_path() / "dropped";

  DroppedBody() : testing::Stage({.model = "planar", .width = 1000, .height = 700}) {
    std::filesystem::create_directories(folder);
    const std::string path = (folder / "body.obj").string();
    writeObj(path, makeMannequinSkin(mannequin()).mesh);
    sandbox.open(path);
  }
  ~DroppedBody() { std::filesystem::remove_all(folder); }

  void play(const std::string& script) { testing::Stage::play(script, 1); }
  json status() {
    const json all = json::parse(sandbox.status());
    return all.contains("panels") && all["panels"].contains("Rig") ? all["panels"]["Rig"] : json{};
  }
  void waitForWork() {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(300);
    do {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      frame();
    } while ((status()["working"] == true || status()["weighing"] == true) &&
             std::chrono::steady_clock::now() < end);
  }
  const Skeleton& skeleton() { return sandbox.session().skeleton(); }
  Eigen::Vector3d at(const std::string& joint) {
    return restFrames(skeleton())[skeleton().jointIndex(joint)].translation();
  }
  double weightOn(const std::string& joint) {
    double sum = 0.0;
    for (const Influences& row : sandbox.session().skin()->influences)
      for (int k = 0; k < 4; ++k)
        if (row.joints[k] == skeleton().jointIndex(joint)) sum += row.weights[k];
    return sum;
  }
};

TEST(RigPanel, AMeshIsRiggedMendedByHandAndUndone) {
  DroppedBody stage;
  stage.frame();
  ASSERT_EQ(stage.status()["asking"], true);
  stage.play("0 do Rig human\n");
  stage.waitForWork();
  ASSERT_TRUE(stage.skeleton().findJoint("elbow_l"));

  // Handles, limits and pins stand.
  const Session& session = stage.sandbox.session();
  ASSERT_TRUE(session.findGoal("ankle_l"));
  EXPECT_EQ(session.goal(*session.findGoal("ankle_l")).state, GoalState::Pinned);
  const Joint knee = stage.skeleton().joint(stage.skeleton().jointIndex("knee_l"));
  EXPECT_FALSE(knee.ball);
  EXPECT_TRUE(std::isfinite(knee.axes.back().upper));

  // A joint is dragged with the mouse; the other side goes along; the weights follow.
  const Eigen::Vector3d left = stage.at("elbow_l"), right = stage.at("elbow_r"), wrist = stage.at("wrist_l");
  const double carried = stage.weightOn("elbow_l");
  stage.play("0 tab Rig\n1 do Rig tool on\n3 move 5 5\n");
  EXPECT_TRUE(mouseHint(stage.sandbox).starts_with("Drag a joint")) << mouseHint(stage.sandbox);
  const auto pixel = stage.sandbox.state().toWindow(left).pixel;
  stage.play("0 move " + std::to_string(pixel.x()) + " " + std::to_string(pixel.y()) +
             "\n1 press left\n2 move " + std::to_string(pixel.x() + 6) + " " + std::to_string(pixel.y() - 5) +
             "\n4 release left\n");
  stage.waitForWork();
  EXPECT_GT((stage.at("elbow_l") - left).norm(), 0.005);
  EXPECT_NEAR((stage.at("elbow_r") - right).norm(), (stage.at("elbow_l") - left).norm(), 1e-4);
  EXPECT_LT((stage.at("wrist_l") - wrist).norm(), 1e-9);
  EXPECT_NE(stage.weightOn("elbow_l"), carried);
  EXPECT_EQ(stage.status()["moved"], 1);

  // What was written says the same, limits included.
  const Skeleton written = readGltf((stage.folder / "body_rigged.glb").string()).skeleton;
  EXPECT_LT((restFrames(written)[written.jointIndex("elbow_l")].translation() - stage.at("elbow_l")).norm(),
            1e-6);
  EXPECT_EQ(written.joint(written.jointIndex("knee_l")).axes.back().upper, knee.axes.back().upper);

  stage.play("0 do Rig undo\n");
  EXPECT_LT((stage.at("elbow_l") - left).norm(), 1e-12);
  EXPECT_EQ(stage.weightOn("elbow_l"), carried);
  stage.play("0 do Rig confidence on\n1 tab Rig\n3 move 5 5\n");
  EXPECT_TRUE(stage.log.messages().empty());
}

TEST(RigPanel, EveryStepIsTakenBackAndDoneAgainToTheBit) {
  DroppedBody stage;
  const auto file = [&] { return readFile((stage.folder / "body_rigged.glb").string()); };
  stage.play("0 do Rig human\n");
  stage.waitForWork();
  std::vector<std::string> files{file()};
  for (const char* step : {"move knee_l 0.13 0.5 0.03", "move wrist_r -0.5 1.0 0.2", "weigh", "pinocchio",
                           "human", "move neck 0.01 1.5 0"}) {
    stage.play(std::string("0 do Rig ") + step + "\n");
    stage.waitForWork();
    files.push_back(file());
  }
  EXPECT_EQ(stage.status()["moved"], 6);
  for (auto expected = files.rbegin() + 1; expected != files.rend(); ++expected) {
    stage.play("0 keydown ctrl\n1 key z\n2 keyup ctrl\n");  // the document's history is empty
    EXPECT_EQ(file() == *expected, true) << "back to step " << files.rend() - expected - 1;
  }
  for (std::size_t k = 1; k < files.size(); ++k) {
    stage.play("0 do Rig redo\n");
    EXPECT_EQ(file() == files[k], true) << "forth to step " << k;
  }
}

TEST(RigPanel, ABodyThatIsOnlyAskedAboutChangesNothingOfTheOneThatStands) {
  DroppedBody stage;
  stage.play("0 do Rig human\n");
  stage.waitForWork();
  const std::string other = (stage.folder / "other.obj").string();
  writeObj(other, makeMannequinSkin(mannequin()).mesh);
  stage.sandbox.open(other);
  stage.play("0 key escape\n1 move 5 5\n");
  EXPECT_EQ(stage.status()["asking"], false);
  stage.play("0 do Rig weigh\n");
  stage.waitForWork();
  EXPECT_FALSE(std::filesystem::exists(stage.folder / "other_rigged.glb"));
  EXPECT_EQ(stage.sandbox.session().model().name, "body");
}

TEST(RigPanel, WhatIsNoBodyIsSaidAtOnceAndLeavesWhatStands) {
  DroppedBody stage;
  stage.play("0 do Rig cancel\n");
  for (const char* name : {"broken.stl", "missing.obj", "broken.obj"}) {
    const std::string path = (stage.folder / name).string();
    if (name != std::string("missing.obj")) writeFile(path, "v 0 0\n");
    EXPECT_FALSE(stage.sandbox.open(path)) << name;
    EXPECT_TRUE(stage.status().is_null()) << name;
  }
  EXPECT_EQ(stage.sandbox.session().model().name, "planar");
}

TEST(RigPanel, AGltfWithoutBonesIsAskedAboutAndOpensAsItIsWhereWanted) {
  DroppedBody stage;
  stage.play("0 do Rig cancel\n");
  const std::string path = (stage.folder / "stiff.gltf").string();
  writeFile(path, stiffGltf());
  ASSERT_TRUE(stage.sandbox.open(path));
  EXPECT_EQ(stage.status()["asking"], true);
  stage.play("0 do Rig as-it-is\n");
  EXPECT_EQ(stage.sandbox.session().model().name, "stiff");
}

}  // namespace
}  // namespace gelenk
