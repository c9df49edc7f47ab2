#pragma once

#include <string>
#include <vector>

namespace gelenk {

/// A table of a derivation: each of its lines begins with a tab, and tabs part the cells. The line "\t---"
/// rules off the heads of the columns, which come first. An empty head joins the one before it: one head over
/// several columns.
struct TextTable {
  using Row = std::vector<std::string>;
  std::vector<Row> rows;
  bool hasHeads = false;  ///< rows[0]
};

/// A piece of a derivation: a table, the rows of a matrix ("[ 1 2 ]" on lines of their own), or one line.
struct TextPiece {
  enum class Kind { Line, Table, Matrix };
  Kind kind = Kind::Line;
  std::size_t indent = 0;  ///< blanks before a line or a matrix
  std::string line = {};
  TextTable table = {};  ///< a matrix is a table without heads
};
std::vector<TextPiece> piecesOf(const std::string& derivation);

/// A number alone in a cell, as 0.5, -12 or 1.3e-05. Columns of them stand with their points below each
/// other.
bool isNumber(const std::string& cell);
/// The characters before the decimal point of a number.
std::size_t wholeDigits(const std::string& number);
/// A cell below the heads is a number; words among them end where the column does.
bool isNumberColumn(const TextTable& table, std::size_t column);
/// How many columns a head stands over.
std::size_t headSpan(const TextTable& table, std::size_t column);

/// Which columns stand together where a table is wider than its room: as many parts as that takes, below each
/// other, each beginning with the table's first column; columns under one head stay together. widths, gap
/// between two columns, room: of one unit.
std::vector<std::vector<std::size_t>> partsOf(const TextTable& table, const std::vector<float>& widths,
                                              float gap, float room);
/// Some of a table's columns.
TextTable withColumns(const TextTable& table, const std::vector<std::size_t>& columns);

/// The derivation as a terminal shows it: the columns of its tables padded with blanks.
std::string padded(const std::string& derivation);

}  // namespace gelenk
