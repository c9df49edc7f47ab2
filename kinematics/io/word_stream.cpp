#include "kinematics/io/word_stream.h"

#include <algorithm>

#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

std::string inQuotes(std::string_view word) {
  constexpr std::size_t longest = 60;
  return "'" + std::string(word.substr(0, longest)) + (word.size() > longest ? "...'" : "'");
}

}  // namespace

bool sameWord(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return lower(x) == lower(y); });
}

std::string lowerCase(std::string_view word) {
  std::string result(word);
  for (char& c : result) c = lower(c);
  return result;
}

WordStream::WordStream(std::string_view text, std::string file, std::string_view alsoBlank, char comment)
    : rest_(plainText(text, file)), file_(std::move(file)), alsoBlank_(alsoBlank), comment_(comment) {
  for (const char c : std::string_view(" \t\r\f\v")) blank_[static_cast<unsigned char>(c)] = true;
  for (const char c : alsoBlank) blank_[static_cast<unsigned char>(c)] = true;
  advance();
}

void WordStream::advance() {
  std::size_t at = 0;
  for (; at < rest_.size(); ++at) {
    const char c = rest_[at];
    if (c == '\n') {
      if (at + 1 < rest_.size()) ++line_;
    } else if (comment_ != '\0' && c == comment_) {
      at = std::min(rest_.find('\n', at), rest_.size()) - 1;
    } else if (!blank_[static_cast<unsigned char>(c)]) {
      break;
    }
  }
  std::size_t end = at;
  while (end < rest_.size() && rest_[end] != '\n' && !blank_[static_cast<unsigned char>(rest_[end])]) ++end;
  word_ = rest_.substr(at, end - at);
  rest_.remove_prefix(end);
}

std::string_view WordStream::next(const std::string& expected) {
  if (atEnd()) fail(expected);
  const std::string_view word = word_;
  lineTaken_ = line_;
  advance();
  return word;
}

double WordStream::number(const std::string& expected) {
  const auto value = parseNumber(word_);
  if (!value && !atEnd()) throw ParseError(file_, line_, expected, badNumber(word_));
  if (!value) fail(expected);
  next(expected);
  return *value;
}

int WordStream::integer(const std::string& expected) {
  const auto value = parseInteger(word_);
  if (!value) fail(expected);
  next(expected);
  return *value;
}

bool WordStream::take(std::string_view keyword) {
  if (atEnd() || !sameWord(word_, keyword)) return false;
  next("");
  return true;
}

bool WordStream::takePrefix(std::string_view prefix) {
  if (atEnd() || word_.size() < prefix.size() || !sameWord(word_.substr(0, prefix.size()), prefix))
    return false;
  if (word_.size() == prefix.size()) return take(prefix);
  lineTaken_ = line_;
  word_.remove_prefix(prefix.size());
  return true;
}

void WordStream::expect(std::string_view keyword) {
  if (!take(keyword)) fail("'" + std::string(keyword) + "'");
}

void WordStream::skipLine() {
  const int line = line_;
  while (!atEnd() && line_ == line) next("");
}

void WordStream::fail(const std::string& expected) const {
  throw ParseError(file_, line_, expected, atEnd() ? "the end of the file" : inQuotes(word_));
}

void WordStream::failTaken(const std::string& expected, const std::string& found) const {
  throw ParseError(file_, lineTaken_, expected, found);
}

}  // namespace gelenk
