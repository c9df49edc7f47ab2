// Pictures as PNG without libpng.
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image_write.h>

#include <stdexcept>

#include "apps/commands/image.h"

namespace gelenk {

void writePng(const std::string& path, const Image& image, bool withAlpha) {
  const int bytes = withAlpha ? 4 : 3;
  std::vector<std::uint8_t> values;
  values.reserve(image.pixels.size());
  for (std::size_t i = 0; i < image.pixels.size(); i += 4)
    values.insert(values.end(), image.pixels.begin() + i, image.pixels.begin() + i + bytes);
  if (!stbi_write_png(path.c_str(), image.width, image.height, bytes, values.data(), bytes * image.width))
    throw std::runtime_error("cannot write " + path);
}

}  // namespace gelenk
