#pragma once

#include "skinning/mesh.h"
#include "skinning/rigging/bone.h"
#include "skinning/skin.h"

namespace gelenk {

struct RigWeightOptions {
  double strength = 8.0;  ///< of the bones' heat (BoneHeatOptions)
  int voxels = 160;
  /// The stand-in for the ribs reaches from chest + ribWidth (shoulder - chest) + ribDrop (pelvis - chest) to
  /// pelvis + ribWaist (hip - pelvis), chest and pelvis the middles between shoulders and hips.
  double ribWidth = 0.65, ribDrop = 0.12, ribWaist = 0.8;

  // Four-legged bodies: all legs hang down across the trunk.
  double animalStrength = 3.0;  ///< shoulder and croup go along with the leg over a wide seam
  /// Along the trunk, from pelvis (0) to chest (1): the ribs end this far before the knees, so that flank and
  /// front of the thigh are the leg's. animalWaist: ribWaist of these bodies.
  double ribLoin = 0.2, animalWaist = 0.6;
  /// The stand-in for belly and breast, so that the skin between the legs is no leg's: from this far before
  /// the knees to beyond the shoulders; depth: share of the way from there to the surface below.
  double bellyGroin = 0.1, bellyBreast = 1.15, bellyDepth = 0.5;
};

/// A bone that heats the skin, and the joint at its lower end: the bone of a skeleton file's column.
struct RigBone {
  Bone bone;
  int end = 0;  ///< a child of bone.joint
};

/// The bones that heat the skin: those of the skeleton and, where it has shoulders and hips, a segment a side
/// that stands in for the ribs, carried by the spine: without it the flank follows the arm. A four-legged
/// body has another one in the middle above its belly: without it the groin follows the thighs.
std::vector<RigBone> rigBones(const Mesh& mesh, const Skeleton& skeleton, const Frames& rest,
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
