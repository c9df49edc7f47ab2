#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

namespace gelenk {

/// About a quarter of the triangles, over some of the same vertices: each vertex that is not taken yet
/// takes the neighbours that are not either, and a triangle remains where its corners belong to three
/// different ones. So the surface stays as fine where it was finer, and its parts stay apart.
std::vector<std::array<int, 3>> coarseTriangles(const std::vector<std::array<int, 3>>& triangles,
                                                int vertexCount);

/// Every edge has a triangle on each side, one in each direction, and the volume within is positive.
bool enclosesItsInside(const std::vector<std::array<int, 3>>& triangles, int vertexCount,
                       const std::function<Eigen::Vector3f(int)>& position);

}  // namespace gelenk
