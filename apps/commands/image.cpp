#include "apps/commands/image.h"

#include <png.h>

#include <stdexcept>
#include <string_view>

#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

std::string encodePng(const Image& image, bool withAlpha) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = withAlpha ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
  std::string values;
  values.reserve(image.pixels.size());
  for (std::size_t i = 0; i < image.pixels.size(); i += 4)
    values.append(reinterpret_cast<const char*>(&image.pixels[i]), withAlpha ? 4 : 3);

  png_alloc_size_t bytes = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::string encoded(bytes, '\0');
  if (!png_image_write_to_memory(&header, encoded.data(), &bytes, 0, values.data(), 0, nullptr))
    throw std::runtime_error(std::string("cannot encode a PNG: ") + header.message);
  encoded.resize(bytes);
  return encoded;
}

}  // namespace

void writePng(const std::string& path, const Image& image, bool withAlpha) {
  if (image.width < 1 || image.height < 1 ||
      image.pixels.size() != 4 * static_cast<std::size_t>(image.width) * image.height)
    throw std::invalid_argument("an image needs 4 bytes for each of its pixels");
  writeFile(path, encodePng(image, withAlpha));
}

}  // namespace gelenk
