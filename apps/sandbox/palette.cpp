#include "apps/sandbox/palette.h"

#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "apps/lecture/example.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/notation/robots.h"
#include "skinning/blend/skin_method.h"
#include "solvers/problem/goal_type.h"
#include "solvers/problem/ik_solver.h"

namespace gelenk {
namespace {

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string titleOf(const std::string& model) {
  for (const Robot& robot : robots())
    if (robot.name == model) return fmt::format("Open robot {} ({})", robot.title, model);
  return "Open model " + model;
}

}  // namespace

bool matches(const std::string& query, const std::string& text) {
  const std::string whole = lower(text), words = lower(query);
  std::size_t from = 0;
  while ((from = words.find_first_not_of(' ', from)) != std::string::npos) {
    const std::size_t to = std::min(words.find(' ', from), words.size());
    if (whole.find(words.substr(from, to - from)) == std::string::npos) return false;
    from = to;
  }
  return true;
}

std::vector<Action> actionsOf(Sandbox& sandbox) {
  std::vector<Action> all;
  const auto add = [&](std::string name, std::string key, std::function<void(Sandbox&)> run) {
    all.push_back({std::move(name), std::move(key), std::move(run)});
  };
  using Dialog = Sandbox::State::Dialog;
  add("Open a file", "Ctrl+O", [](Sandbox& s) { askForFiles(s.state()); });
  add("Save scene", "Ctrl+S", [](Sandbox& s) {
    if (s.state().scenePath.empty())
      s.state().dialog = Dialog::SaveScene;
    else
      s.saveSceneTo(s.state().scenePath);
  });
  add("Save scene as", "Ctrl+Shift+S", [](Sandbox& s) { s.state().dialog = Dialog::SaveScene; });
  if (sandbox.state().options.shareScene)
    add("Link to this scene", "", [](Sandbox& s) { s.state().options.shareScene(); });
  add("Screenshot", "F12", [](Sandbox& s) { s.state().screenshotPath = nextFileName(".png"); });
  add("Record a film, or stop", "Ctrl+R", [](Sandbox& s) { toggleRecording(s); });
  add("Quit", "Ctrl+Q", [](Sandbox& s) { s.requestClose(); });
  add("Undo", "Ctrl+Z", [](Sandbox& s) { undoOrRedo(s, false); });
  add("Redo", "Ctrl+Shift+Z", [](Sandbox& s) { undoOrRedo(s, true); });
  add("Rest pose", "R", [](Sandbox& s) { s.session().resetPose(); });
  add("Mirror pose and goals", "M", mirrorPose);
  add("Free all pins", "", [](Sandbox& s) { s.session().freePins(); });
  add("Let every goal go", "", [](Sandbox& s) { s.session().removeAllGoals(); });
  add("Balance on or off", "", [](Sandbox& s) { s.session().setBalance(!s.session().balance()); });
  add("Frame the selection", "F", [](Sandbox& s) { frameSelection(s); });
  add("Frame everything", "Home", [](Sandbox& s) { frameEverything(s, true); });
  const auto look = [&](const char* name, const char* key, StandardView view) {
    add(std::string("View: ") + name, key, [view](Sandbox& s) {
      s.state().cameraMove = {s.camera(), lookFrom(s.camera(), view), s.time()};
    });
  };
  look("front", "1", StandardView::Front);
  look("side", "3", StandardView::Side);
  look("top", "7", StandardView::Top);
  look("three quarters", "", StandardView::ThreeQuarter);
  add("View: orthographic or perspective", "5",
      [](Sandbox& s) { s.camera().orthographic = !s.camera().orthographic; });
  add("Light theme", "", [](Sandbox& s) { s.state().theme() = Theme::Light; });
  add("Dark theme", "", [](Sandbox& s) { s.state().theme() = Theme::Dark; });
  add("Inspector on or off", "", [](Sandbox& s) { s.state().inspectorOpen = !s.state().inspectorOpen; });
  add("Bottom strip on or off", "", [](Sandbox& s) { s.state().stripOpen = !s.state().stripOpen; });
  add("Presentation: the derivation in large type", "F5",
      [](Sandbox& s) { s.state().presenting = !s.state().presenting; });
  add("Play or pause", "Space", [](Sandbox& s) { s.setPlaying(!s.playing()); });
  add("Mouse and keys (help)", "H", [](Sandbox& s) { s.state().helpOpen = true; });
  for (const ViewOptionName& option : viewOptionNames())
    add(fmt::format("Show or hide {}", option.title), "", [which = option.option](Sandbox& s) {
      s.options().*which = !(s.options().*which);
      if (which == &ViewOptions::reachable && s.options().reachable) frameReachable(s);
    });
  for (const auto& panel : sandbox.state().panels) {
    const std::string name = panel->name();
    if (panel->hasInspector()) add("Tab " + name, "", [name](Sandbox& s) { s.showInspector(name); });
    if (panel->hasBottomStrip())
      add("Strip " + panel->stripTitle(), "", [name](Sandbox& s) { s.showBottomStrip(name); });
  }
  add("Lab: compare the solvers, or stop", "L", [](Sandbox& s) {
    for (const auto& panel : s.state().panels)
      if (panel->name() == "Lab") panel->keyPressed(s, GLFW_KEY_L, 0);
  });
  if (const auto& muscles = sandbox.session().edits().muscles)
    add("Muscles: one limb alone, or the body", "", [alone = muscles->enabled && muscles->alone](Sandbox& s) {
      for (const auto& panel : s.state().panels)
        if (panel->name() == "Muscles") {
          if (!alone) panel->act(s, {"layers", "on"});
          panel->act(s, {"alone", alone ? "off" : "on"});
          s.showInspector("Muscles");
        }
    });
  for (const std::string& name : frameSolverNames()) {
    const SolverEntry& entry = solverEntry(name);
    add(fmt::format("Solver {} ({})", entry.title, name), "", [name](Sandbox& s) { chooseSolver(s, name); });
  }
  add("Next solver", "Tab", [](Sandbox& s) { s.session().nextSolver(1); });
  add("Previous solver", "Shift+Tab", [](Sandbox& s) { s.session().nextSolver(-1); });
  if (sandbox.session().skin())
    for (const SkinMethod* method : skinMethods())
      if (!method->shader.empty())
        add(fmt::format("Skin {} ({})", method->title, method->name), "",
            [kind = method->kind](Sandbox& s) { s.session().skinChoice().method = kind; });
  for (const std::string& name : builtInModels())
    add(titleOf(name), "", [name](Sandbox& s) { s.requestOpen(name); });
  for (const LectureTopic& topic : lectureTopics())
    add(fmt::format("Lecture {} {}", topic.section, topic.title), "",
        [id = topic.id](Sandbox& s) { s.requestOpen("lecture:" + id); });
  for (const GoalType* type : goalTypes())
    add(fmt::format("Add a goal: {}", type->title), "", [kind = type->kind](Sandbox& s) {
      const int joint = s.session().selectedJoint().value_or(
          s.session().goals().empty() ? 0 : s.session().goals().front().goal.joint);
      const Edits before = s.session().edits();
      s.state().selectedGoal = s.session().addGoalOf(kind, joint, 0);
      s.session().rememberAs(before);
    });
  for (const std::string& path : sandbox.state().preferences.recent)
    add("Open recent " + path, "", [path](Sandbox& s) { s.requestOpen(path); });
  return all;
}

void CommandPalette::open() {
  open_ = focus_ = true;
  chosen_ = 0;
  query_[0] = '\0';
  actions_.clear();
}

void CommandPalette::draw(Sandbox& sandbox) {
  if (!open_) return;
  Sandbox::State& s = sandbox.state();
  if (actions_.empty()) actions_ = actionsOf(sandbox);
  const Layout::Rect& view = s.layout.view;
  const float width = std::min(560 * s.scale, view.width - 24 * s.scale);
  ImGui::SetNextWindowPos({view.x + 0.5f * view.width, view.y + 30 * s.scale}, ImGuiCond_Always,
                          {0.5f, 0.0f});
  ImGui::SetNextWindowSize({width, 0});
  pushFloating(s);
  ImGui::Begin("##palette", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                   ImGuiWindowFlags_NoSavedSettings);
  dropShadow(s);
  if (std::exchange(focus_, false)) {
    ImGui::SetWindowFocus();
    s.gui.focusText();
  }
  ImGui::SetNextItemWidth(-1);
  const std::string before = query_;
  const bool entered = ImGui::InputTextWithHint("##query", "What do you want to do?", query_, sizeof query_,
                                                ImGuiInputTextFlags_EnterReturnsTrue);
  if (before != query_) chosen_ = 0;
  std::vector<const Action*> found;
  for (const Action& action : actions_)
    if (matches(query_, action.name)) found.push_back(&action);
  const int count = static_cast<int>(found.size());
  if (ImGui::IsKeyPressed(GLFW_KEY_DOWN)) ++chosen_;
  if (ImGui::IsKeyPressed(GLFW_KEY_UP)) --chosen_;
  chosen_ = count > 0 ? std::clamp(chosen_, 0, count - 1) : 0;
  const Action* run = entered && count > 0 ? found[chosen_] : nullptr;
  ImGui::BeginChild("##found", {0, 300 * s.scale});
  for (int i = 0; i < count; ++i) {
    ImGui::PushID(i);
    if (ImGui::Selectable(found[i]->name.c_str(), i == chosen_)) run = found[i];
    if (i == chosen_ && (ImGui::IsKeyPressed(GLFW_KEY_DOWN) || ImGui::IsKeyPressed(GLFW_KEY_UP)))
      ImGui::SetScrollHereY();
    if (!found[i]->key.empty()) {
      const float keyWidth = ImGui::CalcTextSize(found[i]->key.c_str()).x;
      ImGui::SameLine(ImGui::GetContentRegionMax().x - keyWidth - 4 * s.scale);
      ImGui::TextColored(s.colours().textDim, "%s", found[i]->key.c_str());
    }
    ImGui::PopID();
  }
  if (count == 0) ImGui::TextColored(s.colours().textDim, "Nothing of that name.");
  ImGui::EndChild();
  const bool left = ImGui::IsMouseClicked(0) && !ImGui::IsWindowHovered(ImGuiHoveredFlags_ChildWindows) &&
                    !ImGui::IsWindowAppearing();
  ImGui::End();
  popFloating();
  if (ImGui::IsKeyPressed(GLFW_KEY_ESCAPE) || left || run) open_ = false;
  if (!run) return;
  try {
    const std::function<void(Sandbox&)> act = run->run;  // opening a model may end the list
    act(sandbox);
  } catch (const std::exception& error) {
    sandbox.say(error.what(), true);
  }
}

}  // namespace gelenk
