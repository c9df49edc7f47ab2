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

  /// Gives the next widget, a text field, the keys; those that are pressed until it has them wait for it.
  void focusText();
  /// Whom the next frame's keys belong to.
  Keys keys() const;

 private:
  int awaited_ = 0;  ///< frames in which a text field may still become ready
  Theme theme_ = Theme::Light;
  float scale_ = 0.0f;
  Fonts fonts_;
};

/// A rectangle with round corners, as what is plotted on; a large opaque one on whole pixels costs little.
void fillRounded(ImDrawList& draw, ImVec2 low, ImVec2 high, ImU32 colour, float rounding);

/// From where to where something lies along a line, pixels.
struct Span {
  float low = 0, high = 0;
};
/// Where a slider's value, so wide, is written within its frame: at its end, at its beginning where the grab
/// would cover it there; where neither has room, in the wider rest, as much of it as that holds. gap: kept to
/// both ends and to the grab.
Span placeOfValue(const Span& frame, const Span& grab, float width, float gap);

/// The sliders of every panel: as Dear ImGui's, but that the grab never covers the value.
/// Ctrl+click types. True when moved.
bool valueSlider(const char* label, float& value, float lower, float upper, const char* format,
                 ImGuiSliderFlags flags = 0);
bool valueSlider(const char* label, double& value, double lower, double upper, const char* format,
                 ImGuiSliderFlags flags = 0);
bool valueSlider(const char* label, int& value, int lower, int upper, const char* format,
                 ImGuiSliderFlags flags = 0);

}  // namespace gelenk
