#include <gtest/gtest.h>

#include "skinning/blend/linear_blend.h"
#include "tests/kinematics/random_skeleton.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

Mesh tetrahedron() {
  return {.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          .triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}},
          .normals = {}};
}

TEST(Mesh, TetrahedronIsClosedManifoldAndOfKnownVolume) {
  const MeshTopology facts = topology(tetrahedron());
  EXPECT_TRUE(facts.closed());
  EXPECT_TRUE(facts.manifold());
  EXPECT_EQ(facts.eulerCharacteristic(), 2);
  EXPECT_EQ(facts.components, 1);
  EXPECT_NEAR(enclosedVolume(tetrahedron()), 1.0 / 6.0, 1e-15);
}

TEST(Mesh, TwoTetrahedraAtOneVertexAreNotManifold) {
  Mesh mesh = tetrahedron();
  const Mesh second = tetrahedron();
  for (int v = 1; v < 4; ++v) mesh.positions.push_back(-second.positions[v]);
  for (auto t : second.triangles) {
    for (int& corner : t) corner = corner == 0 ? 0 : corner + 3;
    std::swap(t[1], t[2]);
    mesh.triangles.push_back(t);
  }
  const MeshTopology facts = topology(mesh);
  EXPECT_EQ(facts.nonManifoldVertices, 1);
  EXPECT_EQ(facts.nonManifoldEdges, 0);
  EXPECT_TRUE(facts.closed());
}

TEST(Mesh, OpenAndFlippedFacesAreSeen) {
  Mesh open = tetrahedron();
  open.triangles.pop_back();
  EXPECT_EQ(topology(open).boundaryEdges, 3);
  Mesh flipped = tetrahedron();
  std::swap(flipped.triangles[0][0], flipped.triangles[0][1]);
  EXPECT_EQ(topology(flipped).nonManifoldEdges, 3);
}

TEST(Skinning, BindPoseLeavesEveryVertexInPlaceAndRigidMotionMovesAllAlike) {
  std::mt19937_64 random(1);
  const Skeleton skeleton = testing::randomSkeleton(random, 5);
  SparseWeights weights(4);
  for (auto& row : weights)
    for (int j = 0; j < 5; ++j) row.emplace_back(j, uniform01(random));
  WeightLoss loss;
  const Skin skin = bindSkin(tetrahedron(), restFrames(skeleton), fourLargest(weights, 5, &loss));
  EXPECT_EQ(loss.verticesOverFour, 4);
  EXPECT_GT(loss.max, 0.0);

  Frames frames = restFrames(skeleton);
  SkinnedVertices at = linearBlendSkin(skin, frames);
  for (int v = 0; v < 4; ++v) EXPECT_LE((at.positions[v] - skin.mesh.positions[v]).norm(), 1e-14);

  Eigen::Isometry3d motion(expRotation({0.3, -1.0, 0.5}));
  motion.translation() << 1, 2, 3;
  for (auto& frame : frames) frame = motion * frame;
  at = linearBlendSkin(skin, frames);
  for (int v = 0; v < 4; ++v) {
    EXPECT_LE((at.positions[v] - motion * skin.mesh.positions[v]).norm(), 1e-13);
    EXPECT_LE((at.normals[v] - motion.linear() * skin.mesh.normals[v]).norm(), 1e-13);
  }
}

}  // namespace
}  // namespace gelenk
