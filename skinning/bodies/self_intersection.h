#pragma once

#include <Eigen/Core>
#include <array>
#include <utility>
#include <vector>

namespace gelenk {

/// Pairs of triangles that pass through each other: an edge of one crosses the inside of the other. Triangles
/// with a common vertex are not counted. Sweep over bounding boxes, so near-linear for surfaces. Pairs in
/// ascending order.
std::vector<std::pair<int, int>> selfIntersections(const std::vector<Eigen::Vector3d>& positions,
                                                   const std::vector<std::array<int, 3>>& triangles);

}  // namespace gelenk
