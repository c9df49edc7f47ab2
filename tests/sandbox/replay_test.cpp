#include "apps/sandbox/replay.h"

#include <gtest/gtest.h>

#include "kinematics/io/parse_error.h"

namespace gelenk {
namespace {

std::string messageOf(const std::string& text) {
  try {
    Replay::parse("drag.txt", text);
    return "accepted";
  } catch (const ParseError& error) {
    return error.what();
  }
}

TEST(Replay, LastsUntilTheLastMoveAndRelease) {
  EXPECT_EQ(Replay::parse("r", "# nothing\n\n0 move 1 2\n").length(), 1);
  EXPECT_EQ(Replay::parse("r", "3 drag hand_r 10 0 20\n").length(), 25);
}

/// Arrows, End and the brush's brackets could be pressed in a window alone.
TEST(Replay, CanPressEveryKeyThatTheWindowKnows) {
  for (const char* key :
       {"left", "right", "up", "down", "home", "end", "[", "]", "?", "f5", "f12", "delete", "k"})
    EXPECT_NO_THROW(Replay::parse("test", std::string("0 key ") + key + "\n")) << key;
}

TEST(Replay, SaysWhichLineIsWrongAndWhatBelongsThere) {
  EXPECT_EQ(messageOf("0 move 1 2\nnow move 1 2\n"), "drag.txt:2: expected a frame number, found 'now'");
  EXPECT_EQ(messageOf("9 move 1 2\n8 move 1 2\n"), "drag.txt:2: expected a frame not before 9, found 8");
  EXPECT_EQ(messageOf("0\n"), "drag.txt:1: expected a command after the frame number, found none");
  EXPECT_EQ(messageOf("0 move 1\n"), "drag.txt:1: expected move X Y, found 1 words after move");
  EXPECT_EQ(messageOf("0 move 1 nan\n"), "drag.txt:1: expected a number, found 'nan'");
  EXPECT_EQ(messageOf("0 press side\n"), "drag.txt:1: expected left, right or middle, found 'side'");
  EXPECT_NE(messageOf("0 jump 1\n").find("a command: move, press"), std::string::npos);
  EXPECT_NE(messageOf("0 key F99\n").find("a key"), std::string::npos);
  EXPECT_NE(messageOf("0 drag hand_r 1 2 0\n").find("at least 1"), std::string::npos);
}

}  // namespace
}  // namespace gelenk
