#include "skinning/bodies/self_intersection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace gelenk {
namespace {

using Eigen::Vector3d;

/// Six times the signed volume of the tetrahedron a, b, c, d.
double orientation(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  return (b - a).cross(c - a).dot(d - a);
}

bool segmentCrosses(const Vector3d& p, const Vector3d& q, const Vector3d& a, const Vector3d& b,
                    const Vector3d& c) {
  const double below = orientation(a, b, c, p), above = orientation(a, b, c, q);
  if ((below > 0.0) == (above > 0.0) || below == 0.0 || above == 0.0) return false;
  const double ab = orientation(p, q, a, b), bc = orientation(p, q, b, c), ca = orientation(p, q, c, a);
  return (ab > 0.0 && bc > 0.0 && ca > 0.0) || (ab < 0.0 && bc < 0.0 && ca < 0.0);
}

}  // namespace

std::vector<std::pair<int, int>> selfIntersections(const std::vector<Vector3d>& positions,
                                                   const std::vector<std::array<int, 3>>& triangles) {
  const int count = static_cast<int>(triangles.size());
  std::vector<Eigen::AlignedBox3d> boxes(count);
  for (int t = 0; t < count; ++t)
    for (const int corner : triangles[t]) boxes[t].extend(positions[corner]);
  Eigen::AlignedBox3d all;
  for (const auto& box : boxes) all.extend(box);
  int axis = 0;
  if (count > 0) all.sizes().maxCoeff(&axis);

  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return boxes[a].min()[axis] < boxes[b].min()[axis]; });

  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < count; ++i) {
    const int s = order[i];
    for (int k = i + 1; k < count && boxes[order[k]].min()[axis] <= boxes[s].max()[axis]; ++k) {
      const int t = order[k];
      if (!boxes[s].intersects(boxes[t])) continue;
      const auto &S = triangles[s], &T = triangles[t];
      if (std::any_of(S.begin(), S.end(), [&](int v) { return v == T[0] || v == T[1] || v == T[2]; }))
        continue;
      bool crosses = false;
      for (int e = 0; e < 3 && !crosses; ++e)
        crosses = segmentCrosses(positions[S[e]], positions[S[(e + 1) % 3]], positions[T[0]], positions[T[1]],
                                 positions[T[2]]) ||
                  segmentCrosses(positions[T[e]], positions[T[(e + 1) % 3]], positions[S[0]], positions[S[1]],
                                 positions[S[2]]);
      if (crosses) pairs.emplace_back(std::min(s, t), std::max(s, t));
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace gelenk
