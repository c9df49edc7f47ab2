#pragma once

/// OpenGL as this program uses it: what OpenGL 3.3 core and WebGL 2 have in common, by the same sources and
/// shaders (docs/rendering.md). The few places where the two differ are here.
#ifdef __EMSCRIPTEN__
#include <GLES3/gl3.h>
/// In WebGL 2, though not in OpenGL ES 3, whose header this is.
extern "C" void glGetBufferSubData(GLenum target, GLintptr offset, GLsizeiptr size, void* data);
#else
#include <epoxy/gl.h>
#endif

namespace gelenk {

/// The lines before every shader.
#ifdef __EMSCRIPTEN__
inline constexpr const char* glslHeader =
    "#version 300 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler2D;\n"
    "precision highp sampler2DShadow;\n";
#else
inline constexpr const char* glslHeader = "#version 330 core\n";
#endif

/// Whether numbers written into an sRGB target are encoded. WebGL does so always.
inline void encodeSrgbTargets([[maybe_unused]] bool on) {
#ifndef __EMSCRIPTEN__
  if (on)
    glEnable(GL_FRAMEBUFFER_SRGB);
  else
    glDisable(GL_FRAMEBUFFER_SRGB);
#endif
}

}  // namespace gelenk
