#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <imgui_internal.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <optional>
#include <utility>

#include "apps/document/model.h"
#include "apps/sandbox/key_help.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/symmetry.h"
#include "skinning/gpu/driver.h"
#include "solvers/problem/ik_solver.h"

namespace gelenk {
namespace {

constexpr ImGuiWindowFlags fixedWindow = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                         ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
                                         ImGuiWindowFlags_NoSavedSettings |
                                         ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoNav;

void place(const Layout::Rect& rect) {
  ImGui::SetNextWindowPos({rect.x, rect.y});
  ImGui::SetNextWindowSize({rect.width, rect.height});
}

void openDialog(Sandbox::State& s, Sandbox::State::Dialog dialog) {
  using Dialog = Sandbox::State::Dialog;
  s.dialog = dialog;
  const std::filesystem::path scene(s.scenePath);
  const std::string beside = scene.parent_path().string();
  if (dialog == Dialog::SaveScene)
    s.browser.begin(FileBrowser::Purpose::Save, beside.empty() ? s.preferences.folder : beside,
                    scene.empty() ? "scene.json" : scene.filename().string());
  if (dialog == Dialog::OpenFile) s.browser.begin(FileBrowser::Purpose::Open, s.preferences.folder, "");
}

}  // namespace

void toggleRecording(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (s.recorder.isRunning())
    sandbox.stopRecording();
  else
    sandbox.startRecording(nextFileName(".mp4"));
}

namespace {

void fileMenu(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (!ImGui::BeginMenu("File")) return;
  if (ImGui::MenuItem("Open…", "Ctrl+O")) askForFiles(s);
  if (ImGui::MenuItem("Save scene", "Ctrl+S")) {
    if (s.scenePath.empty())
      openDialog(s, Sandbox::State::Dialog::SaveScene);
    else
      sandbox.saveSceneTo(s.scenePath);
  }
  if (ImGui::MenuItem("Save scene as…", "Ctrl+Shift+S")) openDialog(s, Sandbox::State::Dialog::SaveScene);
  if (s.options.shareScene && ImGui::MenuItem("Link to this scene")) s.options.shareScene();
  if (!s.preferences.recent.empty() && ImGui::BeginMenu("Open recent")) {
    for (const std::string& path : s.preferences.recent)
      if (ImGui::MenuItem(path.c_str())) s.toOpen = path;
    ImGui::EndMenu();
  }
  if (ImGui::MenuItem("Screenshot", "F12")) s.screenshotPath = nextFileName(".png");
  if (ImGui::MenuItem(s.recorder.isRunning() ? "Stop recording" : "Record a film", "Ctrl+R"))
    toggleRecording(sandbox);
  ImGui::Separator();
  if (ImGui::MenuItem("Quit", "Ctrl+Q")) sandbox.requestClose();
  ImGui::EndMenu();
}

void editMenu(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (!ImGui::BeginMenu("Edit")) return;
  const auto can = [&](bool redo) {
    return (redo ? s.session->canRedo() : s.session->canUndo()) ||
           std::ranges::any_of(s.panels, [&](const auto& panel) { return panel->canTakeBack(redo); });
  };
  if (ImGui::MenuItem("Undo", "Ctrl+Z", false, can(false))) undoOrRedo(sandbox, false);
  if (ImGui::MenuItem("Redo", "Ctrl+Shift+Z", false, can(true))) undoOrRedo(sandbox, true);
  ImGui::Separator();
  if (ImGui::MenuItem("Rest pose", "R")) s.session->resetPose();
  const std::string whyNot = whyNotMirrored(s.session->skeleton());
  if (ImGui::MenuItem("Mirror pose", "M", false, whyNot.empty())) mirrorPose(sandbox);
  if (!whyNot.empty()) tooltip(whyNot.c_str());
  if (ImGui::MenuItem("Let every goal go")) s.session->removeAllGoals();
  ImGui::EndMenu();
}

void viewMenu(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (!ImGui::BeginMenu("View")) return;
  const auto look = [&](const char* name, const char* key, StandardView view) {
    if (ImGui::MenuItem(name, key)) s.cameraMove = {s.camera(), lookFrom(s.camera(), view), s.time};
  };
  look("Front", "1", StandardView::Front);
  look("Side", "3", StandardView::Side);
  look("Top", "7", StandardView::Top);
  look("Three quarters", "", StandardView::ThreeQuarter);
  ImGui::MenuItem("Orthographic", "5", &s.camera().orthographic);
  if (ImGui::MenuItem("Frame everything", "Home")) frameEverything(sandbox, true);
  ImGui::Separator();
  ImGui::MenuItem("Inspector", nullptr, &s.inspectorOpen);
  ImGui::MenuItem("Bottom strip", nullptr, &s.stripOpen);
  ImGui::MenuItem("Presentation", "F5", &s.presenting);
  ImGui::Separator();
  if (ImGui::MenuItem("Light theme", nullptr, s.theme() == Theme::Light)) s.theme() = Theme::Light;
  if (ImGui::MenuItem("Dark theme", nullptr, s.theme() == Theme::Dark)) s.theme() = Theme::Dark;
  ImGui::EndMenu();
}

void modelMenu(Sandbox& sandbox) {
  if (!ImGui::BeginMenu("Model")) return;
  for (const std::string& name : builtInModels())
    if (ImGui::MenuItem(name.c_str(), nullptr, sandbox.state().session->document().model.nameOrFile == name))
      sandbox.state().toOpen = name;
  ImGui::EndMenu();
}

void menuBar(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (!ImGui::BeginMainMenuBar()) return;
  ImGui::PushFont(s.gui.fonts().medium);
  ImGui::TextColored(s.colours().accent, "Gelenk");
  ImGui::PopFont();
  ImGui::SameLine(0.0f, 14.0f * s.scale);
  fileMenu(sandbox);
  editMenu(sandbox);
  viewMenu(sandbox);
  modelMenu(sandbox);
  for (const auto& panel : s.panels) panel->drawMenu(sandbox);
  if (ImGui::BeginMenu("Help")) {
    if (ImGui::MenuItem("Find an action…", "Ctrl+K")) s.palette.open();
    if (ImGui::MenuItem("Mouse and keys", "H or ?")) s.helpOpen = true;
    ImGui::EndMenu();
  }
  const std::string name = s.session->model().name;
  const float width = ImGui::CalcTextSize(name.c_str()).x;
  if (const float x = ImGui::GetWindowWidth() - width - 14.0f * s.scale; x > ImGui::GetCursorPosX()) {
    ImGui::SetCursorPosX(x);
    ImGui::TextColored(s.colours().textDim, "%s", name.c_str());
  }
  ImGui::EndMainMenuBar();
}

/// Tabs in as many rows as they need, so that none is hidden, and the one in front.
void stripTabs(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  Panel* front = nullptr;
  for (const auto& panel : s.panels)
    if (panel->hasBottomStrip() && (!front || panel->name() == s.stripTab)) front = panel.get();
  if (!front) return;
  s.stripTab = front->name();
  const float gap = 2 * s.scale, right = ImGui::GetCursorPosX() + ImGui::GetContentRegionAvail().x;
  float x = ImGui::GetCursorPosX();
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {gap, 2 * s.scale});
  for (const auto& panel : s.panels) {
    if (!panel->hasBottomStrip()) continue;
    const std::string title = panel->stripTitle();
    const float width = ImGui::CalcTextSize(title.c_str()).x + 2 * ImGui::GetStyle().FramePadding.x;
    if (x + width <= right && x > ImGui::GetCursorStartPos().x) ImGui::SameLine(x);
    if (x + width > right) x = ImGui::GetCursorPosX();
    ImGui::PushStyleColor(ImGuiCol_Button,
                          ImGui::GetStyleColorVec4(panel.get() == front ? ImGuiCol_TabActive : ImGuiCol_Tab));
    if (ImGui::Button(title.c_str())) s.stripTab = panel->name();
    ImGui::PopStyleColor();
    x += width + gap;
  }
  front->drawBesideTabs(sandbox);
  ImGui::PopStyleVar();
  ImGui::Separator();
  ImGui::BeginChild(front->name().c_str(), {0, 0}, false, ImGuiWindowFlags_None);
  ImGui::PushItemWidth(-1.0f);
  front->drawBottomStrip(sandbox);
  ImGui::PopItemWidth();
  ImGui::EndChild();
}

/// The inspector's tabs under each other at the window's edge: all in sight at every width.
Panel* rail(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  Panel* front = nullptr;
  for (const auto& panel : s.panels)
    if (panel->hasInspector() && (!front || panel->name() == s.inspectorTab)) front = panel.get();
  if (!front) return nullptr;
  s.inspectorTab = front->name();
  place(s.layout.rail);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {4 * s.scale, 8 * s.scale});
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {0, 3 * s.scale});
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {0, 7 * s.scale});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, s.colours().panelSunken);
  ImGui::Begin("##rail", nullptr, fixedWindow);
  ImGui::PushFont(s.gui.fonts().small);
  for (const auto& panel : s.panels) {
    if (!panel->hasInspector()) continue;
    const std::string name = panel->name();
    const bool inFront = name == s.inspectorTab;
    ImGui::PushStyleColor(ImGuiCol_Button, inFront ? s.colours().panel : ImVec4(0, 0, 0, 0));
    ImGui::PushStyleColor(ImGuiCol_Text, inFront ? s.colours().accent : s.colours().textDim);
    if (ImGui::Button(name.c_str(), {ImGui::GetContentRegionAvail().x, 0})) s.inspectorTab = name;
    ImGui::PopStyleColor(2);
  }
  ImGui::PopFont();
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar(3);
  return front;
}

void inspector(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (s.layout.inspector.width <= 0) return;
  if (s.presenting) {
    place(s.layout.inspector);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {28 * s.scale, 24 * s.scale});
    ImGui::Begin("##presentation", nullptr, fixedWindow);
    bool drawn = false;
    for (const auto& panel : s.panels) drawn = drawn || panel->drawPresentation(sandbox);
    ImGui::End();
    ImGui::PopStyleVar();
    if (!drawn) {
      s.presenting = false;
      sandbox.say("Open an example of the lecture first: its derivation is what F5 shows large");
    }
    return;
  }
  Panel* front = rail(sandbox);
  if (!front) return;
  place(s.layout.inspector);
  ImGui::Begin("##inspector", nullptr, fixedWindow);
  ImGui::BeginChild(front->name().c_str(), {0, 0}, false, ImGuiWindowFlags_None);
  ImGui::PushItemWidth(-1.0f);
  front->drawInspector(sandbox);
  ImGui::PopItemWidth();
  ImGui::EndChild();
  ImGui::End();
}

/// The edges of inspector and strip can be dragged; a double click gives them their own size again.
void splitters(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  const float grip = 6 * s.scale;
  const auto edge = [&](const char* id, const Layout::Rect& rect, bool vertical, double& size, double now) {
    place(rect);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1, 1});
    constexpr ImGuiWindowFlags above = fixedWindow & ~ImGuiWindowFlags_NoBringToFrontOnFocus;
    ImGui::Begin(id, nullptr,
                 above | ImGuiWindowFlags_NoBackground | ImGuiWindowFlags_NoScrollbar |
                     ImGuiWindowFlags_NoFocusOnAppearing);
    ImGui::InvisibleButton("##grip", {rect.width, rect.height});
    if (ImGui::IsItemHovered() || ImGui::IsItemActive()) {
      ImGui::SetMouseCursor(vertical ? ImGuiMouseCursor_ResizeEW : ImGuiMouseCursor_ResizeNS);
      const ImVec4 colour = s.colours().accent;
      ImGui::GetWindowDrawList()->AddRectFilled(
          {rect.x + (vertical ? 0.4f * rect.width : 0), rect.y + (vertical ? 0 : 0.4f * rect.height)},
          {rect.x + (vertical ? 0.6f : 1.0f) * rect.width, rect.y + (vertical ? 1.0f : 0.6f) * rect.height},
          colour32(colour));
    }
    if (ImGui::IsItemActive() && !ImGui::IsItemActivated()) {  // the way to the edge is no part of the drag
      const ImVec2 moved = ImGui::GetIO().MouseDelta;
      if (moved.x != 0.0f || moved.y != 0.0f)
        size = std::max(1.0, (now - (vertical ? moved.x : moved.y)) / s.scale);
    }
    if (ImGui::IsItemHovered() && ImGui::IsMouseDoubleClicked(0)) size = 0.0;
    ImGui::End();
    ImGui::PopStyleVar(2);
  };
  const Layout::Rect &inspector = s.layout.inspector, &strip = s.layout.strip;
  if (inspector.width > 0)
    edge("##edge of inspector", {inspector.x - 0.5f * grip, inspector.y, grip, inspector.height}, true,
         s.preferences.inspector, inspector.width + s.layout.rail.width);
  if (strip.height > 0)
    edge("##edge of strip", {strip.x, strip.y - 0.5f * grip, strip.width, grip}, false, s.preferences.strip,
         strip.height);
}

void strip(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (s.layout.strip.height <= 0) return;
  place(s.layout.strip);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {10 * s.scale, 6 * s.scale});
  ImGui::Begin("##strip", nullptr, fixedWindow | ImGuiWindowFlags_NoScrollbar);
  ImGui::PopStyleVar();
  stripTabs(sandbox);
  ImGui::End();
}

}  // namespace

std::string mouseHint(Sandbox& sandbox) {
  const Sandbox::State& s = sandbox.state();
  if (const Panel* tool = toolOf(sandbox)) return tool->mouseHint();
  if (s.gesture.kind == Gesture::Kind::Drag) {
    if (s.turning()) return "Turning the goal · release T or Alt to move it";
    return "X Y Z lock an axis · Shift: ground plane · T or Alt turns · P pins · Esc cancels";
  }
  switch (s.hover.kind) {
    case Hover::Kind::Goal:
      return "Drag to move " + s.session->goal(s.hover.goal).goal.name + " · P pins · Del lets go";
    case Hover::Kind::Joint:
      return "Drag " + s.session->skeleton().joint(s.hover.joint).name + " · click selects · P pins";
    case Hover::Kind::Skin:
      return "Drag the skin (" + s.session->skeleton().joint(s.hover.joint).name +
             ") · click selects · P pins";
    default: break;
  }
  return s.session->model().planar
             ? "Drag the arm · drag the ground to pan · wheel zooms · H: help"
             : "Drag a handle or the skin · drag the ground to orbit · wheel zooms · H: help";
}

std::string statusFacts(Sandbox& sandbox) {
  const Sandbox::State& s = sandbox.state();
  const FrameSolve& solve = s.session->lastSolve();
  std::string facts = solve.ran ? fmt::format("{} it · {} · {:.0f} µs · ", solve.iterations,
                                              describeErrors(solve), 1e6 * solve.seconds)
                                : std::string("at rest · ");
  facts += fmt::format("{} dof", s.session->skeleton().nv());
  if (s.secondsPerFrame > 0.0) facts += fmt::format(" · {:.0f} fps", 1.0 / s.secondsPerFrame);
  std::string renderer = sandbox.renderer();
  if (const auto at = renderer.find(" ("); at != std::string::npos) renderer.resize(at);
  facts = std::string(solverEntry(s.session->solver()).title) + " · " + facts + " · " + renderer;
  if (s.recorder.isRunning()) facts = fmt::format("film {:.0f} s · {}", s.recorder.seconds(), facts);
  return facts;
}

namespace {

void statusLine(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  place(s.layout.statusLine);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {12 * s.scale, 5 * s.scale});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, {1, 1});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, s.colours().panelSunken);
  ImGui::Begin("##status", nullptr,
               fixedWindow | ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
  ImGui::PushFont(s.gui.fonts().small);
  const std::string facts = statusFacts(sandbox);
  const float width = ImGui::CalcTextSize(facts.c_str()).x;
  const float x = ImGui::GetWindowWidth() - width - 12 * s.scale;
  const std::string help = mouseHint(sandbox);
  if (ImGui::CalcTextSize(help.c_str()).x + 40 * s.scale < x) {
    ImGui::TextColored(s.colours().text, "%s", help.c_str());
    ImGui::SameLine(x);
  }
  ImGui::TextColored(s.colours().textDim, "%s", facts.c_str());
  tooltip(
      "solver · iterations of this frame · largest goal error, from forward kinematics · time of the solve · "
      "degrees of freedom · frames a second · OpenGL renderer");
  ImGui::PopFont();
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar(2);
}

void help(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (!s.helpOpen) return;
  const Layout::Rect& view = s.layout.view;
  ImGui::SetNextWindowPos({view.x + 0.5f * view.width, view.y + 0.5f * view.height}, ImGuiCond_Always,
                          {0.5f, 0.5f});
  ImGui::SetNextWindowBgAlpha(0.97f);
  pushFloating(s);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {22 * s.scale, 18 * s.scale});
  ImGui::Begin("##help", &s.helpOpen,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoSavedSettings);
  dropShadow(s);
  ImGui::PushFont(s.gui.fonts().large);
  ImGui::TextUnformatted("Mouse and keys");
  ImGui::PopFont();
  ImGui::Dummy({0, 4 * s.scale});
  if (ImGui::BeginTable("##keys", 2, ImGuiTableFlags_SizingFixedFit)) {
    for (const auto& [key, what] : keyHelp) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::PushFont(s.gui.fonts().medium);
      ImGui::TextUnformatted(key);
      ImGui::PopFont();
      ImGui::TableNextColumn();
      ImGui::TextColored(s.colours().textDim, "%s", what);
    }
    ImGui::EndTable();
  }
  if (ImGui::IsMouseClicked(0) && !ImGui::IsWindowHovered() && !ImGui::IsWindowAppearing())
    s.helpOpen = false;
  ImGui::End();
  ImGui::PopStyleVar();
  popFloating();
}

/// Save, leave or stay.
void askUnsaved(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  using Dialog = Sandbox::State::Dialog;
  ImGui::TextUnformatted("Poses, goals or other edits of this scene are not saved.");
  ImGui::Dummy({0, 4 * s.scale});
  const auto goOn = [&] {
    s.dialog = Dialog::None;
    s.savedEdits = s.session->editCount();
    if (const auto next = std::exchange(s.next, nullptr)) s.afterFrame = next;
  };
  if (ImGui::Button(s.scenePath.empty() ? "Save…" : "Save", {110 * s.scale, 0}) ||
      (ImGui::IsKeyPressed(GLFW_KEY_ENTER, false) && !ImGui::IsWindowAppearing())) {
    if (s.scenePath.empty()) {
      openDialog(s, Dialog::SaveScene);
      ImGui::CloseCurrentPopup();
      return;
    }
    if (sandbox.saveSceneTo(s.scenePath)) goOn();
  }
  ImGui::SameLine();
  if (ImGui::Button("Do not save (D)", {140 * s.scale, 0}) || ImGui::IsKeyPressed(GLFW_KEY_D)) goOn();
  ImGui::SameLine();
  if (ImGui::Button("Cancel", {96 * s.scale, 0}) || ImGui::IsKeyPressed(GLFW_KEY_ESCAPE)) {
    s.dialog = Dialog::None;
    s.next = nullptr;
  }
  if (s.dialog == Dialog::None) ImGui::CloseCurrentPopup();
}

void dialogs(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  using Dialog = Sandbox::State::Dialog;
  if (s.dialog == Dialog::None) return;
  const bool saving = s.dialog == Dialog::SaveScene;
  const char* title = saving                        ? "Save scene"
                      : s.dialog == Dialog::Unsaved ? "Unsaved changes"
                                                    : "Open a model or a scene";
  if (!ImGui::IsPopupOpen(title)) {
    openDialog(s, s.dialog);
    ImGui::OpenPopup(title);
  }
  const Layout::Rect& view = s.layout.view;
  ImGui::SetNextWindowPos({view.x + 0.5f * view.width, view.y + 0.5f * view.height}, ImGuiCond_Always,
                          {0.5f, 0.5f});
  pushFloating(s);
  const bool isOpen = ImGui::BeginPopupModal(
      title, nullptr,
      ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoMove);
  popFloating();
  if (!isOpen) return;
  dropShadow(s);
  ImGui::PushFont(s.gui.fonts().medium);
  ImGui::TextUnformatted(title);
  ImGui::PopFont();
  if (s.dialog == Dialog::Unsaved) {
    askUnsaved(sandbox);
    ImGui::EndPopup();
    return;
  }
  const std::optional<std::string> chosen = s.browser.draw(sandbox);
  ImGui::SameLine();
  const bool cancelled = ImGui::Button("Cancel", {96 * s.scale, 0}) || ImGui::IsKeyPressed(GLFW_KEY_ESCAPE);
  s.preferences.folder = s.browser.folder();
  if (chosen && saving && sandbox.saveSceneTo(*chosen)) {
    s.dialog = Dialog::None;
    if (const auto next = std::exchange(s.next, nullptr)) s.afterFrame = next;
  } else if (chosen && !saving) {
    s.dialog = Dialog::None;
    s.toOpen = *chosen;
  } else if (cancelled) {
    s.dialog = Dialog::None;
    s.next = nullptr;
  }
  if (s.dialog == Dialog::None) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
}

}  // namespace

void askForFiles(Sandbox::State& s) {
  if (s.options.chooseFiles)
    s.options.chooseFiles();
  else
    s.dialog = Sandbox::State::Dialog::OpenFile;
}

Layout layOut(const Sandbox::State& s, int width, int height) {
  const float scale = s.scale, w = static_cast<float>(width), h = static_cast<float>(height);
  if (s.options.bare)
    return {.view = {0, 0, w, h}, .inspector = {}, .rail = {}, .strip = {}, .statusLine = {}};
  const float menu = ImGui::GetIO().Fonts->Fonts.empty()
                         ? 24 * scale
                         : s.gui.fonts().regular->FontSize + 2 * ImGui::GetStyle().FramePadding.y;
  const float status = s.gui.fonts().small->FontSize + 10 * scale;
  if (s.presenting) {
    // Half of the window, or more of a narrow one, for the tables' sake.
    const float words = std::round(std::max(0.5f * w, std::min(0.8f * h + 66 * scale, 0.56f * w)));
    return {.view = {0, 0, w - words, h},
            .inspector = {w - words, 0, words, h},
            .rail = {},
            .strip = {},
            .statusLine = {}};
  }
  // By themselves they grow with the window; what a person chose stays within what leaves a view.
  const auto sized = [&](double chosen, float own, float least, float most) {
    return std::round(
        std::clamp(chosen > 0.0 ? static_cast<float>(chosen) * scale : own, least, std::max(least, most)));
  };
  const float inspector =
      s.inspectorOpen
          ? std::min(sized(s.preferences.inspector, std::clamp(0.25f * w, 364 * scale, 460 * scale),
                           250 * scale, 0.6f * w),
                     std::floor(0.6f * w))
          : 0.0f;
  const float strip =
      s.stripOpen && h > 560 * scale
          ? sized(s.preferences.strip, std::clamp(0.245f * h, 198 * scale, 320 * scale), 90 * scale, 0.6f * h)
          : 0.0f;
  const float railWidth = inspector > 0 ? std::round(62 * scale) : 0.0f;
  Layout layout;
  layout.inspector = {w - inspector, menu, inspector - railWidth, h - menu - status};
  layout.rail = {w - railWidth, menu, railWidth, h - menu - status};
  layout.strip = {0, h - status - strip, w - inspector, strip};
  layout.statusLine = {0, h - status, w, status};
  layout.view = {0, menu, w - inspector, h - menu - status - strip};
  return layout;
}

void drawShell(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (s.options.bare) return;
  if (!s.presenting) menuBar(sandbox);
  inspector(sandbox);
  strip(sandbox);
  if (!s.presenting) {
    statusLine(sandbox);
    splitters(sandbox);
  }
  help(sandbox);
  s.palette.draw(sandbox);
  dialogs(sandbox);
  if (!s.toOpen.empty()) {
    const std::string name = std::exchange(s.toOpen, {});
    s.afterFrame = [name](Sandbox& box) { box.requestOpen(name); };
  }
}

void pushFloating(const Sandbox::State& state) {
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 9 * state.scale);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 1.0f);
  ImGui::PushStyleColor(ImGuiCol_WindowBg, state.colours().panelRaised);
}

void dropShadow(const Sandbox::State& state) {
  ImDrawList* draw = ImGui::GetWindowDrawList();
  const ImVec2 low = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  const float reach = std::round(14 * state.scale), corner = 9 * state.scale;
  draw->PushClipRectFullScreen();
  for (float away = 1.0f; away < reach; away += 1.0f) {
    const float near = 1.0f - away / reach;
    draw->AddRect({low.x - away, low.y - away}, {low.x + size.x + away, low.y + size.y + away},
                  colour32({0, 0, 0, 0.16f * near * near}), corner + away, 0, 1.0f);
  }
  draw->PopClipRect();
}

void popFloating() {
  ImGui::PopStyleColor();
  ImGui::PopStyleVar(2);
}

void heading(const Sandbox::State& state, const char* words) {
  ImGui::Dummy({0, 4 * state.scale});
  ImGui::PushFont(state.gui.fonts().small);
  ImGui::TextColored(state.colours().textDim, "%s", words);
  ImGui::PopFont();
}

void colourBar(const Sandbox::State& state, ColourMap map) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x, height = 10 * state.scale;
  constexpr int steps = 48;
  for (int i = 0; i < steps; ++i) {
    const Colour c = map((static_cast<float>(i) + 0.5f) / steps);
    const auto edge = [&](int k) { return std::round(at.x + width * static_cast<float>(k) / steps); };
    ImGui::GetWindowDrawList()->AddRectFilled({edge(i), at.y}, {edge(i + 1), at.y + height},
                                              colour32(toImVec4(c)));
  }
  ImGui::Dummy({width, height});
}

void colourBar(const Sandbox::State& state, const char* least, const char* most) {
  colourBar(state, viridis, least, most);
}

void colourBar(const Sandbox::State& state, ColourMap map, const char* least, const char* most) {
  colourBar(state, map);
  ImGui::PushFont(state.gui.fonts().small);
  ImGui::TextColored(state.colours().textDim, "%s", least);
  ImGui::SameLine(ImGui::GetContentRegionMax().x - ImGui::CalcTextSize(most).x);
  ImGui::TextColored(state.colours().textDim, "%s", most);
  ImGui::PopFont();
}

void tooltip(const char* words) {
  if (!ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
  showTooltip(words);
}

/// Where it covers no control of the panel: to the left of one at the right, above one at the foot of the
/// window, above the mouse elsewhere in the lower half. As plain over what is disabled as over the rest.
/// One a frame: the first.
void showTooltip(const char* words) {
  for (const ImGuiWindow* window : ImGui::GetCurrentContext()->Windows)
    if ((window->Flags & ImGuiWindowFlags_Tooltip) && window->LastFrameActive == ImGui::GetFrameCount())
      return;
  const ImGuiStyle& style = ImGui::GetStyle();
  const ImGuiWindow& panel = *ImGui::GetCurrentWindow()->RootWindow;
  const ImVec2 mouse = ImGui::GetMousePos(), display = ImGui::GetIO().DisplaySize;
  const float font = ImGui::GetFontSize(), gap = 0.5f * font;
  const bool isAtRight = panel.Pos.x > 0.4f * display.x;
  const float room = (isAtRight ? panel.Pos.x - gap : display.x) - 2 * style.WindowPadding.x;
  const std::string text = brokenAtBlanks(words, std::clamp(room, 10.0f * font, 22.0f * font));
  const ImVec2 whole = ImGui::CalcTextSize(text.c_str());
  const float width = whole.x + 2 * style.WindowPadding.x, height = whole.y + 2 * style.WindowPadding.y;
  const auto place = [&](float x, float y) {
    ImGui::SetNextWindowPos({std::clamp(x, 0.0f, std::max(0.0f, display.x - width)),
                             std::clamp(y, 0.0f, std::max(0.0f, display.y - height))});
  };
  if (isAtRight && width + gap <= panel.Pos.x)
    place(panel.Pos.x - gap - width, mouse.y - 0.5f * height);
  else if (panel.Pos.y > 0.4f * display.y && height + gap <= panel.Pos.y)
    place(std::min(mouse.x, panel.Pos.x + panel.Size.x - width), panel.Pos.y - gap - height);
  else if (mouse.y > 0.5f * display.y && height + 2 * gap < mouse.y)
    place(mouse.x, mouse.y - 2 * gap - height);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, style.PopupRounding);
  ImGui::PushStyleVar(ImGuiStyleVar_Alpha, 1.0f);
  ImGui::BeginTooltip();
  ImGui::TextUnformatted(text.c_str());
  ImGui::EndTooltip();
  ImGui::PopStyleVar(2);
}

std::string brokenAtBlanks(const std::string& text, float width) {
  const auto isTooLong = [&](const std::string& line) { return ImGui::CalcTextSize(line.c_str()).x > width; };
  std::string out, line;
  const auto add = [&](const std::string& piece, const char* joint) {
    const std::string longer = line.empty() ? piece : line + joint + piece;
    if (!line.empty() && isTooLong(longer)) {
      out += line + "\n";
      line = piece;
    } else {
      line = longer;
    }
  };
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t to = std::min(text.find_first_of(" \n", from), text.size());
    const std::string word = text.substr(from, to - from);
    const std::size_t slash = isTooLong(word) ? word.find('/', 1) : std::string::npos;
    add(word.substr(0, slash == std::string::npos ? slash : slash + 1), " ");
    for (std::size_t at = slash; at != std::string::npos;) {
      const std::size_t next = word.find('/', at + 1);
      add(word.substr(at + 1, next == std::string::npos ? next : next - at), "");
      at = next;
    }
    if (to < text.size() && text[to] == '\n') {
      out += line + "\n";
      line.clear();
    }
    from = to + 1;
  }
  return out + line;
}

void wrappedText(const std::string& words) {
  ImGui::TextUnformatted(brokenAtBlanks(words, ImGui::GetContentRegionAvail().x).c_str());
}

void wrappedText(const ImVec4& colour, const std::string& words) {
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  wrappedText(words);
  ImGui::PopStyleColor();
}

std::string formatLength(double metres) {
  const double mm = 1e3 * metres;
  if (mm < 0.0995) return fmt::format("{:.1f} µm", 1e6 * metres);
  if (mm < 9.95) return fmt::format("{:.2f} mm", mm);
  if (mm < 999.5) return fmt::format("{:.1f} mm", mm);
  return fmt::format("{:.2f} m", metres);
}

std::string describeErrors(const FrameSolve& solve) {
  std::string words = formatLength(solve.error);
  if (solve.orientationError > 0.1 * Session::reachedAngle)
    words += fmt::format(", {:.2g}°", solve.orientationError * 180.0 / M_PI);
  return words;
}

std::string describeSolve(const Session& session) {
  const FrameSolve& solve = session.lastSolve();
  if (!solve.ran) return "nothing is held";
  if (solve.why == Stop::Unsupported) return "not for this solver: " + solve.unsupported;
  if (solve.why == Stop::Failure) return "numerical failure";
  const std::string errors = describeErrors(solve);
  if (solve.reached) return "reached, " + errors;
  if (solve.outOfReach) return "out of reach by " + errors + ": no pose nearby comes closer";
  switch (solve.why) {
    case Stop::Saddle: return "stuck at a saddle, " + errors;
    case Stop::Stalled: return "stalled, " + errors;
    default: return (solve.jointMotion < 1e-5 ? "at rest, " : "on the way, ") + errors;
  }
}

}  // namespace gelenk
