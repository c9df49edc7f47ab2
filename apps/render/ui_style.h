#pragma once

#include <imgui.h>

#include <Eigen/Core>

#include "apps/document/theme.h"
#include "apps/render/signs.h"

namespace gelenk {

/// The colours of panels and marks. One hue for what is held (amber), one for what is pinned (teal), one for
/// what acts (blue), red for limits and failures only; told apart with any colour vision.
struct Palette {
  ImVec4 panel, panelRaised, panelSunken, border;
  ImVec4 text, textDim, textFaint;
  ImVec4 accent, accentText;
  ImVec4 held, pinned, pole, free;
  ImVec4 good, warning, bad;
  ImVec4 plotBackground, plotGrid;
};
const Palette& palette(Theme theme);

struct Fonts {
  ImFont *regular = nullptr, *medium = nullptr, *small = nullptr, *large = nullptr, *title = nullptr,
         *script = nullptr;
};

/// The first line of Dear ImGui's shaders.
#ifdef __EMSCRIPTEN__
inline constexpr const char* imguiShaderVersion = "#version 300 es";
#else
inline constexpr const char* imguiShaderVersion = "#version 330";
#endif

/// Spacing, rounding and colours of Dear ImGui; all sizes times scale.
void applyStyle(Theme theme, float scale);
/// Roboto through FreeType at the scale, the built-in font where Roboto is not installed. Clears the atlas.
Fonts loadFonts(float scale);

inline ImU32 colour32(const ImVec4& c, float alpha = 1.0f) {
  return ImGui::ColorConvertFloat4ToU32({c.x, c.y, c.z, c.w * alpha});
}
inline ImVec4 toImVec4(const Eigen::Vector3f& c, float alpha = 1.0f) { return {c.x(), c.y(), c.z(), alpha}; }
inline ImVec4 toImVec4(const Colour& c) { return {c.r, c.g, c.b, c.a}; }

}  // namespace gelenk
