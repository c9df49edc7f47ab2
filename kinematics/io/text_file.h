#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gelenk {

/// The whole file. Throws std::runtime_error with the system's reason when it cannot be opened or read.
std::string readFile(const std::string& path);

/// Writes beside the target under a temporary name and renames, so that a failure leaves the old file
/// untouched. Throws std::runtime_error with the system's reason.
void writeFile(const std::string& path, std::string_view content);

/// A text as its readers want it: without the byte-order mark that some programs put first. Throws ParseError
/// for UTF-16 and UTF-32, which only look like text.
std::string_view plainText(std::string_view text, const std::string& file);

/// Lines without their ends (LF, CRLF); a last line without an end counts.
std::vector<std::string_view> splitLines(std::string_view text);

/// Words between blanks and tabs.
std::vector<std::string_view> splitWords(std::string_view line);

/// The whole word as a finite number / an integer; nullopt if it is anything else (locale-independent, "inf"
/// and "nan" are no numbers here).
std::optional<double> parseNumber(std::string_view word);
std::optional<int> parseInteger(std::string_view word);

/// The word in quotes and why parseNumber refuses it, where that is worth a word: "'3.1+e2' (the sign of an
/// exponent stands after the e)".
std::string badNumber(std::string_view word);

/// Shortest text that reads back as exactly the same double.
std::string exactNumber(double value);

}  // namespace gelenk
