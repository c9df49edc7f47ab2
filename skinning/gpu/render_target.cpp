#include "skinning/gpu/render_target.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace gelenk {

void requireCompleteFramebuffer(const char* what) {
  const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status == GL_FRAMEBUFFER_COMPLETE) return;
  throw std::runtime_error(std::string("the renderer cannot make a framebuffer for ") + what + " (status " +
                           std::to_string(status) + ")");
}

namespace {

GlTexture attachedTexture(GLenum attachment, GLenum internal, GLenum format, GLenum type, GLint filter,
                          int width, int height) {
  GlTexture texture = GlTexture::create();
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(internal), width, height, 0, format, type, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glBindTexture(GL_TEXTURE_2D, 0);
  glFramebufferTexture2D(GL_FRAMEBUFFER, attachment, GL_TEXTURE_2D, texture, 0);
  return texture;
}

GlRenderbuffer attachedBuffer(GLenum attachment, GLenum internal, int samples, int width, int height) {
  GlRenderbuffer buffer = GlRenderbuffer::create();
  glBindRenderbuffer(GL_RENDERBUFFER, buffer);
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, internal, width, height);
  glBindRenderbuffer(GL_RENDERBUFFER, 0);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer);
  return buffer;
}

}  // namespace

RenderTarget::RenderTarget(int width, int height, Colour format, int samples)
    : width_(width), height_(height), samples_(samples), framebuffer_(GlFramebuffer::create()) {
  GLint largest = 0;
  glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &largest);
  if (width < 1 || height < 1 || width > largest || height > largest)
    throw std::runtime_error("a picture of " + std::to_string(width) + " x " + std::to_string(height) +
                             " pixels is not possible; this renderer's largest is " +
                             std::to_string(largest));
  const GLenum internal = format == Colour::Srgb8 ? GL_SRGB8_ALPHA8 : GL_RGBA8;
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  if (samples > 0) {
    multisampledColour_ = attachedBuffer(GL_COLOR_ATTACHMENT0, internal, samples, width, height);
    multisampledDepth_ = attachedBuffer(GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT24, samples, width, height);
  } else {
    texture_ =
        attachedTexture(GL_COLOR_ATTACHMENT0, internal, GL_RGBA, GL_UNSIGNED_BYTE, GL_LINEAR, width, height);
    depth_ = attachedTexture(GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT,
                             GL_NEAREST, width, height);
  }
  requireCompleteFramebuffer("the picture");
}

std::vector<std::uint8_t> RenderTarget::readPixels() const {
  return gelenk::readPixels(framebuffer_, width_, height_);
}

std::vector<std::uint8_t> readPixels(GLuint framebuffer, int width, int height) {
  const std::size_t row = 4 * static_cast<std::size_t>(width);
  std::vector<std::uint8_t> pixels(row * height);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
  for (int y = 0; y < height / 2; ++y)  // OpenGL begins at the bottom
    std::swap_ranges(&pixels[y * row], &pixels[y * row] + row, &pixels[(height - 1 - y) * row]);
  return pixels;
}

}  // namespace gelenk
