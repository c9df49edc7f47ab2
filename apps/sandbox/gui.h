#pragma once

#include "apps/render/ui_style.h"
#include "apps/sandbox/input.h"

namespace gelenk {

/// Dear ImGui without a window system: input comes from InputEvents, so that window, offscreen and replay
/// take the same way. Needs a current GL 3.3 context for its whole life.
class Gui {
 public:
  Gui();
  ~Gui();
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;

  /// Style and fonts; does nothing when both are as they were.
  void setLook(Theme theme, float scale);
  const Fonts& fonts() const { return fonts_; }

  void beginFrame(const Input& input, double dt);
  /// Draws everything into the framebuffer that is bound.
  void endFrame();

 private:
  Theme theme_ = Theme::Light;
  float scale_ = 0.0f;
  Fonts fonts_;
};

}  // namespace gelenk
