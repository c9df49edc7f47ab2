#pragma once

#include <imgui.h>

#include <string>
#include <vector>

#include "apps/render/ui_style.h"

namespace gelenk {

/// One line of a plot; x is the index.
struct Curve {
  std::vector<double> values;
  ImVec4 colour;
  float width = 1.8f;
  std::string label = {};  ///< written beside its last point
  bool dots = false;
};

struct PlotLook {
  std::string title;
  std::string xLabel;
  bool logarithmic = false;  ///< powers of ten on the y axis; values <= 0 are drawn at the lower edge
  double lowest = 0.0,
         highest = 1.0;  ///< the least range shown; grows with the data, downwards by three decades at most
  int leastCount = 10;   ///< points that the x axis holds at least
};

/// A plot in the rectangle, drawn with ImDrawList: thin grid, ticks, title in the upper left, labels beside
/// the curves.
void drawPlot(const PlotLook& look, const std::vector<Curve>& curves, ImVec2 position, ImVec2 size,
              const Palette& palette, const Fonts& fonts, float scale);

/// A value within its range as a row: name, bar with the allowed range, marker; red at a limit.
struct RangeRow {
  std::string name;
  double value, lower, upper;
  bool atLimit;
};
/// Rows of joint angles against their limits, in as many columns as fit.
void drawRanges(const std::string& title, const std::vector<RangeRow>& rows, ImVec2 position, ImVec2 size,
                const Palette& palette, const Fonts& fonts, float scale);

}  // namespace gelenk
