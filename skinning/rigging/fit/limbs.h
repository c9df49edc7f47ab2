#pragma once

#include <Eigen/Core>

#include "skinning/rigging/fit/voxel_body.h"

namespace gelenk {

/// How many slender branches a body has: arms, legs, a tail; fingers and noses are too short to count, and
/// limbs that touch each other or the trunk all along are one with it. The distance from the middle, inside
/// the body, falls from each tip towards the trunk; what is further away than a level falls into pieces, and
/// a piece is a limb where it is longer than a fifth of the way to the furthest tip and than 1.7 times its
/// thickness (of the largest ball in it) before it meets another.
int countLimbs(const VoxelBody& body);

/// On how many legs a body stands: parts of its cut between 5 and 15 % of its height that reach all through
/// that. People have two, in a long skirt one; a chair has four.
int countLegs(const VoxelBody& body, const Eigen::Vector3d& up);

}  // namespace gelenk
