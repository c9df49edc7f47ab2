#include "skinning/creases.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace gelenk {
namespace {

using Eigen::Vector3d;

/// Two squares that meet in the y axis, folded by so many radians.
Mesh fold(double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {.positions = {{-1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {-1, 1, 0}, {c, 0, s}, {c, 1, s}},
          .triangles = {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}},
          .normals = {}};
}

TEST(Creases, AnEdgeSharperThanTheAngleIsCutAndEachSideKeepsItsNormal) {
  const Mesh cut = withCreases(fold(1.0), 0.6);
  ASSERT_EQ(cut.positions.size(), 8u);  // the two of the edge come twice
  const Vector3d sides[] = {Vector3d::UnitZ(), Vector3d(-std::sin(1.0), 0, std::cos(1.0))};
  for (std::size_t t = 0; t < 4; ++t)
    for (const int v : cut.triangles[t]) EXPECT_NEAR((cut.normals[v] - sides[t / 2]).norm(), 0.0, 1e-12);
}

TEST(Creases, AFlatterEdgeIsSmoothAndNothingMoves) {
  const Mesh before = fold(0.5), after = withCreases(before, 0.6);
  ASSERT_EQ(after.positions.size(), 6u);
  const Vector3d middle(-std::sin(0.25), 0, std::cos(0.25));
  for (std::size_t t = 0; t < 4; ++t)
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(after.positions[after.triangles[t][k]], before.positions[before.triangles[t][k]]);
      if (before.triangles[t][k] == 1)
        EXPECT_NEAR((after.normals[after.triangles[t][k]] - middle).norm(), 0.0, 1e-12);
    }
}

/// However its cap is cut into triangles: a vertex's normal on a cylinder points from its axis, on the cap
/// along it.
TEST(Creases, ACylinderHasRoundSidesAndFlatEnds) {
  constexpr int sides = 12;
  Mesh mesh;
  for (int s = 0; s < sides; ++s)
    for (const double z : {0.0, 1.0})
      mesh.positions.emplace_back(std::cos(2 * std::numbers::pi * s / sides),
                                  std::sin(2 * std::numbers::pi * s / sides), z);
  for (int s = 0; s < sides; ++s) {
    const int a = 2 * s, b = 2 * ((s + 1) % sides);
    mesh.triangles.push_back({a, b, b + 1});
    mesh.triangles.push_back({a, b + 1, a + 1});
    if (s > 0 && s + 1 < sides) {
      mesh.triangles.push_back({0, b, a});
      mesh.triangles.push_back({1, a + 1, b + 1});
    }
  }
  const Mesh cut = withCreases(mesh, 0.6);
  ASSERT_EQ(cut.positions.size(), 4u * sides);
  for (std::size_t v = 0; v < cut.positions.size(); ++v) {
    const Vector3d radial = Vector3d(cut.positions[v].x(), cut.positions[v].y(), 0.0);
    const double along = std::abs(cut.normals[v].z());
    if (along > 0.5)
      EXPECT_NEAR(along, 1.0, 1e-12);
    else
      EXPECT_NEAR(cut.normals[v].dot(radial), 1.0,
                  1e-3);  // both triangles of a side meet at one of its corners only
  }
}

}  // namespace
}  // namespace gelenk
