#pragma once

#include <imgui.h>

#include <string>
#include <vector>

namespace gelenk {

/// A stretch of a formula in one size and height, or a fraction.
struct MathRun {
  enum class Place { Line, Super, Sub };
  std::string text = {};  ///< UTF-8
  Place place = Place::Line;
  bool overline = false;                        ///< under a root
  std::vector<MathRun> above = {}, below = {};  ///< of a fraction, whose text is empty
  bool operator==(const MathRun&) const = default;
};

/// The plain notation of the lecture's texts as it is to be set: names of Greek letters that stand alone
/// become the letters, also in differentials (dphi), x^2, x^(i+1), D_f^+ and 10^-6 get raised and lowered
/// parts, sqrt(x) a root, -1 a minus, 1.5e-07 a power of ten, P1 an index, -> an arrow, (a) / (b) and (a) / b
/// and df / dx a fraction, <= >= != +- - * || ~ their signs. Everything else stays as it is.
std::vector<MathRun> setMathematics(const std::string& plain);

/// What a formula takes in pixels: its width, and what it needs over and under a line of text (fractions).
struct MathExtent {
  float width = 0.0f, over = 0.0f, under = 0.0f;
};
MathExtent mathExtent(ImFont* font, float size, const std::string& plain);
/// Draws it with the top of its line of text at `at`; returns its width.
float drawMathematics(ImDrawList& draw, ImFont* font, float size, ImVec2 at, ImU32 colour,
                      const std::string& plain);
/// The same as an item of the present window, in its font and text colour. over: room above the line that all
/// items of a line share; negative: the formula's own.
void mathItem(const std::string& plain, float over = -1.0f);

/// Right of the field that was drawn last, as its label.
void mathLabel(const std::string& plain);

/// A tick, or a cross, as high as a line of text: an item.
void tickItem(bool good, const ImVec4& colour);

/// Brackets around a rectangle of the present window.
void drawBrackets(ImDrawList& draw, ImVec2 low, ImVec2 high, ImU32 colour, float width);

}  // namespace gelenk
