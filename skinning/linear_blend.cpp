#include "skinning/linear_blend.h"

namespace gelenk {

void linearBlendSkin(const Skin& skin, const Frames& worldFromJoint, SkinnedVertices& out) {
  const std::vector<Eigen::Isometry3d> matrices = skinningMatrices(skin, worldFromJoint);
  const std::size_t count = skin.mesh.positions.size();
  out.positions.resize(count);
  out.normals.resize(count);
  for (std::size_t v = 0; v < count; ++v) {
    const Influences& in = skin.influences[v];
    Eigen::Matrix<double, 3, 4> blended = in.weights[0] * matrices[in.joints[0]].matrix().topRows<3>();
    for (int k = 1; k < 4 && in.weights[k] > 0.0; ++k)
      blended += in.weights[k] * matrices[in.joints[k]].matrix().topRows<3>();
    out.positions[v] = blended.leftCols<3>() * skin.mesh.positions[v] + blended.col(3);
    out.normals[v] = (blended.leftCols<3>() * skin.mesh.normals[v]).normalized();
  }
}

SkinnedVertices linearBlendSkin(const Skin& skin, const Frames& worldFromJoint) {
  SkinnedVertices out;
  linearBlendSkin(skin, worldFromJoint, out);
  return out;
}

}  // namespace gelenk
