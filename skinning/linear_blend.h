#pragma once

#include "skinning/skin.h"

namespace gelenk {

/// Skinned positions and unit normals on the CPU, in double precision: the reference for the shader.
/// Normals are blended with the same matrices; as all of them are rotations no inverse transpose is needed.
struct SkinnedVertices {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Vector3d> normals;
};
SkinnedVertices linearBlendSkin(const Skin& skin, const Frames& worldFromJoint);
/// The same into existing storage; allocates only when the size changes.
void linearBlendSkin(const Skin& skin, const Frames& worldFromJoint, SkinnedVertices& out);

}  // namespace gelenk
