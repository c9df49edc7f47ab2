#pragma once

#include "skinning/mesh.h"
#include "skinning/rigging/bone.h"
#include "skinning/skin.h"

namespace gelenk {

struct RigWeightOptions {
  double strength = 10.0;  ///< of the bones' heat (BoneHeatOptions)
  int voxels = 160;
  /// The stand-in for the ribs reaches from chest + ribWidth (shoulder - chest) + ribDrop (pelvis - chest) to
  /// pelvis + ribWaist (hip - pelvis), chest and pelvis the middles between shoulders and hips.
  double ribWidth = 0.75, ribDrop = 0.12, ribWaist = 0.8;
};

/// The bones that heat the skin: those of the skeleton and, where it has shoulders and hips, a segment a side
/// that stands in for the ribs, carried by the spine: without it the flank follows the arm.
std::vector<Bone> rigBones(const Skeleton& skeleton, const Frames& rest,
                           const RigWeightOptions& options = {});

/// Heat weights of the joints (bone_heat.h) for a skeleton that stands in the mesh in its rest pose.
SparseWeights rigWeights(const Mesh& mesh, const Skeleton& skeleton, const RigWeightOptions& options = {});

}  // namespace gelenk
