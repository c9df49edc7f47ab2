#include "skinning/gpu/offscreen_context.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string_view>

namespace gelenk {
namespace {

bool contains(const char* list, const char* word) { return list && std::strstr(list, word) != nullptr; }

/// LIBGL_ALWAYS_SOFTWARE asks for Mesa's software renderer; a device of another vendor would not heed it.
bool softwareWanted() {
  const char* value = std::getenv("LIBGL_ALWAYS_SOFTWARE");
  return value && std::string_view(value) != "0" && std::string_view(value) != "false";
}

/// Displays in the order in which they are worth trying. Not yet initialised.
std::vector<EGLDisplay> candidateDisplays() {
  std::vector<EGLDisplay> displays;
  const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  if (!contains(client, "EGL_EXT_platform_base")) return {eglGetDisplay(EGL_DEFAULT_DISPLAY)};
  if (contains(client, "EGL_EXT_device_enumeration") && contains(client, "EGL_EXT_platform_device") &&
      !softwareWanted()) {
    EGLDeviceEXT devices[16];
    EGLint count = 0;
    if (eglQueryDevicesEXT(16, devices, &count))
      for (EGLint i = 0; i < count; ++i)
        if (!contains(eglQueryDeviceStringEXT(devices[i], EGL_EXTENSIONS), "EGL_MESA_device_software"))
          displays.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr));
  }
  if (contains(client, "EGL_MESA_platform_surfaceless"))
    displays.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
  return displays;
}

EGLContext createContext(EGLDisplay display, bool version33) {
  const EGLint configAttributes[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                                     EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (!eglChooseConfig(display, configAttributes, &config, 1, &count) || count == 0)
    config = EGL_NO_CONFIG_KHR;
  const EGLint core33[] = {EGL_CONTEXT_MAJOR_VERSION,
                           3,
                           EGL_CONTEXT_MINOR_VERSION,
                           3,
                           EGL_CONTEXT_OPENGL_PROFILE_MASK,
                           EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                           EGL_CONTEXT_OPENGL_DEBUG,
                           EGL_TRUE,
                           EGL_NONE};
  const EGLint any[] = {EGL_NONE};
  return eglCreateContext(display, config, EGL_NO_CONTEXT, version33 ? core33 : any);
}

/// The current context's version and renderer, once it is known that 3.3 core is not to be had.
[[noreturn]] void rejectOldContext() {
  const std::string renderer = glRenderer();
  requireOpenGl33(epoxy_gl_version() / 10, epoxy_gl_version() % 10, renderer);
  throw std::runtime_error("OpenGL 3.3 core is needed, and " + renderer + " does not offer the core profile");
}

}  // namespace

OffscreenContext::OffscreenContext() {
  bool anyDisplay = false;
  for (EGLDisplay display : candidateDisplays()) {
    EGLint major = 0, minor = 0;
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, &major, &minor) || !eglBindAPI(EGL_OPENGL_API))
      continue;
    anyDisplay = true;
    for (const bool version33 : {true, false}) {
      EGLContext context = createContext(display, version33);
      if (context == EGL_NO_CONTEXT) continue;
      if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
        display_ = display;
        context_ = context;
        if (!version33) rejectOldContext();
        requireOpenGl33();
        return;
      }
      eglDestroyContext(display, context);
    }
  }
  throw std::runtime_error(std::string(anyDisplay ? "EGL is there but gives no OpenGL context"
                                                  : "there is no EGL display to draw with") +
                           " (tried: EGL devices, then Mesa's surfaceless platform); install a driver, or "
                           "Mesa's software renderer: "
                           "apt install libgl1-mesa-dri libegl1");
}

OffscreenContext::~OffscreenContext() {
  // The display is one for the whole process (EGL hands out the same one again), so it is not terminated
  // here.
  if (eglGetCurrentContext() == context_)
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
}

void OffscreenContext::makeCurrent() const {
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_);
}

GlDebugLog::GlDebugLog() {
  available_ = epoxy_has_gl_extension("GL_KHR_debug");
  if (!available_) return;
  glEnable(GL_DEBUG_OUTPUT);
  glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  glDebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DONT_CARE, 0, nullptr, GL_TRUE);
  glDebugMessageCallback(
      [](GLenum, GLenum, GLuint, GLenum severity, GLsizei length, const GLchar* text, const void* log) {
        if (severity != GL_DEBUG_SEVERITY_NOTIFICATION)
          const_cast<GlDebugLog*>(static_cast<const GlDebugLog*>(log))
              ->messages_.emplace_back(text,
                                       length < 0 ? std::strlen(text) : static_cast<std::size_t>(length));
      },
      this);
}

GlDebugLog::~GlDebugLog() {
  if (available_ && glGetString(GL_VERSION)) glDebugMessageCallback(nullptr, nullptr);
}

}  // namespace gelenk
