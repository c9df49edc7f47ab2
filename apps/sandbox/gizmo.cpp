#include "apps/sandbox/gizmo.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "solvers/problem/goal_type.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double arrowPixels = 84.0, ringShare = 0.72, reach = 6.0;  // pixels at scale 1; share of an arrow
constexpr double freeRadius = 16.0;  // about the middle, where the handle itself is taken

double distanceToSegment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d d = b - a;
  const double t = d.squaredNorm() > 0.0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0.0;
  return (a + t * d - p).norm();
}

/// The ring's half that faces the viewer, window pixels.
std::vector<Vector2d> ringPixels(const Sandbox::State& s, const GizmoPlace& place, int axis) {
  const Vector3d u = Vector3d::Unit((axis + 1) % 3), v = Vector3d::Unit((axis + 2) % 3);
  const Vector3d towards = s.camera().axes().col(2);
  std::vector<Vector2d> pixels;
  constexpr int steps = 64;
  // Begin where the near half begins, so that it is one line.
  const double a = u.dot(towards), b = v.dot(towards);
  const bool whole = std::hypot(a, b) < 0.25;  // seen from the front: all of it
  const double middle = std::atan2(b, a), span = whole ? 2.0 * M_PI : M_PI;
  for (int i = 0; i <= steps; ++i) {
    const double t = middle - 0.5 * span + span * i / steps;
    pixels.push_back(
        s.toWindow(place.at + ringShare * place.size * (std::cos(t) * u + std::sin(t) * v)).pixel);
  }
  return pixels;
}

ImU32 axisColour(int axis, bool bright) {
  static const ImVec4 colours[] = {
      {0.82f, 0.22f, 0.20f, 1}, {0.20f, 0.60f, 0.25f, 1}, {0.20f, 0.42f, 0.85f, 1}};
  return bright ? IM_COL32(255, 176, 0, 255) : colour32(colours[axis], 0.92f);
}

ImVec2 toImVec2(const Vector2d& p) { return {static_cast<float>(p.x()), static_cast<float>(p.y())}; }

}  // namespace

std::optional<GizmoPlace> gizmoOf(const Sandbox::State& s) {
  const auto selected = s.goalSelected();
  if (!selected || !s.show().handles || (s.shownFrames && !s.handlesOnShown)) return std::nullopt;
  const bool own = s.gesture.kind == Gesture::Kind::Drag && s.gesture.part.has_value();
  if (s.session->dragged() && !own) return std::nullopt;
  const SceneGoal& goal = s.session->goal(*selected);
  if (!isGoalShown(*s.session, goal)) return std::nullopt;
  GizmoPlace place{.goal = *selected, .at = s.session->reached(*selected)};
  bool target = false, rotation = goal.goal.kind == GoalKind::Position;
  for (const GoalField& field : goalType(goal.goal.kind).fields) {
    target = target || field.meaning == GoalField::Meaning::Target;
    rotation = rotation || field.meaning == GoalField::Meaning::Rotation;
  }
  if (!target && !rotation) return std::nullopt;
  const bool planar = s.session->model().planar;
  for (int axis = 0; axis < 3; ++axis) {
    place.arrows[axis] = target && !(planar && axis == 2);
    place.rings[axis] = rotation && !planar && goal.surface.triangle < 0;
  }
  if (s.toWindow(place.at).depth <= 0.0) return std::nullopt;
  place.size = arrowPixels * s.viewScale() * pixelSize(s.camera(), s.viewport(), place.at);
  return place;
}

std::optional<GizmoPart> gizmoPartAt(const Sandbox::State& s, const GizmoPlace& place,
                                     const Vector2d& pixel) {
  const Vector2d middle = s.toWindow(place.at).pixel;
  if ((pixel - middle).norm() < freeRadius * s.viewScale()) return std::nullopt;
  std::optional<GizmoPart> best;
  double nearest = reach * s.viewScale();
  const auto consider = [&](double distance, GizmoPart part) {
    if (distance < nearest) best = part, nearest = distance;
  };
  for (int axis = 0; axis < 3; ++axis) {
    if (place.arrows[axis]) {
      const Vector2d tip = s.toWindow(place.at + place.size * Vector3d::Unit(axis)).pixel;
      if ((tip - middle).norm() > freeRadius * s.viewScale())  // else it points at the viewer
        consider(distanceToSegment(pixel, middle, tip), {GizmoPart::Kind::Arrow, axis});
    }
    if (place.rings[axis]) {
      const std::vector<Vector2d> ring = ringPixels(s, place, axis);
      for (std::size_t i = 0; i + 1 < ring.size(); ++i)
        consider(distanceToSegment(pixel, ring[i], ring[i + 1]), {GizmoPart::Kind::Ring, axis});
    }
  }
  return best;
}

std::optional<double> angleAbout(const Sandbox::State& s, const Vector3d& at, int axis,
                                 const Vector2d& pixel) {
  const Ray ray = rayThroughPixel(s.camera(), s.viewport(), s.toView(pixel));
  const Vector3d n = Vector3d::Unit(axis);
  const double facing = ray.direction.dot(n);
  if (std::abs(facing) < 0.12) return std::nullopt;
  const Vector3d p = ray.at((at - ray.origin).dot(n) / facing) - at;
  const double u = p[(axis + 1) % 3], v = p[(axis + 2) % 3];
  if (std::hypot(u, v) < 1e-12) return std::nullopt;
  return std::atan2(v, u);
}

void drawGizmo(const Sandbox::State& s, ImDrawList& draw) {
  const std::optional<GizmoPlace> place = gizmoOf(s);
  if (!place) return;
  const std::optional<GizmoPart> lit = s.gesture.part         ? s.gesture.part
                                       : s.session->dragged() ? std::nullopt
                                                              : gizmoPartAt(s, *place, s.mouse);
  const Vector2d middle = s.toWindow(place->at).pixel;
  for (int axis = 0; axis < 3; ++axis) {
    const auto width = [&](GizmoPart part) { return (lit == part ? 3.2f : 2.0f) * s.viewScale(); };
    if (const GizmoPart part{GizmoPart::Kind::Ring, axis}; place->rings[axis]) {
      std::vector<ImVec2> points;
      for (const Vector2d& p : ringPixels(s, *place, axis)) points.push_back(toImVec2(p));
      draw.AddPolyline(points.data(), static_cast<int>(points.size()), axisColour(axis, lit == part), 0,
                       width(part));
    }
    if (const GizmoPart part{GizmoPart::Kind::Arrow, axis}; place->arrows[axis]) {
      const Vector2d tip = s.toWindow(place->at + place->size * Vector3d::Unit(axis)).pixel;
      const double length = (tip - middle).norm();
      if (length <= freeRadius * s.viewScale()) continue;
      const Vector2d way = (tip - middle) / length, across(-way.y(), way.x());
      const ImU32 colour = axisColour(axis, lit == part);
      const double head = 11.0 * s.viewScale();
      draw.AddLine(toImVec2(middle + freeRadius * s.viewScale() * way), toImVec2(tip - 0.8 * head * way),
                   colour, width(part));
      draw.AddTriangleFilled(toImVec2(tip), toImVec2(tip - head * way + 0.45 * head * across),
                             toImVec2(tip - head * way - 0.45 * head * across), colour);
    }
  }
}

void keepGizmoFree(const Sandbox::State& s, LabelPlaces& places) {
  const std::optional<GizmoPlace> place = gizmoOf(s);
  const auto keep = [&](const Vector2d& at) {
    places.takeAround(static_cast<float>(at.x()), static_cast<float>(at.y()), 6 * s.viewScale());
  };
  for (int axis = 0; place && axis < 3; ++axis) {
    for (int step = 1; place->arrows[axis] && step <= 8; ++step)
      keep(s.toWindow(place->at + step / 8.0 * place->size * Vector3d::Unit(axis)).pixel);
    if (!place->rings[axis]) continue;
    const std::vector<Vector2d> ring = ringPixels(s, *place, axis);
    for (std::size_t i = 0; i < ring.size(); i += 4) keep(ring[i]);  // nearer than a line of words is high
  }
}

}  // namespace gelenk
