#include "skinning/winding_number.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace gelenk {

using Eigen::Vector3d;

double windingNumber(const Mesh& mesh, const Vector3d& p) {
  double solidAngle = 0.0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vector3d a = mesh.positions[i] - p, b = mesh.positions[j] - p, c = mesh.positions[k] - p;
    const Vector3d centre = (a + b + c) / 3.0;
    const double distance2 = centre.squaredNorm(),
                 extent2 = std::max({(a - b).squaredNorm(), (b - c).squaredNorm(), (c - a).squaredNorm()});
    if (distance2 > 16.0 * extent2) {
      solidAngle += 0.5 * (b - a).cross(c - a).dot(centre) / (distance2 * std::sqrt(distance2));
      continue;
    }
    // Van Oosterom and Strackee 1983
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    solidAngle += 2.0 * std::atan2(a.dot(b.cross(c)), denominator);
  }
  return solidAngle / (4.0 * M_PI);
}

}  // namespace gelenk
