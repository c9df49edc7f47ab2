#include "apps/lecture/text_table.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <iterator>
#include <sstream>

namespace gelenk {
namespace {

constexpr std::string_view headRule = "\t---";

TextTable::Row cellsOf(const std::string& line) {
  TextTable::Row cells;
  for (std::size_t at = 0; at != std::string::npos;) {
    const std::size_t next = line.find('\t', at + 1);
    cells.push_back(line.substr(at + 1, next == std::string::npos ? next : next - at - 1));
    at = next;
  }
  return cells;
}

/// The cells of a line "   [ 1   2.5 ]"; empty: the line is no row of a matrix.
TextTable::Row matrixRow(const std::string& line) {
  const std::size_t from = line.find_first_not_of(' '), to = line.find_last_not_of(' ');
  if (from == std::string::npos || line[from] != '[' || line[to] != ']') return {};
  std::istringstream words(line.substr(from + 1, to - from - 1));
  return {std::istream_iterator<std::string>(words), {}};
}

/// What the cells of a column take in characters, before and from the decimal point of its numbers.
struct Widths {
  std::size_t whole = 0, rest = 0, all = 0;
};

Widths widthsOf(const TextTable& table, std::size_t column) {
  Widths widths;
  const bool numbers = isNumberColumn(table, column);
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    if (column >= table.rows[i].size()) continue;
    const std::string& cell = table.rows[i][column];
    const bool isHead = table.hasHeads && i == 0;
    if (numbers && !isHead && isNumber(cell)) {
      widths.whole = std::max(widths.whole, wholeDigits(cell));
      widths.rest = std::max(widths.rest, cell.size() - wholeDigits(cell));
    }
    if (!isHead || headSpan(table, column) == 1) widths.all = std::max(widths.all, cell.size());
  }
  widths.all = std::max(widths.all, widths.whole + widths.rest);
  return widths;
}

std::string padded(const TextTable& table) {
  std::size_t columns = 0;
  for (const TextTable::Row& row : table.rows) columns = std::max(columns, row.size());
  std::vector<Widths> widths;
  for (std::size_t j = 0; j < columns; ++j) widths.push_back(widthsOf(table, j));
  constexpr std::size_t gap = 3;
  std::string out;
  std::size_t longest = 0;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const bool isHead = table.hasHeads && i == 0;
    std::string line = "   ";
    std::size_t left = line.size();
    for (std::size_t j = 0; j < table.rows[i].size(); ++j) {
      const std::string& cell = table.rows[i][j];
      const Widths& w = widths[j];
      std::size_t before = 0;
      if (isNumberColumn(table, j) && (i > 0 || headSpan(table, j) == 1))
        before = isNumber(cell) && !isHead ? w.all - w.rest - wholeDigits(cell) : w.all - cell.size();
      line.resize(std::max(line.size(), left + before), ' ');
      line += cell;
      left += w.all + gap;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    longest = std::max(longest, line.size());
    out += line + "\n";
  }
  if (table.hasHeads) out.insert(out.find('\n') + 1, "   " + std::string(longest - 3, '-') + "\n");
  return out;
}

}  // namespace

bool isNumber(const std::string& cell) {
  const std::size_t digit = cell.starts_with('-') ? 1 : 0;
  if (digit >= cell.size() || !std::isdigit(static_cast<unsigned char>(cell[digit]))) return false;
  char* end = nullptr;
  std::strtod(cell.c_str(), &end);
  return *end == '\0';
}

std::size_t wholeDigits(const std::string& number) {
  return std::min(number.find_first_of(".e"), number.size());
}

bool isNumberColumn(const TextTable& table, std::size_t column) {
  for (std::size_t i = table.hasHeads ? 1 : 0; i < table.rows.size(); ++i)
    if (column < table.rows[i].size() && isNumber(table.rows[i][column])) return true;
  return false;
}

std::size_t headSpan(const TextTable& table, std::size_t column) {
  const TextTable::Row& heads = table.rows.front();
  if (!table.hasHeads || column >= heads.size() || heads[column].empty()) return 1;
  std::size_t end = column + 1;
  while (end < heads.size() && heads[end].empty()) ++end;
  return end - column;
}

std::vector<std::vector<std::size_t>> partsOf(const TextTable& table, const std::vector<float>& widths,
                                              float gap, float room) {
  std::vector<std::vector<std::size_t>> parts(1);
  float taken = 0.0f;
  std::size_t firstHead = headSpan(table, 0), next = 0;
  for (std::size_t j = 0; j < widths.size(); j = next) {
    next = std::min(j + headSpan(table, j), widths.size());
    float width = 0.0f;
    for (std::size_t k = j; k < next; ++k) width += widths[k] + gap;
    if (taken + width > room + gap && parts.back().size() > firstHead) {
      parts.emplace_back();
      taken = 0.0f;
      for (std::size_t k = 0; k < firstHead; ++k) {
        parts.back().push_back(k);
        taken += widths[k] + gap;
      }
    }
    for (std::size_t k = j; k < next; ++k) parts.back().push_back(k);
    taken += width;
  }
  return parts;
}

TextTable withColumns(const TextTable& table, const std::vector<std::size_t>& columns) {
  TextTable some{.rows = {}, .hasHeads = table.hasHeads};
  for (const TextTable::Row& row : table.rows) {
    some.rows.emplace_back();
    for (const std::size_t j : columns)
      if (j < row.size()) some.rows.back().push_back(row[j]);
  }
  return some;
}

std::vector<TextPiece> piecesOf(const std::string& derivation) {
  std::vector<TextPiece> pieces;
  const auto continued = [&](TextPiece::Kind kind) -> TextTable& {
    if (pieces.empty() || pieces.back().kind != kind) pieces.push_back({.kind = kind});
    return pieces.back().table;
  };
  std::istringstream lines(derivation);
  for (std::string line; std::getline(lines, line);) {
    if (line == headRule) {
      continued(TextPiece::Kind::Table).hasHeads = true;
    } else if (line.starts_with('\t')) {
      continued(TextPiece::Kind::Table).rows.push_back(cellsOf(line));
    } else if (auto row = matrixRow(line); !row.empty()) {
      continued(TextPiece::Kind::Matrix).rows.push_back(std::move(row));
      pieces.back().indent = line.find('[');
    } else {
      const std::size_t from = std::min(line.find_first_not_of(' '), line.size());
      pieces.push_back({.indent = from, .line = line.substr(from)});
    }
  }
  return pieces;
}

std::string padded(const std::string& derivation) {
  std::string out, rows;
  const auto endTable = [&] {
    if (!rows.empty()) out += padded(piecesOf(rows).front().table);
    rows.clear();
  };
  std::istringstream lines(derivation);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('\t')) {
      rows += line + "\n";
      continue;
    }
    endTable();
    out += line + "\n";
  }
  endTable();
  return out;
}

}  // namespace gelenk
