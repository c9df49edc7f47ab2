#pragma once

#include "skinning/skin.h"

namespace gelenk {

/// Skinned positions and unit normals on the CPU, in double precision: the reference for the shader.
/// Normals go with the cofactors of the blended matrix (det M M^-T): a blend of rotations shrinks across the
/// bend, and only so does the normal stay perpendicular to the surface that the same matrix gives. Zero where
/// the blend is singular.
struct SkinnedVertices {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Vector3d> normals;
};
SkinnedVertices linearBlendSkin(const Skin& skin, const Frames& worldFromJoint);
/// The same into existing storage; allocates only when the size changes.
void linearBlendSkin(const Skin& skin, const Frames& worldFromJoint, SkinnedVertices& out);

}  // namespace gelenk
