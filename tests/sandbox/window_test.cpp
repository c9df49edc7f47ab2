// A real window under Xvfb, moved by a real mouse (xdotool). The program writes its status after every frame;
// the test waits for frame numbers and facts in it, never for a time.
#include <gtest/gtest.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "kinematics/configuration.h"
#include "kinematics/io/text_file.h"
#include "kinematics/notation/mannequin.h"
#include "skinning/bodies/mannequin_body.h"
#include "skinning/io/obj.h"
#include "tests/places.h"
#include "tests/sandbox/drop_source.h"
#include "tests/sandbox/program.h"

namespace gelenk {
namespace {

using nlohmann::json;
using testing::hasCommand;
using testing::Program;
using testing::runProgram;

class RealWindow : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* command : {"Xvfb", "xdotool"})
      if (!hasCommand(command)) GTEST_SKIP() << command << " is not installed";
    folder_ = std::filesystem::temp_directory_path() / ("gelenk_window_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    xvfb_ = std::make_unique<Program>(std::vector<std::string>{
        "Xvfb", "-displayfd", "1", "-screen", "0", "1280x800x24", "-noreset", "-nolisten", "tcp"});
    std::string number;  // it says so on the same pipe when it finds a display taken and tries the next one
    for (int line = 0; line < 40 && !parseInteger(number); ++line) number = xvfb_->readLine();
    ASSERT_TRUE(parseInteger(number)) << "Xvfb did not start";
    display_ = "DISPLAY=:" + number;
    program_ = std::make_unique<Program>(
        std::vector<std::string>{"env", "-C", folder_.string(), testing::programFile(), "sandbox", "figure",
                                 "--status", statusPath(), "--size", "900x640", "--scale", "1"},
        std::vector<std::string>{display_, "LIBGL_ALWAYS_SOFTWARE=1", "XDG_CONFIG_HOME=" + folder_.string()});
    waitFor([](const json& s) { return s["frame"] >= 2; });
  }
  void TearDown() override {
    program_.reset();
    xvfb_.reset();
    std::filesystem::remove_all(folder_);
  }

  std::string statusPath() const { return folder_ / "status.json"; }

  static constexpr int patience = 200;  ///< seconds: machines that test may be busy
  /// The first status for which the condition holds; fails when the program ends or it takes too long.
  template <typename Condition>
  json waitFor(Condition condition, int line = __builtin_LINE()) {
    const time_t begin = time(nullptr);
    json status;
    while (time(nullptr) - begin < patience) {
      if (std::filesystem::exists(statusPath())) {
        status = json::parse(readFile(statusPath()));
        if (condition(status)) return status;
      }
      if (!program_->running()) {
        std::string output;
        program_->wait(output);
        throw std::runtime_error("the program ended: " + output);
      }
      const timespec pause{0, 2'000'000};
      nanosleep(&pause, nullptr);
    }
    if (status.is_object()) status.erase("q");
    throw std::runtime_error("waited in vain in line " + std::to_string(line) + ": " + status.dump());
  }
  json nextFrames(int count) {
    const int now = waitFor([](const json&) { return true; })["frame"];
    return waitFor([&](const json& s) { return s["frame"] >= now + count; });
  }
  static json goal(const json& status, const std::string& name) {
    for (const json& g : status["goals"])
      if (g["name"] == name) return g;
    throw std::runtime_error("no goal " + name);
  }
  void mouse(std::vector<std::string> words) {
    words.insert(words.begin(), "xdotool");
    const auto finished = runProgram(words, {display_});
    ASSERT_EQ(finished.status, 0) << finished.output;
  }
  static std::string whole(double x) { return std::to_string(std::lround(x)); }
  void moveTo(double x, double y) { mouse({"mousemove", whole(x), whole(y)}); }

  static Eigen::VectorXd configuration(const json& status) {
    const std::vector<double> values = status["q"];
    return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  }

  std::filesystem::path folder_;
  std::string display_;
  std::unique_ptr<Program> xvfb_, program_;
};

TEST_F(RealWindow, TheRightHandFollowsTheMouseAndIsStillWhereItCannot) {
  const json start = goal(waitFor([](const json&) { return true; }), "hand_r");
  const double x = start["pixel"][0], y = start["pixel"][1];
  moveTo(x, y);
  waitFor([&](const json& s) { return std::lround(s["mouse"][0].get<double>()) == std::lround(x); });
  mouse({"mousedown", "1"});
  waitFor([](const json& s) { return s["dragging"] == "hand_r"; });

  // Within reach: up and a little outwards.
  for (int i = 1; i <= 10; ++i) {
    moveTo(x - 2.0 * i, y - 6.0 * i);
    nextFrames(1);
  }
  json status = nextFrames(20);
  const json reached = goal(status, "hand_r");
  EXPECT_LT(reached["error"].get<double>(), 1e-3);
  EXPECT_NEAR(reached["pixel"][0].get<double>(), x - 20.0, 1.0);
  EXPECT_NEAR(reached["pixel"][1].get<double>(), y - 60.0, 1.0);

  // Far outside: to the left edge of the window.
  for (int i = 1; i <= 10; ++i) {
    moveTo(x - 20.0 - (x - 30.0) * i / 10.0, y - 60.0);
    nextFrames(1);
  }
  status = waitFor([](const json& s) { return s["mouse"][0] < 12.0; });
  const int arrived = status["frame"];
  status = waitFor([&](const json& s) { return s["frame"] >= arrived + 25; });
  EXPECT_GT(goal(status, "hand_r")["error"].get<double>(), 0.05);
  // Read two statuses at least one frame apart: motion a frame is at most their difference over the frames
  // between.
  const Skeleton skeleton = mannequin();
  const auto motion = [&](int least) {
    const json a = waitFor([&](const json& s) { return s["frame"] >= arrived + least; });
    const json b = nextFrames(5);
    EXPECT_LT(a["joint_motion"].get<double>(), least >= 200 ? 1e-5 : 1e-4)
        << a["frame"] << " " << goal(a, "hand_r");
    return difference(skeleton, configuration(a), configuration(b)).lpNorm<Eigen::Infinity>() /
           (b["frame"].get<int>() - a["frame"].get<int>());
  };
  EXPECT_LT(motion(25), 1e-4);
  EXPECT_LT(motion(200), 1e-5);

  mouse({"mouseup", "1"});
  status = waitFor([](const json& s) { return s["dragging"].is_null(); });
  EXPECT_EQ(goal(status, "hand_r")["state"], "held");
}

TEST_F(RealWindow, AShortTapOfAKeyIsNotLost) {
  const std::string before = waitFor([](const json&) { return true; })["solver"];
  moveTo(300, 120);
  mouse({"key", "Tab"});
  const json status = waitFor([&](const json& s) { return s["solver"] != before; });
  EXPECT_NE(status["solver"], before);
}

/// On a machine so slow that everything is there before the next frame: the same is done, in the same order.
TEST_F(RealWindow, WhatWasDoneWhileTheProgramDidNotAnswerIsDone) {
  const json start = waitFor([](const json&) { return true; }), at = goal(start, "hand_r");
  const double x = at["pixel"][0], y = at["pixel"][1];
  ::kill(program_->id(), SIGSTOP);
  moveTo(x, y);
  mouse({"mousedown", "1"});
  for (int i = 1; i <= 5; ++i) moveTo(x - 4.0 * i, y - 8.0 * i);
  mouse({"mouseup", "1"});
  moveTo(40, 60);
  ::kill(program_->id(), SIGCONT);
  waitFor([](const json& s) { return goal(s, "hand_r")["state"] == "held"; });
  json status = nextFrames(8);
  EXPECT_NEAR(goal(status, "hand_r")["pixel"][0].get<double>(), x - 20.0, 1.5);
  EXPECT_NEAR(goal(status, "hand_r")["pixel"][1].get<double>(), y - 40.0, 1.5);

  ::kill(program_->id(), SIGSTOP);
  moveTo(x - 20.0, y - 40.0);
  for (const char* words : {"robot scarra", "show velocity ellipsoid"}) {
    mouse({"key", "ctrl+k"});
    mouse({"type", "--delay", "2", words});
    if (words[0] == 'r') mouse({"key", "BackSpace", "BackSpace", "a"});
    mouse({"key", "Return"});
    if (words[0] == 'r') mouse({"key", "d"});  // not saved
  }
  mouse({"key", "Tab"});
  ::kill(program_->id(), SIGCONT);
  status = waitFor([&](const json& s) { return s["solver"] != start["solver"]; });
  EXPECT_EQ(status["model"], "scara");
  EXPECT_EQ(std::ranges::count(status["shown"], json("velocity_ellipsoid")), 1);
  EXPECT_EQ(status["dragging"], nullptr);
}

/// The hour in short, with a real mouse and real keys: everything is found through the command palette.
TEST_F(RealWindow, ALectureHourRunsFromStartToEnd) {
  const auto find = [&](const std::string& words) {
    mouse({"key", "ctrl+k"});
    nextFrames(3);
    mouse({"type", "--delay", "30", words});
    nextFrames(3);
    mouse({"key", "Return"});
    nextFrames(2);
  };
  const auto dragGoal = [&](const json& at, double dx, double dy) {
    const double x = at["pixel"][0], y = at["pixel"][1];
    moveTo(x, y);
    waitFor([&](const json& s) { return std::lround(s["mouse"][0].get<double>()) == std::lround(x); });
    mouse({"mousedown", "1"});
    waitFor([](const json& s) { return !s["dragging"].is_null(); });
    for (int i = 1; i <= 6; ++i) {
      moveTo(x + dx * i / 6, y + dy * i / 6);
      nextFrames(1);
    }
    const json status = nextFrames(8);
    mouse({"mouseup", "1"});
    waitFor([](const json& s) { return s["dragging"].is_null(); });
    return goal(status, at["name"]);
  };
  moveTo(300, 200);

  find("lecture analytic two links");
  json status = waitFor([](const json& s) { return s["example"] == "two-link"; });
  EXPECT_LT(dragGoal(goal(status, "end-effector"), -40, -30)["error"].get<double>(), 1e-6);

  find("lecture newton several");
  status = waitFor([](const json& s) { return s["example"] == "newton-square"; });
  mouse({"key", "F5"});  // for the room, and back
  waitFor([](const json& s) { return s["view"]["height"] == 640; });
  mouse({"key", "F5"});
  waitFor([](const json& s) { return s["view"]["height"] < 640; });

  find("show convergence");
  waitFor([](const json& s) { return std::ranges::count(s["shown"], json("convergence")) == 1; });
  nextFrames(6);

  find("robot scara");
  status = waitFor([](const json& s) { return s["model"] == "scara"; });
  find("show velocity ellipsoid");
  waitFor([](const json& s) { return std::ranges::count(s["shown"], json("velocity_ellipsoid")) == 1; });
  EXPECT_LT(dragGoal(goal(nextFrames(1), "tool"), 30, 20)["error"].get<double>(), 2e-3);

  find("open model figure");
  mouse({"key", "d"});  // the arm's pose is not to be saved
  status = waitFor([](const json& s) { return s["model"] == "figure"; });
  const bool films = hasCommand("ffmpeg");
  if (films) {
    mouse({"key", "ctrl+r"});
    waitFor([](const json& s) { return s["recording"] == true; });
  }
  dragGoal(goal(nextFrames(2), "hand_r"), -20, -60);
  mouse({"key", "p"});  // under the mouse
  status = waitFor([](const json& s) { return goal(s, "hand_r")["state"] == "pinned"; });
  find("tab muscles");
  dragGoal(goal(nextFrames(2), "hand_l"), 20, -40);
  status = nextFrames(2);
  EXPECT_LT(goal(status, "hand_r")["error"].get<double>(), 3e-4);
  EXPECT_LT(goal(status, "foot_l")["error"].get<double>(), 3e-4);
  if (films) {
    mouse({"key", "ctrl+r"});
    waitFor([](const json& s) { return s["recording"] == false; });
    EXPECT_GT(std::filesystem::file_size(folder_ / "gelenk-0001.mp4"), 1000u);
  }

  find("lecture hierarchical leg");
  mouse({"key", "d"});
  waitFor([](const json& s) { return s["example"] == "leg"; });
  nextFrames(10);
}

/// By the protocol that file managers speak: the question, the work, and a hand that follows the mouse.
TEST_F(RealWindow, AFileDroppedFromAnotherWindowIsRiggedAndDragged) {
  if (!testing::canDropFiles()) GTEST_SKIP() << "built without X11's library";
  const auto drop = [&](const std::vector<std::string>& paths) {
    testing::dropFiles(display_.substr(display_.find(':')), paths, 300, 200);
  };
  const auto rigOf = [](const json& s) {
    return s.contains("panels") ? s["panels"].value("Rig", json::object()) : json::object();
  };
  const auto file = folder_ / "K\u00f6rper #1 50%.obj";
  writeObj(file.string(), makeMannequinSkin(mannequin()).mesh);

  drop({file.string(), (folder_ / "nothing.obj").string()});  // two surfaces: neither
  nextFrames(3);
  drop({file.string()});
  waitFor([&](const json& s) { return rigOf(s).value("asking", false); });
  drop({file.string()});  // impatience: asked once
  EXPECT_TRUE(rigOf(nextFrames(3)).value("asking", false));
  mouse({"key", "Escape"});
  waitFor([&](const json& s) { return rigOf(s).empty(); });
  drop({file.string()});
  waitFor([&](const json& s) { return rigOf(s).value("asking", false); });
  mouse({"key", "Return"});
  json status = waitFor([&](const json& s) { return rigOf(s).value("confidence", 0.0) > 0.0; });
  EXPECT_TRUE(std::filesystem::exists(folder_ / "K\u00f6rper #1 50%_rigged.glb"));

  const json wrist = goal(status, "wrist_l");
  const double x = wrist["pixel"][0], y = wrist["pixel"][1];
  moveTo(x, y);
  waitFor([&](const json& s) { return std::lround(s["mouse"][0].get<double>()) == std::lround(x); });
  mouse({"mousedown", "1"});
  waitFor([](const json& s) { return s["dragging"] == "wrist_l"; });
  for (int i = 1; i <= 6; ++i) {
    moveTo(x + 3.0 * i, y - 6.0 * i);
    nextFrames(1);
  }
  status = nextFrames(10);
  EXPECT_LT(goal(status, "wrist_l")["error"].get<double>(), 1e-3);
  EXPECT_NEAR(goal(status, "wrist_l")["pixel"][1].get<double>(), y - 36.0, 1.5);
  mouse({"mouseup", "1"});
}

/// Ticks of processor time that the process has taken so far, its own and the system's for it.
long ticksOf(int process) {
  const std::string line = readFile("/proc/" + std::to_string(process) + "/stat");
  std::istringstream words(line.substr(line.rfind(')') + 2));
  std::string skipped;
  for (int i = 0; i < 11; ++i) words >> skipped;
  long user = 0, system = 0;
  words >> user >> system;
  return user + system;
}

TEST_F(RealWindow, AtRestItTakesUnderTwoPercentOfACoreAndWakesAtOnce) {
  const auto frame = [&] { return waitFor([](const json&) { return true; })["frame"].get<int>(); };
  const auto pause = [](int milliseconds) {
    const timespec time{milliseconds / 1000, milliseconds % 1000 * 1'000'000L};
    nanosleep(&time, nullptr);
  };
  int last = -1;
  // Until it has come to rest; its last frame, the smooth one, may take a loaded machine more than a second.
  for (int now = frame(), tries = 0, same = 0; same < 4 && tries < 120; ++tries) {
    same = now == last ? same + 1 : 0;
    last = now;
    pause(1000);
    now = frame();
  }
  const long before = ticksOf(program_->id());
  constexpr int seconds = 5;
  pause(1000 * seconds);
  const double share =
      static_cast<double>(ticksOf(program_->id()) - before) / (seconds * sysconf(_SC_CLK_TCK));
  EXPECT_EQ(frame(), last);
  EXPECT_LT(share, 0.02);
  RecordProperty("share_of_a_core", std::to_string(share));
  moveTo(300, 120);
  waitFor([&](const json& s) { return std::lround(s["mouse"][0].get<double>()) == 300; });
  mouse({"key", "space"});  // nothing plays: no reason to go on
  mouse({"key", "Tab"});
  waitFor([&](const json& s) { return s["solver"] != "hybrid"; });
}

}  // namespace
}  // namespace gelenk
