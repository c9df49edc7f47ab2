// What a first user met (the review of the sandbox), a test a bug: each failed before it was mended.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/document/model_files.h"
#include "apps/document/muscle_settings.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/configuration.h"
#include "kinematics/io/text_file.h"
#include "solvers/problem/ik_solver.h"
#include "tests/places.h"
#include "tests/sandbox/stage.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int width = 800, height = 600;

struct Stage : testing::Stage {
  explicit Stage(const std::string& model)
      : testing::Stage({.model = model, .width = gelenk::width, .height = gelenk::height}) {}
  Vector2d pixelOf(const std::string& goal) {
    Session& session = sandbox.session();
    return sandbox.state().toWindow(session.reached(*session.findGoal(goal))).pixel;
  }
};

std::string at(const Vector2d& pixel) { return std::to_string(pixel.x()) + " " + std::to_string(pixel.y()); }

/// 3: a lecture example's ground, shadow and solver stayed for what was opened next.
TEST(Review, WhatALectureExampleShowsEndsWithIt) {
  Stage stage("planar");
  for (const char* topic : {"planar-fk", "two-link", "rotations", "newton-square"}) {
    ASSERT_TRUE(stage.sandbox.open(std::string("lecture:") + topic));
    stage.play("", 2);
    ASSERT_TRUE(stage.sandbox.open("panda"));
    stage.play("", 1);
    EXPECT_TRUE(stage.sandbox.options().ground) << topic;
    EXPECT_TRUE(stage.sandbox.options().shadow) << topic;
    EXPECT_EQ(stage.sandbox.session().solver(), "drag") << topic;
  }
}

/// Notes on a file's seven missing meshes covered a small window.
TEST(Review, NoticesLeaveMostOfASmallViewFree) {
  Stage stage("figure");
  for (int i = 0; i < 4; ++i) {
    std::string words = "meshes that were not found:";
    for (int k = 0; k < 40; ++k) words += " package://example/robots/meshes/visual/part.dae,";
    stage.sandbox.say(words, i % 2 == 0);
  }
  const auto picture = [&](int w, int h, double dt) {
    stage.target.resize(w, h);
    glBindFramebuffer(GL_FRAMEBUFFER, stage.target.framebuffer());
    stage.sandbox.frame({.width = w, .height = h, .events = {}}, dt);
    return readPixels(stage.target.framebuffer(), w, h);
  };
  for (const auto& [w, h] : {std::pair{640, 480}, {1280, 800}}) {
    const auto with = picture(w, h, 1e-3);
    auto notices = std::exchange(stage.sandbox.state().notices, {});
    const auto without = picture(w, h, 1e-3);
    stage.sandbox.state().notices = std::move(notices);
    const Layout::Rect view = stage.sandbox.state().layout.view;
    int covered = 0;
    for (std::size_t i = 0; i < with.size(); i += 4) covered += std::memcmp(&with[i], &without[i], 3) != 0;
    EXPECT_GT(covered, 1000);
    EXPECT_LT(covered, 0.5 * view.width * view.height);
  }
}

/// 7: with a low eye a strip without ground stood at the bottom; from below there was none.
TEST(Review, TheGroundReachesTheBottomAndIsSeenFromBelow) {
  Stage stage("panda");
  stage.play("", 1);
  Sandbox::State& s = stage.sandbox.state();
  const auto rows = [&](double height, double elevation, bool ground) {
    s.show().ground = ground;
    s.show().handles = false;
    Camera& camera = stage.sandbox.camera();
    camera.elevation = elevation;
    camera.distance = 3.0;
    camera.target = Vector3d(0, 0, s.view->groundHeight() + height) -
                    camera.distance * std::sin(elevation) * Vector3d::UnitZ();
    stage.play("", 1);
    return readPixels(s.picture.framebuffer(), s.viewport().width, s.viewport().height);
  };
  const auto differing = [&](const auto& a, const auto& b, int lines) {  // of the lowest lines of the view
    int count = 0;
    const std::size_t first = a.size() - 4u * s.viewport().width * lines;
    for (std::size_t p = first; p < a.size(); p += 4)
      count += a[p] != b[p] || a[p + 1] != b[p + 1] || a[p + 2] != b[p + 2];
    return count;
  };
  for (const double height : {0.02, 0.1, 0.5})
    EXPECT_GT(differing(rows(height, 0.02, true), rows(height, 0.02, false), 4),
              0.95 * 4 * s.viewport().width)
        << height;
  EXPECT_GT(differing(rows(-0.5, -0.3, true), rows(-0.5, -0.3, false), s.viewport().height), 2000);
}

/// 9: the lattice took the click that was meant for the hand's handle.
TEST(Review, AHandleWinsOverTheLattice) {
  Stage stage("figure");
  const auto limbs = limbsOf(stage.sandbox.session().model());
  MuscleSettings settings = defaultMuscleSettings(limbs);
  settings.enabled = settings.lattice = true;
  settings.shownLimb = "left arm";
  stage.sandbox.session().setMuscles(std::make_shared<const MuscleSettings>(settings));
  stage.play("0 tab Muscles\n", 4);
  ASSERT_NE(stage.sandbox.muscles(), nullptr);
  stage.play("0 move " + at(stage.pixelOf("hand_l")) + "\n", 3);
  stage.play("0 press left\n2 shift-by 6 -12 3\n", 2);
  ASSERT_TRUE(stage.sandbox.session().dragged());
  EXPECT_EQ(stage.sandbox.session().goal(*stage.sandbox.session().dragged()).goal.name, "hand_l");
}

/// 9: the skin beside left the view when zoomed in.
TEST(Review, TheBodyBesideStaysInViewWhenZoomedIn) {
  Stage stage("figure");
  Camera& camera = stage.sandbox.camera();
  camera.target = stage.sandbox.session().reached(*stage.sandbox.session().findGoal("hand_l"));
  camera.distance = 0.8;
  stage.play("", 1);
  const Frames beside = framesBeside(stage.sandbox.session(), stage.sandbox.session().frames(),
                                     0.55 * stage.sandbox.state().size());
  const int hand = stage.sandbox.session().skeleton().jointIndex("hand_l");
  const Vector2d pixel = stage.sandbox.state().toWindow(beside[hand].translation()).pixel;
  const Layout::Rect& view = stage.sandbox.state().layout.view;
  EXPECT_TRUE(view.contains(pixel.x(), pixel.y())) << pixel.transpose();
}

/// 10: a character without a glyph; line breaks within numbers.
TEST(Review, EveryCharacterOfTheSandboxHasAGlyph) {
  Stage stage("planar");
  stage.play("", 1);
  int characters = 0;
  for (const char* folder :
       {"/../apps/sandbox", "/../apps/lecture", "/../solvers/problem/goals", "/../solvers"})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(testing::assetFolder() + folder)) {
      if (entry.path().extension() != ".cpp") continue;
      const std::string text = readFile(entry.path().string());
      std::size_t lineBegin = 0;
      while (lineBegin < text.size()) {
        const std::size_t lineEnd = std::min(text.find('\n', lineBegin), text.size());
        const std::string line = text.substr(lineBegin, lineEnd - lineBegin);
        lineBegin = lineEnd + 1;
        const std::size_t code = line.find_first_not_of(' ');
        if (code == std::string::npos || line.compare(code, 2, "//") == 0) continue;
        const std::string said = line.substr(0, line.find(" // "));
        for (std::size_t i = 0; i < said.size();) {
          const auto byte = static_cast<unsigned char>(said[i]);
          const int length = byte < 0x80 ? 1 : byte < 0xe0 ? 2 : byte < 0xf0 ? 3 : 4;
          unsigned point = length == 1 ? byte : byte & (0xffu >> (length + 1));
          for (int k = 1; k < length; ++k)
            point = point << 6 | (static_cast<unsigned char>(said[i + k]) & 63);
          i += length;
          if (point < 0x80) continue;
          ++characters;
          EXPECT_TRUE(point <= 0xffff && stage.sandbox.state().gui.fonts().regular->FindGlyphNoFallback(
                                             static_cast<ImWchar>(point)))
              << std::hex << point << " in " << entry.path().filename() << ": " << line;
        }
      }
    }
  EXPECT_GT(characters, 100);
}

/// What Dear ImGui breaks by itself it breaks within numbers: after their point.
TEST(Review, NoPanelLeavesItToDearImGuiToBreakLines) {
  int wrapped = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(testing::assetFolder() + "/../apps")) {
    if (entry.path().extension() != ".cpp") continue;
    const std::string text = readFile(entry.path().string());
    wrapped += text.find("wrappedText(") != std::string::npos;
    for (const char* direct : {"TextWrapped", "TextWrapPos", "CalcWordWrap"})
      EXPECT_EQ(text.find(direct), std::string::npos) << entry.path() << " calls " << direct;
  }
  EXPECT_GT(wrapped, 5);
}

/// A path has no blank; it must not run out of the window.
TEST(Review, ALongPathIsBrokenAfterItsSlashes) {
  Stage stage("planar");
  stage.play("", 1);
  ImGui::NewFrame();
  const std::string text = "Saved /home/somebody/a/long/way/through/many/folders/scene_0.75.json at 0.34 s";
  const float room = ImGui::CalcTextSize("/home/somebody/a/long/").x;
  const std::string broken = brokenAtBlanks(text, room);
  ImGui::EndFrame();
  std::string joined;
  for (std::size_t from = 0; from < broken.size();) {
    const std::size_t end = std::min(broken.find('\n', from), broken.size());
    const std::string line = broken.substr(from, end - from);
    EXPECT_LE(ImGui::CalcTextSize(line.c_str()).x, room) << line;
    joined += line + (line.ends_with('/') ? "" : " ");
    from = end + 1;
  }
  EXPECT_EQ(joined, text + " ");
}

TEST(Review, LinesAreBrokenAtBlanksOnly) {
  Stage stage("planar");
  stage.play("", 1);
  const std::string text = "computed 0.34202, -0.93969, 1.2345e-07 at 12.5 mm (3.25, 4.75) and 0.34";
  for (float room = 20; room < 400; room += 7) {
    ImGui::NewFrame();
    const std::string broken = brokenAtBlanks(text, room);
    ImGui::EndFrame();
    std::string joined = broken;
    for (char& c : joined)
      if (c == '\n') c = ' ';
    EXPECT_EQ(joined, text);
  }
}

/// 12, 13: in words, and in the status line by the list's name.
TEST(Review, ATargetOutOfReachIsCalledThat) {
  Stage stage("figure");
  Session& session = stage.sandbox.session();
  const GoalId hand = *session.findGoal("hand_r");
  session.setTarget(hand, session.reached(hand) + Vector3d(-2.0, 0.6, 0.4));
  stage.play("", 300);
  EXPECT_TRUE(describeSolve(session).starts_with("out of reach by ")) << describeSolve(session);
}

/// It said "at rest" while the last micrometres went by, seconds where a frame takes long.
TEST(Review, ATargetOutOfReachIsNeverAtRestAndNothingMore) {
  Stage stage("figure");
  Session& session = stage.sandbox.session();
  const GoalId hand = *session.findGoal("hand_r");
  for (const Vector3d& way : {Vector3d(-2.0, 0.6, 0.4), Vector3d(-0.5, 1.0, 0.4), Vector3d(0.0, 0.0, 2.0)}) {
    session.resetPose();
    session.setTarget(hand, session.reached(hand) + way);
    for (int i = 0; i < 120; ++i) {
      session.step();
      EXPECT_FALSE(describeSolve(session).starts_with("at rest")) << i << ": " << describeSolve(session);
    }
    EXPECT_TRUE(describeSolve(session).starts_with("out of reach by ")) << describeSolve(session);
  }
}

/// 13: status line, list and Lab named one solver in three ways. Lists have the catalogue's titles.
TEST(Review, TheStatusLineNamesASolverAsTheListsDo) {
  Stage stage("planar");
  for (const std::string& name : frameSolverNames()) {
    stage.sandbox.session().setSolver(name);
    EXPECT_TRUE(statusFacts(stage.sandbox).starts_with(std::string(solverEntry(name).title) + " · "))
        << statusFacts(stage.sandbox);
  }
}

/// 6: the click after Esc was swallowed.
TEST(Review, TheFirstClickAfterEscCounts) {
  Stage stage("planar");
  stage.play("0 tab Solve\n", 2);
  const Sandbox::State& s = stage.sandbox.state();
  const Layout::Rect &inspector = s.layout.inspector, &rail = s.layout.rail;
  const auto click = [&](double x, double y) {
    stage.play("0 move " + at({x, y}) + "\n2 press left\n4 release left\n", 2);
  };
  const auto isOpen = [] { return ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup); };
  for (float y = inspector.y; y < inspector.y + inspector.height && !isOpen(); y += 8)
    click(inspector.x + 60, y);  // for the list of solvers
  ASSERT_TRUE(isOpen());
  stage.play("0 key escape\n", 3);
  ASSERT_FALSE(isOpen());
  const float row = s.gui.fonts().small->FontSize + 17 * s.scale;  // of the rail
  click(rail.x + 0.5f * rail.width, rail.y + 8 * s.scale + 1.5f * row);
  EXPECT_EQ(s.inspectorTab, "Model");
}

/// Tab in the inspector that was clicked turned a slider into a field of text, and no key did anything any
/// more.
TEST(Review, TabIsTheNextSolverWhereverWasClickedBefore) {
  Stage stage("planar");
  stage.play("0 tab Solve\n", 2);
  const Sandbox::State& s = stage.sandbox.state();
  const Layout::Rect& inspector = s.layout.inspector;
  stage.play("0 move " + at({inspector.x + 20.0, inspector.y + inspector.height - 20.0}) +
                 "\n2 press left\n4 release left\n",
             2);
  const std::string first = s.session->solver();
  stage.play("0 key tab\n", 3);
  const std::string second = s.session->solver();
  stage.play("0 key tab\n", 3);
  EXPECT_NE(second, first);
  EXPECT_NE(s.session->solver(), second);
  EXPECT_TRUE(stage.sandbox.keys() == Keys::Commands);
}

/// 8: the message of endings left out .json, which scenes have.
TEST(Review, WhatDoesNotOpenIsToldWithEveryEndingThatDoes) {
  Stage stage("planar");
  EXPECT_FALSE(stage.sandbox.open("myscene"));
  const std::string said = stage.sandbox.state().notices.back().words;
  EXPECT_NE(said.find(".json"), std::string::npos) << said;
  EXPECT_NE(said.find(knownExtensions()), std::string::npos) << said;
}

/// A robot's file may have a frame at its base and no shapes: that frame was a handle, the first, about which
/// all pictures stood, and the body was of clay.
TEST(Review, ARobotWithoutShapesIsOfMetalAndItsBaseIsNoHandle) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("arm" + std::to_string(getpid()) + ".urdf");
  writeFile(
      file.string(),
      R"(<robot name="arm"><link name="world"/><link name="base"/><link name="a"/><link name="b"/><link name="c"/>
<joint name="base_frame" type="fixed"><parent link="world"/><child link="base"/></joint>
<joint name="j1" type="continuous"><parent link="world"/><child link="a"/><axis xyz="0 0 1"/></joint>
<joint name="j2" type="continuous"><parent link="a"/><child link="b"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint>
<joint name="tip" type="fixed"><parent link="b"/><child link="c"/><origin xyz="1 0 0"/></joint></robot>)");
  Stage stage(file.string());
  std::filesystem::remove(file);
  const Session& session = stage.sandbox.session();
  EXPECT_TRUE(session.findGoal("tip"));
  EXPECT_FALSE(session.findGoal("base_frame"));
  ASSERT_TRUE(session.model().skin);
  EXPECT_TRUE(session.model().look);
}

TEST(Review, AFileOfAnotherKindIsToldWhatOpens) {
  Stage stage("planar");
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("notes" + std::to_string(getpid()) + ".md");
  writeFile(file.string(), "# Notes");
  EXPECT_FALSE(stage.sandbox.open(file.string()));
  std::filesystem::remove(file);
  const std::string said = stage.sandbox.state().notices.back().words;
  for (const char* ending : {".json", ".stl", ".glb"})
    EXPECT_NE(said.find(ending), std::string::npos) << said;
}

/// 14: dragging a hand lifted the whole body, though "Pinned feet" is ticked.
TEST(Review, TheLegExamplesStandingFootStaysWhileAHandIsDragged) {
  Stage stage("lecture:leg");
  stage.play("", 3);
  Session& session = stage.sandbox.session();
  stage.sandbox.setPlaying(false);
  const Vector3d left = session.reached(*session.findGoal("foot_l")),
                 right = session.reached(*session.findGoal("foot_r"));
  stage.play("0 drag hand_r -10 -60 20\n", 30);
  const double movedLeft = (session.reached(*session.findGoal("foot_l")) - left).norm(),
               movedRight = (session.reached(*session.findGoal("foot_r")) - right).norm();
  EXPECT_LT(std::min(movedLeft, movedRight), 1e-3) << movedLeft << " " << movedRight;
}

/// 15: Alt + drag moves the window under many window managers; T turns as well.
TEST(Review, TTurnsTheGoalThatIsDragged) {
  Stage stage("panda");
  const std::string tool = stage.sandbox.session().goals().front().goal.name;
  stage.play("0 grab " + tool + "\n2 keydown t\n3 shift-by 30 0 4\n9 keyup t\n", 3);
  ASSERT_TRUE(stage.sandbox.session().dragged());
  EXPECT_EQ(stage.sandbox.session().goal(*stage.sandbox.session().dragged()).goal.kind, GoalKind::Pose);
}

/// 16: an AMC that was dropped asked for its ASF, which lay beside it.
TEST(Review, AMotionThatIsDroppedFindsItsSkeletonBesideIt) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("gelenk_review_" + std::to_string(getpid()));
  fs::create_directories(folder);
  Imported motion = importFiles(testing::inputFolder() + "/forearm.bvh");
  exportFile((folder / "walk.asf").string(), motion);
  exportFile((folder / "walk.amc").string(), motion);
  const int joints = importFiles((folder / "walk.asf").string()).model.skeleton.jointCount();
  {
    Stage stage("figure");
    stage.play("0 drop " + (folder / "walk.amc").string() + "\n", 3);
    EXPECT_EQ(stage.sandbox.session().skeleton().jointCount(), joints);
    EXPECT_TRUE(stage.sandbox.session().model().clip);
  }
  {  // another one takes the place of one that was opened with its ASF; it was left aside without a word
    MotionClip& clip = *motion.model.clip;
    const Eigen::MatrixXd first = clip.q.leftCols(1);
    clip.q = first.replicate(1, 5);
    exportFile((folder / "stand.amc").string(), motion);
    Stage stage("figure");
    ASSERT_TRUE(stage.sandbox.open(
        {.nameOrFile = (folder / "walk.amc").string(), .files = {.asf = (folder / "walk.asf").string()}}));
    ASSERT_NE(stage.sandbox.session().model().clip->frameCount(), 5);
    stage.play("0 drop " + (folder / "stand.amc").string() + "\n", 3);
    EXPECT_EQ(stage.sandbox.session().model().clip->frameCount(), 5);
  }
  fs::remove(folder / "walk.asf");  // and alone it says what is missing, and what opens it
  Stage stage("figure");
  stage.play("0 drop " + (folder / "walk.amc").string() + "\n", 3);
  ASSERT_FALSE(stage.sandbox.state().notices.empty());
  EXPECT_NE(stage.sandbox.state().notices.back().words.find("open the .asf first"), std::string::npos)
      << stage.sandbox.state().notices.back().words;
  EXPECT_EQ(stage.sandbox.session().model().name, "figure");
  fs::remove_all(folder);
}

/// 2: of a body that opens with a limb far above its head, the limb was out of the view.
TEST(Review, AMotionsFirstPoseIsInViewWhenItOpens) {
  const std::string file = (std::filesystem::temp_directory_path() / "reaching_up.bvh").string();
  writeFile(
      file,
      "HIERARCHY\nROOT hip\n{\nOFFSET 0 1 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation "
      "Yrotation\n"
      "JOINT leg\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 -1 "
      "0\n}\n}\n"
      "JOINT arm\n{\nOFFSET 0 0.2 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 2 0 "
      "0\n}\n}\n}\n"
      "MOTION\nFrames: 1\nFrame Time: 0.04\n0 1 0 0 0 0 0 0 0 90 0 0\n");
  Stage stage(file);
  Sandbox::State& s = stage.sandbox.state();
  stage.play("", 1);
  double highest = 0.0;
  for (const Eigen::Isometry3d& frame : stage.sandbox.shownFrames()) {
    highest = std::max(highest, frame.translation().y());
    const Vector2d pixel = s.toWindow(frame.translation()).pixel;
    EXPECT_TRUE(s.layout.view.contains(pixel.x(), pixel.y())) << pixel.transpose();
  }
  EXPECT_NEAR(highest, 3.2, 0.01);
}

/// 9: edges were stepped. Where a person watches, what stands still is drawn once more, smooth; it stays
/// while the mouse moves over nothing, and a drag has the quick picture again.
TEST(Review, WhatStandsStillIsDrawnSmooth) {
  Stage stage("figure");
  Sandbox::State& s = stage.sandbox.state();
  const auto view = [&] {
    return readPixels(s.picture.framebuffer(), s.viewport().width, s.viewport().height);
  };
  stage.play("0 move 30 60\n", 8);
  const auto quick = view();
  s.options.refines = true;
  stage.play("", 8);
  EXPECT_TRUE(s.drawnFine);
  const auto smooth = view();
  EXPECT_NE(smooth, quick);
  stage.play("0 move 40 70\n1 move 45 70\n", 1);
  EXPECT_EQ(view(), smooth);
  stage.play("0 grab hand_r\n2 shift-by -20 -40 6\n", 1);
  EXPECT_FALSE(s.drawnFine);
  stage.play("0 release left\n1 key r\n", 20);
  EXPECT_TRUE(s.drawnFine);
}

/// Led far out of reach and back the same way, an arm ends where it began, and never jumps on the way.
TEST(Review, ADragOutOfReachAndBackNeverJumps) {
  for (const auto& [model, goal] : {std::pair{"figure", "hand_r"}, {"panda", "tool"}, {"ur5", "tool"}}) {
    Stage stage(model);
    const Skeleton& skeleton = stage.sandbox.session().skeleton();
    ViewOptions& show = stage.sandbox.state().show();
    show.skin = show.shadow = show.ground = false;  // the picture does not matter here
    stage.play("", 1);
    const Eigen::VectorXd start = stage.sandbox.session().q();
    stage.play(std::string("0 grab ") + goal + "\n", 2);
    Eigen::VectorXd before = stage.sandbox.session().q();
    double largest = 0.0, farthest = 0.0;
    for (int i = 0; i < 90; ++i) {
      const int way = i < 20 ? -18 : i >= 30 && i < 50 ? 18 : 0;
      stage.play("0 shift-by " + std::to_string(way) + " " + std::to_string(way / 4) + " 1\n", 0);
      const Eigen::VectorXd& now = stage.sandbox.session().q();
      largest = std::max(largest, difference(skeleton, before, now).lpNorm<Eigen::Infinity>());
      farthest = std::max(farthest, stage.sandbox.session().lastSolve().error);
      before = now;
    }
    EXPECT_GT(farthest, 0.05) << model;  // it was out of reach
    EXPECT_LT(largest, 0.4) << model;    // radians in a frame; another branch of the arm lies 1 and more away
    EXPECT_LT(difference(skeleton, start, before).lpNorm<Eigen::Infinity>(), 0.05) << model;
  }
}

}  // namespace
}  // namespace gelenk
