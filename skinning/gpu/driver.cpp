#include "skinning/gpu/driver.h"

#include <stdexcept>

#include "skinning/gpu/gl.h"
#ifdef __EMSCRIPTEN__
#include <emscripten/html5.h>
#endif

namespace gelenk {

std::string glRenderer() {
#ifdef __EMSCRIPTEN__
  // A page gets the true name from an extension alone.
  constexpr GLenum unmasked = 0x9246;  // UNMASKED_RENDERER_WEBGL
  if (emscripten_webgl_enable_extension(emscripten_webgl_get_current_context(), "WEBGL_debug_renderer_info"))
    return reinterpret_cast<const char*>(glGetString(unmasked));
#endif
  const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return name ? name : "unknown renderer";
}

bool isSoftwareRenderer() {
  const std::string name = glRenderer();
  for (const char* software : {"llvmpipe", "softpipe", "SwiftShader", "swrast"})
    if (name.find(software) != std::string::npos) return true;
  return false;
}

void requireOpenGl33(int major, int minor, const std::string& renderer) {
  if (10 * major + minor >= 33) return;
  throw std::runtime_error("OpenGL 3.3 is needed, but " + renderer + " offers " + std::to_string(major) +
                           "." + std::to_string(minor) +
                           "; a newer driver, or the software renderer (LIBGL_ALWAYS_SOFTWARE=1), would do");
}

void requireOpenGl33() {
#ifndef __EMSCRIPTEN__  // there a context is WebGL 2
  requireOpenGl33(epoxy_gl_version() / 10, epoxy_gl_version() % 10, glRenderer());
#endif
}

}  // namespace gelenk
