#include "apps/sandbox/input.h"

#include <gtest/gtest.h>

namespace gelenk {
namespace {

using Kind = InputEvent::Kind;

TEST(InputQueue, ATapBetweenTwoFramesIsSeenDownAndUp) {
  InputQueue queue;
  queue.add({.kind = Kind::Key, .code = 80, .down = true});
  queue.add({.kind = Kind::Key, .code = 80, .down = false});
  const auto first = queue.take(), second = queue.take();
  ASSERT_EQ(first.size(), 1u);
  EXPECT_TRUE(first[0].down);
  ASSERT_EQ(second.size(), 1u);
  EXPECT_FALSE(second[0].down);
  EXPECT_TRUE(queue.empty());
}

TEST(InputQueue, APressHappensWhereTheMouseWasThen) {
  InputQueue queue;
  queue.add({.kind = Kind::MouseMove, .x = 10, .y = 20});
  queue.add({.kind = Kind::MouseButton, .code = 0, .down = true});
  queue.add({.kind = Kind::MouseMove, .x = 90, .y = 20});
  const auto first = queue.take(), second = queue.take();
  ASSERT_EQ(first.size(), 2u);
  EXPECT_EQ(first[0].x, 10);
  ASSERT_EQ(second.size(), 1u);
  EXPECT_EQ(second[0].x, 90);
}

/// Edges of panels and sliders stayed where the frame before the last had them.
TEST(InputQueue, AReleaseWaitsUntilTheMovesBeforeItWereSeen) {
  InputQueue queue;
  queue.add({.kind = Kind::MouseMove, .x = 10, .y = 20});
  queue.add({.kind = Kind::MouseMove, .x = 40, .y = 20});
  queue.add({.kind = Kind::MouseButton, .code = 0, .down = false});
  const auto first = queue.take(), second = queue.take();
  ASSERT_EQ(first.size(), 2u);
  EXPECT_EQ(first[1].x, 40);
  ASSERT_EQ(second.size(), 1u);
  EXPECT_FALSE(second[0].down);
}

}  // namespace
}  // namespace gelenk
