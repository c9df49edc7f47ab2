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
  double ribWidth = 0.65, ribDrop = 0.12, ribWaist = 0.8;
};

/// A bone that heats the skin, and the joint at its lower end: the bone of a skeleton file's column.
struct RigBone {
  Bone bone;
  int end = 0;  ///< a child of bone.joint
};

/// The bones that heat the skin: those of the skeleton and, where it has shoulders and hips, a segment a side
/// that stands in for the ribs, carried by the spine: without it the flank follows the arm.
std::vector<RigBone> rigBones(const Skeleton& skeleton, const Frames& rest,
                              const RigWeightOptions& options = {});

struct RigWeights {
  SparseWeights joints;  ///< of the joints, up to four a vertex; each row sums to 1
  SparseWeights bones;   ///< the same by bone: j is the bone from joint j to its parent, which carries it
};

/// Heat weights (bone_heat.h) for a skeleton that stands in the mesh in its rest pose. loss: of keeping four
/// bones a vertex.
RigWeights rigWeights(const Mesh& mesh, const Skeleton& skeleton, const RigWeightOptions& options = {},
                      WeightLoss* loss = nullptr);

}  // namespace gelenk
