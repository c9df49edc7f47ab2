#pragma once

#include "kinematics/motion/skeleton_transfer.h"
#include "skinning/io/pinocchio_weights.h"

namespace gelenk {

/// Pinocchio's weights on the bones of the ASF skeleton that lie on the fitted bones. Where several lie on
/// one, a vertex divides its weight by where it stands along the bone, with a smooth step over half the
/// shorter piece at each border. The weight of a fitted bone on which none lies goes to the ASF joint nearest
/// to its start in the bind pose. vertices: positions of the mesh in the fitted pose; weights: vertices x
/// (fitted joints - 1).
SparseWeights transferWeights(const BoneWeights& weights, const std::vector<Eigen::Vector3d>& vertices,
                              const Skeleton& fitted, const TransferredSkeleton& transferred);

}  // namespace gelenk
