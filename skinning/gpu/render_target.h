#pragma once

#include <cstdint>
#include <vector>

#include "skinning/gpu/gl_handle.h"

namespace gelenk {

/// A framebuffer of its own: one colour attachment and a 24-bit depth attachment, textures where it is not
/// multisampled.
class RenderTarget {
 public:
  /// Rgba8 keeps what is written, as a window does; Srgb8 encodes on writing while
  /// encodeSrgbTargets is on.
  enum class Colour { Rgba8, Srgb8 };

  RenderTarget() = default;  ///< nothing; a place to assign to
  /// samples: 0 for none. Throws std::runtime_error where the driver cannot make it.
  RenderTarget(int width, int height, Colour format = Colour::Rgba8, int samples = 0);

  int width() const { return width_; }
  int height() const { return height_; }
  int samples() const { return samples_; }
  GLuint framebuffer() const { return framebuffer_; }
  GLuint texture() const { return texture_; }     ///< the colour; 0 where multisampled
  GLuint depthTexture() const { return depth_; }  ///< likewise

  /// RGBA as stored, top row first: 4 width height bytes. Not for multisampled targets.
  std::vector<std::uint8_t> readPixels() const;

 private:
  int width_ = 0, height_ = 0, samples_ = 0;
  GlFramebuffer framebuffer_;
  GlTexture texture_, depth_;
  GlRenderbuffer multisampledColour_, multisampledDepth_;
};

/// Pixels of any framebuffer that is not multisampled: RGBA as stored, top row first.
std::vector<std::uint8_t> readPixels(GLuint framebuffer, int width, int height);

/// Throws std::runtime_error unless the bound framebuffer is complete.
void requireCompleteFramebuffer(const char* what);

}  // namespace gelenk
