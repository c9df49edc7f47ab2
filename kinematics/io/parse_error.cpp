#include "kinematics/io/parse_error.h"

namespace gelenk {

ParseError::ParseError(std::string file, int line, std::string expected, std::string found)
    : std::runtime_error(file + (line > 0 ? ":" + std::to_string(line) : "") + ": expected " + expected +
                         ", found " + found),
      file_(std::move(file)),
      line_(line),
      expected_(std::move(expected)),
      found_(std::move(found)) {}

}  // namespace gelenk
