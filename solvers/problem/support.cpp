#include "solvers/problem/support.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gelenk {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Two unit vectors across up, right-handed with it.
struct Across {
  Vector3d x, y;
  explicit Across(const Vector3d& up) : x(up.unitOrthogonal()), y(up.cross(x)) {}
  Vector2d operator()(const Vector3d& p) const { return {x.dot(p), y.dot(p)}; }
};

}  // namespace

/// Andrew's monotone chain.
SupportPolygon SupportPolygon::hull(const std::vector<Vector3d>& points, const Vector3d& up) {
  const Across across(up);
  std::vector<Vector3d> sorted = points;
  std::ranges::sort(sorted, [&](const Vector3d& a, const Vector3d& b) {
    const Vector2d p = across(a), q = across(b);
    return p.x() < q.x() || (p.x() == q.x() && p.y() < q.y());
  });
  std::vector<Vector3d> chain;
  const auto add = [&](const Vector3d& p, std::size_t least) {
    while (chain.size() >= least + 2 && cross(across(chain.back()) - across(chain[chain.size() - 2]),
                                              across(p) - across(chain.back())) <= 0.0)
      chain.pop_back();
    chain.push_back(p);
  };
  for (const Vector3d& p : sorted) add(p, 0);
  if (chain.size() > 1) {
    chain.pop_back();
    const std::size_t lower = chain.size();
    for (auto p = sorted.rbegin(); p != sorted.rend(); ++p) add(*p, lower);
    chain.pop_back();
  }
  return {std::move(chain), up};
}

SupportPolygon SupportPolygon::inset(double margin) const {
  if (!(margin > 0.0) || corners.size() < 3) return *this;
  // Cut by every edge's line moved inwards (Sutherland, Hodgman 1974).
  std::vector<Vector3d> rest = corners;
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& c : corners) middle += c / static_cast<double>(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector3d& a = corners[i];
    const Vector3d outward = (corners[(i + 1) % corners.size()] - a).cross(up).normalized();
    const double line = outward.dot(a) - margin;
    std::vector<Vector3d> kept;
    for (std::size_t k = 0; k < rest.size(); ++k) {
      const Vector3d &p = rest[k], &q = rest[(k + 1) % rest.size()];
      const double dp = outward.dot(p) - line, dq = outward.dot(q) - line;
      if (dp <= 0.0) kept.push_back(p);
      if (dp * dq < 0.0) kept.push_back(p + dp / (dp - dq) * (q - p));
    }
    rest = std::move(kept);
  }
  if (rest.size() < 3) return {{middle}, up};
  return {std::move(rest), up};
}

bool SupportPolygon::isConvex(std::span<const Vector3d> corners, const Vector3d& up) {
  const std::size_t n = corners.size();
  for (std::size_t i = 0; n >= 3 && i < n; ++i) {
    const Vector3d &a = corners[i], &b = corners[(i + 1) % n], &c = corners[(i + 2) % n];
    if (!((b - a).cross(c - b).dot(up) > 0.0)) return false;
  }
  return n >= 3;
}

SupportPolygon::Nearest SupportPolygon::nearest(std::span<const Vector3d> corners, const Vector3d& up,
                                                const Vector3d& point) {
  Nearest best;
  if (corners.empty()) return best;
  const auto flat = [&](const Vector3d& v) { return Vector3d(v - up * up.dot(v)); };
  double shortest = std::numeric_limits<double>::infinity();
  bool inside = corners.size() >= 3;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector3d edge = flat(corners[(i + 1) % corners.size()] - corners[i]), to = flat(point - corners[i]);
    const double length2 = edge.squaredNorm();
    if (corners.size() >= 3 && edge.cross(up).dot(to) > 0.0) inside = false;
    const double along = length2 > 0.0 ? std::clamp(edge.dot(to) / length2, 0.0, 1.0) : 0.0;
    const Vector3d way = along * edge - to;
    if (way.squaredNorm() >= shortest) continue;
    shortest = way.squaredNorm();
    best.way = way;
    best.corner = !(along > 0.0 && along < 1.0);
    best.outward = best.corner ? Vector3d(Vector3d::Zero()) : Vector3d(edge.cross(up).normalized());
  }
  return inside ? Nearest{} : best;
}

double SupportPolygon::outside(const Vector3d& point) const {
  if (corners.size() < 3) return nearest(point).way.norm();
  double most = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector3d outward = (corners[(i + 1) % corners.size()] - corners[i]).cross(up).normalized();
    most = std::max(most, outward.dot(point - corners[i]));
  }
  return most;
}

}  // namespace gelenk
