#pragma once

#include <random>

#include "kinematics/configuration.h"
#include "kinematics/rotation.h"
#include "kinematics/skeleton.h"

namespace gelenk::testing {

inline Eigen::Vector3d randomUnit(std::mt19937_64& random) {
  Eigen::Vector3d v;
  do
    v = 2.0 * Eigen::Vector3d(uniform01(random), uniform01(random), uniform01(random)) -
        Eigen::Vector3d::Ones();
  while (v.norm() > 1.0 || v.norm() < 1e-3);
  return v.normalized();
}

/// A tree of every kind of joint: fixed, hinges about coordinate and skew axes, several axes, sliders, balls
/// with and without limits, a free root.
inline Skeleton randomSkeleton(std::mt19937_64& random, int joints) {
  std::vector<Joint> list;
  for (int i = 0; i < joints; ++i) {
    Joint joint{.name = "j" + std::to_string(i), .parent = i == 0 ? -1 : static_cast<int>(random() % i)};
    joint.parentFromZero.linear() =
        expRotation(3.0 * uniform01(random) * randomUnit(random)).toRotationMatrix();
    joint.parentFromZero.translation() = uniform01(random) * randomUnit(random);
    const int kind = static_cast<int>(random() % 6);
    if (i == 0 || kind == 0)
      for (int k = 0; k < 3; ++k)
        joint.axes.push_back({AxisDof::Kind::Translation, Eigen::Vector3d::Unit(k), -2.0, 2.0});
    if (kind == 1)
      joint.axes.push_back({AxisDof::Kind::Rotation, Eigen::Vector3d::Unit(random() % 3), -1.0, 2.0});
    if (kind == 2) joint.axes.push_back({AxisDof::Kind::Rotation, randomUnit(random), -1.5, 1.0});
    if (kind == 3)
      for (int k = 0; k < 3; ++k)
        joint.axes.push_back({AxisDof::Kind::Rotation, randomUnit(random), -1.0, 1.0});
    joint.ball = i == 0 || kind >= 4;
    if (joint.ball && kind == 5) joint.ballLimit = BallLimit{{0.1, -0.2}, {0.9, 0.5}, -0.7, 1.1};
    list.push_back(joint);
  }
  return Skeleton(list);
}

/// The same tree, in which joints of one axis follow others, below, beside or above them; sliders among them.
inline Skeleton withCouplings(const Skeleton& skeleton, std::mt19937_64& random) {
  std::vector<Joint> joints = skeleton.joints();
  std::vector<int> single;
  for (int i = 1; i < skeleton.jointCount(); ++i) {
    Joint& joint = joints[i];
    if (joint.ball || joint.axes.size() > 1) {  // more of them than by chance
      if (random() % 2) continue;
      joint.ball = false;
      joint.ballLimit.reset();
      joint.axes = {{random() % 4 ? AxisDof::Kind::Rotation : AxisDof::Kind::Translation, randomUnit(random),
                     -1.2, 1.5}};
    }
    if (joint.axes.size() == 1) single.push_back(i);
  }
  for (std::size_t k = 0; k + 1 < single.size(); ++k) {
    const int follower = single[k], source = single[k + 1 + random() % (single.size() - k - 1)];
    if (joints[source].coupling || joints[follower].coupling || random() % 3 == 0) continue;
    joints[follower].coupling = {.source = source,
                                 .multiplier = (random() % 2 ? 1.0 : -1.0) * (0.3 + uniform01(random)),
                                 .offset = 0.4 * (uniform01(random) - 0.5)};
    joints[follower].axes[0].lower = -3.0, joints[follower].axes[0].upper = 2.0;
  }
  for (Joint& joint : joints)  // none follows a follower
    if (joint.coupling && joints[joint.coupling->source].coupling) joint.coupling.reset();
  return Skeleton(joints);
}

/// Trees of every kind of joint; every second one with couplings.
inline Skeleton randomTree(std::mt19937_64& random, int joints, int number) {
  const Skeleton skeleton = randomSkeleton(random, joints);
  return number % 2 ? withCouplings(skeleton, random) : skeleton;
}

}  // namespace gelenk::testing
