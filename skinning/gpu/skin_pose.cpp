#include "skinning/gpu/skin_pose.h"

#include <stdexcept>

namespace gelenk {

void poseSkin(const Skin& skin, const Frames& worldFromJoint, SkinPose& out) {
  if (worldFromJoint.size() != skin.jointFromRestWorld.size())
    throw std::invalid_argument("the skin has " + std::to_string(skin.jointFromRestWorld.size()) + " joints, the pose has " +
                                std::to_string(worldFromJoint.size()) + " frames");
  out.rows.resize(12 * worldFromJoint.size());
  for (std::size_t i = 0; i < worldFromJoint.size(); ++i) {
    const Eigen::Isometry3d skinned = worldFromJoint[i] * skin.jointFromRestWorld[i];
    Eigen::Map<Eigen::Matrix<float, 3, 4, Eigen::RowMajor>>(&out.rows[12 * i]) =
        skinned.matrix().topRows<3>().cast<float>();
  }
}

SkinPose poseSkin(const Skin& skin, const Frames& worldFromJoint) {
  SkinPose pose;
  poseSkin(skin, worldFromJoint, pose);
  return pose;
}

SkinPose unposed(int jointCount) {
  SkinPose pose;
  for (int i = 0; i < jointCount; ++i) pose.rows.insert(pose.rows.end(), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
  return pose;
}

}  // namespace gelenk
