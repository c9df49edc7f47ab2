#pragma once

#include <string>
#include <vector>

#include "skinning/gpu/driver.h"

namespace gelenk {

/// An OpenGL 3.3 core context without a window, through EGL: first the machine's EGL devices (a software
/// device not among them), then Mesa's surfaceless platform. It has no framebuffer of its own: draw into a
/// RenderTarget. Current on the thread that made it, until it is destroyed.
class OffscreenContext {
 public:
  /// Throws std::runtime_error that says what was tried, and the way out, where there is no context or it is
  /// too old.
  OffscreenContext();
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;

  void makeCurrent() const;

 private:
  void* display_ = nullptr;
  void* context_ = nullptr;
};

/// Collects the messages of KHR_debug while it lives (errors, undefined behaviour, performance; not the
/// driver's chatter of severity "notification"). Needs a current context; collects nothing where the
/// extension is missing.
class GlDebugLog {
 public:
  GlDebugLog();
  ~GlDebugLog();
  GlDebugLog(const GlDebugLog&) = delete;
  GlDebugLog& operator=(const GlDebugLog&) = delete;

  const std::vector<std::string>& messages() const { return messages_; }
  bool available() const { return available_; }

 private:
  bool available_ = false;
  std::vector<std::string> messages_;
};

}  // namespace gelenk
