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

/// Whom the keys belong to.
enum class Keys {
  Commands,  ///< each does something
  Text,      ///< a text field has them
  Awaited,   ///< one that just opened will have them, but is not ready
};

/// Holds events until a frame may see them. A key or button that goes down ends what its frame sees, since it
/// may change whom the next belongs to; a release comes after the frame that saw the moves before it. So the
/// same is done whatever the frame rate: no tap is lost, no end of a drag, no letter of a word.
class InputQueue {
 public:
  void add(InputEvent event) { waiting_.push_back(std::move(event)); }
  /// What is typed into a text field comes at once, as fast as it was typed; keys that do something to the
  /// text, such as Backspace and Enter, keep their place in it.
  std::vector<InputEvent> take(Keys keys);
  bool empty() const { return waiting_.empty(); }

 private:
  /// Whether the first event that waits is a character, the key that typed it, that key's release, or Shift.
  bool nextTypes() const;

  std::deque<InputEvent> waiting_;
  std::set<int> typed_;  ///< keys that are down and typed a character
};

}  // namespace gelenk
