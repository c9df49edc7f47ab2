#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "kinematics/configuration.h"
#include "skinning/skin.h"

namespace gelenk::testing {

/// A tube around a straight chain of hinges along x (axes z), `joints` long, each link of length `link`,
/// closed by its ends' centres.
struct Arm {
  Skeleton skeleton;
  Skin skin;
};
inline Arm arm(int joints, double link, double radius, int rings = 8, int sides = 16) {
  std::vector<Joint> chain;
  for (int j = 0; j < joints; ++j)
    chain.push_back({.name = "joint" + std::to_string(j),
                     .parent = j - 1,
                     .parentFromZero = Eigen::Isometry3d(Eigen::Translation3d(j == 0 ? 0.0 : link, 0.0, 0.0)),
                     .axes = {AxisDof{.axis = Eigen::Vector3d::UnitZ()}}});
  Arm result{.skeleton = Skeleton(chain), .skin = {}};

  Mesh mesh;
  SparseWeights weights;
  const int stations = joints * rings;
  const auto add = [&](const Eigen::Vector3d& p) {
    mesh.positions.push_back(p);
    const double at = std::clamp(p.x() / link - 0.5, 0.0, joints - 1.0);  // half of each neighbour at a joint
    const int left = std::min(static_cast<int>(at), joints - 1);
    const double share = at - left;
    weights.push_back({{left, 1.0 - share}});
    if (share > 0.0) weights.back().emplace_back(std::min(left + 1, joints - 1), share);
  };
  for (int s = 0; s <= stations; ++s)
    for (int k = 0; k < sides; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / sides;
      add({link * s / rings, radius * std::cos(angle), radius * std::sin(angle)});
    }
  add({-0.2 * radius, 0, 0});
  add({link * joints + 0.2 * radius, 0, 0});
  const int first = sides * (stations + 1), last = first + 1;
  for (int k = 0; k < sides; ++k) {
    const int next = (k + 1) % sides, end = sides * stations;
    mesh.triangles.push_back({first, next, k});
    mesh.triangles.push_back({last, end + k, end + next});
    for (int s = 0; s < stations; ++s) {
      const int a = sides * s;
      mesh.triangles.push_back({a + k, a + next, a + sides + k});
      mesh.triangles.push_back({a + next, a + sides + next, a + sides + k});
    }
  }
  result.skin = bindSkin(mesh, restFrames(result.skeleton), fourLargest(weights, joints));
  return result;
}

/// A box standing on the plane up = 0 around the origin, carried by one joint.
inline Arm box(const Eigen::Vector3d& size) {
  Arm result{.skeleton = Skeleton({{.name = "root"}}), .skin = {}};
  Mesh mesh;
  // One vertex a corner and a face, so that faces are flat.
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-0.5, 0.5}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3, start = static_cast<int>(mesh.positions.size());
      for (const auto& [a, b] : {std::pair{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}) {
        Eigen::Vector3d p;
        p[axis] = side * size[axis];
        p[u] = a * size[u];
        p[v] = b * size[v];
        p.y() += 0.5 * size.y();
        mesh.positions.push_back(p);
      }
      const bool outwards = side > 0.0;
      for (const auto& [b, c] : {std::pair{1, 2}, {2, 3}})
        mesh.triangles.push_back({start, start + (outwards ? b : c), start + (outwards ? c : b)});
    }
  std::vector<Influences> influences(mesh.positions.size());
  result.skin = bindSkin(mesh, restFrames(result.skeleton), influences);
  return result;
}

/// Every rotation of the skeleton turned by up to `radians`.
inline Eigen::VectorXd bent(const Skeleton& skeleton, std::mt19937_64& random, double radians) {
  Eigen::VectorXd dq(skeleton.nv());
  for (int i = 0; i < dq.size(); ++i) dq[i] = radians * (2.0 * uniform01(random) - 1.0);
  return integrate(skeleton, skeleton.rest(), dq);
}

}  // namespace gelenk::testing
