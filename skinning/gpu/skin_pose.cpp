#include "skinning/gpu/skin_pose.h"

#include <algorithm>
#include <stdexcept>

namespace gelenk {

void poseSkin(const Skin& skin, const Frames& worldFromJoint, SkinPose& out) {
  if (worldFromJoint.size() != skin.jointFromRestWorld.size())
    throw std::invalid_argument("the skin has " + std::to_string(skin.jointFromRestWorld.size()) +
                                " joints, the pose has " + std::to_string(worldFromJoint.size()) + " frames");
  out.layers.clear();
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

namespace {

void append(std::vector<float>& rows, const Eigen::Vector3d& v) {
  for (int k = 0; k < 3; ++k) rows.push_back(static_cast<float>(v[k]));
  rows.push_back(0.0f);
}

void append(std::vector<float>& rows, const FfdPlane& plane) {
  append(rows, plane.origin);
  append(rows, plane.axes.col(0));
  append(rows, plane.axes.col(1));
}

/// Four planes a third of a metre apart that move with the frame: the tri-cubic is then the rigid map of (u,
/// v, w) in metres.
void appendRigid(std::vector<float>& rows, const Eigen::Isometry3d& end) {
  for (int k = 0; k < 4; ++k)
    append(rows, FfdPlane{end.translation() + k / 3.0 * end.linear().col(2), end.linear().leftCols<2>()});
}

int links(const Limb& limb) { return static_cast<int>(limb.shape.links.size()); }

}  // namespace

int firstLayerRow(const MuscleSkin& body, int limb) {
  int row = 0;
  for (int l = 0; l < limb; ++l) row += 3 * (6 * links(body.limbs[l]) + 9) + 3 * links(body.limbs[l]);
  return row;
}

int firstLinkRow(const MuscleSkin& body, int limb) {
  return firstLayerRow(body, limb) + 3 * (6 * links(body.limbs[limb]) + 9);
}

void poseSkin(const MuscleSkin& body, const Frames& worldFromJoint, const std::vector<LimbPose>& limbs,
              SkinPose& out) {
  poseSkin(body.skin, worldFromJoint, out);
  for (const LimbPose& limb : limbs) {
    for (const FfdPlane& plane : limb.planes) append(out.layers, plane);
    appendRigid(out.layers, limb.worldFromNearEnd);
    appendRigid(out.layers, limb.worldFromFarEnd);
    for (const Eigen::Matrix3d& matrix : limb.worldFromDisplacement)
      for (int k = 0; k < 3; ++k) append(out.layers, matrix.col(k));
  }
  out.sculpted = std::any_of(limbs.begin(), limbs.end(),
                             [](const LimbPose& limb) { return !limb.displacement.empty(); });
}

std::string layerDefines(const SkinPose& pose) {
  return pose.layers.empty() ? "" : pose.sculpted ? "LAYERS SCULPTED" : "LAYERS";
}

SkinPose unposed(int jointCount) {
  SkinPose pose;
  for (int i = 0; i < jointCount; ++i)
    pose.rows.insert(pose.rows.end(), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
  return pose;
}

}  // namespace gelenk
