#pragma once

#include "skinning/gpu/gl_handle.h"

namespace gelenk {

/// A colour texture with a framebuffer, of the size of the view; 8-bit RGBA, holding sRGB-encoded values as
/// they are.
class ViewPicture {
 public:
  /// Makes it anew when that changes. stretched: it is shown in another size. The framebuffer binding is left
  /// changed.
  void resize(int width, int height, bool stretched = false);
  unsigned framebuffer() const { return framebuffer_; }
  unsigned texture() const { return texture_; }

 private:
  int width_ = 0, height_ = 0;
  bool stretched_ = false;
  GlTexture texture_;
  GlFramebuffer framebuffer_;
};

}  // namespace gelenk
