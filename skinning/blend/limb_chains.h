#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinematics/forward_kinematics.h"

namespace gelenk {

/// An arm or a leg: the joints where its two bones and its hand or foot begin.
struct LimbChain {
  bool arm = true, left = true;
  std::vector<int> joints;  ///< shoulder, elbow, hand or hip, knee, foot; joints between are passed over
};

/// Arms and legs by the names that rigs use (kinematics/motion/joint_matching.h: upperarm, forearm, hand;
/// thigh, calf, foot with a side), or by the numbers of Pinocchio's human skeleton. At most four; empty for
/// anything else.
std::vector<LimbChain> limbChains(const Skeleton& skeleton);

}  // namespace gelenk
