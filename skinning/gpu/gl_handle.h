#pragma once

#include <utility>

#include "skinning/gpu/gl.h"

namespace gelenk {

/// Owns one OpenGL object name; the deleter runs while its context is current. 0: nothing owned. Movable, not
/// copyable.
template <class Traits>
class GlHandle {
 public:
  GlHandle() = default;
  explicit GlHandle(GLuint name) : name_(name) {}
  GlHandle(GlHandle&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlHandle& operator=(GlHandle&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  ~GlHandle() {
    if (name_ != 0) Traits::destroy(name_);
  }
  static GlHandle create() { return GlHandle(Traits::create()); }
  operator GLuint() const { return name_; }

 private:
  GLuint name_ = 0;
};

struct BufferTraits {
  static GLuint create() {
    GLuint n = 0;
    glGenBuffers(1, &n);
    return n;
  }
  static void destroy(GLuint n) { glDeleteBuffers(1, &n); }
};
struct VertexArrayTraits {
  static GLuint create() {
    GLuint n = 0;
    glGenVertexArrays(1, &n);
    return n;
  }
  static void destroy(GLuint n) { glDeleteVertexArrays(1, &n); }
};
struct TextureTraits {
  static GLuint create() {
    GLuint n = 0;
    glGenTextures(1, &n);
    return n;
  }
  static void destroy(GLuint n) { glDeleteTextures(1, &n); }
};
struct FramebufferTraits {
  static GLuint create() {
    GLuint n = 0;
    glGenFramebuffers(1, &n);
    return n;
  }
  static void destroy(GLuint n) { glDeleteFramebuffers(1, &n); }
};
struct RenderbufferTraits {
  static GLuint create() {
    GLuint n = 0;
    glGenRenderbuffers(1, &n);
    return n;
  }
  static void destroy(GLuint n) { glDeleteRenderbuffers(1, &n); }
};
struct QueryTraits {
  static GLuint create() {
    GLuint n = 0;
    glGenQueries(1, &n);
    return n;
  }
  static void destroy(GLuint n) { glDeleteQueries(1, &n); }
};
struct ProgramTraits {
  static GLuint create() { return glCreateProgram(); }
  static void destroy(GLuint n) { glDeleteProgram(n); }
};

using GlBuffer = GlHandle<BufferTraits>;
using GlVertexArray = GlHandle<VertexArrayTraits>;
using GlTexture = GlHandle<TextureTraits>;
using GlFramebuffer = GlHandle<FramebufferTraits>;
using GlRenderbuffer = GlHandle<RenderbufferTraits>;
using GlQuery = GlHandle<QueryTraits>;
using GlProgram = GlHandle<ProgramTraits>;

}  // namespace gelenk
