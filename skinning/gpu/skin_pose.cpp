#include "skinning/gpu/skin_pose.h"

#include <algorithm>
#include <stdexcept>

namespace gelenk {

void poseSkin(const Skin& skin, const Frames& worldFromJoint, SkinPose& out) {
  if (worldFromJoint.size() != skin.jointFromRestWorld.size())
    throw std::invalid_argument("the skin has " + std::to_string(skin.jointFromRestWorld.size()) +
                                " joints, the pose has " + std::to_string(worldFromJoint.size()) + " frames");
  out.layers.clear();
  out.jointRows = 3;
  out.method = {};
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

/// plane: over section coordinates in metres.
void append(std::vector<float>& rows, const FfdPlane& plane, double turn) {
  append(rows, plane.origin);
  rows.back() = static_cast<float>(turn);
  append(rows, plane.axes.col(0));
  append(rows, plane.axes.col(1));
}

/// Four planes a third of a metre apart that move with the frame: the tri-cubic is then the rigid map of (u,
/// v, w) in metres.
void appendRigid(std::vector<float>& rows, const Eigen::Isometry3d& end) {
  for (int k = 0; k < 4; ++k)
    append(rows, FfdPlane{end.translation() + k / 3.0 * end.linear().col(2), end.linear().leftCols<2>()},
           0.0);
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

void poseSkin(const PreparedSkin& prepared, const PosedBones& bones, SkinPose& out) {
  out.layers.clear();
  out.method = prepared.method->shader;
  out.jointRows = prepared.spread.empty() ? 4 : 7;
  const std::size_t stride = 4 * static_cast<std::size_t>(out.jointRows);
  out.rows.assign(stride * bones.worldFromRest.size(), 0.0f);
  for (std::size_t i = 0; i < bones.worldFromRest.size(); ++i) {
    const Eigen::Isometry3d& skinned = bones.worldFromRest[i];
    Eigen::Map<Eigen::Matrix<float, 3, 4, Eigen::RowMajor>>(&out.rows[stride * i]) =
        skinned.matrix().topRows<3>().cast<float>();
    Eigen::Map<Eigen::Vector4f>(&out.rows[stride * i + 12]) =
        Eigen::Quaterniond(skinned.linear()).coeffs().cast<float>();
  }
  for (std::size_t b = 0; b < prepared.spread.bones.size(); ++b) {
    const TwistBone& bone = prepared.spread.bones[b];
    const BoneTwist& twist = bones.twists[b];
    Eigen::Matrix<double, 9, 1> row;
    row << bone.axis, 1.0 / bone.length, bone.head, twist.atHead, twist.atEnd - twist.atHead;
    Eigen::Map<Eigen::Matrix<float, 9, 1>>(&out.rows[stride * static_cast<std::size_t>(bone.joint) + 16]) =
        row.cast<float>();
  }
}

namespace {

void appendLayers(const std::vector<LimbPose>& limbs, SkinPose& out) {
  for (const LimbPose& limb : limbs) {
    for (std::size_t k = 0; k < limb.planes.size(); ++k) {
      const FfdPlane& plane = limb.planes[k];
      const Eigen::Matrix<double, 3, 2> axes = plane.axes * limb.sectionSize.cwiseInverse().asDiagonal();
      append(out.layers, FfdPlane{plane.origin - axes * limb.sectionLower, axes}, limb.turns[k]);
    }
    appendRigid(out.layers, limb.worldFromNearEnd);
    appendRigid(out.layers, limb.worldFromFarEnd);
    for (const Eigen::Matrix3d& matrix : limb.worldFromDisplacement)
      for (int k = 0; k < 3; ++k) append(out.layers, matrix.col(k));
  }
  out.sculpted = std::any_of(limbs.begin(), limbs.end(),
                             [](const LimbPose& limb) { return !limb.displacement.empty(); });
}

}  // namespace

void poseSkin(const MuscleSkin& body, const Frames& worldFromJoint, const std::vector<LimbPose>& limbs,
              SkinPose& out) {
  poseSkin(body.skin, worldFromJoint, out);
  appendLayers(limbs, out);
}

void poseSkin(const LayeredSkin& layered, const PosedBones& bones, const std::vector<LimbPose>& limbs,
              SkinPose& out) {
  poseSkin(layered.outside, bones, out);
  appendLayers(limbs, out);
}

std::string poseDefines(const SkinPose& pose, bool layered) {
  std::string words = pose.rowCount() > maxBlockRows ? "POSE_IN_TEXTURE " : "";
  if (!pose.method.empty()) words += "PREPARED " + std::string(pose.method) + " ";
  if (pose.jointRows == 7) words += "TWIST ";
  if (layered) words += pose.sculpted ? "LAYERS SCULPTED " : "LAYERS ";
  return words;
}

SkinPose unposed(int jointCount) {
  SkinPose pose;
  for (int i = 0; i < jointCount; ++i)
    pose.rows.insert(pose.rows.end(), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
  return pose;
}

}  // namespace gelenk
