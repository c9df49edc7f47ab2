#pragma once

#include <deque>
#include <set>
#include <string>
#include <vector>

namespace gelenk {

/// Something the user did. Keys, buttons and modifiers are GLFW's codes (GLFW/glfw3.h).
struct InputEvent {
  enum class Kind { MouseMove, MouseButton, Wheel, Key, Character, Drop };
  Kind kind = Kind::MouseMove;
  double x = 0.0, y = 0.0;              ///< MouseMove: pixels from the upper left; Wheel: steps
  int code = 0;                         ///< button, key, or code point
  bool down = false;                    ///< MouseButton, Key
  std::vector<std::string> paths = {};  ///< Drop: what came at once
};

/// What one frame gets to see.
struct Input {
  int width = 0, height = 0;  ///< framebuffer, pixels
  double scale = 1.0;
  std::vector<InputEvent> events = {};
};

/// Holds events until a frame may see them. Within one frame a button or key changes at most once, a press is
/// seen where it was made, and a release after the frame that saw the moves before it: whatever the frame
/// rate, a quick tap is never lost, nor the end of a drag.
class InputQueue {
 public:
  void add(InputEvent event) { waiting_.push_back(std::move(event)); }
  /// writing: a text field has the keys. What was typed into it comes at once, as fast as it was typed; keys
  /// that do something to the text, such as Backspace and Enter, have a frame of their own, in their order.
  std::vector<InputEvent> take(bool writing = false);
  bool empty() const { return waiting_.empty(); }

 private:
  /// Whether the first event that waits is a character, the key that typed it, that key's release, or Shift.
  bool nextTypes() const;

  std::deque<InputEvent> waiting_;
  std::set<int> typed_;  ///< keys that are down and typed a character
};

}  // namespace gelenk
