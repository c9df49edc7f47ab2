#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "skinning/mesh_look.h"

namespace gelenk {

/// Where a surface may let light through it is drawn solid from this alpha on, and not at all below.
inline constexpr float blendCutOff = 0.3f;

/// A picture file (PNG, JPEG, TGA, BMP and others that stb_image reads); null where it is not there, cannot
/// be decoded or this build has no stb.
std::shared_ptr<const Texture> readPicture(const std::string& path);
/// The same from the file's bytes.
std::shared_ptr<const Texture> decodePicture(std::string_view bytes);

}  // namespace gelenk
