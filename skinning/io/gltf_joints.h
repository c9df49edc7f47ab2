#pragma once

#include <tiny_gltf.h>

#include <optional>
#include <vector>

#include "kinematics/skeleton.h"

namespace gelenk {

/// glTF nodes hold frames only. How a joint moves (axes, limits, where it rests) stands beside them, as the
/// node's `extras.gelenk`: this program takes it up again, others pass it over. rest: the joint's entries of
/// q at rest.
tinygltf::Value withMotion(const Joint& joint, const std::vector<double>& rest);

struct JointMotion {
  std::vector<AxisDof> axes = {};
  bool ball = false;
  std::optional<BallLimit> ballLimit = {};
  std::vector<double> rest = {};
};
/// Nothing where the extras say nothing. Throws std::invalid_argument that says what is wrong.
std::optional<JointMotion> motionOf(const tinygltf::Value& extras);

}  // namespace gelenk
