#pragma once

#include <string>

#include "skinning/blend/skin_choice.h"

namespace gelenk {

/// prepareSkin (skin_choice.h, layers apart) with what takes long, smoothed weights and centres of rotation,
/// kept in a file of the folder: NAME and the choice name it, and its key is a checksum of all that it is
/// made from. A folder that is empty (""), missing or read-only, a damaged or old file cost time, never an
/// error.
PreparedSkin cachedPreparedSkin(const std::string& folder, const std::string& name, const Skin& skin,
                                SkinChoice choice, const Skeleton& skeleton, const Frames& bound);

/// Puts into the folder what was prepared elsewhere: weights, centres and their slopes of `prepared`, where
/// the function above looks for it.
void keepPreparedSkin(const std::string& folder, const std::string& name, const Skin& skin,
                      const SkinChoice& choice, const PreparedSkin& prepared);

}  // namespace gelenk
