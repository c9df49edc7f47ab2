#include "apps/sandbox/input.h"

#include <GLFW/glfw3.h>

#include <utility>

namespace gelenk {
namespace {

bool isModifier(int key) { return key >= GLFW_KEY_LEFT_SHIFT && key <= GLFW_KEY_RIGHT_SUPER; }

}  // namespace

bool InputQueue::nextTypes() const {
  const InputEvent& next = waiting_.front();
  if (next.kind == InputEvent::Kind::Character) return true;
  if (next.kind != InputEvent::Kind::Key) return false;
  if (next.code == GLFW_KEY_LEFT_SHIFT || next.code == GLFW_KEY_RIGHT_SHIFT) return true;
  if (!next.down) return typed_.contains(next.code);
  return waiting_.size() > 1 && waiting_[1].kind == InputEvent::Kind::Character;
}

std::vector<InputEvent> InputQueue::take(Keys keys) {
  std::vector<InputEvent> events;
  std::set<std::pair<InputEvent::Kind, int>> released;
  bool moved = false, wrote = false, buttonReleased = false;
  const auto pass = [&] {
    events.push_back(std::move(waiting_.front()));
    waiting_.pop_front();
  };
  const auto isNextCharacter = [&] {
    return !waiting_.empty() && waiting_.front().kind == InputEvent::Kind::Character;
  };
  while (!waiting_.empty()) {
    const InputEvent& next = waiting_.front();
    const bool isButton = next.kind == InputEvent::Kind::MouseButton;
    const bool isKey = next.kind == InputEvent::Kind::Key;
    const bool isMove = next.kind == InputEvent::Kind::MouseMove;
    const bool types = keys == Keys::Text && nextTypes();
    const bool commands = (isButton || isKey) && !types;
    if (keys == Keys::Awaited && (isNextCharacter() || (isKey && next.down))) break;
    if (isButton && !next.down && moved) break;  // what is dragged goes where it is let go
    if (isMove && buttonReleased) break;
    if (commands && next.down && (wrote || released.contains({next.kind, next.code}))) break;
    if (commands && !next.down) released.emplace(next.kind, next.code);
    if (types && isKey && next.down) typed_.insert(next.code);
    if (isKey && !next.down) typed_.erase(next.code);
    wrote |= keys == Keys::Text && isNextCharacter();
    buttonReleased |= isButton && !next.down;
    moved |= isMove;
    const bool ends = commands && next.down && !(isKey && isModifier(next.code));
    pass();
    if (!ends) continue;
    if (isKey && isNextCharacter()) pass();  // its own: no field that it opens is to have it
    break;
  }
  return events;
}

}  // namespace gelenk
