#include "skinning/coarse_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>

namespace gelenk {
namespace {

/// The vertices that follow each one in its triangles, as one list with offsets: all its neighbours where the
/// surface is closed.
struct Followers {
  std::vector<int> start, vertices;
  Followers(const std::vector<std::array<int, 3>>& triangles, int vertexCount)
      : start(static_cast<std::size_t>(vertexCount) + 1, 0), vertices(3 * triangles.size()) {
    for (const auto& t : triangles)
      for (const int v : t) ++start[v + 1];
    for (std::size_t v = 1; v < start.size(); ++v) start[v] += start[v - 1];
    std::vector<int> next(start.begin(), start.end() - 1);
    for (const auto& t : triangles)
      for (int k = 0; k < 3; ++k) vertices[next[t[k]]++] = t[(k + 1) % 3];
  }
};

}  // namespace

std::vector<std::array<int, 3>> coarseTriangles(const std::vector<std::array<int, 3>>& triangles,
                                                int vertexCount) {
  const Followers near(triangles, vertexCount);
  std::vector<int> takenBy(vertexCount, -1);
  for (int v = 0; v < vertexCount; ++v) {
    if (takenBy[v] >= 0) continue;
    takenBy[v] = v;
    for (int i = near.start[v]; i < near.start[v + 1]; ++i)
      if (int& other = takenBy[near.vertices[i]]; other < 0) other = v;
  }
  std::vector<std::array<int, 3>> fewer;
  for (const auto& t : triangles) {
    const std::array<int, 3> by{takenBy[t[0]], takenBy[t[1]], takenBy[t[2]]};
    if (by[0] != by[1] && by[1] != by[2] && by[2] != by[0]) fewer.push_back(by);
  }
  return fewer;
}

bool enclosesItsInside(const std::vector<std::array<int, 3>>& triangles, int vertexCount,
                       const std::function<Eigen::Vector3f(int)>& position) {
  Followers after(triangles, vertexCount);
  for (int v = 0; v < vertexCount; ++v) {
    const auto begin = after.vertices.begin() + after.start[v],
               end = after.vertices.begin() + after.start[v + 1];
    std::sort(begin, end);
    if (std::adjacent_find(begin, end) != end) return false;  // an edge of two triangles in one direction
  }
  double volume = 0.0;
  for (const auto& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      const int from = t[(k + 1) % 3];
      if (!std::binary_search(after.vertices.begin() + after.start[from],
                              after.vertices.begin() + after.start[from + 1], t[k]))
        return false;
    }
    const Eigen::Vector3d a = position(t[0]).cast<double>(), b = position(t[1]).cast<double>(),
                          c = position(t[2]).cast<double>();
    volume += a.dot(b.cross(c));
  }
  return volume > 0.0;
}

}  // namespace gelenk
