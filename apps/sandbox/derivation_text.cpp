#include "apps/sandbox/derivation_text.h"

#include <algorithm>
#include <numeric>
#include <sstream>
#include <vector>

#include "apps/lecture/text_table.h"
#include "apps/render/mathematics.h"

namespace gelenk {
namespace {

float widthOf(const std::string& formula) {
  return mathExtent(ImGui::GetFont(), ImGui::GetFontSize(), formula).width;
}

/// A column's place, in units of the type's size.
struct Column {
  float whole = 0.0f, rest = 0.0f;  ///< its numbers before and from the decimal point
  float width = 0.0f, left = 0.0f;
  bool numbers = false;
};

/// What a width was at its widest, so that nothing moves while numbers change; it is given up where much less
/// is needed.
float lasting(float width, const std::string& name) {
  float& widest = *ImGui::GetStateStorage()->GetFloatRef(ImGui::GetID(name.c_str()), 0.0f);
  if (width > widest || width < 0.6f * widest) widest = width;
  return widest;
}

constexpr float columnGap = 1.2f, narrowGap = 0.6f;

/// room: that they should do with, in units of the type's size; gaps between them give way first.
std::vector<Column> columnsOf(const TextTable& table, float room) {
  std::vector<Column> columns;
  for (const TextTable::Row& row : table.rows) columns.resize(std::max(columns.size(), row.size()));
  const float em = ImGui::GetFontSize();
  std::string name;
  if (table.hasHeads)
    for (const std::string& head : table.rows[0]) name += head + "|";
  for (std::size_t j = 0; j < columns.size(); ++j) {
    Column& column = columns[j];
    column.numbers = isNumberColumn(table, j);
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      if (j >= table.rows[i].size() || (i == 0 && headSpan(table, j) > 1)) continue;
      const std::string& cell = table.rows[i][j];
      const float all = widthOf(cell) / em;
      column.width = std::max(column.width, all);
      if (!column.numbers || !isNumber(cell) || (table.hasHeads && i == 0)) continue;
      const float whole = widthOf(cell.substr(0, wholeDigits(cell))) / em;
      column.whole = std::max(column.whole, whole);
      column.rest = std::max(column.rest, all - whole);
    }
    name += "|";
    column.whole = lasting(column.whole, name + "whole");
    column.rest = lasting(column.rest, name + "rest");
    column.width = lasting(std::max(column.width, column.whole + column.rest), name);
  }
  float wide = 0.0f;
  for (const Column& column : columns) wide += column.width;
  const float gap = columns.size() < 2 ? 0.0f
                                       : std::clamp((room - wide) / static_cast<float>(columns.size() - 1),
                                                    narrowGap, columnGap);
  for (std::size_t j = 0; j < columns.size(); ++j) {  // a head that is wider than all its columns
    const std::size_t span = headSpan(table, j);
    if (span == 1) continue;
    float below = gap * static_cast<float>(span - 1);
    for (std::size_t k = j; k < j + span; ++k) below += columns[k].width;
    columns[j].width += std::max(0.0f, widthOf(table.rows[0][j]) / em - below);
  }
  float x = 0.0f;
  for (Column& column : columns) {
    column.left = x;
    x += column.width + gap;
  }
  return columns;
}

/// Where a cell begins, from its column's left edge.
float cellOffset(const TextTable& table, const std::vector<Column>& columns, std::size_t i, std::size_t j) {
  const Column& column = columns[j];
  const std::string& cell = table.rows[i][j];
  const float em = ImGui::GetFontSize(), all = widthOf(cell) / em;
  if (i == 0 && headSpan(table, j) > 1) {
    const Column& last = columns[j + headSpan(table, j) - 1];
    return 0.5f * (last.left + last.width - column.left - all);
  }
  if (!column.numbers) return 0.0f;
  if (!isNumber(cell)) return column.width - all;
  return column.width - column.rest - widthOf(cell.substr(0, wholeDigits(cell))) / em;
}

/// left, stretch: pixels.
void drawRows(const TextTable& table, const std::vector<Column>& columns, float left, float stretch,
              int now = -1) {
  const float em = ImGui::GetFontSize();
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    float over = 0.0f;
    for (const std::string& cell : table.rows[i])
      over = std::max(over, mathExtent(ImGui::GetFont(), em, cell).over);
    bool first = true;
    const bool isFaint = now >= 0 && static_cast<int>(i) > now;
    if (isFaint) ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    for (std::size_t j = 0; j < table.rows[i].size(); ++j) {
      if (table.rows[i][j].empty() && j > 0) continue;
      if (!first) ImGui::SameLine(0, 0);
      first = false;
      ImGui::SetCursorPosX(left + stretch * static_cast<float>(j) +
                           em * (columns[j].left + cellOffset(table, columns, i, j)));
      mathItem(table.rows[i][j], over);
    }
    if (isFaint) ImGui::PopStyleColor();
    if (i == 0 && table.hasHeads) {
      const ImVec2 at = ImGui::GetCursorScreenPos();
      const float x = at.x - ImGui::GetCursorPosX() + left, y = at.y - 0.5f * ImGui::GetStyle().ItemSpacing.y,
                  width = stretch * static_cast<float>(columns.size() - 1) +
                          em * (columns.back().left + columns.back().width);
      ImGui::GetWindowDrawList()->AddLine({x, y}, {x + width, y}, ImGui::GetColorU32(ImGuiCol_TextDisabled),
                                          std::max(1.0f, 0.05f * em));
    }
  }
}

/// Rows between tall brackets.
void drawMatrix(const TextTable& table, const std::vector<Column>& columns, float left) {
  const float em = ImGui::GetFontSize(), edge = 0.5f * em;
  const ImVec2 low = ImGui::GetCursorScreenPos();
  const float x = low.x - ImGui::GetCursorPosX() + left;
  drawRows(table, columns, left + edge, 0.0f);
  drawBrackets(*ImGui::GetWindowDrawList(), {x, low.y},
               {x + 2 * edge + em * (columns.back().left + columns.back().width),
                ImGui::GetCursorScreenPos().y - ImGui::GetStyle().ItemSpacing.y},
               ImGui::GetColorU32(ImGuiCol_Text), std::max(1.2f, 0.08f * em));
}

/// Pieces of a line that must not be parted: brackets and fractions stay whole, a sign stands with what
/// follows it.
std::vector<std::string> unbreakable(const std::string& line) {
  std::vector<std::string> pieces;
  int depth = 0;
  bool joined = false;
  std::istringstream words(line);
  for (std::string word; words >> word;) {
    const bool isSign = word.size() <= 2 && word.find_first_not_of("=<>!+-*/~|") == std::string::npos;
    if (!pieces.empty() && (joined || word == "/"))
      pieces.back() += " " + word;
    else
      pieces.push_back(word);
    for (const char c : word) depth += c == '(' || c == '{' ? 1 : c == ')' || c == '}' ? -1 : 0;
    joined = depth > 0 || isSign;
  }
  return pieces;
}

/// A line in as many as the width asks for.
std::vector<std::string> wrapped(const std::string& line, float width) {
  std::vector<std::string> lines{""};
  const auto add = [&](const std::string& piece) {
    const std::string longer = lines.back().empty() ? piece : lines.back() + " " + piece;
    if (lines.back().empty() || widthOf(longer) <= width)
      lines.back() = longer;
    else
      lines.push_back(piece);
  };
  for (const std::string& piece : unbreakable(line)) {
    if (widthOf(piece) <= width || piece.find(" / (") != std::string::npos) {
      add(piece);
      continue;
    }
    std::istringstream words(piece);  // a long remark in brackets
    for (std::string word; words >> word;) add(word);
  }
  return lines;
}

float rightEdge(const std::vector<Column>& columns) { return columns.back().left + columns.back().width; }

/// The table, or parts of it where it would have to be set in much smaller type. room: in units of the type.
std::vector<TextTable> readable(const TextTable& table, float room) {
  constexpr float least = 0.75f, goodEnough = 0.85f;  // of the type's size
  const std::vector<Column> columns = columnsOf(table, room);
  if (!table.hasHeads || least * rightEdge(columns) <= room) return {table};
  std::vector<float> widths;
  for (const Column& column : columns) widths.push_back(column.width);
  std::vector<TextTable> parts;
  for (const auto& part : partsOf(table, widths, narrowGap, room / goodEnough))
    parts.push_back(withColumns(table, part));
  return parts;
}

}  // namespace

void drawDerivation(const std::string& text, ImFont* font, float size) {
  ImGui::PushFont(font);
  const float whole = size / font->FontSize;
  const auto fit = [&](float width) {  // what is wider than the window is set smaller
    const float room = ImGui::GetContentRegionAvail().x - 0.2f * size;
    ImGui::SetWindowFontScale(whole * std::min(room / std::max(width, 1.0f), 1.0f));
  };
  ImGui::Dummy({0, 0.1f * size});  // what is raised stands out of its line
  int count = 0;
  for (const TextPiece& piece : piecesOf(text)) {
    fit(0.0f);
    const float left = 0.47f * size * static_cast<float>(piece.indent);  // about the width of a blank in type
    if (piece.kind == TextPiece::Kind::Line) {
      if (piece.line.empty()) ImGui::Dummy({0, 0.35f * ImGui::GetTextLineHeight()});
      const float room = std::max(ImGui::GetContentRegionAvail().x - left, 8.0f * size);
      for (const std::string& line : wrapped(piece.line, room)) {
        if (line.empty()) continue;
        fit(left + widthOf(line));
        ImGui::SetCursorPosX(left);
        mathItem(line);
        fit(0.0f);
      }
      continue;
    }
    const bool isMatrix = piece.kind == TextPiece::Kind::Matrix;
    const float indent = isMatrix ? left / size : 1.0f;  // a blank of a line, whatever the type
    const float room =
        (ImGui::GetContentRegionAvail().x - 0.2f * size) / size - indent - (isMatrix ? 1.0f : 0.0f);
    ImGui::PushID(count++);
    const std::vector<TextTable> parts = isMatrix ? std::vector{piece.table} : readable(piece.table, room);
    std::vector<std::vector<Column>> columns;
    float widest = 0.0f;
    for (const TextTable& part : parts) {
      columns.push_back(columnsOf(part, room));
      widest = std::max(widest, rightEdge(columns.back()));
    }
    ImGui::PopID();
    fit(size * (indent + widest + (isMatrix ? 1.0f : 0.0f)));
    const float from = indent * ImGui::GetFontSize();
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (i > 0) ImGui::Dummy({0, 0.2f * ImGui::GetFontSize()});
      if (isMatrix)
        drawMatrix(parts[i], columns[i], from);
      else
        drawRows(parts[i], columns[i], from, 0.0f);
    }
  }
  fit(0.0f);
  ImGui::PopFont();
}

void drawTable(const std::string& rows, int now) {
  const TextTable table = piecesOf(rows).front().table;
  const float room = ImGui::GetContentRegionAvail().x;
  const std::vector<Column> columns = columnsOf(table, room / ImGui::GetFontSize());
  const float shrunk = std::min(1.0f, room / (ImGui::GetFontSize() * rightEdge(columns)));
  ImGui::SetWindowFontScale(shrunk);
  const float stretch = columns.size() < 2
                            ? 0.0f
                            : std::max(0.0f, room - ImGui::GetFontSize() * rightEdge(columns)) /
                                  static_cast<float>(columns.size() - 1);
  drawRows(table, columns, ImGui::GetCursorPosX(), stretch, now);
  ImGui::SetWindowFontScale(1.0f);
}

}  // namespace gelenk
