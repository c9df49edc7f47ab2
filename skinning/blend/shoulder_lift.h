#pragma once

#include "skinning/blend/limb_chains.h"
#include "skinning/blend/skin_method.h"

namespace gelenk {

/// How far centres of rotation go up to their vertices where an arm meets the trunk, 0 to 1.
inline constexpr double shoulderLift = 0.5;

/// Lifts the centres of rotation of shoulders. About a centre on the bone the skin over a raised arm swings
/// out in an arc and the shoulder swells. Linear blending for a point y that belongs to the vertex and one
/// rotation about it, x' = L(y) + R (x - y), is linear blending itself where y = x: the centre is moved
/// towards the vertex, along the body's up alone, so that arms that swing forwards or across, about up, keep
/// what centres of rotation give them:
///
///     c <- c + lift s u u^T (x - c),   s = W (1 - W) / sum_{j<k} w_j w_k
///
///     u the unit direction from the middle of the hips to that of the shoulders, W the vertex's weight on an
///     arm, s the part of its pairs of bones that are one of the arm and one of the rest.
///
/// Without two arms and two legs nothing is done. bound: frames of the bind pose; metres.
void liftShoulderCentres(PreparedSkin& prepared, const Skeleton& skeleton, const Frames& bound,
                         const std::vector<LimbChain>& limbs, double lift = shoulderLift);

}  // namespace gelenk
