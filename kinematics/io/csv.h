#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gelenk {

/// A field of a line of comma-separated values, in quotes where it holds a comma, a quote or an end of line
/// (RFC 4180).
std::string csvField(std::string_view text);

/// Fields joined by commas, with the end of the line.
std::string csvLine(std::span<const std::string> fields);

/// The records of a text in comma-separated values, one after the other. Quoted fields may hold commas,
/// doubled quotes and ends of lines; lines end with LF or CRLF.
class CsvReader {
 public:
  explicit CsvReader(std::string_view text) : rest_(text) {}

  /// The next record's fields; false at the end of the text.
  bool next(std::vector<std::string>& fields);
  int line() const { return line_; }                   ///< where the record begins, from 1
  std::string_view record() const { return record_; }  ///< its text, end of line included
  bool complete() const { return complete_; }          ///< it has an end of line: nothing was cut off

 private:
  std::string_view rest_, record_;
  int line_ = 0, nextLine_ = 1;
  bool complete_ = false;
};

}  // namespace gelenk
