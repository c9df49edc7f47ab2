#include "apps/render/posed_bounds.h"

namespace gelenk {

PosedBounds::PosedBounds(const Skin& skin) : restBoxes_(skin.jointCount()) {
  for (std::size_t v = 0; v < skin.mesh.positions.size(); ++v)
    restBoxes_[skin.influences[v].joints[0]].extend(skin.mesh.positions[v].cast<float>());
}

Eigen::AlignedBox3d PosedBounds::operator()(const SkinPose& pose) const {
  Eigen::AlignedBox3d bounds;
  for (std::size_t i = 0; i < restBoxes_.size(); ++i) {
    if (restBoxes_[i].isEmpty()) continue;
    const Eigen::Map<const Eigen::Matrix<float, 3, 4, Eigen::RowMajor>> skinned(&pose.rows[12 * i]);
    const Eigen::Vector3f centre = skinned.leftCols<3>() * restBoxes_[i].center() + skinned.col(3);
    const Eigen::Vector3f half = skinned.leftCols<3>().cwiseAbs() * (0.5f * restBoxes_[i].sizes());
    bounds.extend((centre - half).cast<double>());
    bounds.extend((centre + half).cast<double>());
  }
  return bounds;
}

}  // namespace gelenk
