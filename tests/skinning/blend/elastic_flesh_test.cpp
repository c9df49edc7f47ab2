#include "skinning/blend/elastic_flesh.h"

#include <gtest/gtest.h>

#include "skinning/blend/skin_measures.h"
#include "tests/gpu/test_bodies.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// A tube of two bones along x, 40 mm thick, each 150 mm long.
struct Tube {
  Mesh mesh = testing::arm(2, 0.15, 0.04, 10, 20).skin.mesh;
  std::vector<FleshBone> bones{{0, {0, 0, 0}, {0.15, 0, 0}}, {1, {0.15, 0, 0}, {0.3, 0, 0}}};
  ElasticFlesh flesh{mesh, bones, {0.15, 0, 0}, 0.3, 0.012, 0.013};
  std::vector<Vector3d> positions = mesh.positions;

  /// Both bones moved by the same, the second one turned about its head besides.
  const std::vector<Vector3d>& pose(const Isometry3d& motion, const Eigen::AngleAxisd& turn, int steps) {
    const Vector3d joint(0.15, 0, 0);
    for (int i = 1; i <= steps; ++i) {
      const Eigen::AngleAxisd part(turn.angle() * i / steps, turn.axis());
      const Isometry3d second =
          motion * Eigen::Translation3d(joint) * part * Eigen::Translation3d(Vector3d(-joint));
      flesh.follow({motion, second}, i < steps ? 10 : 100);
    }
    flesh.carry(positions);
    return positions;
  }
  double volumeNow() const {
    return enclosedVolume({.positions = positions, .triangles = mesh.triangles, .normals = {}}) /
           enclosedVolume(mesh);
  }
};

TEST(ElasticFlesh, RestStaysAndARigidMotionMovesAllOfItAlike) {
  Tube tube;
  const auto& still = tube.pose(Isometry3d::Identity(), Eigen::AngleAxisd::Identity(), 1);
  for (std::size_t v = 0; v < still.size(); ++v) EXPECT_LE((still[v] - tube.mesh.positions[v]).norm(), 1e-9);
  Isometry3d motion = Isometry3d::Identity();
  for (int i = 0; i < 6; ++i) {  // in small steps, as it is to be used
    motion = Eigen::Translation3d(0.01, 0.02, -0.01) * Eigen::AngleAxisd(0.1, Vector3d(1, 2, 2) / 3) * motion;
    tube.pose(motion, Eigen::AngleAxisd::Identity(), 1);
  }
  for (int i = 0; i < 3; ++i) tube.pose(motion, Eigen::AngleAxisd::Identity(), 1);  // till it stands
  for (std::size_t v = 0; v < tube.positions.size(); ++v)
    EXPECT_LE((tube.positions[v] - motion * tube.mesh.positions[v]).norm(), 2e-4);
}

TEST(ElasticFlesh, BendAndTwistKeepItsVolumeAndBonesTheirPlace) {
  for (const Vector3d& axis : {Vector3d(0, 0, 1), Vector3d(1, 0, 0)}) {
    Tube tube;
    tube.pose(Isometry3d::Identity(), Eigen::AngleAxisd(M_PI / 3, axis), 10);
    EXPECT_NEAR(tube.volumeNow(), 1.0, 0.03) << axis.transpose();
    // The far end is the second bone's: all but rigid.
    const Vector3d joint(0.15, 0, 0);
    const Eigen::AngleAxisd turn(M_PI / 3, axis);
    for (std::size_t v = 0; v < tube.positions.size(); ++v)
      if (tube.mesh.positions[v].x() > 0.26) {
        const Vector3d rigid = joint + turn * (tube.mesh.positions[v] - joint);
        EXPECT_LE((tube.positions[v] - rigid).norm(), 0.008);
      }
  }
}

TEST(ElasticFlesh, APartWithoutABoneIsNamed) {
  const Tube tube;
  EXPECT_THROW(ElasticFlesh(tube.mesh, {{0, {9, 0, 0}, {9, 1, 0}}}, {0.15, 0, 0}, 0.3),
               std::invalid_argument);
}

TEST(SurfaceDistance, IsToTheSurfaceNotToTheVertex) {
  const Mesh mesh = testing::arm(2, 0.15, 0.04, 10, 20).skin.mesh;
  const SurfaceDistance distance(mesh);
  std::vector<Vector3d> slid = mesh.positions;  // along the tube by half an edge: the same surface
  for (Vector3d& p : slid) p.x() += 0.0075;
  for (int v = 20; v < 200; ++v) {
    EXPECT_NEAR(distance.of(mesh.positions[v], v, mesh.positions), 0.0, 1e-15);
    if (mesh.positions[v].x() < 0.02) continue;
    EXPECT_NEAR(distance.of(mesh.positions[v], v, slid), 0.0, 1e-12);
    const Vector3d outside = mesh.positions[v] + 0.003 * mesh.normals[v];
    EXPECT_NEAR(distance.of(outside, v, slid), 0.003, 1e-5);
  }
}

}  // namespace
}  // namespace gelenk
