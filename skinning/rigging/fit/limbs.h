#pragma once

#include "skinning/rigging/fit/voxel_body.h"

namespace gelenk {

/// How many slender branches a body has: arms, legs, a tail; fingers and noses are too short to count, and
/// limbs that touch each other or the trunk all along are one with it. The distance from the middle, inside
/// the body, falls from each tip towards the trunk; what is further away than a level falls into pieces, and
/// a piece is a limb where it is longer than a fifth of the way to the furthest tip and than 1.7 times its
/// thickness (of the largest ball in it) before it meets another.
int countLimbs(const VoxelBody& body);

}  // namespace gelenk
