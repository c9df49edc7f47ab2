#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "skinning/skin.h"

namespace gelenk {

/// FNV-1a, 64 bits.
std::uint64_t checksum(std::string_view bytes);

/// $XDG_CACHE_HOME/gelenk, else $HOME/.cache/gelenk; empty where neither variable is set.
std::string cacheFolder();

/// The skin in a file of this program, as it was written. nullopt where the file is missing, cut short,
/// damaged (its checksum says so), or was made from something else (another key).
std::optional<Skin> readCachedSkin(const std::string& path, std::uint64_t key);

/// Throws std::runtime_error with the system's reason.
void writeCachedSkin(const std::string& path, std::uint64_t key, const Skin& skin);

/// The skin called `name` from the folder, or a new one, which is then kept there. A folder that is empty
/// (""), missing or read-only costs time, never an error.
Skin cachedSkin(const std::string& folder, const std::string& name, std::uint64_t key,
                const std::function<Skin()>& make);

}  // namespace gelenk
