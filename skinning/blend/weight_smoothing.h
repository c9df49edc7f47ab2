#pragma once

#include "skinning/skin.h"

namespace gelenk {

/// The length over which the built-in figure's weights are smoothed where a method blends rotations, metres.
inline constexpr double defaultSmoothing = 0.045;

/// The skin with weights smoothed over a length (metres) along its surface, or over the radius of a limb that
/// is thinner (of a joint's part of the surface: the root mean square distance from the axis along which the
/// part is longest; a vertex has the mean of its joints' by their weights). Two implicit steps of the heat
/// equation, dw/dt = div(l^2 grad w) / length^2, that together take t = length^2 / 2, so that a weight which
/// is 1 in one place alone spreads with the standard deviation l in each direction. Four are kept,
/// continuously along the surface (less the fifth largest). Vertices in one place stay alike. A length of 0
/// changes nothing. Throws std::invalid_argument where it is negative or not finite.
Skin smoothWeights(Skin skin, double length);

}  // namespace gelenk
