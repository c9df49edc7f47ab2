#include "skinning/rigging/fit/nearest_skin.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace gelenk {

using Eigen::Vector3d;

namespace {

Vector3d nearestOfEdge(const Vector3d& a, const Vector3d& b, const Vector3d& p) {
  const double square = (b - a).squaredNorm();
  return square > 0.0 ? Vector3d(a + std::clamp((p - a).dot(b - a) / square, 0.0, 1.0) * (b - a)) : a;
}

}  // namespace

Vector3d nearestSkin(const Mesh& mesh, const Vector3d& point) {
  Vector3d best = mesh.positions[mesh.triangles[0][0]];
  double least = std::numeric_limits<double>::infinity();
  const auto offer = [&](const Vector3d& q) {
    if (const double d = (q - point).squaredNorm(); d < least) least = d, best = q;
  };
  for (const auto& t : mesh.triangles) {
    const Vector3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    const Vector3d u = b - a, v = c - a, n = u.cross(v), w = point - a;
    if (const double square = n.squaredNorm(); square > 0.0) {
      const double s = w.cross(v).dot(n) / square,
                   r = u.cross(w).dot(n) / square;  // a + s u + r v lies below
      if (s >= 0.0 && r >= 0.0 && s + r <= 1.0) {
        offer(a + s * u + r * v);
        continue;
      }
    }
    offer(nearestOfEdge(a, b, point));
    offer(nearestOfEdge(b, c, point));
    offer(nearestOfEdge(c, a, point));
  }
  return best;
}

}  // namespace gelenk
