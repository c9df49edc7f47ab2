#include "apps/sandbox/input.h"

#include <GLFW/glfw3.h>
#include <gtest/gtest.h>

namespace gelenk {
namespace {

using Kind = InputEvent::Kind;

TEST(InputQueue, ATapBetweenTwoFramesIsSeenDownAndUp) {
  InputQueue queue;
  queue.add({.kind = Kind::Key, .code = 80, .down = true});
  queue.add({.kind = Kind::Key, .code = 80, .down = false});
  const auto first = queue.take(Keys::Commands), second = queue.take(Keys::Commands);
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
  const auto first = queue.take(Keys::Commands), second = queue.take(Keys::Commands);
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
  const auto first = queue.take(Keys::Commands), second = queue.take(Keys::Commands);
  ASSERT_EQ(first.size(), 2u);
  EXPECT_EQ(first[1].x, 40);
  ASSERT_EQ(second.size(), 1u);
  EXPECT_FALSE(second[0].down);
}

void tap(InputQueue& queue, int key, int character) {
  queue.add({.kind = Kind::Key, .code = key, .down = true});
  if (character > 0) queue.add({.kind = Kind::Character, .code = character});
  queue.add({.kind = Kind::Key, .code = key, .down = false});
}

std::string charactersOf(const std::vector<InputEvent>& events) {
  std::string characters;
  for (const InputEvent& event : events)
    if (event.kind == Kind::Character) characters += static_cast<char>(event.code);
  return characters;
}

TEST(InputQueue, ATextFieldGetsAllThatWasTypedAtOnce) {
  InputQueue queue;
  for (const char c : std::string("LEVEL")) {
    queue.add({.kind = Kind::Key, .code = GLFW_KEY_LEFT_SHIFT, .down = true});
    tap(queue, c, c);
    queue.add({.kind = Kind::Key, .code = GLFW_KEY_LEFT_SHIFT, .down = false});
  }
  EXPECT_EQ(charactersOf(queue.take(Keys::Text)), "LEVEL");
  EXPECT_TRUE(queue.empty());
}

TEST(InputQueue, KeysThatChangeTheTextKeepTheirPlaceAmongTheCharacters) {
  InputQueue queue;
  tap(queue, GLFW_KEY_A, 'a');
  tap(queue, GLFW_KEY_B, 'b');
  tap(queue, GLFW_KEY_BACKSPACE, 0);
  tap(queue, GLFW_KEY_C, 'c');
  tap(queue, GLFW_KEY_ENTER, 0);
  std::string story;
  while (!queue.empty())
    for (const InputEvent& event : queue.take(Keys::Text)) {
      if (event.kind == Kind::Character) story += static_cast<char>(event.code);
      if (event.kind == Kind::Key && event.down && event.code >= GLFW_KEY_ESCAPE)
        story += event.code == GLFW_KEY_ENTER ? '!' : '<';
    }
  EXPECT_EQ(story, "ab<c!");
  tap(queue, GLFW_KEY_A, 'a');
  tap(queue, GLFW_KEY_BACKSPACE, 0);
  for (const InputEvent& event : queue.take(Keys::Text)) EXPECT_NE(event.code, GLFW_KEY_BACKSPACE);
}

TEST(InputQueue, WithoutATextFieldEveryTapIsSeenDownAndUp) {
  InputQueue queue;
  tap(queue, GLFW_KEY_N, 'n');
  tap(queue, GLFW_KEY_N, 'n');
  int frames = 0;
  while (!queue.empty()) {
    queue.take(Keys::Commands);
    ++frames;
  }
  EXPECT_EQ(frames, 4);
}

/// What a key does may give the next one to a text field, or take it from there.
TEST(InputQueue, AKeyThatGoesDownIsTheLastOfItsFrameAModifierIsNot) {
  InputQueue queue;
  queue.add({.kind = Kind::Key, .code = GLFW_KEY_LEFT_CONTROL, .down = true});
  queue.add({.kind = Kind::Key, .code = GLFW_KEY_K, .down = true});
  queue.add({.kind = Kind::Key, .code = GLFW_KEY_LEFT_CONTROL, .down = false});
  queue.add({.kind = Kind::Key, .code = GLFW_KEY_K, .down = false});
  tap(queue, GLFW_KEY_P, 'p');
  tap(queue, GLFW_KEY_ENTER, 0);
  tap(queue, GLFW_KEY_D, 'd');
  const auto opened = queue.take(Keys::Commands), awaited = queue.take(Keys::Awaited);
  ASSERT_EQ(opened.size(), 2u);
  EXPECT_EQ(opened[1].code, GLFW_KEY_K);
  ASSERT_EQ(awaited.size(), 2u);
  EXPECT_FALSE(awaited[0].down || awaited[1].down);
  EXPECT_TRUE(queue.take(Keys::Awaited).empty());
  EXPECT_EQ(charactersOf(queue.take(Keys::Text)), "p");
  const auto entered = queue.take(Keys::Text);
  ASSERT_EQ(entered.size(), 1u);
  EXPECT_EQ(entered[0].code, GLFW_KEY_ENTER);
  const auto answered =
      queue.take(Keys::Commands);  // Enter's release, D, and what D writes where nobody reads
  ASSERT_EQ(answered.size(), 3u);
  EXPECT_EQ(answered[1].code, GLFW_KEY_D);
  EXPECT_TRUE(answered[1].down);
}

}  // namespace
}  // namespace gelenk
