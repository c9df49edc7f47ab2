#pragma once

#include <imgui.h>

#include <string>
#include <vector>

namespace gelenk {

/// A stretch of a formula in one size and height.
struct MathRun {
  enum class Place { Line, Super, Sub };
  std::string text = {};  ///< UTF-8
  Place place = Place::Line;
  bool overline = false;  ///< under a root
  bool operator==(const MathRun&) const = default;
};

/// The plain notation of the lecture's texts as it is to be set: names of Greek letters that stand alone
/// become the letters, x^2, x^(i+1), D_f^+ and 10^-6 get raised and lowered parts, sqrt(x) a root, <= >= !=
/// -> +- * their signs. Everything else stays as it is.
std::vector<MathRun> setMathematics(const std::string& plain);

/// Size of the formula in pixels.
ImVec2 mathSize(ImFont* font, float size, const std::string& plain);
/// Draws it; returns its width.
float drawMathematics(ImDrawList& draw, ImFont* font, float size, ImVec2 at, ImU32 colour,
                      const std::string& plain);
/// The same as an item of the present window, in its font and text colour.
void mathItem(const std::string& plain);

/// A tick, or a cross, as high as a line of text: an item.
void tickItem(bool good, const ImVec4& colour);

/// Brackets around a rectangle of the present window.
void drawBrackets(ImDrawList& draw, ImVec2 low, ImVec2 high, ImU32 colour, float width);

}  // namespace gelenk
