#include "skinning/mesh_look.h"

#include <cmath>
#include <stdexcept>

namespace gelenk {

void validate(const MeshLook& look, int vertexCount, int triangleCount) {
  int next = 0;
  for (const MeshLook::Part& part : look.parts) {
    if (part.firstTriangle != next || part.triangleCount < 0)
      throw std::invalid_argument("parts of a look follow each other over the triangles");
    next += part.triangleCount;
    if (part.material < 0 || part.material >= static_cast<int>(look.materials.size()))
      throw std::invalid_argument("a part of a look has a material that is not there");
  }
  if (next != triangleCount) throw std::invalid_argument("the parts of a look cover all triangles");
  for (const Material& material : look.materials)
    if (material.texture >= static_cast<int>(look.textures.size()))
      throw std::invalid_argument("a material has a texture that is not there");
  for (const auto& texture : look.textures)
    if (!texture || texture->width < 1 || texture->height < 1 ||
        texture->rgba.size() != 4 * static_cast<std::size_t>(texture->width) * texture->height)
      throw std::invalid_argument("a texture holds four bytes a pixel");
  const auto onePerVertex = [&](std::size_t count) {
    return count == 0 || count == static_cast<std::size_t>(vertexCount);
  };
  if (!onePerVertex(look.coordinates.size()) || !onePerVertex(look.colours.size()))
    throw std::invalid_argument("a look has one texture coordinate and one colour a vertex, or none");
}

float linearFromSrgb(float value) {
  return value <= 0.04045f ? value / 12.92f : std::pow((value + 0.055f) / 1.055f, 2.4f);
}
Eigen::Vector3f linearFromSrgb(const Eigen::Vector3f& rgb) {
  return {linearFromSrgb(rgb.x()), linearFromSrgb(rgb.y()), linearFromSrgb(rgb.z())};
}
float srgbFromLinear(float value) {
  return value <= 0.0031308f ? 12.92f * value : 1.055f * std::pow(value, 1.0f / 2.4f) - 0.055f;
}

}  // namespace gelenk
