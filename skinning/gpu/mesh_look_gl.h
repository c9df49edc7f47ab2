#pragma once

#include <vector>

#include "skinning/gpu/gl_handle.h"
#include "skinning/mesh_look.h"

namespace gelenk {

/// A look in GPU memory: its textures, with mipmaps, decoded from sRGB when they are read.
class MeshLookGl {
 public:
  explicit MeshLookGl(MeshLook look);
  const MeshLook& look() const { return look_; }
  /// Of a material; white for one without.
  GLuint texture(const Material& material) const;

 private:
  MeshLook look_;
  std::vector<GlTexture> textures_;
  GlTexture white_;
};

}  // namespace gelenk
