#include "skinning/io/picture.h"

#include <filesystem>
#include <limits>

#include "kinematics/io/text_file.h"

#if __has_include(<stb/stb_image.h>)
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC  // other libraries bring the same code
#define STBI_NO_STDIO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop
#endif

namespace gelenk {

std::shared_ptr<const Texture> readPicture(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return nullptr;
  const auto picture = decodePicture(readFile(path));
  if (!picture) return nullptr;
  Texture named = *picture;
  named.file = path;
  return std::make_shared<const Texture>(std::move(named));
}

std::shared_ptr<const Texture> decodePicture([[maybe_unused]] std::string_view bytes) {
#if __has_include(<stb/stb_image.h>)
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) return nullptr;
  Texture texture;
  const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
      stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(bytes.data()), static_cast<int>(bytes.size()),
                            &texture.width, &texture.height, nullptr, 4),
      stbi_image_free);
  if (!pixels) return nullptr;
  texture.rgba.assign(pixels.get(),
                      pixels.get() + 4 * static_cast<std::size_t>(texture.width) * texture.height);
  return std::make_shared<const Texture>(std::move(texture));
#else
  return nullptr;
#endif
}

}  // namespace gelenk
