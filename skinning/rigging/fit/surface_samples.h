#pragma once

#include <Eigen/Core>
#include <vector>

#include "skinning/mesh.h"

namespace gelenk {

/// Points spread evenly over a surface, with unit normals.
struct SurfaceSamples {
  std::vector<Eigen::Vector3d> points, normals;
};

/// About `count` points, evenly by area and the same at every call. Triangles without area get none.
SurfaceSamples sampleSurface(const Mesh& mesh, int count);

}  // namespace gelenk
