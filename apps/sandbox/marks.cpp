#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/render/label_writer.h"
#include "apps/sandbox/gizmo.h"
#include "apps/sandbox/sandbox_state.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

ImVec2 toImVec2(const Eigen::Vector2d& p) { return {static_cast<float>(p.x()), static_cast<float>(p.y())}; }

// --- drawn with Dear ImGui over the picture: crisp at every scale

/// What the picture itself does not tell: how far, which, chosen.
void nameGoal(const LabelPen& pen, Sandbox& sandbox, const SceneGoal& goal) {
  Sandbox::State& s = sandbox.state();
  const Vector3d reached = s.session->reached(goal.id);
  const Projected p = s.toWindow(reached);
  if (p.depth <= 0.0) return;
  const ImVec2 at = toImVec2(p.pixel);
  const double error = s.session->error(goal.id);
  const GoalType& type = goalType(goal.goal.kind);
  const bool wish = type.preference < 1.0;
  if (goal.state != GoalState::Free && !wish && type.movesWithPose && error > 2e-4 * s.size()) {
    const ImVec2 end = toImVec2(s.toWindow(goal.goal.target).pixel);
    if (std::hypot(end.x - at.x, end.y - at.y) > 26 * pen.scale)
      writeWords(pen, {0.5f * (at.x + end.x) + 9 * pen.scale, 0.5f * (at.y + end.y) - 9 * pen.scale},
                 toImVec4(distanceColour(markColours(s.theme()), 2.0 * error / s.size())),
                 (s.session->lastSolve().outOfReach ? "out of reach by " : "") + formatLength(error));
  }
  const float r = wish ? 5.0f : 6.5f;
  if (s.selectedGoal == goal.id && s.session->dragged() != goal.id)
    pen.draw->AddCircle(at, (r + 4) * pen.scale, colour32(pen.colours.accent), 40, 1.8f * pen.scale);
  if (s.hover.kind == Hover::Kind::Goal && s.hover.goal == goal.id)
    writeWords(pen, {at.x + 16 * pen.scale, at.y - (s.selectedGoal == goal.id ? 34 : 8) * pen.scale},
               pen.colours.text,
               goal.goal.name);  // beside the arrows of the selected one
}

void drawHover(const LabelPen& pen, Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (s.hover.kind != Hover::Kind::Skin && s.hover.kind != Hover::Kind::Joint) return;
  const ImVec2 at = toImVec2(s.toWindow(s.hover.position).pixel);
  pen.draw->AddCircle(at, 6 * pen.scale, IM_COL32(255, 255, 255, 230), 24, 3.2f * pen.scale);
  pen.draw->AddCircle(at, 6 * pen.scale, colour32(pen.colours.held), 24, 1.6f * pen.scale);
}

void drawConstraint(const LabelPen& pen, Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (!s.session->dragged() || s.gesture.kind != Gesture::Kind::Drag) return;
  const Vector3d target = s.session->goal(*s.session->dragged()).goal.target;
  if (s.gesture.constraint >= DragConstraint::AxisX) {
    const int axis = static_cast<int>(s.gesture.constraint) - static_cast<int>(DragConstraint::AxisX);
    static const ImVec4 axisColours[] = {
        {0.82f, 0.22f, 0.20f, 1}, {0.20f, 0.60f, 0.25f, 1}, {0.20f, 0.42f, 0.85f, 1}};
    const Vector3d u = 0.6 * s.size() * Vector3d::Unit(axis);
    pen.draw->AddLine(toImVec2(s.toWindow(target - u).pixel), toImVec2(s.toWindow(target + u).pixel),
                      colour32(axisColours[axis], 0.8f), 1.4f * pen.scale);
  }
}

/// How far the gizmo was moved or turned.
void nameGesture(const LabelPen& pen, Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (!s.session->dragged() || !s.gesture.part) return;
  const Vector3d target = s.session->goal(*s.session->dragged()).goal.target;
  const int axis = s.gesture.part->axis;
  const double moved = target[axis] - s.gesture.start[axis];
  const std::string text = s.gesture.part->kind == GizmoPart::Kind::Ring
                               ? fmt::format("{:+.1f}°", s.gesture.angle * 180.0 / M_PI)
                               : (moved < 0.0 ? "−" : "+") + formatLength(std::abs(moved));
  writeWords(
      pen,
      {static_cast<float>(s.mouse.x()) + 18 * pen.scale, static_cast<float>(s.mouse.y()) + 14 * pen.scale},
      pen.colours.text, text);
}

/// As much of the words as stands in so many lines of that width.
std::string withinLines(const std::string& words, float width, int lines) {
  std::string text = brokenAtBlanks(words, width);
  std::size_t end = 0;
  for (int line = 0; line < lines && end != std::string::npos; ++line) end = text.find('\n', end + 1);
  if (end == std::string::npos) return text;
  text.resize(end);
  const std::size_t last = text.rfind('\n') + 1;  // 0 where there is one line
  const std::string shorter = brokenAtBlanks(text.substr(last), width - ImGui::CalcTextSize(" …").x);
  return text.substr(0, last) + shorter.substr(0, shorter.find('\n')) + " …";
}

/// From the newest at the bottom upwards, over less than half of the view: two lines of each, all of it under
/// the mouse, which keeps it.
void drawNotices(const LabelPen& pen, ImFont* font, Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  std::erase_if(s.notices, [&](const Notice& notice) { return notice.until <= s.time; });
  const Layout::Rect& view = s.layout.view;
  const float margin = 7 * pen.scale, width = std::min(view.width - 40 * pen.scale, 760 * pen.scale);
  float y = view.y + view.height - 14 * pen.scale;
  for (auto it = s.notices.rbegin(); it != s.notices.rend(); ++it) {
    const auto boxOf = [&](const std::string& words) {
      const ImVec2 size = font->CalcTextSizeA(font->FontSize, 1e9f, 0.0f, words.c_str());
      const float x = view.x + 0.5f * (view.width - size.x);
      return Layout::Rect{x - 2 * margin, y - size.y - 3 * margin, size.x + 4 * margin, size.y + 2 * margin};
    };
    std::string words = withinLines(it->words, width, 2);
    Layout::Rect box = boxOf(words);
    if (box.contains(s.mouse.x(), s.mouse.y())) {
      it->until = std::max(it->until, s.time + noticeFade);
      box = boxOf(words = brokenAtBlanks(it->words, width));
    }
    if (it != s.notices.rbegin() && box.y < view.y + 0.55f * view.height) break;
    const float alpha = static_cast<float>(std::clamp((it->until - s.time) / noticeFade, 0.0, 1.0));
    const ImVec2 low{box.x, box.y}, high{box.x + box.width, box.y + box.height};
    pen.draw->AddRectFilled(low, high, colour32(pen.colours.panelRaised, 0.95f * alpha), margin);
    pen.draw->AddRect(low, high, colour32(it->isError ? pen.colours.bad : pen.colours.border, alpha), margin);
    pen.draw->AddText(font, font->FontSize, {low.x + 2 * margin, low.y + margin},
                      colour32(it->isError ? pen.colours.bad : pen.colours.text, alpha), words.c_str());
    y = box.y - margin;
  }
}

}  // namespace

/// Where the drag presses against them, fading within a second.
void glowLimits(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (s.shownFrames) return;
  const std::vector<bool> at = s.session->jointsAtLimit();
  const std::optional<GoalId> dragged = s.session->dragged();
  for (int i = 0; i < static_cast<int>(at.size()); ++i) {
    const bool pressed =
        at[i] && dragged && s.session->skeleton().isAncestor(i, s.session->goal(*dragged).goal.joint);
    const bool examined = at[i] && s.selectedJoint() == i && !dragged;
    double& glow = s.limitGlow[i];
    glow = pressed || examined ? 1.0 : std::max(0.0, glow - ImGui::GetIO().DeltaTime / 0.9);
  }
}

void drawMarks(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  const Layout::Rect& view = s.layout.view;
  ImDrawList* draw = ImGui::GetBackgroundDrawList();
  const ImVec2 corner{view.x, view.y};
  LabelPlaces places = roomForLabels(corner, s.viewport(), s.session->model().planar, s.viewScale());
  const Fonts& fonts = s.gui.fonts();
  ImFont* font = s.presenting ? fonts.title : fonts.small;
  const float size = fonts.small->FontSize * s.viewScale() / s.scale;
  const LabelPen pen{draw, s.colours(), font, size, s.viewScale(), &places};
  // It is opaque: nothing needs to be blended.
  draw->AddCallback([](const ImDrawList*, const ImDrawCmd*) { glDisable(GL_BLEND); }, nullptr);
  draw->AddImage(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(s.picture.texture())),
                 {view.x, view.y}, {view.x + view.width, view.y + view.height}, {0, 1}, {1, 0});
  draw->AddCallback([](const ImDrawList*, const ImDrawCmd*) { glEnable(GL_BLEND); }, nullptr);
  draw->PushClipRect({view.x, view.y}, {view.x + view.width, view.y + view.height}, true);
  keepGizmoFree(s, places);
  writeLabels(pen, s.labels, s.camera(), s.viewport(), corner);
  drawConstraint(pen, sandbox);
  drawGizmo(sandbox.state(), *draw);
  if (s.show().handles && (!s.shownFrames || s.handlesOnShown)) {
    std::vector<const SceneGoal*> shown;
    for (const SceneGoal& goal : s.session->goals())
      if (s.view->shows(sandbox.session(), goal)) shown.push_back(&goal);
    for (const SceneGoal* goal : shown) {  // no words on a handle
      const ImVec2 at = toImVec2(s.toWindow(s.session->reached(goal->id)).pixel);
      places.takeAround(at.x, at.y, 7 * s.viewScale());
    }
    for (const SceneGoal* goal : shown) nameGoal(pen, sandbox, *goal);
  }
  nameGesture(pen, sandbox);
  drawHover(pen, sandbox);
  drawNotices(pen, s.gui.fonts().regular, sandbox);
  draw->PopClipRect();
}

}  // namespace gelenk
