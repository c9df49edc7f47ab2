#include "apps/sandbox/timeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/sandbox/sandbox_state.h"

namespace gelenk {
namespace {

/// Where things are in the strip, pixels.
struct Geometry {
  ImVec2 at, size;
  float scale, left, width, ruler, firstRow, row;
  int lastFrame;

  float x(double frame) const { return left + static_cast<float>(frame / std::max(1, lastFrame)) * width; }
  double frame(float px) const {
    return std::clamp<double>((px - left) / width * std::max(1, lastFrame), 0.0, lastFrame);
  }
  float bottom() const { return at.y + size.y - 4 * scale; }
};

Geometry measure(const Sandbox::State& s, const TimelineContent& content) {
  Geometry g{.at = ImGui::GetCursorScreenPos(),
             .size = ImGui::GetContentRegionAvail(),
             .scale = s.scale,
             .left = 0,
             .width = 0,
             .ruler = 0,
             .firstRow = 0,
             .row = 0,
             .lastFrame = content.frameCount - 1};
  g.left = g.at.x + 84 * s.scale;
  g.width = std::max(1.0f, g.size.x - 96 * s.scale);
  g.ruler = g.at.y + 4 * s.scale;
  g.firstRow = g.ruler + ImGui::GetFontSize() + 6 * s.scale;
  g.row = std::min(20 * s.scale, (g.bottom() - g.firstRow) / static_cast<float>(content.rows.size() + 2));
  return g;
}

/// Marks of seconds; a label is left out where it would run into the one before.
void drawRuler(const Geometry& g, const TimelineContent& content, const Palette& colours, ImDrawList& draw) {
  const double duration = g.lastFrame / content.framesPerSecond;
  double tick = duration > 0.0 ? std::pow(10.0, std::floor(std::log10(duration))) : 1.0;
  while (duration > 0.0 && duration / tick < 5.0) tick /= 2.0;
  float free = g.left;
  for (double t = 0.0; t <= duration * (1.0 + 1e-9); t += tick) {
    const float px = g.x(t * content.framesPerSecond);
    draw.AddLine({px, g.firstRow - 5 * g.scale}, {px, g.bottom()}, colour32(colours.plotGrid));
    const std::string label = fmt::format("{:.3g} s", t);
    if (px < free) continue;
    draw.AddText({px + 3 * g.scale, g.ruler}, colour32(colours.textDim), label.c_str());
    free = px + ImGui::CalcTextSize(label.c_str()).x + 9 * g.scale;
  }
}

void drawRowGround(const Geometry& g, float y, const std::string& label, const Palette& colours,
                   ImDrawList& draw) {
  draw.AddText({g.at.x + 4 * g.scale, y + 0.5f * (g.row - ImGui::GetFontSize())}, colour32(colours.textDim),
               label.c_str());
  draw.AddRectFilled({g.left, y + 2 * g.scale}, {g.left + g.width, y + g.row - 2 * g.scale},
                     colour32(colours.plotBackground), 3 * g.scale);
}

void drawDiamond(const Geometry& g, double frame, float y, bool strong, const Palette& colours,
                 ImDrawList& draw) {
  const float r = 5 * g.scale, px = g.x(frame), py = y + 0.5f * g.row;
  draw.AddQuadFilled({px - r, py}, {px, py - r}, {px + r, py}, {px, py + r},
                     colour32(strong ? colours.accent : colours.textFaint));
}

}  // namespace

TimelineAction Timeline::draw(Sandbox::State& s, const TimelineContent& content) {
  const Palette& colours = s.colours();
  ImGui::PushFont(s.gui.fonts().small);
  const Geometry g = measure(s, content);
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  drawRuler(g, content, colours, draw);

  float y = g.firstRow;
  for (const TimelineContent::Row& row : content.rows) {
    drawRowGround(g, y, row.label, colours, draw);
    for (const auto& [first, last] : row.spans)
      draw.AddRectFilled({g.x(first), y + 2 * g.scale},
                         {std::max(g.x(last), g.x(first) + 1), y + g.row - 2 * g.scale},
                         colour32(colours.held, 0.85f), 3 * g.scale);
    y += g.row;
  }
  drawRowGround(g, y, "limits left", colours, draw);
  for (int f = 0; f < static_cast<int>(content.bars.size()); ++f)
    if (const float share = content.bars[f]; share > 0.0f)
      draw.AddRectFilled(
          {std::max(g.left, g.x(f - 0.5)), y + g.row - 2 * g.scale - share * (g.row - 4 * g.scale)},
          {std::min(g.left + g.width, g.x(f + 0.5) + 0.5f), y + g.row - 2 * g.scale},
          colour32(colours.bad, 0.75f));
  y += g.row;
  const float keyRow = y;
  drawRowGround(g, keyRow, "keys", colours, draw);
  keyPixels_.clear();
  for (const int frame : content.keys) {
    keyPixels_.emplace_back(g.x(frame), keyRow + 0.5f * g.row);
    const bool moving = movingKey_ && movingKey_->first == frame;
    drawDiamond(g, moving ? movingKey_->second : frame, keyRow,
                moving || std::ranges::count(content.selectedKeys, frame) > 0, colours, draw);
  }

  const float head = g.x(std::min<double>(content.seconds * content.framesPerSecond, g.lastFrame));
  draw.AddLine({head, g.ruler}, {head, g.bottom()}, colour32(colours.accent), 2 * g.scale);
  draw.AddTriangleFilled({head - 5 * g.scale, g.ruler}, {head + 5 * g.scale, g.ruler},
                         {head, g.ruler + 7 * g.scale}, colour32(colours.accent));
  const int frame =
      std::clamp(static_cast<int>(std::lround(content.seconds * content.framesPerSecond)), 0, g.lastFrame);
  draw.AddText({g.at.x + 4 * g.scale, g.ruler}, colour32(colours.text),
               fmt::format("{} / {}", frame + 1, content.frameCount).c_str());
  ImGui::PopFont();

  TimelineAction action;
  ImGui::SetCursorScreenPos({g.left, g.at.y});
  ImGui::InvisibleButton("##timeline", {g.width, std::max(1.0f, g.size.y)});
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  if (ImGui::IsItemActivated() && mouse.y >= keyRow && mouse.y < keyRow + g.row)
    for (const int key : content.keys)
      if (std::abs(g.x(key) - mouse.x) <= 6 * g.scale) movingKey_ = {key, key};
  if (ImGui::IsItemActive() && movingKey_)
    movingKey_->second = static_cast<int>(std::lround(g.frame(mouse.x)));
  else if (ImGui::IsItemActive())
    action.scrubTo = g.frame(mouse.x) / content.framesPerSecond;
  else if (movingKey_)
    action.moveKey = std::exchange(movingKey_, std::nullopt);
  return action;
}

}  // namespace gelenk
