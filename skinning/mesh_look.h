#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace gelenk {

/// A picture that lies on a surface: rows from the top, four bytes a pixel, sRGB with straight alpha.
struct Texture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;
  std::string file = {};  ///< that it was read from; empty: none of its own
};

/// How a part of a surface looks. Colours are linear light, 0 to 1.
struct Material {
  std::string name = {};
  Eigen::Vector4f colour = Eigen::Vector4f::Ones();  ///< times texture and vertex colour
  int texture = -1;                                  ///< in MeshLook::textures; -1: none
  float cutOff = 0.0f;                               ///< above 0: where alpha is below it nothing is drawn
  bool doubleSided = true;                           ///< false: the inside is not drawn
  float gloss = 0.0f;                                ///< 0 clay, 1 polished
};

/// Colours of a mesh, beside its shape: which material each stretch of triangles has, and what the vertices
/// carry for it.
struct MeshLook {
  struct Part {
    std::string name = {};
    int firstTriangle = 0, triangleCount = 0;
    int material = 0;
    bool shown = true;
  };
  std::vector<Material> materials;
  std::vector<std::shared_ptr<const Texture>> textures = {};
  std::vector<Part> parts;                        ///< one after the other over all triangles
  std::vector<Eigen::Vector2f> coordinates = {};  ///< one a vertex, (0, 0) the texture's upper left; or none
  std::vector<Eigen::Vector3f> colours = {};      ///< one a vertex, or none: white
};

/// Throws std::invalid_argument: parts that do not cover so many triangles in order, materials and textures
/// that are not there, coordinates or colours that are not one a vertex.
void validate(const MeshLook& look, int vertexCount, int triangleCount);

/// Linear light of an sRGB value, 0 to 1.
float linearFromSrgb(float value);
Eigen::Vector3f linearFromSrgb(const Eigen::Vector3f& rgb);
/// Its inverse.
float srgbFromLinear(float value);

}  // namespace gelenk
