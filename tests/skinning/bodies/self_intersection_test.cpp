#include "skinning/bodies/self_intersection.h"

#include <gtest/gtest.h>

namespace gelenk {
namespace {

using Eigen::Vector3d;

TEST(SelfIntersection, CrossingTrianglesAreFoundAndNeighboursAreNot) {
  const std::vector<Vector3d> positions{{0, 0, 0},     {1, 0, 0},   {0, 1, 0},  {0.2, 0.2, -1},
                                        {0.2, 0.2, 1}, {0.2, 2, 0}, {1, 1, 0.1}};
  EXPECT_EQ(selfIntersections(positions, {{0, 1, 2}, {3, 4, 5}}).size(), 1u);
  EXPECT_EQ(selfIntersections(positions, {{0, 1, 2}, {1, 6, 2}}).size(), 0u);  // share an edge
}

TEST(SelfIntersection, CountEqualsBruteForceOverAllPairs) {
  // Two interlocking fans of thin triangles; brute force is the same routine on two triangles at a time.
  std::vector<Vector3d> positions;
  std::vector<std::array<int, 3>> triangles;
  for (int i = 0; i < 40; ++i) {
    const double a = 0.37 * i;
    for (const double s : {0.0, 0.3, 0.9})
      positions.push_back({std::cos(a + s) * (1.0 + s), std::sin(1.7 * a) + s * s, std::cos(2.3 * a) * s});
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  std::size_t brute = 0;
  for (std::size_t s = 0; s < triangles.size(); ++s)
    for (std::size_t t = s + 1; t < triangles.size(); ++t)
      brute += selfIntersections(positions, {triangles[s], triangles[t]}).size();
  EXPECT_GT(brute, 5u);
  EXPECT_EQ(selfIntersections(positions, triangles).size(), brute);
}

}  // namespace
}  // namespace gelenk
