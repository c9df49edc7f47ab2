#include "apps/render/label_writer.h"

#include <imgui_impl_opengl3.h>

#include <cmath>
#include <utility>

#include "apps/render/mathematics.h"
#include "apps/render/rulers.h"
#include "skinning/gpu/gl.h"

namespace gelenk {

LabelPlaces roomForLabels(ImVec2 corner, const Viewport& viewport, bool planar, float scale) {
  const float left = planar ? static_cast<float>(rulerWidth) * scale : 2.0f,
              low = planar ? static_cast<float>(rulerHeight) * scale : 2.0f;
  return LabelPlaces({corner.x + left, corner.y + 2, static_cast<float>(viewport.width) - left - 2,
                      static_cast<float>(viewport.height) - low - 2});
}

ImVec4 inkOf(const ImVec4& colour, const Palette& palette) {
  const auto luminance = [](const ImVec4& c) { return 0.3f * c.x + 0.59f * c.y + 0.11f * c.z; };
  const float lacks = luminance(palette.panelRaised) < 0.5f ? 0.55f - luminance(colour) : 0.0f;
  if (lacks <= 0.0f) return colour;
  const float white = lacks / (1.0f - luminance(colour));
  return {colour.x + white * (1.0f - colour.x), colour.y + white * (1.0f - colour.y),
          colour.z + white * (1.0f - colour.z), colour.w};
}

ImVec2 sizeOfWords(const LabelPen& pen, const std::string& text, bool isFormula) {
  const ImVec2 size = pen.font->CalcTextSizeA(pen.size, 1e9f, 0.0f, text.c_str());
  return isFormula ? ImVec2(mathExtent(pen.font, pen.size, text).width, size.y) : size;
}

void writeWords(const LabelPen& pen, ImVec2 at, const ImVec4& named, const std::string& text,
                bool isFormula) {
  const ImVec4 colour = inkOf(named, pen.colours);
  ImFont* font = pen.font;
  const ImVec2 size = sizeOfWords(pen, text, isFormula);
  // In whole pixels: sharp, and the same wherever the picture lies.
  LabelBox box{std::floor(at.x - 5 * pen.scale), std::floor(at.y - 2 * pen.scale),
               std::ceil(size.x + 10 * pen.scale), std::ceil(size.y + 4 * pen.scale)};
  if (!pen.places->place(box)) return;
  at = {box.x + 5 * pen.scale, box.y + 2 * pen.scale};
  pen.draw->AddRectFilled({box.x, box.y}, {box.x + box.width, box.y + box.height},
                          colour32(pen.colours.panelRaised, 0.82f), 4 * pen.scale);
  if (isFormula)
    drawMathematics(*pen.draw, font, pen.size, at, colour32(colour), text);
  else
    pen.draw->AddText(font, pen.size, at, colour32(colour), text.c_str());
}

void writeLabels(const LabelPen& pen, const std::vector<SceneLabel>& labels, const Camera& camera,
                 const Viewport& viewport, ImVec2 corner) {
  const float dot = 6 * pen.scale;  // half of its width: what labels name must stay in sight
  const auto pixelOf = [&](const Projected& p) {
    return ImVec2(corner.x + static_cast<float>(p.pixel.x()), corner.y + static_cast<float>(p.pixel.y()));
  };
  std::vector<std::pair<const SceneLabel*, ImVec2>> seen;
  for (const SceneLabel& label : labels) {
    const Projected p = project(camera, viewport, label.at),
                    mark = project(camera, viewport, label.mark.value_or(label.at));
    if (p.depth <= 0.0) continue;
    const ImVec2 middle = pixelOf(mark);
    if (!label.isAbove) pen.places->takeAround(middle.x, middle.y, dot);
    seen.emplace_back(&label, pixelOf(p));
  }
  for (const auto& [label, at] : seen) {
    const ImVec2 size = sizeOfWords(pen, label->text, !label->isName);
    const ImVec2 from = label->isAbove ? ImVec2(at.x - 0.5f * size.x, at.y - size.y)
                                       : ImVec2(at.x + 12 * pen.scale, at.y - 8 * pen.scale);
    writeWords(pen, from, toImVec4(label->colour), label->text, !label->isName);
  }
}

LabelWriter::LabelWriter(Theme theme, float scale) : theme_(theme), scale_(scale) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;
  ImGui::GetIO().LogFilename = nullptr;
  ImGui_ImplOpenGL3_Init(imguiShaderVersion);
  fonts_ = loadFonts(scale);
  applyStyle(theme, scale);
}

LabelWriter::~LabelWriter() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui::DestroyContext();
}

void LabelWriter::write(const std::vector<SceneLabel>& labels, const Camera& camera, const Viewport& viewport,
                        bool planar, unsigned framebuffer) {
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(viewport.width), static_cast<float>(viewport.height)};
  io.DeltaTime = 1.0f;
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::NewFrame();
  LabelPlaces places = roomForLabels({0, 0}, viewport, planar, scale_);
  writeLabels({ImGui::GetBackgroundDrawList(), palette(theme_), fonts_.small, fonts_.small->FontSize, scale_,
               &places},
              labels, camera, viewport, {0, 0});
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace gelenk
