#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace gelenk {

/// 8-bit RGBA, sRGB encoded, top row first.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;  ///< 4 width height

  const std::uint8_t* at(int x, int y) const {
    return &pixels[4 * (static_cast<std::size_t>(y) * width + x)];
  }
};

/// Writes a PNG, through a temporary file. Throws std::runtime_error with the system's reason.
void writePng(const std::string& path, const Image& image, bool withAlpha = false);

}  // namespace gelenk
