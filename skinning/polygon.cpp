#include "skinning/polygon.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace gelenk {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Twice the signed area of the triangle.
double turn(const Vector2d& a, const Vector2d& b, const Vector2d& c) { return cross(b - a, c - a); }

/// The polygon seen against its normal, counter-clockwise; empty where it has no area.
std::vector<Vector2d> seenFromAbove(std::span<const Vector3d> polygon) {
  Vector3d normal = Vector3d::Zero();
  double extent = 0.0;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vector3d a = polygon[k] - polygon[0], b = polygon[(k + 1) % polygon.size()] - polygon[0];
    normal += a.cross(b);
    extent = std::max(extent, a.squaredNorm());
  }
  std::vector<Vector2d> flat;
  if (!(normal.norm() > 1e-12 * extent)) return flat;
  const Vector3d u = normal.unitOrthogonal(), v = normal.normalized().cross(u);
  for (const Vector3d& p : polygon) flat.emplace_back(u.dot(p - polygon[0]), v.dot(p - polygon[0]));
  return flat;
}

std::vector<std::array<int, 3>> fan(int corners) {
  std::vector<std::array<int, 3>> triangles;
  for (int k = 2; k < corners; ++k) triangles.push_back({0, k - 1, k});
  return triangles;
}

/// Whether two edges without a common corner meet.
bool edgesCross(const std::vector<Vector2d>& p) {
  const int n = static_cast<int>(p.size());
  for (int i = 0; i < n; ++i)
    for (int j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      const Vector2d &a = p[i], &b = p[i + 1], &c = p[j], &d = p[(j + 1) % n];
      if (turn(a, b, c) * turn(a, b, d) < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0) return true;
    }
  return false;
}

bool inTriangle(const Vector2d& p, const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
}

/// Empty where no ear is left to cut.
std::vector<std::array<int, 3>> earsCut(const std::vector<Vector2d>& p) {
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> left(p.size());
  for (std::size_t k = 0; k < p.size(); ++k) left[k] = static_cast<int>(k);
  const auto isEar = [&](std::size_t k, bool flatToo) {
    const std::size_t n = left.size();
    const int a = left[(k + n - 1) % n], b = left[k], c = left[(k + 1) % n];
    const double area = turn(p[a], p[b], p[c]);
    if (flatToo ? area != 0.0 : !(area > 0.0)) return false;
    if (flatToo) return true;
    return std::none_of(left.begin(), left.end(), [&](int other) {
      return other != a && other != b && other != c && p[other] != p[a] && p[other] != p[b] &&
             p[other] != p[c] && inTriangle(p[other], p[a], p[b], p[c]);
    });
  };
  std::size_t k = 1;  // the first ear looked at is the second corner, as in a fan
  for (std::size_t tried = 0; left.size() > 3;) {
    const std::size_t n = left.size();
    const bool flatToo = tried >= n;  // corners on a straight edge go where nothing else does
    if (tried >= 2 * n) return {};
    if (!isEar(k, flatToo)) {
      k = (k + 1) % n, ++tried;
      continue;
    }
    triangles.push_back({left[(k + n - 1) % n], left[k], left[(k + 1) % n]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(k));
    k %= left.size(), tried = 0;
  }
  triangles.push_back({left[0], left[1], left[2]});
  return triangles;
}

}  // namespace

PolygonTriangles triangulated(std::span<const Vector3d> polygon) {
  const int n = static_cast<int>(polygon.size());
  PolygonTriangles result{.triangles = fan(n)};
  if (n == 3) return result;
  const std::vector<Vector2d> flat = seenFromAbove(polygon);
  if (flat.empty()) {
    result.crossing = true;
    return result;
  }
  const bool folds = std::any_of(result.triangles.begin(), result.triangles.end(), [&](const auto& t) {
    return turn(flat[t[0]], flat[t[1]], flat[t[2]]) < 0.0;
  });
  if (!folds) return result;
  result.crossing = edgesCross(flat);
  if (result.crossing) return result;
  if (auto ears = earsCut(flat); !ears.empty()) result.triangles = std::move(ears);
  return result;
}

}  // namespace gelenk
