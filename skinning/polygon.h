#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace gelenk {

struct PolygonTriangles {
  std::vector<std::array<int, 3>>
      triangles;          ///< corners of the polygon, in its sense of rotation; n - 2 of them
  bool crossing = false;  ///< edges cross, or the polygon has no area: the triangles may fold
};

/// A polygon of n >= 3 corners, flat or nearly so, as triangles: the fan about its first corner where none of
/// its triangles turns against the polygon's normal (Newell's), as with every convex one; else ears are cut
/// off, seen along that normal (Meisters 1975).
PolygonTriangles triangulated(std::span<const Eigen::Vector3d> polygon);

}  // namespace gelenk
