#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "skinning/gpu/skin_pose.h"

namespace gelenk {

/// Box of a body in a pose, from one box a joint around the vertices that it carries mainly: cheap, and never
/// much larger or smaller than the exact box.
class PosedBounds {
 public:
  explicit PosedBounds(const Skin& skin);
  Eigen::AlignedBox3d operator()(const SkinPose& pose) const;

 private:
  std::vector<Eigen::AlignedBox3f> restBoxes_;  ///< one a joint; empty where it carries nothing
};

}  // namespace gelenk
