#pragma once

#include <stdexcept>
#include <string>

namespace gelenk {

/// A file that cannot be read as what it should be: where, what was expected there, what was found.
/// what() reads "arm.skel:12: expected a parent index below 11, found '17'". line 0: the file as a whole.
class ParseError : public std::runtime_error {
 public:
  ParseError(std::string file, int line, std::string expected, std::string found);

  const std::string& file() const { return file_; }
  int line() const { return line_; }
  const std::string& expected() const { return expected_; }
  const std::string& found() const { return found_; }

 private:
  std::string file_;
  int line_;
  std::string expected_, found_;
};

}  // namespace gelenk
