#pragma once

#include "skinning/rigging/bone.h"
#include "skinning/rigging/fit/rig_skeleton.h"
#include "skinning/skin.h"

namespace gelenk {

/// The bones that heat the skin: those of the skeleton and, where it has shoulders and hips, two segments a
/// side that stand in for the ribs, carried by the spine: without them the flank follows the arm.
std::vector<Bone> rigBones(const Skeleton& skeleton, const Frames& rest);

/// Heat weights of the joints (bone_heat.h) for a fitted skeleton in its rest pose.
SparseWeights rigWeights(const Mesh& mesh, const Skeleton& skeleton, const std::vector<RigJoint>& joints);

}  // namespace gelenk
