// Pictures as PNG without libpng.
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image_write.h>

#include <stdexcept>

#include "apps/commands/image.h"

namespace gelenk {

void writePng(const std::string& path, const Image& image) {
  std::vector<std::uint8_t> rgb;
  rgb.reserve(image.pixels.size() / 4 * 3);
  for (std::size_t i = 0; i < image.pixels.size(); i += 4)
    rgb.insert(rgb.end(), image.pixels.begin() + i, image.pixels.begin() + i + 3);
  if (!stbi_write_png(path.c_str(), image.width, image.height, 3, rgb.data(), 3 * image.width))
    throw std::runtime_error("cannot write " + path);
}

}  // namespace gelenk
