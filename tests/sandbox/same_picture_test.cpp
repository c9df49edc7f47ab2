// One document, three ways to see it: the window's frame, the offscreen program and `gelenk render`.
#include <gtest/gtest.h>
#include <png.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "apps/commands/image.h"
#include "apps/document/scene_file.h"
#include "apps/lecture/example.h"
#include "apps/sandbox/replay.h"
#include "apps/sandbox/sandbox_state.h"
#include "apps/sandbox/view_picture.h"
#include "kinematics/io/text_file.h"
#include "skinning/gpu/offscreen_context.h"
#include "skinning/gpu/render_target.h"
#include "tests/places.h"
#include "tests/sandbox/program.h"

namespace gelenk {
namespace {

constexpr int width = 800, height = 600;

Image readPng(const std::string& path) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_file(&header, path.c_str())) throw std::runtime_error(path);
  header.format = PNG_FORMAT_RGBA;
  Image image{static_cast<int>(header.width), static_cast<int>(header.height), {}};
  image.pixels.resize(PNG_IMAGE_SIZE(header));
  if (!png_image_finish_read(&header, nullptr, image.pixels.data(), 0, nullptr))
    throw std::runtime_error(path);
  return image;
}

/// Pixels of a rectangle from a picture's top left corner, RGB.
std::vector<std::uint8_t> cut(const Image& image, int x, int y, int w, int h) {
  std::vector<std::uint8_t> pixels;
  for (int row = y; row < y + h; ++row)
    for (int column = x; column < x + w; ++column)
      pixels.insert(pixels.end(), image.at(column, row), image.at(column, row) + 3);
  return pixels;
}

std::size_t differing(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i];
  return count;
}

/// Opens the model, plays the script, saves, and compares the three pictures of what was saved.
void expectTheSamePicture(const std::string& model, const std::string& script,
                          const std::function<void(Session&)>& change = {}) {
  SCOPED_TRACE(model);
  const auto folder = std::filesystem::temp_directory_path() / ("gelenk_same_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const std::string scene = folder / "scene.json", offscreen = folder / "offscreen.png",
                    status = folder / "status.json", rendered = folder / "rendered.png";
  Image window{width, height, {}};
  {
    const OffscreenContext context;
    Sandbox sandbox({.model = model, .width = width, .height = height});
    ViewPicture target;
    target.resize(width, height);
    InputQueue queue;
    Replay replay = Replay::parse("test", script + "60 move 5 5\n");
    const auto frame = [&](double dt) {
      glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
      sandbox.frame({.width = width, .height = height, .events = queue.take(sandbox.keys())}, dt);
    };
    for (int i = 0; i < replay.length(); ++i) {
      replay.play(i, sandbox, queue);
      frame(1.0 / 60.0);
    }
    if (change) change(sandbox.session());
    ASSERT_TRUE(sandbox.saveSceneTo(scene));
    const auto opened = openDocument({.nameOrFile = scene});
    sandbox.openDocument(opened.model, opened.document);
    frame(20.0);  // notices have gone
    window.pixels = readPixels(target.framebuffer(), width, height);
  }
  const std::string size = std::to_string(width) + "x" + std::to_string(height);
  auto finished = testing::runProgram({testing::programFile(), "sandbox", scene, "--offscreen", "--size",
                                       size, "--scale", "1", "--screenshot", offscreen, "--status", status});
  ASSERT_EQ(finished.status, 0) << finished.output;
  const auto view = nlohmann::json::parse(readFile(status))["view"];
  const int x = view["x"], y = view["y"], w = view["width"], h = view["height"];
  finished =
      testing::runProgram({testing::programFile(), "render", scene, "--size",
                           std::to_string(w) + "x" + std::to_string(h), "--smoothing", "1", "-o", rendered});
  ASSERT_EQ(finished.status, 0) << finished.output;

  // A model's own notice lies over the lower part of the view in the program's first frame.
  const int clear = h - 90;
  const auto ofWindow = cut(window, x, y, w, clear), ofOffscreen = cut(readPng(offscreen), x, y, w, clear),
             ofRender = cut(readPng(rendered), 0, 0, w, clear);
  EXPECT_EQ(differing(ofWindow, ofOffscreen), 0u);
  EXPECT_EQ(differing(ofWindow, ofRender), 0u);
  const std::size_t distinct = std::set<std::uint8_t>(ofRender.begin(), ofRender.end()).size();
  EXPECT_GT(distinct, 40u);  // a picture, not a blank
  std::filesystem::remove_all(folder);
}

TEST(SamePicture, OfAPlanarArmThatWasDragged) {
  expectTheSamePicture("planar", "0 drag end-effector -40 -50 20\n30 show joint_frames on\n");
}

TEST(SamePicture, OfARobotWithItsFramesInTheDark) {
  expectTheSamePicture("panda",
                       "0 theme dark\n1 drag tool 30 -40 10\n30 show skeleton on\n31 show joint_frames on\n");
}

TEST(SamePicture, OfTheFigureWithPaintedWeightsMusclesAndPins) {
  expectTheSamePicture("figure", "0 drag hand_r -30 -60 10\n", [](Session& session) {
    MuscleSettings muscles = *session.edits().muscles;
    muscles.enabled = true;
    session.setMuscles(std::make_shared<MuscleSettings>(muscles));
    WeightChange change;
    for (int v = 0; v < 4000; ++v) change.push_back({v, Influences{}});
    session.changeWeights(change);
    session.view().show.weights = true;
    session.selectJoint(session.skeleton().jointIndex("lowerarm_l"));
  });
}

/// Ghosts of the compared solvers, in place and side by side under their names.
TEST(SamePicture, OfSolversComparedOnOneGoal) {
  for (const bool sideBySide : {false, true})
    expectTheSamePicture("planar", "1 key L\n3 target end-effector 150 500 0\n", [&](Session& session) {
      EXPECT_EQ(session.lab().poses.size(), session.lab().solvers.size());
      session.lab().sideBySide = sideBySide;
    });
}

/// With all that they draw and write into the view.
TEST(SamePicture, OfEveryExampleOfTheLecture) {
  for (const LectureTopic& topic : lectureTopics())
    expectTheSamePicture("lecture:" + topic.id,
                         topic.id == "two-link" ? "5 drag end-effector -40 -50 20\n" : "");
}

/// Trails, places where feet stand and limits that are left.
TEST(SamePicture, OfAMotionWithAllItsMarks) {
  const std::string file = (std::filesystem::temp_directory_path() / "gelenk_same_walk.bvh").string();
  std::string text =
      "HIERARCHY\nROOT hips\n{\nOFFSET 0 1 0\nCHANNELS 3 Xposition Yposition Zposition\n"
      "JOINT lfemur\n{\nOFFSET 0.1 0 0\nCHANNELS 1 Xrotation\nJOINT ltibia\n{\nOFFSET 0 -0.45 0\nCHANNELS 1 "
      "Xrotation\n"
      "JOINT lfoot\n{\nOFFSET 0 -0.45 0\nCHANNELS 1 Xrotation\nJOINT ltoes\n{\nOFFSET 0 -0.1 0.15\nCHANNELS "
      "1 "
      "Xrotation\nEnd Site\n{\nOFFSET 0 0 0.06\n}\n}\n}\n}\n}\n"
      "JOINT head\n{\nOFFSET 0 0.7 0\nCHANNELS 1 Yrotation\nEnd Site\n{\nOFFSET 0 0.2 0\n}\n}\n}\n"
      "MOTION\nFrames: 60\nFrame Time: 0.0333333\n";
  for (int f = 0; f < 60; ++f) {
    const double swing = f < 30 ? 0.0 : 25.0 * std::sin(0.2 * (f - 30));
    text += std::to_string(0.01 * f) + " 1 0 " + std::to_string(-swing) + " " +
            std::to_string(std::abs(swing)) + " 0 0 " + std::to_string(f) + "\n";
  }
  writeFile(file, text);
  expectTheSamePicture(file, "5 do Motion frame 34\n", [](Session& session) {
    EXPECT_TRUE(session.playback().trails && session.playback().contacts && session.playback().limits);
  });
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace gelenk
