#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "kinematics/io/parse_error.h"

namespace gelenk::testing {

/// A text that must be refused, the line that must be named (0: the file as a whole) and a part of the
/// message.
struct BadInput {
  std::string name;
  std::string text;
  int line;
  std::string part;
};

/// Runs every text through parse(text, file) and demands a ParseError of that line whose sentence holds that
/// part.
template <class Parse>
void expectRefused(const std::vector<BadInput>& table, Parse parse) {
  for (const BadInput& bad : table) {
    SCOPED_TRACE(bad.name);
    try {
      parse(bad.text, std::string("bad.txt"));
      ADD_FAILURE() << "was accepted";
    } catch (const ParseError& error) {
      EXPECT_EQ(error.line(), bad.line) << error.what();
      EXPECT_NE(std::string(error.what()).find(bad.part), std::string::npos)
          << error.what() << "\n  lacks: " << bad.part;
      EXPECT_EQ(std::string(error.what()).rfind("bad.txt", 0), 0u) << error.what();
    } catch (const std::exception& error) {
      ADD_FAILURE() << "not a ParseError: " << error.what();
    }
  }
}

}  // namespace gelenk::testing
