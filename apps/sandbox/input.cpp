#include "apps/sandbox/input.h"

#include <set>
#include <utility>

namespace gelenk {

std::vector<InputEvent> InputQueue::take() {
  std::vector<InputEvent> events;
  std::set<std::pair<InputEvent::Kind, int>> changed;
  bool buttonChanged = false, moved = false;
  while (!waiting_.empty()) {
    const InputEvent& next = waiting_.front();
    const bool isButton = next.kind == InputEvent::Kind::MouseButton;
    if (isButton && !next.down && moved) break;  // what is dragged goes where it is let go
    if (isButton || next.kind == InputEvent::Kind::Key)
      if (!changed.emplace(next.kind, next.code).second) break;
    // A click belongs where it was made: moves that follow it wait for the next frame.
    if (next.kind == InputEvent::Kind::MouseMove && buttonChanged) break;
    buttonChanged |= isButton;
    moved |= next.kind == InputEvent::Kind::MouseMove;
    events.push_back(next);
    waiting_.pop_front();
  }
  return events;
}

}  // namespace gelenk
