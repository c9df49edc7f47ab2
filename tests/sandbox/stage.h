#pragma once

#include <string>

#include "apps/sandbox/gui.h"
#include "apps/sandbox/replay.h"
#include "apps/sandbox/sandbox.h"
#include "apps/sandbox/view_picture.h"
#include "skinning/gpu/offscreen_context.h"
#include "skinning/gpu/render_target.h"

namespace gelenk::testing {

/// A sandbox without a window, and everything that it needs to be driven and drawn.
struct Stage {
  OffscreenContext context;
  GlDebugLog log;
  Sandbox sandbox;
  ViewPicture target;
  InputQueue queue;
  int width, height;

  explicit Stage(const SandboxOptions& options)
      : sandbox(options), width(options.width), height(options.height) {
    target.resize(width, height);
  }
  void frame() {
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
    sandbox.frame({.width = width, .height = height, .events = queue.take(sandbox.keys())}, 1.0 / 60.0);
  }
  /// The script's frames, counted from 0, and some more.
  void play(const std::string& script, int more = 2) {
    Replay replay = Replay::parse("test", script);
    for (int i = 0; i < replay.length() + more; ++i) {
      replay.play(i, sandbox, queue);
      frame();
    }
  }
};

}  // namespace gelenk::testing
