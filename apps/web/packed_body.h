#pragma once

#include <string>
#include <string_view>

#include "kinematics/skeleton.h"
#include "skinning/skin.h"

namespace gelenk {

/// A body that is its own mirror image at x = 0, small enough to be sent: places in steps of a 2^18th of its
/// size, weights of a 65,535th, one half of it. Throws std::invalid_argument for a body that is not
/// symmetric.
std::string packBody(const Skin& skin, const Skeleton& skeleton);
/// The whole body again. Throws std::runtime_error where bytes are missing.
Skin unpackBody(std::string_view packed, const Skeleton& skeleton);

}  // namespace gelenk
