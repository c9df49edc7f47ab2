#include "apps/sandbox/input.h"

#include <GLFW/glfw3.h>

#include <utility>

namespace gelenk {

bool InputQueue::nextTypes() const {
  const InputEvent& next = waiting_.front();
  if (next.kind == InputEvent::Kind::Character) return true;
  if (next.kind != InputEvent::Kind::Key) return false;
  if (next.code == GLFW_KEY_LEFT_SHIFT || next.code == GLFW_KEY_RIGHT_SHIFT) return true;
  if (!next.down) return typed_.contains(next.code);
  return waiting_.size() > 1 && waiting_[1].kind == InputEvent::Kind::Character;
}

std::vector<InputEvent> InputQueue::take(bool writing) {
  std::vector<InputEvent> events;
  std::set<std::pair<InputEvent::Kind, int>> changed;
  bool buttonChanged = false, moved = false, wrote = false, commanded = false;
  while (!waiting_.empty()) {
    const InputEvent& next = waiting_.front();
    const bool isButton = next.kind == InputEvent::Kind::MouseButton;
    const bool isKey = next.kind == InputEvent::Kind::Key;
    if (isButton && !next.down && moved) break;  // what is dragged goes where it is let go
    // A click belongs where it was made: moves that follow it wait for the next frame.
    if (next.kind == InputEvent::Kind::MouseMove && buttonChanged) break;
    const bool types = writing && nextTypes();
    const bool commands = !types && (isButton || isKey);
    if (types && commanded) break;
    if (commands && next.down && wrote) break;
    if (commands && !changed.emplace(next.kind, next.code).second) break;
    if (types && isKey && next.down) typed_.insert(next.code);
    if (isKey && !next.down) typed_.erase(next.code);
    wrote |= writing && next.kind == InputEvent::Kind::Character;
    commanded |= commands && next.down;
    buttonChanged |= isButton;
    moved |= next.kind == InputEvent::Kind::MouseMove;
    events.push_back(next);
    waiting_.pop_front();
  }
  return events;
}

}  // namespace gelenk
