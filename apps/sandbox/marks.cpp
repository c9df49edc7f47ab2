#include <algorithm>
#include <cmath>

#include "apps/render/signs.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/configuration.h"
#include "kinematics/rotation.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Colour toColour(const ImVec4& c, float alpha = 1.0f) { return {c.x, c.y, c.z, alpha}; }
ImVec2 toImVec2(const Eigen::Vector2d& p) { return {static_cast<float>(p.x()), static_cast<float>(p.y())}; }

/// worldFromZero of the joint's motion after its first `axes` axes.
Isometry3d worldFromMotion(const Skeleton& skeleton, const Eigen::VectorXd& q, const Frames& frames,
                           int joint, int axes) {
  const Joint& j = skeleton.joint(joint);
  Isometry3d T = (j.parent < 0 ? Isometry3d::Identity() : frames[j.parent]) * j.parentFromZero;
  for (int k = 0; k < axes; ++k) {
    const double value = q[skeleton.qIndex(joint) + k];
    if (j.axes[k].kind == AxisDof::Kind::Rotation)
      T.rotate(Eigen::AngleAxisd(value, j.axes[k].axis));
    else
      T.translate(value * j.axes[k].axis);
  }
  return T;
}

double boneLength(const Skeleton& skeleton, int joint) {
  double length = 0.0;
  for (const int child : skeleton.children(joint))
    length = std::max(length, skeleton.joint(child).parentFromZero.translation().norm());
  return length;
}

/// The boundary of the swing as a cone around the joint.
void addCone(Overlay& overlay, const Isometry3d& worldFromZero, const BallLimit& limit, double radius,
             const Colour& line, const Colour& fill) {
  std::vector<Vector3d> rim;
  for (int i = 0; i < 48; ++i) {
    const double t = 2.0 * M_PI * i / 48;
    Vector3d c(limit.swingCentre.x() + limit.swingRadii.x() * std::cos(t),
               limit.swingCentre.y() + limit.swingRadii.y() * std::sin(t), 0.0);
    if (c.head<2>().norm() > 1.99) c.head<2>() *= 1.99 / c.head<2>().norm();
    rim.push_back(worldFromZero * (radius * (fromSwingTwistCoordinates(c) * Vector3d::UnitZ())));
  }
  overlay.fan(worldFromZero.translation(), rim, fill);
  overlay.polyline(rim, line, 2.0f, true);
}

/// The range of a rotation axis as a sector, the present angle as a line.
void addArc(Overlay& overlay, const Isometry3d& worldFromAxis, const AxisDof& axis, double value,
            const Vector3d& bone, double radius, const Colour& line, const Colour& fill) {
  Vector3d zero = bone - axis.axis * axis.axis.dot(bone);
  if (zero.norm() < 1e-9) zero = axis.axis.unitOrthogonal();
  zero = radius * zero.normalized();
  const double low = std::max(axis.lower, value - 2.0 * M_PI),
               high = std::min(axis.upper, value + 2.0 * M_PI);
  std::vector<Vector3d> rim;
  for (int i = 0; i <= 32; ++i)
    rim.push_back(worldFromAxis * (Eigen::AngleAxisd(low + (high - low) * i / 32, axis.axis) * zero));
  overlay.fan(worldFromAxis.translation(), rim, fill, false);
  overlay.polyline(rim, line, 2.0f);
  overlay.line(worldFromAxis.translation(), worldFromAxis * (Eigen::AngleAxisd(value, axis.axis) * zero),
               line, 2.0f);
}

void addLimit(Sandbox& sandbox, int joint, float glow) {
  Sandbox::State& s = sandbox.state();
  const Skeleton& skeleton = s.session->skeleton();
  const Joint& j = skeleton.joint(joint);
  const Eigen::VectorXd& q = s.session->q();
  const Colour line = toColour(s.colours().bad, 0.9f * glow), fill = toColour(s.colours().bad, 0.16f * glow);
  const double bone = std::max(boneLength(skeleton, joint), 0.04 * s.size);
  const double radius = std::clamp(0.5 * bone, 0.03 * s.size, 0.12 * s.size);
  const Vector3d alongBone =
      skeleton.children(joint).empty()
          ? Vector3d(Vector3d::UnitZ())
          : skeleton.joint(skeleton.children(joint).front()).parentFromZero.translation();
  for (int k = 0; k < static_cast<int>(j.axes.size()); ++k) {
    const AxisDof& axis = j.axes[k];
    const double value = q[skeleton.qIndex(joint) + k];
    const bool at =
        value <= axis.lower + 2.0 * Session::limitMargin || value >= axis.upper - 2.0 * Session::limitMargin;
    if (axis.kind == AxisDof::Kind::Rotation && at && std::isfinite(axis.upper - axis.lower))
      addArc(sandbox.overlay(), worldFromMotion(skeleton, q, sandbox.shownFrames(), joint, k), axis, value,
             alongBone, radius, line, fill);
  }
  if (j.ballLimit)
    addCone(sandbox.overlay(),
            worldFromMotion(skeleton, q, sandbox.shownFrames(), joint, static_cast<int>(j.axes.size())),
            *j.ballLimit, radius, line, fill);
}

/// Limits light up where the drag presses against them, and fade within a second.
void addLimits(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  const std::vector<bool> at = s.session->jointsAtLimit();
  const std::optional<GoalId> dragged = s.session->dragged();
  for (int i = 0; i < static_cast<int>(at.size()); ++i) {
    const bool pressed =
        at[i] && dragged && s.session->skeleton().isAncestor(i, s.session->goal(*dragged).goal.joint);
    const bool examined = at[i] && s.selectedJoint() == i && !dragged;
    double& glow = s.limitGlow[i];
    glow = pressed || examined ? 1.0 : std::max(0.0, glow - ImGui::GetIO().DeltaTime / 0.9);
    if (glow > 0.0 && s.show().limits) addLimit(sandbox, i, static_cast<float>(glow));
  }
}

// --- drawn with Dear ImGui over the picture: crisp at every scale

struct Pen {
  ImDrawList* draw;
  const Palette& colours;
  const Fonts& fonts;
  float scale;
};

void words(const Pen& pen, ImVec2 at, const ImVec4& colour, const std::string& text) {
  ImFont* font = pen.fonts.small;
  const ImVec2 size = font->CalcTextSizeA(font->FontSize, 1e9f, 0.0f, text.c_str());
  pen.draw->AddRectFilled({at.x - 5 * pen.scale, at.y - 2 * pen.scale},
                          {at.x + size.x + 5 * pen.scale, at.y + size.y + 2 * pen.scale},
                          colour32(pen.colours.panelRaised, 0.82f), 4 * pen.scale);
  pen.draw->AddText(font, font->FontSize, at, colour32(colour), text.c_str());
}

const ImVec4& stateColour(const Palette& colours, const SceneGoal& goal) {
  if (goal.state == GoalState::Pinned) return colours.pinned;
  if (goalType(goal.goal.kind).preference < 1.0) return colours.pole;
  return goal.state == GoalState::Free ? colours.free : colours.held;
}

void drawLine(const Pen& pen, Sandbox::State& s, const Vector3d& from, const Vector3d& to, ImU32 ink) {
  const Projected a = s.toWindow(from), b = s.toWindow(to);
  if (a.depth > 0.0 && b.depth > 0.0)
    pen.draw->AddLine(toImVec2(a.pixel), toImVec2(b.pixel), ink, 1.4f * pen.scale);
}

/// What the goal's type says it looks like. Faint lines where it is looked at alone.
void drawMark(const Pen& pen, Sandbox& sandbox, const GoalMark& mark, const ImVec4& colour, bool looked) {
  Sandbox::State& s = sandbox.state();
  for (const GoalMark::Polygon& polygon : mark.polygons) {
    std::vector<ImVec2> corners;
    for (const Vector3d& corner : polygon.corners)
      if (const Projected p = s.toWindow(corner); p.depth > 0.0) corners.push_back(toImVec2(p.pixel));
    if (corners.size() < polygon.corners.size()) continue;
    const int count = static_cast<int>(corners.size());
    if (polygon.filled) pen.draw->AddConvexPolyFilled(corners.data(), count, colour32(colour, 0.16f));
    pen.draw->AddPolyline(corners.data(), count, colour32(colour, 0.75f), ImDrawFlags_Closed,
                          1.4f * pen.scale);
  }
  for (const GoalMark::Ring& ring : mark.rings) {
    constexpr int sides = 48;
    const Vector3d x = ring.radius * ring.normal.unitOrthogonal(), y = ring.normal.normalized().cross(x);
    for (int k = 0; k < sides; ++k) {
      const double a = 2.0 * M_PI * k / sides, b = 2.0 * M_PI * (k + 1) / sides;
      drawLine(pen, s, ring.centre + std::cos(a) * x + std::sin(a) * y,
               ring.centre + std::cos(b) * x + std::sin(b) * y, colour32(colour, 0.7f));
    }
  }
  for (const GoalMark::Segment& segment : mark.segments)
    if (looked || segment.stress == GoalMark::Stress::Main)
      drawLine(pen, s, segment.from, segment.to,
               colour32(colour, segment.stress == GoalMark::Stress::Main ? 0.6f : 0.45f));
}

void drawGoal(const Pen& pen, Sandbox& sandbox, const SceneGoal& goal) {
  Sandbox::State& s = sandbox.state();
  const Vector3d reached = s.session->reached(goal.id);
  const Projected p = s.toWindow(reached);
  if (p.depth <= 0.0) return;
  const bool hovered = s.hover.kind == Hover::Kind::Goal && s.hover.goal == goal.id;
  const bool dragged = s.session->dragged() == goal.id, selected = s.selectedGoal == goal.id;
  const bool active = goal.state != GoalState::Free;
  const ImVec4& colour = stateColour(pen.colours, goal);
  const ImVec2 at = toImVec2(p.pixel);

  const GoalType& type = goalType(goal.goal.kind);
  const bool wish = type.preference < 1.0;
  if (active || wish)
    drawMark(pen, sandbox, s.session->mark(goal.id), colour, hovered || dragged || selected);
  const double error = s.session->error(goal.id);
  if (active && !wish && type.movesWithPose && error > 2e-4 * s.size) {
    const Projected t = s.toWindow(goal.goal.target);
    const ImVec4 line = distanceColour(pen.colours, error / std::max(s.size, 1e-9) * 2.0);
    const ImVec2 end = toImVec2(t.pixel);
    pen.draw->AddLine(at, end, colour32(line), 1.6f * pen.scale);
    pen.draw->AddCircle(end, 4.5f * pen.scale, colour32(line), 0, 1.6f * pen.scale);
    if (std::hypot(end.x - at.x, end.y - at.y) > 26 * pen.scale)
      words(pen, {0.5f * (at.x + end.x) + 9 * pen.scale, 0.5f * (at.y + end.y) - 9 * pen.scale}, line,
            formatLength(error));
  }
  if (dragged) pen.draw->AddCircleFilled(at, 15 * pen.scale, colour32(colour, 0.22f), 32);
  const float grow = hovered || dragged ? 1.35f : 1.0f, r = (wish ? 5.0f : 6.5f) * grow * pen.scale;
  const ImU32 white = IM_COL32(255, 255, 255, 240), ink = colour32(colour);
  if (goal.state == GoalState::Pinned) {
    pen.draw->AddRectFilled({at.x - r, at.y - r}, {at.x + r, at.y + r}, white, 2 * pen.scale);
    pen.draw->AddRectFilled({at.x - r + 1.6f * pen.scale, at.y - r + 1.6f * pen.scale},
                            {at.x + r - 1.6f * pen.scale, at.y + r - 1.6f * pen.scale}, ink, 2 * pen.scale);
  } else if (wish) {
    pen.draw->AddQuadFilled({at.x, at.y - r - pen.scale}, {at.x + r + pen.scale, at.y},
                            {at.x, at.y + r + pen.scale}, {at.x - r - pen.scale, at.y}, white);
    const float q = r - 1.2f * pen.scale;
    pen.draw->AddQuadFilled({at.x, at.y - q}, {at.x + q, at.y}, {at.x, at.y + q}, {at.x - q, at.y}, ink);
  } else {
    pen.draw->AddCircleFilled(at, r + 1.2f * pen.scale, active ? white : ink, 32);
    pen.draw->AddCircleFilled(at, r - (active ? 0.8f : 1.0f) * pen.scale, active ? ink : white, 32);
  }
  if (goal.goal.kind == GoalKind::Pose || goal.goal.kind == GoalKind::Orientation) {
    pen.draw->AddCircle(at, r + 5 * pen.scale, colour32(colour, 0.9f), 40, 1.6f * pen.scale);
  }
  if (selected && !dragged)
    pen.draw->AddCircle(at, r + 4 * pen.scale, colour32(pen.colours.accent), 40, 1.8f * pen.scale);
  if (hovered) words(pen, {at.x + 16 * pen.scale, at.y - 8 * pen.scale}, pen.colours.text, goal.goal.name);
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
    const Vector3d u = 0.6 * s.size * Vector3d::Unit(axis);
    pen.draw->AddLine(toImVec2(s.toWindow(target - u).pixel), toImVec2(s.toWindow(target + u).pixel),
                      colour32(axisColours[axis], 0.8f), 1.4f * pen.scale);
  }
}

void drawNotices(const Pen& pen, Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  std::erase_if(s.notices, [&](const Notice& notice) { return notice.until <= s.time; });
  float y = s.layout.view.y + s.layout.view.height - 14 * pen.scale;
  for (auto it = s.notices.rbegin(); it != s.notices.rend(); ++it) {
    const float alpha = static_cast<float>(std::clamp((it->until - s.time) / 0.5, 0.0, 1.0));
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

/// What the end of a planar chain can reach when its joints turn freely: the ring between the shortest and
/// the longest reach.
void addWorkspace(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  const Skeleton& skeleton = s.session->skeleton();
  if (s.session->goals().empty()) return;
  double sum = 0.0, longest = 0.0;
  int base = -1;
  for (int j = s.session->goals().front().goal.joint; j >= 0; j = skeleton.parent(j)) {
    if (skeleton.joint(j).ball || skeleton.vCount(j) > 1) return;
    if (skeleton.vCount(j) == 1) base = j;
    bool moves = false;  // a joint above that turns carries this offset round
    for (int a = skeleton.parent(j); a >= 0; a = skeleton.parent(a)) {
      if (skeleton.vCount(a) == 1 && skeleton.joint(a).axes[0].kind != AxisDof::Kind::Rotation) return;
      moves = moves || skeleton.vCount(a) == 1;
    }
    if (!moves) continue;
    const double length = skeleton.joint(j).parentFromZero.translation().norm();
    sum += length;
    longest = std::max(longest, length);
  }
  if (base < 0 || sum <= 0.0) return;
  const Vector3d centre = sandbox.shownFrames()[base].translation();
  const double inner = std::max(0.0, 2.0 * longest - sum);
  const Colour fill = toColour(s.colours().accent, 0.07f), line = toColour(s.colours().accent, 0.45f);
  sandbox.overlayInScene().annulus(centre, Vector3d::UnitX(), Vector3d::UnitY(), inner, sum, fill);
  sandbox.overlayInScene().arc(centre, Vector3d::UnitX(), Vector3d::UnitY(), sum, line);
  if (inner > 0.0) sandbox.overlayInScene().arc(centre, Vector3d::UnitX(), Vector3d::UnitY(), inner, line);
}

}  // namespace

void addSceneMarks(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (s.show().skeleton || !s.mesh)
    addBones(sandbox.overlay(), s.session->skeleton(), sandbox.shownFrames(), s.size, boneColour,
             s.selectedJoint().value_or(-1));
  if (s.session->model().planar) addWorkspace(sandbox);
  if (s.show().jointFrames) {
    addJointFrames(sandbox.overlay(), sandbox.shownFrames(), s.size);
    if (!s.shownFrames && s.session->skeleton().jointCount() <= 12)
      addJointAxes(sandbox.overlay(), s.session->skeleton(), s.session->q(), sandbox.shownFrames(), s.size,
                   toColour(s.colours().textDim));
  }
  if (!s.shownFrames) addLimits(sandbox);
}

void drawMarks(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  const Layout::Rect& view = s.layout.view;
  ImDrawList* draw = ImGui::GetBackgroundDrawList();
  const Pen pen{draw, s.colours(), s.gui.fonts(), s.scale};
  draw->AddImage(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(s.picture.texture())),
                 {view.x, view.y}, {view.x + view.width, view.y + view.height}, {0, 1}, {1, 0});
  draw->PushClipRect({view.x, view.y}, {view.x + view.width, view.y + view.height}, true);
  for (const auto& label : s.labels) {
    const Projected p = s.toWindow(label.at);
    if (p.depth > 0.0)
      words(
          pen,
          {static_cast<float>(p.pixel.x()) + 8 * pen.scale, static_cast<float>(p.pixel.y()) - 8 * pen.scale},
          {label.colour.x(), label.colour.y(), label.colour.z(), label.colour.w()}, label.text);
  }
  drawConstraint(pen, sandbox);
  if (const auto balance = s.session->balanceGoal(); balance && s.show().handles && !s.shownFrames) {
    GoalMark mark;
    goalType(balance->kind)
        .mark(*balance, {s.session->skeleton(), s.session->q(), s.session->frames()}, mark);
    drawMark(pen, sandbox, mark, pen.colours.pinned, false);
  }
  if (s.show().handles && (!s.shownFrames || s.handlesOnShown))
    for (const SceneGoal& goal : s.session->goals())
      if (isGoalShown(sandbox, goal)) drawGoal(pen, sandbox, goal);
  drawHover(pen, sandbox);
  drawNotices(pen, sandbox);
  draw->PopClipRect();
}

}  // namespace gelenk
