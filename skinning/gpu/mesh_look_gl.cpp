#include "skinning/gpu/mesh_look_gl.h"

#include <algorithm>

namespace gelenk {
namespace {

/// Halves a picture that the renderer cannot hold until it can.
Texture fitting(const Texture& texture, int most) {
  if (texture.width <= most && texture.height <= most) return texture;
  Texture half{
      .width = std::max(1, texture.width / 2), .height = std::max(1, texture.height / 2), .rgba = {}};
  half.rgba.resize(4 * static_cast<std::size_t>(half.width) * half.height);
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x)
      for (int k = 0; k < 4; ++k)
        half.rgba[4 * (static_cast<std::size_t>(y) * half.width + x) + k] =
            texture.rgba[4 * (static_cast<std::size_t>(2 * y) * texture.width + 2 * x) + k];
  return fitting(half, most);
}

GlTexture upload(const Texture& source) {
  GLint most = 2048;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
  const Texture texture = fitting(source, most);
  GlTexture handle = GlTexture::create();
  glBindTexture(GL_TEXTURE_2D, handle);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8_ALPHA8, texture.width, texture.height, 0, GL_RGBA, GL_UNSIGNED_BYTE,
               texture.rgba.data());
  glGenerateMipmap(GL_TEXTURE_2D);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_REPEAT);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_REPEAT);
  glBindTexture(GL_TEXTURE_2D, 0);
  return handle;
}

}  // namespace

MeshLookGl::MeshLookGl(MeshLook look)
    : look_(std::move(look)), white_(upload({.width = 1, .height = 1, .rgba = {255, 255, 255, 255}})) {
  for (const auto& texture : look_.textures) textures_.push_back(upload(*texture));
}

GLuint MeshLookGl::texture(const Material& material) const {
  return material.texture >= 0 ? textures_[material.texture] : white_;
}

}  // namespace gelenk
