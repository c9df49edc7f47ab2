#include "apps/sandbox/sandbox.h"

#include <gtest/gtest.h>
#include <imgui.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/sandbox/sandbox_state.h"
#include "kinematics/configuration.h"
#include "kinematics/io/text_file.h"
#include "kinematics/notation/mannequin.h"
#include "skinning/gpu/driver.h"
#include "tests/sandbox/stage.h"

namespace gelenk {
namespace {

using nlohmann::json;

constexpr int width = 640, height = 480;

Model figure() {
  Model model{.name = "figure", .skeleton = mannequin()};
  model.handles = mannequinHandles();
  model.pins = {"foot_l", "foot_r"};
  return model;
}

/// A sandbox without a window, with the figure's skeleton, and everything that it needs.
struct Stage : testing::Stage {
  int next = 0;

  Stage() : testing::Stage({.model = "planar", .width = gelenk::width, .height = gelenk::height}) {
    sandbox.openModel(figure(), {"figure", "", {}});
  }
  void frames(int count, Replay* replay = nullptr) {
    for (int i = 0; i < count; ++i, ++next) {
      if (replay) replay->play(next, sandbox, queue);
      frame();
    }
  }
  json goal(const std::string& name) {
    const json status = json::parse(sandbox.status());
    for (const json& goal : status["goals"])
      if (goal["name"] == name) return goal;
    return {};
  }
};

std::string statusesOf(const std::string& script) {
  Stage stage;
  Replay replay = Replay::parse("test", script);
  std::string all;
  for (int i = 0; i < replay.length(); ++i) {
    stage.frames(1, &replay);
    all += stage.sandbox.status();
  }
  return all;
}

TEST(Sandbox, TheSameReplayGivesTheSameStatusByteForByte) {
  const std::string script =
      "0 drag hand_r -30 -60 8\n12 move 300 200\n13 wheel 2\n14 key m\n16 drag head 20 5 4\n24 key r\n";
  const std::string first = statusesOf(script);
  EXPECT_EQ(first, statusesOf(script));
  EXPECT_NE(first.find("\"dragging\": \"hand_r\""), std::string::npos);
}

/// Frames of more than a tenth of a second are told as that and a rest (slept): they are slow all the same. A
/// pause at rest is no slow frame.
TEST(Sandbox, WhatMovesIsDrawnSmallerHoweverSlowTheMachineIsAndNotAfterAPause) {
  testing::Stage stage({.model = "figure", .width = width, .height = height, .refines = true});
  if (!isSoftwareRenderer()) GTEST_SKIP() << "full pictures on hardware";
  const auto pause = [&](int milliseconds) {
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    stage.sandbox.slept(0.1);
  };
  Sandbox::State& s = stage.sandbox.state();
  for (int i = 0; i < 50 && (i < 3 || stage.sandbox.rests() == 0.0); ++i) stage.frame();
  ASSERT_GT(stage.sandbox.rests(), 0.0);
  const double before = s.secondsPerFrame;
  pause(400);
  stage.frame();
  EXPECT_EQ(s.secondsPerFrame, before);
  s.secondsPerFrame = 0.0;
  Replay replay = Replay::parse("test", "0 drag hand_r -30 -60 12");
  for (int i = 0; i < 8; ++i) {
    replay.play(i, stage.sandbox, stage.queue);
    pause(30);
    stage.frame();
  }
  EXPECT_GT(s.secondsPerFrame, 0.022);
  EXPECT_TRUE(s.drawnSmall);
}

TEST(Sandbox, AHandDraggedByTheMouseEndsUnderTheMouse) {
  Stage stage;
  stage.frames(1);
  const json before = stage.goal("hand_r");
  Replay replay = Replay::parse("test", "1 grab hand_r\n2 shift-by -20 -40 10\n");
  stage.frames(40, &replay);
  const json after = stage.goal("hand_r");
  EXPECT_LT(after["error"].get<double>(), 1e-3);
  EXPECT_EQ(after["state"], "dragged");
  EXPECT_NEAR(after["pixel"][0].get<double>() - before["pixel"][0].get<double>(), -20.0, 0.5);
  EXPECT_NEAR(after["pixel"][1].get<double>() - before["pixel"][1].get<double>(), -40.0, 0.5);
}

TEST(Sandbox, KeysPinUndoAndChangeTheSolver) {
  Stage stage;
  Replay replay = Replay::parse("test",
                                "0 grab hand_r\n1 shift-by 0 -30 4\n6 key p\n8 release left\n"
                                "20 key tab\n30 keydown ctrl\n31 key z\n33 keyup ctrl\n");
  stage.frames(12, &replay);
  EXPECT_EQ(stage.goal("hand_r")["state"], "pinned");
  EXPECT_EQ(json::parse(stage.sandbox.status())["solver"], "drag");
  stage.frames(12, &replay);
  EXPECT_NE(json::parse(stage.sandbox.status())["solver"], "drag");
  stage.frames(12, &replay);
  EXPECT_EQ(stage.goal("hand_r")["state"], "free");
}

TEST(Sandbox, ADragThatAKeyEndsIsOver) {
  Stage stage;
  for (const char* end :
       {"key m", "key r", "free hand_r"}) {  // mirrored, reset, let go: the button still down
    Replay replay = Replay::parse("test", "0 grab hand_r\n1 move 300 200\n3 " + std::string(end) +
                                              "\n6 keydown shift\n7 move 320 260\n9 move 100 260\n"
                                              "11 keyup shift\n12 release left\n");
    stage.next = 0;
    stage.frames(16, &replay);
    const json status = json::parse(stage.sandbox.status());
    EXPECT_TRUE(status["dragging"].is_null()) << end;
    for (const json& q : status["q"]) EXPECT_TRUE(q.is_number()) << end;
  }
}

TEST(Sandbox, ASavedSceneOpensAsTheSamePicture) {
  const std::string path =
      (std::filesystem::temp_directory_path() / ("gelenk_" + std::to_string(getpid()) + ".json")).string();
  Stage stage;
  Replay replay = Replay::parse("test", "0 drag hand_l 30 -30 8\n12 wheel 3\n14 key 5\n");
  stage.frames(30, &replay);
  ASSERT_TRUE(stage.sandbox.saveSceneTo(path));
  const Camera camera = stage.sandbox.camera();
  const Eigen::VectorXd q = stage.sandbox.session().q();
  Replay reset = Replay::parse("test", "30 key r\n32 key Home\n");
  stage.frames(30, &reset);
  EXPECT_NE(stage.sandbox.session().q(), q);
  ASSERT_TRUE(stage.sandbox.open(path));
  EXPECT_EQ(stage.sandbox.session().q(), q);
  EXPECT_EQ(stage.sandbox.camera().distance, camera.distance);
  EXPECT_EQ(stage.sandbox.camera().orthographic, camera.orthographic);
  std::filesystem::remove(path);
}

TEST(Sandbox, ASceneSavedUnderABareNameOpensAgain) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("gelenk_bare_" + std::to_string(getpid()));
  Stage stage;
  stage.frames(1);
  ASSERT_TRUE(stage.sandbox.saveSceneTo(path));
  EXPECT_TRUE(stage.sandbox.open(path.string() + ".json"));
  EXPECT_FALSE(std::filesystem::exists(path));
  std::filesystem::remove(path.string() + ".json");
}

TEST(Sandbox, EscapeClosesAListThatIsOpen) {
  Stage stage;
  stage.frames(2);
  const auto play = [&](const std::string& command, int frames) {
    Replay replay = Replay::parse("test", std::to_string(stage.next) + " " + command + "\n");
    stage.frames(frames, &replay);
  };
  const auto open = [] { return ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup); };
  // The list of solvers stands in the inspector, right of the view: looked for with the mouse.
  const json view = json::parse(stage.sandbox.status())["view"];
  const double x = view["x"].get<double>() + view["width"].get<double>() + 60.0;
  for (int y = view["y"]; y < height && !open(); y += 8) {
    play("tab Solve", 2);  // a click may have hit another tab
    play("move " + std::to_string(x) + " " + std::to_string(y), 2);
    play("press left", 1);
    play("release left", 2);
  }
  ASSERT_TRUE(open());
  play("key escape", 3);
  EXPECT_FALSE(open());
}

TEST(Sandbox, ABadFileIsToldOnScreenAndLeavesWhatIsOpen) {
  Stage stage;
  stage.frames(1);
  EXPECT_FALSE(stage.sandbox.open("/no/such/file.obj"));
  EXPECT_FALSE(stage.sandbox.open("/no/such/scene.json"));
  stage.frames(2);
  EXPECT_EQ(stage.sandbox.session().model().name, "figure");
}

TEST(Sandbox, EveryTabThemeAndViewDrawsWithoutAnOpenGlMessage) {
  Stage stage;
  Replay replay = Replay::parse(
      "test",
      "0 tab Model\n1 theme dark\n2 tab Skin\n3 show joint_frames on\n3 show skeleton on\n4 key h\n6 key h\n"
      "8 key 1\n9 key 3\n10 key 7\n11 key 5\n12 select head\n13 tab Model\n14 key f\n15 drag hand_r 200 0 "
      "5\n");
  stage.frames(30, &replay);
  EXPECT_TRUE(stage.log.messages().empty()) << stage.log.messages().front();
}

TEST(Sandbox, ThePlanarArmIsSeenFromAboveAndFollowsTheMouse) {
  Stage stage;
  ASSERT_TRUE(stage.sandbox.open("planar"));
  EXPECT_TRUE(stage.sandbox.camera().orthographic);
  const std::string end = stage.sandbox.session().goals().front().goal.name;
  Replay replay = Replay::parse("test", "0 drag " + end + " -40 -50 20\n");
  stage.frames(60, &replay);
  const json goal = stage.goal(end);
  const Eigen::Vector3d goalPoint =
      stage.sandbox.session().reached(stage.sandbox.session().goals().front().id);
  const double pixel = pixelSize(stage.sandbox.camera(), {width, height}, goalPoint);
  EXPECT_LT(goal["error"].get<double>(), 0.1 * pixel);
}

}  // namespace
}  // namespace gelenk
