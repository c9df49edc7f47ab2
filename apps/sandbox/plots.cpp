#include "apps/sandbox/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/render/label_writer.h"
#include "apps/render/mathematics.h"
#include "apps/render/rulers.h"
#include "apps/sandbox/gui.h"

namespace gelenk {
namespace {

struct Area {
  ImVec2 low, high;  // upper left, lower right of the curves' field
};

void text(ImDrawList* draw, ImFont* font, ImVec2 at, const ImVec4& colour, const std::string& words) {
  draw->AddText(font, font->FontSize, at, colour32(colour), words.c_str());
}
float textWidth(ImFont* font, const std::string& words) {
  return font->CalcTextSizeA(font->FontSize, 1e9f, 0.0f, words.c_str()).x;
}

std::string superscript(int exponent) {
  static const char* digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string out = exponent < 0 ? "⁻" : "";
  for (const char c : std::to_string(std::abs(exponent))) out += digits[c - '0'];
  return out;
}

Area drawFrame(ImDrawList* draw, const std::string& title, ImVec2 position, ImVec2 size, float leftMargin,
               float bottomMargin, const Palette& palette, const Fonts& fonts, float scale) {
  fillRounded(*draw, position, {position.x + size.x, position.y + size.y}, colour32(palette.plotBackground),
              6.0f * scale);
  drawMathematics(*draw, fonts.small, fonts.small->FontSize,
                  {position.x + 10 * scale, position.y + 6 * scale}, colour32(palette.textDim), title);
  return {{position.x + leftMargin, position.y + 6 * scale + fonts.small->FontSize + 7 * scale},
          {position.x + size.x - 12 * scale, position.y + size.y - bottomMargin}};
}

struct Label {
  LabelBox box;
  ImVec4 colour;
  std::string words;
};

}  // namespace

void drawPlot(const PlotLook& look, const std::vector<Curve>& curves, ImVec2 position, ImVec2 size,
              const Palette& palette, const Fonts& fonts, float scale) {
  ImDrawList* draw = ImGui::GetWindowDrawList();
  const Area area =
      drawFrame(draw, look.title, position, size, 44 * scale, 24 * scale, palette, fonts, scale);

  std::size_t count = look.leastCount;
  double low = look.lowest, high = look.highest;
  for (const Curve& curve : curves) {
    count = std::max(count, curve.values.size());
    for (const double v : curve.values)
      if (std::isfinite(v) && (!look.logarithmic || v > 0.0)) {
        low = look.logarithmic ? std::min(low, std::max(v, 1e-3 * look.lowest)) : std::min(low, v);
        high = std::max(high, v);
      }
  }
  if (look.logarithmic) {
    low = std::floor(std::log10(low));
    high = std::max(std::ceil(std::log10(high)), low + 1.0);
  }
  const auto yOf = [&](double v) {
    const double u = look.logarithmic ? (v > 0.0 ? std::log10(v) : low) : v;
    const double t = std::clamp((u - low) / (high - low), 0.0, 1.0);
    return area.high.y - static_cast<float>(t) * (area.high.y - area.low.y);
  };
  const auto xOf = [&](double i) {
    return area.low.x + static_cast<float>(i / std::max<double>(count - 1, 1)) * (area.high.x - area.low.x);
  };

  const float lines = std::max((area.high.y - area.low.y) / (fonts.small->FontSize * 1.7f), 1.0f);
  const double step =
      look.logarithmic ? std::max(1.0, std::ceil((high - low) / lines)) : niceStep((high - low) / lines);
  for (double u = std::ceil(low / step) * step; u <= high + 1e-9; u += step) {
    const double v = look.logarithmic ? std::pow(10.0, u) : u;
    const float y = std::round(yOf(v)) + 0.5f;
    draw->AddLine({area.low.x, y}, {area.high.x, y}, colour32(palette.plotGrid), 1.0f);
    const std::string label = look.logarithmic ? "10" + superscript(static_cast<int>(std::lround(u)))
                                               : fmt::format("{:g}", std::abs(u) < 1e-12 ? 0.0 : u);
    text(draw, fonts.small,
         {area.low.x - 7 * scale - textWidth(fonts.small, label), y - 0.55f * fonts.small->FontSize},
         palette.textDim, label);
  }
  const double xStep = std::max(1.0, niceStep(static_cast<double>(count - 1) /
                                              std::max((area.high.x - area.low.x) / (60.0f * scale), 1.0f)));
  for (double i = 0; i <= static_cast<double>(count - 1) + 1e-9; i += xStep) {
    const float x = std::round(xOf(i)) + 0.5f;
    draw->AddLine({x, area.high.y}, {x, area.high.y + 3 * scale}, colour32(palette.border), 1.0f);
    const std::string label = fmt::format("{:g}", i);
    text(draw, fonts.small, {x - 0.5f * textWidth(fonts.small, label), area.high.y + 4 * scale},
         palette.textDim, label);
  }
  if (textWidth(fonts.small, look.title) + textWidth(fonts.small, look.xLabel) + 40 * scale < size.x)
    text(draw, fonts.small, {area.high.x - textWidth(fonts.small, look.xLabel), position.y + 6 * scale},
         palette.textFaint, look.xLabel);

  const ImVec2 from{area.low.x - 4 * scale, area.low.y - 6 * scale},
      to{area.high.x + 6 * scale, area.high.y + 4 * scale};
  draw->PushClipRect(from, to, true);
  std::vector<ImVec2> points;
  std::vector<Label> labels;
  for (const Curve& curve : curves) {
    points.clear();
    for (std::size_t i = 0; i < curve.values.size(); ++i)
      points.push_back({xOf(static_cast<double>(i)), yOf(curve.values[i])});
    if (points.empty()) continue;
    draw->AddPolyline(points.data(), static_cast<int>(points.size()), colour32(curve.colour), 0,
                      curve.width * scale);
    if (curve.dots || points.size() == 1)
      for (const ImVec2& p : points) draw->AddCircleFilled(p, 2.4f * scale, colour32(curve.colour));
    if (!curve.label.empty()) {
      const float height = fonts.small->FontSize;
      labels.push_back({{points.back().x + 4 * scale, points.back().y - height - 2 * scale,
                         textWidth(fonts.small, curve.label) + 4 * scale, height},
                        inkOf({curve.colour.x, curve.colour.y, curve.colour.z, 1.0f}, palette),
                        curve.label});
    }
  }
  LabelPlaces places({from.x, from.y, to.x - from.x, to.y - from.y});
  for (Label& label : labels) {
    if (!places.place(label.box)) continue;
    const LabelBox& box = label.box;  // to be read also over a curve
    draw->AddRectFilled({box.x, box.y}, {box.x + box.width, box.y + box.height},
                        colour32(palette.plotBackground, 0.8f), 2 * scale);
    text(draw, fonts.small, {box.x + 2 * scale, box.y}, label.colour, label.words);
  }
  draw->PopClipRect();
}

void drawRanges(const std::string& title, const std::vector<RangeRow>& rows, ImVec2 position, ImVec2 size,
                const Palette& palette, const Fonts& fonts, float scale) {
  ImDrawList* draw = ImGui::GetWindowDrawList();
  const Area area = drawFrame(draw, title, position, size, 10 * scale, 8 * scale, palette, fonts, scale);
  const float rowHeight = fonts.small->FontSize + 3 * scale;
  const int perColumn = std::max(1, static_cast<int>((area.high.y - area.low.y) / rowHeight));
  const int columns = std::max(1, static_cast<int>((area.high.x - area.low.x) / (190 * scale)));
  const float columnWidth = (area.high.x - area.low.x) / static_cast<float>(columns);
  const int shown = std::min<int>(static_cast<int>(rows.size()), perColumn * columns);
  for (int i = 0; i < shown; ++i) {
    const RangeRow& row = rows[i];
    const float x = area.low.x + columnWidth * static_cast<float>(i / perColumn);
    const float y = area.low.y + rowHeight * static_cast<float>(i % perColumn);
    const float barLow = x + 0.56f * columnWidth, barHigh = x + columnWidth - 12 * scale;
    const float middle = y + 0.55f * fonts.small->FontSize;
    const ImVec4& colour = row.atLimit ? palette.bad : palette.accent;
    draw->PushClipRect({x, y - 2 * scale}, {barLow - 6 * scale, y + rowHeight}, true);
    text(draw, fonts.small, {x, y}, row.atLimit ? palette.bad : palette.textDim, row.name);
    draw->PopClipRect();
    draw->AddRectFilled({barLow, middle - 1.5f * scale}, {barHigh, middle + 1.5f * scale},
                        colour32(palette.plotGrid), 2 * scale);
    const double t =
        row.upper > row.lower ? std::clamp((row.value - row.lower) / (row.upper - row.lower), 0.0, 1.0) : 0.5;
    draw->AddCircleFilled({barLow + static_cast<float>(t) * (barHigh - barLow), middle}, 3.6f * scale,
                          colour32(colour));
  }
}

}  // namespace gelenk
