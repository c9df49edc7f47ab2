#include "skinning/rigging/fit/nearest_skin.h"

#include <gtest/gtest.h>

namespace gelenk {
namespace {

using Eigen::Vector3d;

TEST(NearestSkin, LiesInAFaceOnAnEdgeOrAtACorner) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {5, 5, -5}};
  mesh.triangles = {{0, 0, 3}, {0, 1, 2}};  // the first one has no area
  const std::pair<Vector3d, Vector3d> cases[] = {{{0.5, 0.5, 3.0}, {0.5, 0.5, 0.0}},
                                                 {{1.0, -2.0, 1.0}, {1.0, 0.0, 0.0}},
                                                 {{3.0, -1.0, 0.0}, {2.0, 0.0, 0.0}},
                                                 {{2.0, 2.0, 1.0}, {1.0, 1.0, 0.0}},
                                                 {{4.0, 4.0, -4.0}, {4.0, 4.0, -4.0}}};
  for (const auto& [point, expected] : cases)
    EXPECT_LT((nearestSkin(mesh, point) - expected).norm(), 1e-12) << point.transpose();
}

}  // namespace
}  // namespace gelenk
