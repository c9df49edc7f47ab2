#include "skinning/rigging/fit/surface_samples.h"

#include <Eigen/Geometry>
#include <cmath>

namespace gelenk {

using Eigen::Vector3d;

SurfaceSamples sampleSurface(const Mesh& mesh, int count) {
  double total = 0.0;
  for (const auto& t : mesh.triangles)
    total += 0.5 * (mesh.positions[t[1]] - mesh.positions[t[0]])
                       .cross(mesh.positions[t[2]] - mesh.positions[t[0]])
                       .norm();
  SurfaceSamples out;
  if (!(total > 0.0)) return out;
  const double step = total / count;
  double due = 0.5 * step;
  std::size_t drawn = 0;
  for (const auto& t : mesh.triangles) {
    const Vector3d a = mesh.positions[t[0]], u = mesh.positions[t[1]] - a, v = mesh.positions[t[2]] - a;
    const Vector3d normal = u.cross(v);
    const double area = 0.5 * normal.norm();
    for (; due < area; due += step) {
      // Additive recurrence of the plastic number: even without a grid's alignment.
      ++drawn;
      double s = std::fmod(0.5 + 0.7548776662466927 * static_cast<double>(drawn), 1.0);
      double r = std::fmod(0.5 + 0.5698402909980532 * static_cast<double>(drawn), 1.0);
      if (s + r > 1.0) s = 1.0 - s, r = 1.0 - r;
      out.points.push_back(a + s * u + r * v);
      out.normals.push_back(normal / (2.0 * area));
    }
    due -= area;
  }
  return out;
}

}  // namespace gelenk
