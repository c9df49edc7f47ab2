#include "apps/render/overlay.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gelenk {

using Eigen::Vector3d;

namespace {

Overlay::Vertex vertex(const Vector3d& p, const Colour& colour) {
  return {{static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())}, colour};
}

Colour shaded(const Colour& colour, const Vector3d& normal) {
  static const Vector3d light = Vector3d(-0.35, 0.75, 0.55).normalized();
  const auto brightness = static_cast<float>(0.80 + 0.28 * normal.dot(light));
  const auto scale = [brightness](float c) { return std::clamp(c * brightness, 0.0f, 1.0f); };
  return {scale(colour.r), scale(colour.g), scale(colour.b), colour.a};
}

/// Points on an arc, both ends included, one every 3 degrees at most.
std::vector<Vector3d> arcPoints(const Vector3d& centre, const Vector3d& u, const Vector3d& v, double radius,
                                double from, double to) {
  const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(to - from) / (std::numbers::pi / 60.0))));
  std::vector<Vector3d> points(steps + 1);
  for (int i = 0; i <= steps; ++i) {
    const double angle = from + (to - from) * i / steps;
    points[i] = centre + radius * (std::cos(angle) * u + std::sin(angle) * v);
  }
  return points;
}

}  // namespace

void Overlay::line(const Vector3d& a, const Vector3d& b, const Colour& colour, float width) {
  lines.push_back({vertex(a, colour), vertex(b, colour), width});
}

void Overlay::polyline(const std::vector<Vector3d>& points, const Colour& colour, float width, bool closed) {
  const std::size_t first = lines.size();
  for (std::size_t i = 1; i < points.size(); ++i) line(points[i - 1], points[i], colour, width);
  const bool ring = points.size() > 2 && (closed || (points.front() - points.back()).norm() <
                                                        1e-6 * (points[1] - points[0]).norm());
  if (closed && points.size() > 2) line(points.back(), points.front(), colour, width);
  if (colour.a >= opaqueFrom) return;
  const auto along = [](const Line& l) {
    return (Eigen::Map<const Eigen::Vector3f>(l.b.position) - Eigen::Map<const Eigen::Vector3f>(l.a.position))
        .stableNormalized();
  };
  for (std::size_t i = first; i < lines.size(); ++i) {
    const bool last = i + 1 == lines.size();
    if (last && !ring) break;
    Line &before = lines[i], &after = lines[last ? first : i + 1];
    if (along(before).dot(along(after)) < 0.9f) continue;
    before.flatEnds += 2.0f;
    after.flatEnds += 1.0f;
  }
}

void Overlay::dashedLine(const Vector3d& a, const Vector3d& b, double dash, const Colour& colour,
                         float width) {
  constexpr int mostDashes = 1000;
  const double length = (b - a).norm();
  if (!(dash > 0.0) || length <= dash || length > 2.0 * dash * mostDashes) return line(a, b, colour, width);
  const Vector3d direction = (b - a) / length;
  for (double at = 0.0; at < length; at += 2.0 * dash)
    line(a + at * direction, a + std::min(at + dash, length) * direction, colour, width);
}

void Overlay::point(const Vector3d& at, const Colour& colour, float diameter, Shape shape) {
  points.push_back({vertex(at, colour), diameter, static_cast<float>(shape)});
}

void Overlay::triangle(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Colour& colour) {
  for (const Vector3d* corner : {&a, &b, &c}) fills.push_back(vertex(*corner, colour));
}

void Overlay::fan(const Vector3d& apex, const std::vector<Vector3d>& rim, const Colour& colour, bool closed) {
  for (std::size_t i = 1; i < rim.size(); ++i) triangle(apex, rim[i - 1], rim[i], colour);
  if (closed && rim.size() > 2) triangle(apex, rim.back(), rim.front(), colour);
}

void Overlay::bone(const Vector3d& from, const Vector3d& to, double thickness, const Colour& colour) {
  const Vector3d along = to - from;
  if (along.norm() < 1e-12) return;
  const Vector3d x = along.unitOrthogonal(), y = along.normalized().cross(x);
  const Vector3d waist = from + 0.15 * along;
  const Vector3d corners[4] = {waist + thickness * x, waist + thickness * y, waist - thickness * x,
                               waist - thickness * y};
  for (int i = 0; i < 4; ++i) {
    const Vector3d &a = corners[i], &b = corners[(i + 1) % 4];
    triangle(from, b, a, shaded(colour, (b - from).cross(a - from).normalized()));
    triangle(to, a, b, shaded(colour, (a - to).cross(b - to).normalized()));
  }
}

void Overlay::axes(const Eigen::Isometry3d& worldFromFrame, double length, float width) {
  const Colour colours[3] = {{0.86f, 0.25f, 0.26f}, {0.30f, 0.66f, 0.25f}, {0.20f, 0.43f, 0.86f}};
  const Vector3d origin = worldFromFrame.translation();
  for (int k = 0; k < 3; ++k)
    line(origin, origin + length * worldFromFrame.linear().col(k), colours[k], width);
}

void Overlay::annulus(const Vector3d& centre, const Vector3d& u, const Vector3d& v, double inner,
                      double outer, const Colour& colour, double fromAngle, double toAngle) {
  const auto out = arcPoints(centre, u, v, outer, fromAngle, toAngle);
  if (!(inner > 0.0)) return fan(centre, out, colour, false);
  const auto in = arcPoints(centre, u, v, inner, fromAngle, toAngle);
  for (std::size_t i = 1; i < out.size(); ++i) {
    triangle(in[i - 1], out[i - 1], out[i], colour);
    triangle(in[i - 1], out[i], in[i], colour);
  }
}

void Overlay::arc(const Vector3d& centre, const Vector3d& u, const Vector3d& v, double radius,
                  const Colour& colour, float width, double fromAngle, double toAngle) {
  polyline(arcPoints(centre, u, v, radius, fromAngle, toAngle), colour, width);
}

void Overlay::clear() {
  fills.clear();
  lines.clear();
  points.clear();
}

}  // namespace gelenk
