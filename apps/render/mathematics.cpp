#include "apps/render/mathematics.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <string_view>

namespace gelenk {
namespace {

using Place = MathRun::Place;

struct Sign {
  std::string_view plain, set;
};
constexpr std::array greek{Sign{"alpha", "α"},  Sign{"beta", "β"},    Sign{"gamma", "γ"}, Sign{"delta", "δ"},
                           Sign{"Delta", "Δ"},  Sign{"epsilon", "ε"}, Sign{"theta", "θ"}, Sign{"kappa", "κ"},
                           Sign{"lambda", "λ"}, Sign{"mu", "μ"},      Sign{"xi", "ξ"},    Sign{"pi", "π"},
                           Sign{"rho", "ρ"},    Sign{"sigma", "σ"},   Sign{"Sigma", "Σ"}, Sign{"tau", "τ"},
                           Sign{"phi", "φ"},    Sign{"psi", "ψ"},     Sign{"omega", "ω"}, Sign{"Omega", "Ω"}};
constexpr std::array signs{Sign{"<=", "≤"},    Sign{">=", "≥"},    Sign{"!=", "≠"}, Sign{"+-", "±"},
                           Sign{" * ", " · "}, Sign{" - ", " − "}, Sign{"||", "‖"}, Sign{" ~ ", " ≈ "}};
constexpr std::string_view arrow = "→";  ///< drawn: the font has none

bool isLetter(char c) { return std::isalpha(static_cast<unsigned char>(c)); }
bool isWord(char c) { return std::isalnum(static_cast<unsigned char>(c)); }

/// The letter for a name that stands alone or behind the d of a differential, else the name.
std::string spelled(const std::string& word) {
  for (const auto& [plain, set] : greek) {
    if (word == plain) return std::string(set);
    if (word.starts_with('d') && word.substr(1) == plain) return 'd' + std::string(set);
  }
  return word;
}

/// Greek letters and signs of a piece without scripts.
std::string withSigns(const std::string& text) {
  if (text == "-") return "–";
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    if (isLetter(text[i]) && (i == 0 || !isWord(text[i - 1]))) {
      std::size_t to = i;
      while (to < text.size() && isLetter(text[to])) ++to;
      out += spelled(text.substr(i, to - i));
      i = to;
      continue;
    }
    const bool negative = text[i] == '-' && i + 1 < text.size() && isWord(text[i + 1]) &&
                          (i == 0 || std::string_view(" ([{,").find(text[i - 1]) != std::string_view::npos);
    if (negative) {
      out += "−";
      ++i;
      continue;
    }
    const auto sign = std::ranges::find_if(
        signs, [&](const Sign& s) { return text.compare(i, s.plain.size(), s.plain) == 0; });
    if (sign != signs.end()) {
      out += sign->set;
      i += sign->plain.size();
    } else {
      out += text[i++];
    }
  }
  return out;
}

/// Where the bracket at `open` closes; npos: nowhere.
std::size_t closing(const std::string& text, std::size_t open) {
  int depth = 0;
  for (std::size_t i = open; i < text.size(); ++i) {
    if (text[i] == '(') ++depth;
    if (text[i] == ')' && --depth == 0) return i;
  }
  return std::string::npos;
}

/// What is raised or lowered after a ^ or _ at `at`; empty: nothing, the sign itself is meant. to: behind it.
std::string script(const std::string& text, std::size_t at, std::size_t& to) {
  std::size_t from = at + 1;
  if (from < text.size() && text[from] == '(') {
    const std::size_t end = closing(text, from);
    if (end == std::string::npos) return {};
    to = end + 1;
    return text.substr(from + 1, end - from - 1);
  }
  std::size_t end = from;
  if (end < text.size() && (text[end] == '-' || text[end] == '+')) ++end;
  while (end < text.size() && (isWord(text[end]) || text[end] == '\'')) ++end;
  if (end == from || (end == from + 1 && text[from] == '-')) return {};
  to = end;
  return text.substr(from, end - from);
}

/// Behind a factor that begins at `from`: a bracket, or a word with the brackets that follow it, such as
/// f'(phi^i).
std::size_t endOfFactor(const std::string& text, std::size_t from) {
  std::size_t at = from;
  while (at < text.size() && std::string_view(" ,;)").find(text[at]) == std::string_view::npos) {
    if (text[at] == '(') {
      const std::size_t end = closing(text, at);
      if (end == std::string::npos) break;
      at = end;
      if (from == at) break;
    }
    ++at;
  }
  return at;
}

std::string withoutBrackets(const std::string& factor) {
  return factor.front() == '(' && closing(factor, 0) + 1 == factor.size()
             ? factor.substr(1, factor.size() - 2)
             : factor;
}

/// A number as 1.5e-07 that begins at `at`, as what is to be read; to: behind it. Empty: none does.
std::string powerOfTen(const std::string& text, std::size_t at, std::size_t& to) {
  if (!std::isdigit(static_cast<unsigned char>(text[at])) ||
      (at > 0 && (isWord(text[at - 1]) || text[at - 1] == '.' || text[at - 1] == '_')))
    return {};
  const std::size_t e = text.find_first_not_of("0123456789.", at);
  if (e == std::string::npos || text[e] != 'e') return {};
  std::size_t digits = e + 1;
  if (digits < text.size() && (text[digits] == '-' || text[digits] == '+')) ++digits;
  const std::size_t end = std::min(text.find_first_not_of("0123456789", digits), text.size());
  if (end == digits || (end < text.size() && isWord(text[end]))) return {};
  to = end;
  const std::string mantissa = text.substr(at, e - at);
  const int exponent = std::atoi(text.c_str() + e + 1);
  if (mantissa.find_first_of("123456789") == std::string::npos) return "0";
  if (exponent == 0) return mantissa;
  return (mantissa == "1" ? "10^" : mantissa + " * 10^") + std::to_string(exponent);
}

/// The digits after a letter that stands alone: the 1 of P1, the 12 of l12.
std::string index(const std::string& text, std::size_t at) {
  if (at == 0 || !isLetter(text[at - 1]) || (at > 1 && (isWord(text[at - 2]) || text[at - 2] == '_')))
    return {};
  std::size_t end = at;
  while (end < text.size() && std::isdigit(static_cast<unsigned char>(text[end]))) ++end;
  const bool alone = end == text.size() || (!isWord(text[end]) && text[end] != '.' && text[end] != '-');
  return alone && end - at <= 2 ? text.substr(at, end - at) : std::string();
}

/// d and one letter, or the name of a Greek one: df, dphi_1.
bool isDifferential(const std::string& text, std::size_t at) {
  std::size_t end = at;
  while (end < text.size() && isLetter(text[end])) ++end;
  const std::string word = text.substr(at, end - at);
  return word.starts_with('d') && (word.size() == 2 || spelled(word) != word);
}

/// Behind a numerator that begins at `from`, a bracket or the upper half of df / dx; npos: none does.
std::size_t endOfNumerator(const std::string& text, std::size_t from) {
  if (from > 0 && text[from - 1] != ' ' && text[from - 1] != '(') return std::string::npos;
  if (text[from] == '(') {
    const std::size_t end = closing(text, from);
    return end == std::string::npos ? end : end + 1;
  }
  const std::size_t end = endOfFactor(text, from);
  return isDifferential(text, from) && text.compare(end, 3, " / ") == 0 && isDifferential(text, end + 3)
             ? end
             : std::string::npos;
}

/// Shares of the size; small type has larger scripts, which can still be read.
float scriptShare(float size) { return size < 17.0f ? 0.8f : 0.74f; }
constexpr float raised = -0.28f, lowered = 0.40f;
constexpr float fractionSize = 0.86f, numeratorAt = -0.46f, barAt = 0.53f, denominatorAt = 0.60f;

/// What small type is written with: a font of about that size, where there is one, at its own size. Letters
/// that are made smaller lose thin strokes, first of all the minus of an exponent.
struct Type {
  ImFont* font;
  float size;
};
Type typeOf(ImFont* font, float size) {
  if (size >= 15.0f || size >= font->FontSize) return {font, size};
  Type best{font, size};
  float nearest = 0.12f * size;
  for (ImFont* other : ImGui::GetIO().Fonts->Fonts)
    if (const float apart = std::abs(other->FontSize - size); apart < nearest)
      best = {other, other->FontSize}, nearest = apart;
  return best;
}

float widthOf(ImFont* font, float size, const std::string& text) {
  const Type type = typeOf(font, size);
  return type.font->CalcTextSizeA(type.size, 1e9f, 0.0f, text.c_str()).x;
}

/// Measuring only: one type for all depths of the recursion.
struct Nothing {
  template <class... Any>
  void operator()(Any&&...) const {}
};
constexpr Nothing nothing;

/// What lies where: place(run, x, y, size, width) for text, bar(x, y, width) for fractions and roots. Returns
/// what it takes.
template <class Place_, class Bar>
MathExtent layOut(ImFont* font, float size, const std::vector<MathRun>& runs, float x0, float y0,
                  Place_&& place, Bar&& bar) {
  float x = x0, scriptsFrom = 0.0f;
  MathExtent extent;
  bool afterScript = false;
  Place before = Place::Line;
  for (const MathRun& run : runs) {
    if (!run.above.empty()) {
      const float own = fractionSize * size, gap = 0.12f * size;
      const float over = layOut(font, own, run.above, 0, 0, nothing, nothing).width,
                  under = layOut(font, own, run.below, 0, 0, nothing, nothing).width,
                  wide = std::max(over, under);
      layOut(font, own, run.above, x + gap + 0.5f * (wide - over), y0 + numeratorAt * size, place, bar);
      layOut(font, own, run.below, x + gap + 0.5f * (wide - under), y0 + denominatorAt * size, place, bar);
      bar(x + gap, y0 + barAt * size, wide);
      x += wide + 2.0f * gap;
      extent.over = std::max(extent.over, -numeratorAt * size + 0.1f * size);
      extent.under = std::max(extent.under, (denominatorAt + fractionSize - 1.0f) * size + 0.05f * size);
      afterScript = false;
      before = Place::Line;
      continue;
    }
    const bool isScript = run.place != Place::Line;
    const float own = isScript ? scriptShare(size) * size : size,
                width = run.text == arrow ? 0.9f * own : widthOf(font, own, run.text);
    float at = x;
    if (isScript && afterScript && run.place != before) at = scriptsFrom;  // above each other
    if (isScript && !(afterScript && run.place != before)) scriptsFrom = x;
    const float y = run.place == Place::Super ? raised * size + (size - own) * 0.35f
                    : run.place == Place::Sub ? lowered * size
                                              : 0.0f;
    place(run, at, y0 + y, own);
    if (run.overline) bar(at, y0 - 0.04f * size, width);
    x = std::max(x, at + width + (isScript ? 0.04f * size : 0.0f));
    afterScript = isScript;
    before = run.place;
  }
  extent.width = x - x0;
  return extent;
}

}  // namespace

std::vector<MathRun> setMathematics(const std::string& plain) {
  std::vector<MathRun> runs;
  std::string line;
  const auto endLine = [&] {
    if (!line.empty()) runs.push_back({.text = withSigns(line)});
    line.clear();
  };
  for (std::size_t i = 0; i < plain.size();) {
    const bool standsOnSomething = i > 0 && plain[i - 1] != ' ';
    if ((plain[i] == '^' || plain[i] == '_') && standsOnSomething) {
      std::size_t to = i;
      const std::string part = script(plain, i, to);
      if (!part.empty()) {
        endLine();
        const Place place = plain[i] == '^' ? Place::Super : Place::Sub;
        for (std::size_t from = 0; from != std::string::npos;) {
          const std::size_t at = part.find("->", from);
          if (std::string set = withSigns(part.substr(from, at - from)); !set.empty()) {
            if (set[0] == '-') set.replace(0, 1, "−");
            runs.push_back({.text = set, .place = place});
          }
          if (at != std::string::npos) runs.push_back({.text = std::string(arrow), .place = place});
          from = at == std::string::npos ? at : at + 2;
        }
        i = to;
        continue;
      }
    }
    if (plain.compare(i, 2, "->") == 0) {
      endLine();
      runs.push_back({.text = std::string(arrow)});
      i += 2;
      continue;
    }
    std::size_t to = i;
    if (const std::string power = powerOfTen(plain, i, to); !power.empty()) {
      const std::size_t raise = power.find('^');
      line += power.substr(0, raise);
      if (raise != std::string::npos) {
        const bool negative = power[raise + 1] == '-';
        endLine();
        runs.push_back({.text = (negative ? "−" : "") + power.substr(raise + (negative ? 2 : 1)),
                        .place = Place::Super});
      }
      i = to;
      continue;
    }
    if (const std::string lower = index(plain, i); !lower.empty()) {
      endLine();
      runs.push_back({.text = lower, .place = Place::Sub});
      i += lower.size();
      continue;
    }
    if (plain.compare(i, 5, "sqrt(") == 0 && (i == 0 || !isWord(plain[i - 1])))
      if (const std::size_t end = closing(plain, i + 4); end != std::string::npos) {
        line += "√";
        endLine();
        for (MathRun run : setMathematics(plain.substr(i + 5, end - i - 5))) {
          run.overline = true;
          runs.push_back(std::move(run));
        }
        i = end + 1;
        continue;
      }
    if (const std::size_t end = endOfNumerator(plain, i);
        end != std::string::npos && plain.compare(end, 3, " / ") == 0) {
      const std::size_t from = end + 3, to = endOfFactor(plain, from);
      if (to > from) {
        endLine();
        runs.push_back({.above = setMathematics(withoutBrackets(plain.substr(i, end - i))),
                        .below = setMathematics(withoutBrackets(plain.substr(from, to - from)))});
        i = to;
        continue;
      }
    }
    line += plain[i++];
  }
  endLine();
  return runs;
}

MathExtent mathExtent(ImFont* font, float size, const std::string& plain) {
  return layOut(font, size, setMathematics(plain), 0, 0, nothing, nothing);
}

float drawMathematics(ImDrawList& draw, ImFont* font, float size, ImVec2 at, ImU32 colour,
                      const std::string& plain) {
  return layOut(
             font, size, setMathematics(plain), at.x, at.y,
             [&](const MathRun& run, float x, float y, float own) {
               const Type type = typeOf(font, own);
               if (run.text != arrow)
                 return draw.AddText(type.font, type.size, {x, y}, colour, run.text.c_str());
               const float to = x + 0.78f * own, middle = y + 0.56f * own, wide = std::max(1.0f, 0.08f * own);
               draw.AddLine({x + 0.08f * own, middle}, {to, middle}, colour, wide);
               const ImVec2 head[] = {{to - 0.22f * own, middle - 0.2f * own},
                                      {to, middle},
                                      {to - 0.22f * own, middle + 0.2f * own}};
               draw.AddPolyline(head, 3, colour, 0, wide);
             },
             [&](float x, float y, float width) {
               draw.AddLine({x, y}, {x + width, y}, colour, std::max(1.0f, 0.06f * size));
             })
      .width;
}

void mathItem(const std::string& plain, float over) {
  ImFont* font = ImGui::GetFont();
  const float size = ImGui::GetFontSize();
  const MathExtent extent = mathExtent(font, size, plain);
  const float above = over < 0.0f ? extent.over : over;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  drawMathematics(*ImGui::GetWindowDrawList(), font, size, {at.x, at.y + above},
                  ImGui::GetColorU32(ImGuiCol_Text), plain);
  ImGui::Dummy({extent.width, above + ImGui::GetTextLineHeight() + extent.under});
}

void mathLabel(const std::string& plain) {
  ImGui::SameLine(0, ImGui::GetStyle().ItemInnerSpacing.x);
  ImGui::SetCursorPosY(ImGui::GetCursorPosY() + ImGui::GetStyle().FramePadding.y);
  mathItem(plain);
}

void tickItem(bool good, const ImVec4& colour) {
  const float h = ImGui::GetTextLineHeight();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const ImU32 ink = ImGui::GetColorU32(colour);
  const float width = std::max(1.5f, 0.13f * h);
  if (good) {
    const ImVec2 points[] = {{at.x + 0.08f * h, at.y + 0.55f * h},
                             {at.x + 0.32f * h, at.y + 0.80f * h},
                             {at.x + 0.78f * h, at.y + 0.22f * h}};
    draw.AddPolyline(points, 3, ink, 0, width);
  } else {
    draw.AddLine({at.x + 0.14f * h, at.y + 0.24f * h}, {at.x + 0.70f * h, at.y + 0.80f * h}, ink, width);
    draw.AddLine({at.x + 0.70f * h, at.y + 0.24f * h}, {at.x + 0.14f * h, at.y + 0.80f * h}, ink, width);
  }
  ImGui::Dummy({0.9f * h, h});
}

void drawBrackets(ImDrawList& draw, ImVec2 low, ImVec2 high, ImU32 colour, float width) {
  const float foot = 4.0f * width;
  const ImVec2 left[] = {{low.x + foot, low.y}, {low.x, low.y}, {low.x, high.y}, {low.x + foot, high.y}};
  const ImVec2 right[] = {{high.x - foot, low.y}, {high.x, low.y}, {high.x, high.y}, {high.x - foot, high.y}};
  draw.AddPolyline(left, 4, colour, 0, width);
  draw.AddPolyline(right, 4, colour, 0, width);
}

}  // namespace gelenk
