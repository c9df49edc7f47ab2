#pragma once

#include <span>
#include <vector>

#include "skinning/mesh.h"
#include "skinning/rigging/bone.h"
#include "skinning/skin.h"

namespace gelenk {

struct BoneHeatOptions {
  /// Strength of the bones' heat, c in H = c / d^2. The transition between two bones is about d / sqrt(c)
  /// wide.
  double strength = 10.0;
  /// Voxels along the longest side of the bounding box, for distances inside the volume.
  int voxels = 160;
  /// Edges that are longer are cut, in diagonals of the bounding box (up to 30,000 triangles are): a coarse
  /// triangle's corner would heat all of its share by its own bone, and two corners meet in a step where fine
  /// triangles have a slope.
  double longestEdge = 0.02;
};

/// Skin weights by heat diffusion on the surface (Baran and Popovic 2007): for each joint the equilibrium of
///     (K + M H) w = M H p,   H = c / d^2,
/// K the cotangent matrix with negative entries clamped to 0, M the lumped areas, d the distance to the
/// vertex's own bone (at least 0.8 of that bone's mean, so that a bone close under the skin makes no step)
/// and p = 1 where that bone is the joint's. Its own bone is the nearest one inside the volume (Dionne and de
/// Lasa 2013), found on voxels, so that a hand near the hip does not take hold of it. One factorisation, one
/// solve a joint. Coarse triangles get the weights of fine ones.
///
/// Any mesh: it is welded first and the result scattered back; holes, several components, flipped or
/// degenerate faces and loose vertices are fine. Each row is non-negative and sums to 1. bones: joint indices
/// may repeat. Throws std::invalid_argument for an invalid mesh or no bones, std::runtime_error where the
/// factorisation fails.
SparseWeights boneHeatWeights(const Mesh& mesh, std::span<const Bone> bones,
                              const BoneHeatOptions& options = {});

/// For each position the index of its own bone, as above: nearest inside the volume.
std::vector<int> nearestBoneInside(const Mesh& mesh, std::span<const Bone> bones, int voxels);

}  // namespace gelenk
