#pragma once

#include <string>
#include <string_view>

#include "kinematics/skeleton.h"
#include "skinning/blend/skin_choice.h"

namespace gelenk {

/// A body that is its own mirror image at x = 0, small enough to be sent: places in steps of a 2^18th of its
/// size, weights of a 65,535th, one half of it. Throws std::invalid_argument for a body that is not
/// symmetric.
std::string packBody(const Skin& skin);
/// The whole body again; takes it from the front. Throws std::runtime_error where bytes are missing.
Skin unpackBody(std::string_view& packed, const Skeleton& skeleton);

/// What takes long to prepare for such a body (prepareSkin), smoothed weights and centres of rotation, in the
/// same steps.
std::string packPrepared(const SkinChoice& choice, const PreparedSkin& prepared);
/// The choice, and skin, centres and their slopes again: nothing else is set. body: unpacked.
std::pair<SkinChoice, PreparedSkin> unpackPrepared(std::string_view packed, const Skin& body,
                                                   const Skeleton& skeleton);

}  // namespace gelenk
