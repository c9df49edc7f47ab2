#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/sandbox/gizmo.h"
#include "apps/sandbox/label_places.h"
#include "apps/sandbox/mathematics.h"
#include "apps/sandbox/plots.h"
#include "apps/sandbox/sandbox_state.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

ImVec2 toImVec2(const Eigen::Vector2d& p) { return {static_cast<float>(p.x()), static_cast<float>(p.y())}; }

// --- drawn with Dear ImGui over the picture: crisp at every scale

struct Pen {
  ImDrawList* draw;
  const Palette& colours;
  const Fonts& fonts;
  float scale;
  LabelPlaces* places;
};

/// At the point, or as near to it as there is room.
void words(const Pen& pen, ImVec2 at, const ImVec4& colour, const std::string& text, bool isFormula = false) {
  ImFont* font = pen.fonts.small;
  ImVec2 size = font->CalcTextSizeA(font->FontSize, 1e9f, 0.0f, text.c_str());
  if (isFormula) size = {mathExtent(font, font->FontSize, text).width, size.y};
  LabelBox box{at.x - 5 * pen.scale, at.y - 2 * pen.scale, size.x + 10 * pen.scale, size.y + 4 * pen.scale};
  if (!pen.places->place(box)) return;
  at = {box.x + 5 * pen.scale, box.y + 2 * pen.scale};
  pen.draw->AddRectFilled({box.x, box.y}, {box.x + box.width, box.y + box.height},
                          colour32(pen.colours.panelRaised, 0.82f), 4 * pen.scale);
  if (isFormula)
    drawMathematics(*pen.draw, font, font->FontSize, at, colour32(colour), text);
  else
    pen.draw->AddText(font, font->FontSize, at, colour32(colour), text.c_str());
}

/// What the picture itself does not tell: how far, which, chosen.
void nameGoal(const Pen& pen, Sandbox& sandbox, const SceneGoal& goal) {
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
      words(pen, {0.5f * (at.x + end.x) + 9 * pen.scale, 0.5f * (at.y + end.y) - 9 * pen.scale},
            toImVec4(distanceColour(markColours(s.theme()), 2.0 * error / s.size())),
            (s.session->lastSolve().outOfReach ? "out of reach by " : "") + formatLength(error));
  }
  const float r = wish ? 5.0f : 6.5f;
  if (s.selectedGoal == goal.id && s.session->dragged() != goal.id)
    pen.draw->AddCircle(at, (r + 4) * pen.scale, colour32(pen.colours.accent), 40, 1.8f * pen.scale);
  if (s.hover.kind == Hover::Kind::Goal && s.hover.goal == goal.id)
    words(pen, {at.x + 16 * pen.scale, at.y - 8 * pen.scale}, pen.colours.text, goal.goal.name);
}

void drawHover(const Pen& pen, Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (s.hover.kind != Hover::Kind::Skin && s.hover.kind != Hover::Kind::Joint) return;
  const ImVec2 at = toImVec2(s.toWindow(s.hover.position).pixel);
  pen.draw->AddCircle(at, 6 * pen.scale, IM_COL32(255, 255, 255, 230), 24, 3.2f * pen.scale);
  pen.draw->AddCircle(at, 6 * pen.scale, colour32(pen.colours.held), 24, 1.6f * pen.scale);
}

void drawConstraint(const Pen& pen, Sandbox& sandbox) {
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
void nameGesture(const Pen& pen, Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (!s.session->dragged() || !s.gesture.part) return;
  const Vector3d target = s.session->goal(*s.session->dragged()).goal.target;
  const int axis = s.gesture.part->axis;
  const double moved = target[axis] - s.gesture.start[axis];
  const std::string text = s.gesture.part->kind == GizmoPart::Kind::Ring
                               ? fmt::format("{:+.1f}°", s.gesture.angle * 180.0 / M_PI)
                               : (moved < 0.0 ? "−" : "+") + formatLength(std::abs(moved));
  words(pen,
        {static_cast<float>(s.mouse.x()) + 18 * pen.scale, static_cast<float>(s.mouse.y()) + 14 * pen.scale},
        pen.colours.text, text);
}

/// The coordinates of the plane along the left and the lower edge, and the axes through its origin, while a
/// planar scene is seen from straight above.
void drawRulers(const Pen& pen, Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (!s.rulers || !s.session->model().planar) return;
  const auto pixelOf = [&](double x, double y) { return s.toWindow(Vector3d(x, y, 0.0)).pixel; };
  const Eigen::Vector2d origin = pixelOf(0, 0), alongX = pixelOf(1, 0) - origin,
                        alongY = pixelOf(0, 1) - origin;
  const double perUnit = alongX.x();
  if (perUnit <= 0.0 || std::abs(alongX.y()) > 1e-3 * perUnit || std::abs(alongY.x()) > 1e-3 * perUnit)
    return;
  const Layout::Rect& view = s.layout.view;
  const float low = view.y + view.height, tick = 5 * pen.scale, margin = 3 * pen.scale;
  const ImU32 ink = colour32(pen.colours.textDim, 0.9f), faint = colour32(pen.colours.textDim, 0.35f);
  const float x0 = static_cast<float>(origin.x()), y0 = static_cast<float>(origin.y());
  pen.draw->AddLine({view.x, y0}, {view.x + view.width, y0}, faint, pen.scale);
  pen.draw->AddLine({x0, view.y}, {x0, low}, faint, pen.scale);
  const double step = niceStep(80.0 * pen.scale / perUnit);
  ImFont* font = pen.fonts.small;
  const auto number = [&](double value) {
    return fmt::format("{:g}", std::abs(value) < 0.01 * step ? 0.0 : value);
  };
  const double left = (view.x - origin.x()) / perUnit, right = (view.x + view.width - origin.x()) / perUnit;
  for (double i = std::ceil(left / step); i <= right / step; ++i) {
    const float x = static_cast<float>(origin.x() + i * step * perUnit);
    const std::string text = number(i * step);
    const ImVec2 size = font->CalcTextSizeA(font->FontSize, 1e9f, 0.0f, text.c_str());
    pen.draw->AddLine({x, low}, {x, low - tick}, ink, pen.scale);
    const ImVec2 at{x - 0.5f * size.x, low - tick - margin - size.y};
    if (at.x < view.x + 40 * pen.scale) continue;  // the corner belongs to the other ruler
    pen.draw->AddText(font, font->FontSize, at, ink, text.c_str());
    pen.places->take({at.x, at.y, size.x, size.y});
  }
  const double bottom = (origin.y() - low) / perUnit, top = (origin.y() - view.y) / perUnit;
  for (double i = std::ceil(bottom / step); i <= top / step; ++i) {
    const float y = static_cast<float>(origin.y() - i * step * perUnit);
    const std::string text = number(i * step);
    const ImVec2 size = font->CalcTextSizeA(font->FontSize, 1e9f, 0.0f, text.c_str());
    pen.draw->AddLine({view.x, y}, {view.x + tick, y}, ink, pen.scale);
    const ImVec2 at{view.x + tick + margin, y - 0.5f * size.y};
    if (at.y + size.y > low - tick) continue;
    pen.draw->AddText(font, font->FontSize, at, ink, text.c_str());
    pen.places->take({at.x, at.y, size.x, size.y});
  }
}

void drawNotices(const Pen& pen, Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  std::erase_if(s.notices, [&](const Notice& notice) { return notice.until <= s.time; });
  float y = s.layout.view.y + s.layout.view.height - 14 * pen.scale;
  for (auto it = s.notices.rbegin(); it != s.notices.rend(); ++it) {
    const float alpha = static_cast<float>(std::clamp((it->until - s.time) / noticeFade, 0.0, 1.0));
    const float width = std::min(s.layout.view.width - 40 * pen.scale, 760 * pen.scale);
    ImFont* font = pen.fonts.regular;
    const ImVec2 size = font->CalcTextSizeA(font->FontSize, 1e9f, width, it->words.c_str());
    const float x = s.layout.view.x + 0.5f * (s.layout.view.width - size.x);
    y -= size.y + 14 * pen.scale;
    const ImVec4& ink = it->isError ? pen.colours.bad : pen.colours.text;
    pen.draw->AddRectFilled({x - 14 * pen.scale, y - 7 * pen.scale},
                            {x + size.x + 14 * pen.scale, y + size.y + 7 * pen.scale},
                            colour32(pen.colours.panelRaised, 0.95f * alpha), 7 * pen.scale);
    pen.draw->AddRect({x - 14 * pen.scale, y - 7 * pen.scale},
                      {x + size.x + 14 * pen.scale, y + size.y + 7 * pen.scale},
                      colour32(it->isError ? pen.colours.bad : pen.colours.border, alpha), 7 * pen.scale);
    pen.draw->AddText(font, font->FontSize, {x, y}, colour32(ink, alpha), it->words.c_str(), nullptr, width);
    y -= 8 * pen.scale;
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
  LabelPlaces places({view.x + 2, view.y + 2, view.width - 4, view.height - 4});
  const Pen pen{draw, s.colours(), s.gui.fonts(), s.scale, &places};
  draw->AddImage(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(s.picture.texture())),
                 {view.x, view.y}, {view.x + view.width, view.y + view.height}, {0, 1}, {1, 0});
  draw->PushClipRect({view.x, view.y}, {view.x + view.width, view.y + view.height}, true);
  drawRulers(pen, sandbox);
  for (const auto& label : s.labels) {
    const Projected p = s.toWindow(label.at);
    if (p.depth > 0.0)
      words(
          pen,
          {static_cast<float>(p.pixel.x()) + 8 * pen.scale, static_cast<float>(p.pixel.y()) - 8 * pen.scale},
          {label.colour.x(), label.colour.y(), label.colour.z(), label.colour.w()}, label.text, true);
  }
  drawConstraint(pen, sandbox);
  if (s.show().handles && (!s.shownFrames || s.handlesOnShown))
    for (const SceneGoal& goal : s.session->goals())
      if (isGoalShown(sandbox.session(), goal)) nameGoal(pen, sandbox, goal);
  drawGizmo(sandbox.state(), *draw);
  nameGesture(pen, sandbox);
  drawHover(pen, sandbox);
  drawNotices(pen, sandbox);
  draw->PopClipRect();
}

}  // namespace gelenk
