#pragma once

#include <cstdint>
#include <vector>

#include "skinning/gpu/gl_handle.h"

namespace gelenk {

/// A framebuffer of its own: one 8-bit sRGB colour attachment and a 24-bit depth attachment, optionally multisampled.
class RenderTarget {
 public:
  /// samples: 0 for none. Throws std::runtime_error where the driver cannot make it.
  RenderTarget(int width, int height, int samples = 0);

  int width() const { return width_; }
  int height() const { return height_; }
  int samples() const { return samples_; }
  GLuint framebuffer() const { return framebuffer_; }
  /// The colour as a texture (GL_SRGB8_ALPHA8); 0 where multisampled.
  GLuint texture() const { return colour_; }

  /// Resolves (and needs equal sizes where multisampled) into another framebuffer.
  void blitTo(GLuint framebuffer, int width, int height) const;
  /// RGBA, top row first, as stored (sRGB encoded). 4 width height bytes.
  std::vector<std::uint8_t> readPixels() const;

 private:
  int width_, height_, samples_;
  GlFramebuffer framebuffer_;
  GlTexture colour_;
  GlRenderbuffer multisampledColour_, depth_;
};

/// Pixels of a framebuffer: RGBA, top row first.
std::vector<std::uint8_t> readPixels(GLuint framebuffer, int width, int height);

}  // namespace gelenk
