// The frame around the picture: palette, browser, gizmo, splitters, unsaved changes, presentation, films.
#include <GLFW/glfw3.h>
#include <gtest/gtest.h>
#include <imgui_internal.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "apps/lecture/example.h"
#include "apps/sandbox/gizmo.h"
#include "apps/sandbox/key_help.h"
#include "apps/sandbox/palette.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/io/text_file.h"
#include "kinematics/notation/mannequin.h"
#include "tests/places.h"
#include "tests/sandbox/program.h"
#include "tests/sandbox/stage.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
namespace fs = std::filesystem;

struct Stage : testing::Stage {
  fs::path folder = folderOfRun();

  explicit Stage(const std::string& model, bool asks = false, int wide = 1000, int high = 700)
      : testing::Stage({.model = model,
                        .width = wide,
                        .height = high,
                        .preferences = (folderOfRun() / "preferences.json").string(),
                        .asks = asks}) {
    fs::create_directories(folder);
  }
  ~Stage() { fs::remove_all(folder); }
  static fs::path folderOfRun() {
    return fs::temp_directory_path() / ("gelenk_shell_" + std::to_string(getpid()));
  }
  Sandbox::State& state() { return sandbox.state(); }
};

std::string at(const Vector2d& pixel) { return std::to_string(pixel.x()) + " " + std::to_string(pixel.y()); }

TEST(CommandPalette, FindsEveryModelSolverExampleTabAndThingToShow) {
  Stage stage("planar");
  const std::vector<Action> actions = actionsOf(stage.sandbox);
  const auto finds = [&](const std::string& query) {
    return std::ranges::any_of(actions, [&](const Action& action) { return matches(query, action.name); });
  };
  for (const std::string& name : builtInModels()) EXPECT_TRUE(finds("open " + name)) << name;
  for (const std::string& name : frameSolverNames()) EXPECT_TRUE(finds("solver " + name)) << name;
  for (const LectureTopic& topic : lectureTopics())
    EXPECT_TRUE(finds("lecture " + topic.title)) << topic.title;
  for (const auto& panel : stage.state().panels)
    EXPECT_EQ(finds("tab " + panel->name()), panel->hasInspector()) << panel->name();
  for (std::string word :
       {"next solver", "frame the selection", "ground", "convergence map", "reachable set", "all solutions",
        "self-motion", "velocity ellipsoid", "undo", "mirror", "screenshot", "compare"})
    EXPECT_TRUE(finds(word)) << word;
  EXPECT_FALSE(finds("no such thing"));
}

/// A letter, a digit or F5 in a text, as a word of its own.
bool names(const std::string& text, const std::string& key) {
  return std::regex_search(text, std::regex("(^|[^A-Za-z0-9])" + key + "([^A-Za-z0-9]|$)"));
}

/// The keys that the sources ask for, against the help window and docs/sandbox.md.
TEST(KeyHelp, NamesEveryKeyOfTheSourcesAndTheManualNamesThemToo) {
  const fs::path root = fs::path(testing::assetFolder()).parent_path();
  std::string help;
  for (const KeyHelp& row : keyHelp) help += std::string(row.keys) + " " + row.what + "\n";
  std::string manual = readFile((root / "docs/sandbox.md").string());
  manual = manual.substr(manual.find("## Mouse and keys"));
  manual = manual.substr(0, manual.find("## Solvers"));
  std::set<std::string> keys;
  for (const fs::directory_entry& file : fs::directory_iterator(root / "apps/sandbox")) {
    const std::string name = file.path().filename().string();
    if (name != "viewport.cpp" && !name.ends_with("_panel.cpp")) continue;
    const std::string text = readFile(file.path().string());
    const std::regex pattern("GLFW_KEY_([A-Z]|[0-9]|F[0-9]+)\\b");
    for (std::sregex_iterator it(text.begin(), text.end(), pattern), end; it != end; ++it)
      keys.insert((*it)[1]);
  }
  EXPECT_GT(keys.size(), 20u);
  for (const std::string& key : keys) {
    EXPECT_TRUE(names(help, key)) << key;
    EXPECT_TRUE(names(manual, key)) << key;
  }
  Stage stage("planar");
  for (const Action& action : actionsOf(stage.sandbox)) {
    const std::string key = action.key.substr(action.key.rfind('+') + 1);  // Ctrl+Shift+Z
    EXPECT_TRUE(key.empty() || names(help, key)) << action.key;
  }
}

TEST(CommandPalette, AFewLettersAndEnterOpenARobot) {
  Stage stage("planar");
  stage.play("0 keydown ctrl\n1 key k\n3 keyup ctrl\n5 text robot scara\n8 key enter\n", 4);
  EXPECT_EQ(stage.sandbox.session().model().name, "scara");
  EXPECT_FALSE(stage.state().palette.isOpen());
}

void tap(InputQueue& queue, int key, int character = 0) {
  queue.add({.kind = InputEvent::Kind::Key, .code = key, .down = true});
  if (character > 0) queue.add({.kind = InputEvent::Kind::Character, .code = character});
  queue.add({.kind = InputEvent::Kind::Key, .code = key, .down = false});
}

void type(InputQueue& queue, std::string_view word) {
  for (const char c : word) tap(queue, c == ' ' ? GLFW_KEY_SPACE : std::isdigit(c) ? c : std::toupper(c), c);
}

/// As a window of 3 frames a second gets it: all keys of a second at once, one of them a correction.
TEST(CommandPalette, WhatWasTypedWhileAFrameTookLongArrivesAtOnce) {
  Stage stage("planar");
  stage.play("0 keydown ctrl\n1 key k\n3 keyup ctrl\n", 4);
  type(stage.queue, "robot scarr");
  tap(stage.queue, GLFW_KEY_BACKSPACE);
  type(stage.queue, "a");
  tap(stage.queue, GLFW_KEY_ENTER);
  int frames = 0;
  for (; stage.sandbox.session().model().name != "scara" && frames < 60; ++frames) stage.frame();
  EXPECT_EQ(stage.sandbox.session().model().name, "scara");
  EXPECT_LE(frames, 6);  // eleven characters, Backspace, a character, Enter, and the model opens; 15 before
}

/// The first letter was lost where the field that the shortcut opens was not ready yet.
TEST(CommandPalette, EveryLetterThatFollowsTheShortcutAtOnceIsWritten) {
  for (const auto& [shortcut, words] : {std::pair{GLFW_KEY_K, "q"}, {GLFW_KEY_O, "ur5"}}) {
    Stage stage("planar");
    stage.queue.add({.kind = InputEvent::Kind::Key, .code = GLFW_KEY_LEFT_CONTROL, .down = true});
    tap(stage.queue, shortcut);
    stage.queue.add({.kind = InputEvent::Kind::Key, .code = GLFW_KEY_LEFT_CONTROL, .down = false});
    type(stage.queue, words);
    tap(stage.queue, GLFW_KEY_ENTER);
    for (int i = 0; i < 14; ++i) stage.frame();
    if (shortcut == GLFW_KEY_K)
      EXPECT_TRUE(stage.sandbox.wantsToClose());  // Quit, the first of them with a q
    else
      EXPECT_EQ(stage.sandbox.session().model().name, words);
  }
}

TEST(FileBrowser, ListsFoldersFirstAndOnlyWhatOpens) {
  Stage stage("planar");
  fs::create_directories(stage.folder / "Bodies");
  fs::create_directories(stage.folder / ".hidden");
  for (const char* name : {"b.OBJ", "a.json", "readme.md", "walk.bvh"})
    writeFile((stage.folder / name).string(), "");
  const auto names = [&](const std::string& endings) {
    std::string all;
    for (const BrowserEntry& entry : folderEntries(stage.folder.string(), endings))
      all += (all.empty() ? "" : " ") + entry.name + (entry.isFolder ? "/" : "");
    return all;
  };
  EXPECT_EQ(names(""), "Bodies/ a.json b.OBJ walk.bvh");
  EXPECT_EQ(names(".bvh"), "Bodies/ walk.bvh");
  EXPECT_TRUE(folderEntries((stage.folder / "missing").string(), "").empty());
}

/// Home and Here stood there twice, both chosen, where the program runs at home.
TEST(FileBrowser, NoFolderIsOfferedTwice) {
  Stage stage("planar");
  const char* before = std::getenv("HOME");
  const std::string kept = before ? before : "", here = fs::current_path().string();
  const auto placesWithHome = [&](const std::string& folder) {
    setenv("HOME", folder.c_str(), 1);
    std::string names;
    for (const BrowserPlace& place : browserPlaces()) names += place.name + " ";
    return names;
  };
  EXPECT_EQ(placesWithHome(here), "Home ");
  EXPECT_EQ(placesWithHome(here + "/."), "Home ");
  EXPECT_EQ(placesWithHome(stage.folder.string()), "Home Here ");
  before ? setenv("HOME", kept.c_str(), 1) : unsetenv("HOME");
}

TEST(FileBrowser, AnEmptyListSaysWhy) {
  Stage stage("planar");
  FileBrowser browser;
  browser.begin(FileBrowser::Purpose::Open, stage.folder.string(), "");
  EXPECT_EQ(browser.whyEmpty(), "Nothing here that opens.");
  browser.begin(FileBrowser::Purpose::Save, stage.folder.string(), "scene.json");
  EXPECT_EQ(browser.whyEmpty(), "No scenes and no folders here yet.");
  writeFile((stage.folder / "a.json").string(), "");
  browser.begin(FileBrowser::Purpose::Save, stage.folder.string(), "scene.json");
  EXPECT_EQ(browser.whyEmpty(), "");
}

TEST(Preferences, RecentFilesAndSizesAreRememberedAndDamageIsNothing) {
  Stage stage("planar");
  const std::string scene = (stage.folder / "scene.json").string();
  stage.play("", 2);
  ASSERT_TRUE(stage.sandbox.saveSceneTo(scene));
  stage.state().preferences.inspector = 400;
  stage.play("", 2);
  const Preferences read = readPreferences((stage.folder / "preferences.json").string());
  EXPECT_EQ(read.inspector, 400);
  ASSERT_EQ(read.recent.size(), 1u);
  EXPECT_EQ(fs::path(read.recent[0]).filename(), "scene.json");
  writeFile((stage.folder / "preferences.json").string(), "{\"recent\": 3");
  EXPECT_EQ(readPreferences((stage.folder / "preferences.json").string()), Preferences{});
}

TEST(Preferences, AFileOfTheCommandLineIsAmongTheRecentOnes) {
  const std::string scene = Stage::folderOfRun().string() + "_named.json";
  {
    Stage stage("planar");
    ASSERT_TRUE(stage.sandbox.saveSceneTo(scene));
  }
  {
    Stage stage(scene);
    ASSERT_EQ(stage.state().preferences.recent.size(), 1u);
    EXPECT_EQ(stage.state().preferences.recent[0], scene);
  }
  fs::remove(scene);
}

/// The tooltip that stands while the mouse goes down from the first place until there is one.
const ImGuiWindow* tooltipBelow(Stage& stage, double x, double y) {
  for (double down = 0; down < 200; down += 8) {
    stage.play("0 move " + at({x, y + down}) + "\n", 3);
    for (const ImGuiWindow* window : ImGui::GetCurrentContext()->Windows)
      if (window->Active && (window->Flags & ImGuiWindowFlags_Tooltip)) return window;
  }
  return nullptr;
}

/// It covered the control below; in a small window the words were wider than the view, and lay on the panel's
/// next control.
TEST(Tooltips, StandBesideThePanelThatTheyTellOf) {
  for (const auto& [width, height] : {std::pair{1280, 800}, {700, 500}}) {
    Stage stage("panda", false, width, height);
    stage.play("0 tab Pictures\n", 3);
    const Layout::Rect& inspector = stage.state().layout.inspector;
    const ImGuiWindow* tip = tooltipBelow(stage, inspector.x + 60, inspector.y + 20);
    ASSERT_TRUE(tip) << width;
    EXPECT_LE(tip->Pos.x + tip->Size.x, inspector.x) << width;
    EXPECT_GE(tip->Pos.x, 0.0f) << width;
  }
}

/// They covered the plot that they explain, or its neighbour, and reached over the inspector.
TEST(Tooltips, OfThePlotsStandAboveThem) {
  Stage stage("figure");
  stage.play("", 3);
  const Layout::Rect& strip = stage.state().layout.strip;
  for (const double share : {0.1, 0.5, 0.95}) {
    const ImGuiWindow* tip = tooltipBelow(stage, strip.x + share * strip.width, strip.y + 60);
    ASSERT_TRUE(tip) << share;
    EXPECT_LE(tip->Pos.y + tip->Size.y, strip.y) << share;
    EXPECT_LE(tip->Pos.x + tip->Size.x, strip.x + strip.width) << share;
  }
}

/// They were as pale as the button.
TEST(Tooltips, AreAsPlainOverWhatIsDisabled) {
  Stage stage("planar");
  stage.play("", 1);
  ImGui::NewFrame();
  ImGui::Begin("alone");
  ImGui::BeginDisabled();
  showTooltip("words");
  ImGui::EndDisabled();
  ImGui::End();
  ImGui::Render();
  int vertices = 0;
  for (const ImGuiWindow* window : ImGui::GetCurrentContext()->Windows) {
    if (!window->Active || !(window->Flags & ImGuiWindowFlags_Tooltip)) continue;
    const ImVector<ImDrawVert>& drawn = window->DrawList->VtxBuffer;
    for (int v = drawn.Size - 4 * 5; v < drawn.Size; ++v, ++vertices)  // the five letters, drawn last
      EXPECT_EQ(drawn[v].col >> IM_COL32_A_SHIFT, 255u);
  }
  EXPECT_EQ(vertices, 20);
}

/// One was printed over the other.
TEST(Tooltips, AreOneAFrame) {
  Stage stage("planar");
  stage.play("", 1);
  const auto vertices = [&](int tips) {
    ImGui::NewFrame();
    ImGui::Begin("alone");
    for (int i = 0; i < tips; ++i) showTooltip("words");
    ImGui::End();
    ImGui::Render();
    int count = 0;
    for (const ImGuiWindow* window : ImGui::GetCurrentContext()->Windows)
      if (window->Active && (window->Flags & ImGuiWindowFlags_Tooltip))
        count += window->DrawList->VtxBuffer.Size;
    return count;
  };
  vertices(1);  // its first frame is hidden
  const int one = vertices(1);
  EXPECT_GT(one, 0);
  EXPECT_EQ(vertices(2), one);
}

/// Half of it lay outside.
TEST(Pictures, TheReachableSetIsInViewOnceItIsShown) {
  Stage stage("panda");
  stage.play("", 2);
  for (const Action& action : actionsOf(stage.sandbox))
    if (matches("show reachable", action.name)) action.run(stage.sandbox);
  ASSERT_TRUE(stage.sandbox.options().reachable);
  stage.play("", 30);
  const auto box = stage.state().view->teaching().reachableBox(stage.sandbox.session(), std::nullopt);
  ASSERT_GT(box.sizes().minCoeff(), 1.0);  // metres
  for (int corner = 0; corner < 8; ++corner) {
    const Projected p = project(stage.sandbox.camera(), stage.state().viewport(),
                                box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
    EXPECT_GT(p.pixel.x(), 0);
    EXPECT_LT(p.pixel.x(), stage.state().viewport().width);
    EXPECT_GT(p.pixel.y(), 0);
    EXPECT_LT(p.pixel.y(), stage.state().viewport().height);
  }
}

TEST(Splitters, TheInspectorsEdgeIsDragged) {
  Stage stage("planar");
  stage.play("", 2);
  const Layout before = stage.state().layout;
  const double x = before.inspector.x, y = before.inspector.y + 0.5 * before.inspector.height;
  stage.play("0 move " + at({x, y}) + "\n2 press left\n3 shift-by -60 0 4\n8 release left\n", 3);
  EXPECT_NEAR(stage.state().layout.inspector.x, before.inspector.x - 60, 3);
  EXPECT_NEAR(stage.state().layout.view.width, before.view.width - 60, 3);
}

/// A window at rest sees the way to the edge and the press in one frame; the edge jumped by that way.
TEST(Splitters, AnEdgeThatIsPressedStaysWhereItIs) {
  Stage stage("planar");
  stage.play("0 move 900 100\n", 2);
  const Layout before = stage.state().layout;
  const double x = 0.3 * before.strip.width, y = before.strip.y;
  stage.play("0 move " + at({x, y}) + "\n0 press left\n2 shift-by 0 -40 4\n8 release left\n", 3);
  EXPECT_NEAR(stage.state().layout.strip.height, before.strip.height + 40, 3);
}

TEST(Layout, EveryTabIsInSightAtEveryWidthAndTheStripGrows) {
  Stage stage("planar");
  for (const auto& [width, height] : {std::pair{640, 480}, {1280, 800}, {1920, 1080}, {2560, 1600}}) {
    const Layout layout = layOut(stage.state(), width, height);
    EXPECT_GT(layout.view.width, 0.38 * width);
    EXPECT_LE(layout.inspector.x + layout.inspector.width, layout.rail.x + 1);
    EXPECT_LE(layout.rail.x + layout.rail.width, width);
  }
  EXPECT_GT(layOut(stage.state(), 1920, 1080).strip.height,
            layOut(stage.state(), 1280, 800).strip.height + 20);
}

/// Labels, rulers and handles of a presentation grow with its type, and its handles are taken where they are
/// drawn; a narrow window gives its words more than half.
TEST(Layout, APresentationIsToBeReadFromTheLastRow) {
  Stage stage("planar");
  ASSERT_TRUE(stage.sandbox.open("lecture:two-link"));
  stage.play("", 2);
  EXPECT_EQ(stage.state().viewScale(), 1.0f);
  const Vector2d beside =
      stage.state()
          .toWindow(stage.sandbox.session().reached(*stage.sandbox.session().findGoal("end-effector")))
          .pixel;
  EXPECT_FALSE(handleAt(stage.state(), beside + Vector2d(0, 14)));
  stage.state().presenting = true;
  stage.height = 1080;
  stage.width = 1920;
  stage.target.resize(1920, 1080);
  stage.play("", 3);
  EXPECT_FLOAT_EQ(stage.state().viewScale(), 1080.0f / 30.0f / 20.0f);
  const Vector2d now =
      stage.state()
          .toWindow(stage.sandbox.session().reached(*stage.sandbox.session().findGoal("end-effector")))
          .pixel;
  EXPECT_TRUE(handleAt(stage.state(), now + Vector2d(0, 14)));
  EXPECT_EQ(layOut(stage.state(), 1920, 1080).inspector.width, 960);
  const Layout narrow = layOut(stage.state(), 1280, 800);
  EXPECT_GT(narrow.inspector.width, 690);
  EXPECT_EQ(narrow.view.width + narrow.inspector.width, 1280);
}

/// What stands beside the tabs takes no line, with an example open or none.
TEST(Layout, EveryTabOfTheStripBeginsAtTheSameHeight) {
  std::set<float> heights;
  for (const char* model : {"lecture:newton-1d", "planar"}) {
    Stage stage(model);
    for (const auto& panel : stage.state().panels) {
      if (!panel->hasBottomStrip()) continue;
      stage.sandbox.showBottomStrip(panel->name());
      stage.play("", 2);
      const std::string name = "##strip/" + panel->name();
      for (const ImGuiWindow* window : ImGui::GetCurrentContext()->Windows)
        if (std::string_view(window->Name).starts_with(name) &&
            std::string_view(window->Name).find('/', name.size()) == std::string_view::npos)
          heights.insert(window->Pos.y);
    }
  }
  EXPECT_EQ(heights.size(), 1u);
}

/// Motion, Path, Lab and Lecture stood twice in one window; replays and the palette know the strip's tabs.
TEST(Layout, NoTwoTabsOfTheWindowHaveOneTitle) {
  Stage stage("planar");
  std::set<std::string> titles;
  int tabs = 0;
  for (const auto& panel : stage.state().panels) {
    if (panel->hasInspector()) ++tabs, titles.insert(panel->name());
    if (panel->hasBottomStrip()) ++tabs, titles.insert(panel->stripTitle());
  }
  EXPECT_EQ(titles.size(), static_cast<std::size_t>(tabs));
  const std::vector<Action> actions = actionsOf(stage.sandbox);
  for (const auto& panel : stage.state().panels) {
    stage.play("0 tab " + panel->name() + "\n", 2);
    EXPECT_TRUE(stage.state().inspectorTab == panel->name() || stage.state().stripTab == panel->name() ||
                panel->name() == "Rig")
        << panel->name();  // the Rig panel is there for bodies that were rigged here
    if (!panel->hasBottomStrip()) continue;
    const auto action = std::ranges::find(actions, "Strip " + panel->stripTitle(), &Action::name);
    ASSERT_NE(action, actions.end()) << panel->stripTitle();
    action->run(stage.sandbox);
    stage.play("", 1);
    EXPECT_EQ(stage.state().stripTab, panel->name());
  }
}

/// "Drag a handle" stood there while joints of a rig were moved, weights painted, paths drawn.
TEST(StatusLine, SaysWhatTheMouseDoesInTheToolThatHasIt) {
  Stage stage("figure");
  const auto says = [&](const char* words) {
    EXPECT_NE(mouseHint(stage.sandbox).find(words), std::string::npos) << mouseHint(stage.sandbox);
  };
  stage.play("0 move 20 60\n", 2);
  says("Drag a handle");
  stage.play("0 tab Binding\n3 key b\n", 3);
  says("Paint");
  stage.play("0 key v\n", 3);
  says("Draw around");
  stage.play("0 key escape\n", 3);
  says("Drag a handle");
  stage.play("0 open panda\n1 tab Path\n3 do Path draw on\n", 3);
  says("Draw a line");
  stage.play("0 tab Solve\n", 3);
  says("Drag a handle");
}

/// Save as wrote over any file at once.
TEST(FileBrowser, AnotherFileIsReplacedOnlyWhenAskedTwice) {
  Stage stage("planar");
  stage.play("", 2);
  const fs::path other = stage.folder / "other.json", own = stage.folder / "own.json";
  writeFile(other.string(), "kept");
  ASSERT_TRUE(stage.sandbox.saveSceneTo(own.string()));
  const auto saveAs = [&](const std::string& name) {
    stage.sandbox.state().dialog = Sandbox::State::Dialog::SaveScene;
    stage.play("", 3);
    stage.play("0 keydown ctrl\n0 key a\n0 keyup ctrl\n3 text " + name + "\n6 key enter\n", 4);
  };
  saveAs("own");  // the scene itself
  EXPECT_EQ(stage.state().dialog, Sandbox::State::Dialog::None);
  saveAs("other");
  EXPECT_EQ(stage.state().dialog, Sandbox::State::Dialog::SaveScene);
  EXPECT_EQ(readFile(other.string()), "kept");
  stage.play("0 key escape\n", 3);
  EXPECT_EQ(readFile(other.string()), "kept");
  saveAs("other");
  stage.play("0 key enter\n", 4);
  EXPECT_EQ(stage.state().dialog, Sandbox::State::Dialog::None);
  EXPECT_NE(readFile(other.string()), "kept");
}

TEST(Unsaved, ChangesAreAskedAboutBeforeTheyAreLost) {
  Stage stage("figure", true);
  stage.play("", 2);
  stage.sandbox.requestOpen("planar");  // nothing was changed
  EXPECT_EQ(stage.sandbox.session().model().name, "planar");
  stage.sandbox.requestOpen("panda");
  EXPECT_EQ(stage.sandbox.session().model().name, "panda");
  const std::string tool = stage.sandbox.session().goals().front().goal.name;
  stage.play("0 drag " + tool + " 20 -20 6\n", 8);
  stage.sandbox.requestOpen("planar");
  stage.play("", 3);
  EXPECT_EQ(stage.sandbox.session().model().name, "panda");
  EXPECT_EQ(stage.state().dialog, Sandbox::State::Dialog::Unsaved);
  stage.play("0 key escape\n", 3);
  EXPECT_EQ(stage.state().dialog, Sandbox::State::Dialog::None);
  EXPECT_EQ(stage.sandbox.session().model().name, "panda");
  stage.sandbox.requestClose();
  EXPECT_FALSE(stage.sandbox.wantsToClose());
  stage.play("0 key escape\n", 3);
  ASSERT_TRUE(stage.sandbox.saveSceneTo((stage.folder / "s.json").string()));
  stage.sandbox.requestClose();
  EXPECT_TRUE(stage.sandbox.wantsToClose());
  stage.play("0 drag " + tool + " -20 20 6\n", 8);
  const std::string before = readFile((stage.folder / "s.json").string());
  stage.sandbox.requestOpen("planar");
  stage.play("", 3);
  EXPECT_EQ(stage.state().dialog, Sandbox::State::Dialog::Unsaved);
  stage.play("0 key enter\n", 3);  // saves, and goes on
  EXPECT_EQ(stage.state().dialog, Sandbox::State::Dialog::None);
  EXPECT_NE(readFile((stage.folder / "s.json").string()), before);
  EXPECT_EQ(stage.sandbox.session().model().name, "planar");
}

TEST(Gizmo, AnArrowMovesAlongItsAxisAndARingTurnsAboutIt) {
  Stage stage("panda");
  stage.play("", 2);
  Session& session = stage.sandbox.session();
  const GoalId tool = session.goals().front().id;
  stage.play("0 drag " + session.goals().front().goal.name + " 4 -4 4\n", 20);
  const auto place = gizmoOf(stage.state());
  ASSERT_TRUE(place);
  const Vector3d before = session.goal(tool).goal.target;
  const Vector2d along = stage.state().toWindow(place->at + 0.8 * place->size * Vector3d::UnitZ()).pixel;
  stage.play("0 move " + at(along) + "\n1 press left\n3 shift-by 10 -30 6\n12 release left\n", 20);
  const Vector3d moved = session.goal(tool).goal.target - before;
  EXPECT_GT(moved.z(), 0.01);
  EXPECT_LT(moved.head<2>().norm(), 1e-9);

  // A point of the ring about z that no arrow and no other ring comes near.
  const auto now = gizmoOf(stage.state());
  ASSERT_TRUE(now);
  std::optional<Vector2d> grip;
  for (int i = 0; i < 64 && !grip; ++i) {
    const double t = 2.0 * M_PI * i / 64;
    const Vector2d p =
        stage.state().toWindow(now->at + 0.72 * now->size * Vector3d(std::cos(t), std::sin(t), 0.0)).pixel;
    if (gizmoPartAt(stage.state(), *now, p) == GizmoPart{GizmoPart::Kind::Ring, 2}) grip = p;
  }
  ASSERT_TRUE(grip);
  const Eigen::Matrix3d R = session.frames()[session.goal(tool).goal.joint].linear();
  stage.play("0 move " + at(*grip) + "\n1 press left\n3 shift-by 25 4 6\n", 4);
  ASSERT_TRUE(session.dragged());
  const Eigen::AngleAxisd turned(session.goal(tool).goal.orientation * Eigen::Quaterniond(R).conjugate());
  EXPECT_GT(turned.angle(), 0.05);
  EXPECT_GT(std::abs(turned.axis().z()), 0.999);
  stage.play("0 release left\n", 2);
}

/// The pose was mirrored and the goal went to the other hand, the selection stayed with the hand that was let
/// go.
TEST(Gizmo, GoesToTheOtherSideWithAGoalThatIsMirrored) {
  Stage stage("figure");
  stage.play("0 drag hand_l 40 -60 4\n", 20);
  const Session& session = stage.sandbox.session();
  ASSERT_EQ(stage.state().goalSelected(), session.findGoal("hand_l"));
  stage.play("0 key m\n", 3);
  EXPECT_EQ(session.goal(*session.findGoal("hand_r")).state, GoalState::Held);
  EXPECT_EQ(stage.state().goalSelected(), session.findGoal("hand_r"));
  EXPECT_EQ(stage.state().selectedJoint(), session.skeleton().findJoint("hand_r"));
  stage.play("0 key m\n", 3);
  EXPECT_EQ(stage.state().goalSelected(), session.findGoal("hand_l"));
}

TEST(Presentation, WithoutAnExampleThereIsNothingToPresent) {
  Stage plain("planar");
  plain.play("0 key f5\n", 3);
  EXPECT_FALSE(plain.state().presenting);  // and it says so
}

TEST(Presentation, OneKeyGivesHalfTheWindowOrMoreToTheDerivation) {
  Stage stage("lecture:newton-square");
  stage.play("0 key f5\n", 3);
  EXPECT_TRUE(stage.state().presenting);
  EXPECT_EQ(stage.state().layout.view.width, 440);  // this window is narrow for its tables
  EXPECT_EQ(stage.state().layout.inspector.height, 700);
  stage.play("0 key f5\n", 3);
  EXPECT_FALSE(stage.state().presenting);
  EXPECT_TRUE(stage.log.messages().empty()) << stage.log.messages().front();
}

TEST(Recording, ADragBecomesAFilmAsLongAsItWas) {
  if (!testing::hasCommand("ffmpeg") || !testing::hasCommand("ffprobe"))
    GTEST_SKIP() << "ffmpeg is not installed";
  Stage stage("planar");
  for (const char* name : {"film.mp4", "film.gif"}) {
    const std::string path = (stage.folder / name).string();
    stage.play("", 1);
    ASSERT_TRUE(stage.sandbox.startRecording(path));
    stage.play("0 drag end-effector -30 -40 20\n", 12);
    const double seconds = stage.state().recorder.seconds();
    ASSERT_TRUE(stage.sandbox.stopRecording());
    EXPECT_NEAR(seconds, 33.0 / 60.0, 0.1);
    const auto probe =
        testing::runProgram({"ffprobe", "-v", "error", "-select_streams", "v:0", "-count_frames",
                             "-show_entries", "stream=width,height,nb_read_frames", "-of", "csv=p=0", path});
    EXPECT_EQ(probe.output.substr(0, 9), "1000,700,") << probe.output;
    EXPECT_NEAR(std::stod(probe.output.substr(9)), seconds * Recorder::framesPerSecond, 1.5) << probe.output;
  }
  EXPECT_FALSE(stage.sandbox.startRecording("/no/such/folder/film.mp4"));
}

}  // namespace
}  // namespace gelenk
