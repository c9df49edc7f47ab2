#pragma once

#include "apps/render/overlay.h"
#include "skinning/gpu/gl_handle.h"
#include "skinning/gpu/shader_program.h"

namespace gelenk {

/// Draws overlays with the frame's uniforms: fills as triangles, lines and points as quads of their width in
/// pixels.
class OverlayGl {
 public:
  explicit OverlayGl(GLuint frameBinding);
  /// Depth test on, blending on. Opaque fills and lines and points write depth, translucent ones do not.
  /// Leaves depth writes on.
  void draw(const Overlay& overlay);

 private:
  void drawLines(std::size_t first, std::size_t count);

  ShaderProgram fill_, line_, point_;
  GlVertexArray fillArray_, lineArray_, pointArray_;
  GlBuffer fillBuffer_, lineBuffer_, pointBuffer_;
  std::vector<Overlay::Vertex> sorted_;
};

ShaderFolder rendererShaders();  ///< apps/render/shaders, embedded at build time

}  // namespace gelenk
