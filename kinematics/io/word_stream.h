#pragma once

#include <string>
#include <string_view>

namespace gelenk {

/// The words of a text one after the other, with their lines, for formats that are read word by word. Words
/// are separated by blanks, line ends and the characters of alsoBlank; a word that starts with `comment`
/// begins a comment that runs to the end of its line ('\0': there are none). Every failure is a ParseError
/// that names file and line.
class WordStream {
 public:
  WordStream(std::string_view text, std::string file, std::string_view alsoBlank = "", char comment = '\0');

  bool atEnd() const { return word_.empty(); }
  /// The next word, empty at the end.
  std::string_view peek() const { return word_; }
  /// Line of the next word; at the end, the last line.
  int line() const { return line_; }
  /// True if the next word is on the same line as the word taken last.
  bool sameLine() const { return !atEnd() && line_ == lineTaken_; }
  int lineTaken() const { return lineTaken_; }

  /// Takes the next word. expected: what to say at the end of the text.
  std::string_view next(const std::string& expected);
  /// Takes a finite number / an integer.
  double number(const std::string& expected = "a finite number");
  int integer(const std::string& expected = "an integer");
  /// Takes the next word, which must be this one (upper and lower case are the same).
  void expect(std::string_view keyword);
  /// Takes the beginning of the next word if it is this text, as in "Frames:2"; the rest stays the next word.
  bool takePrefix(std::string_view prefix);
  /// Takes the next word if it is this one (upper and lower case are the same).
  bool take(std::string_view keyword);
  /// Passes over the rest of the line on which the next word stands.
  void skipLine();

  /// ParseError at the next word.
  [[noreturn]] void fail(const std::string& expected) const;
  /// ParseError at the line of the word taken last.
  [[noreturn]] void failTaken(const std::string& expected, const std::string& found) const;
  const std::string& file() const { return file_; }

 private:
  void advance();

  std::string_view rest_, word_;
  std::string file_, alsoBlank_;
  char comment_;
  int line_ = 1, lineTaken_ = 0;
  bool blank_[256] = {};
};

/// Equal when upper and lower case of the 26 letters are not told apart.
bool sameWord(std::string_view a, std::string_view b);
std::string lowerCase(std::string_view word);

}  // namespace gelenk
