#pragma once

#include <cmath>

#include "kinematics/configuration.h"
#include "skinning/muscles/muscle_skin.h"

namespace gelenk::testing {

/// Shoulder ball, elbow hinge about y, wrist ball; upper arm along z, elbow resting bent by restBend.
inline Skeleton arm(double restBend) {
  std::vector<Joint> joints{Joint{.name = "chest"}, Joint{.name = "shoulder", .parent = 0, .ball = true},
                            Joint{.name = "elbow", .parent = 1},
                            Joint{.name = "wrist", .parent = 2, .ball = true}};
  joints[1].parentFromZero.translation() << 0.1, 0.2, 0.0;
  joints[2].parentFromZero.translation() << 0.0, 0.0, 0.30;
  joints[2].axes.push_back({AxisDof::Kind::Rotation, Eigen::Vector3d::UnitY(), 0.0, 2.6});
  joints[3].parentFromZero.translation() << 0.0, 0.0, 0.25;
  Skeleton zero(joints);
  Eigen::VectorXd rest = neutral(zero);
  rest[zero.qIndex(2)] = restBend;
  return Skeleton(joints, rest);
}

/// A tube of radius 4 cm around the resting bones, weights blended over 10 cm at the elbow and by arc length.
inline Skin tube(const Skeleton& skeleton) {
  const Frames rest = restFrames(skeleton);
  const double bend = skeleton.rest()[skeleton.qIndex(2)];
  Mesh mesh;
  std::vector<Influences> influences;
  constexpr int rings = 60, sides = 24;
  for (int r = 0; r < rings; ++r) {
    const double s = -0.02 + 0.60 * r / (rings - 1), fromElbow = s - 0.30;
    const double share = 0.5 * (1.0 + std::tanh(fromElbow / 0.03));
    // The elbow's frame turned back by the unbent part, so that rings do not cross on the inside.
    Eigen::Isometry3d frame = rest[1];
    if (fromElbow > 0.0) {
      frame = rest[2];
      frame.translate(Eigen::Vector3d(0, 0, fromElbow));
    } else {
      frame.translate(Eigen::Vector3d(0, 0, s));
    }
    const double half = bend * (fromElbow > 0.0 ? -0.5 : 0.5) * std::exp(-std::abs(fromElbow) / 0.04);
    frame.rotate(Eigen::AngleAxisd(half, Eigen::Vector3d::UnitY()));
    for (int k = 0; k < sides; ++k) {
      const double a = 2.0 * M_PI * k / sides;
      mesh.positions.push_back(frame * Eigen::Vector3d(0.04 * std::cos(a), 0.04 * std::sin(a), 0.0));
      influences.push_back({{1, 2, 0, 0}, {1.0 - share, share, 0.0, 0.0}});
    }
  }
  for (int r = 0; r + 1 < rings; ++r)
    for (int k = 0; k < sides; ++k) {
      const int a = r * sides + k, b = r * sides + (k + 1) % sides;
      mesh.triangles.push_back({a, b, b + sides});
      mesh.triangles.push_back({a, b + sides, a + sides});
    }
  return bindSkin(mesh, rest, influences);
}

}  // namespace gelenk::testing
