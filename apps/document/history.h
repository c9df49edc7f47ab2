#pragma once

#include <deque>
#include <optional>
#include <utility>

namespace gelenk {

/// The way back and forth through a value. T should be cheap to copy, its large parts shared.
template <typename T>
class History {
 public:
  static constexpr std::size_t longest = 200;

  /// Before an edit: the value as it is. What was undone is forgotten.
  void remember(T before) {
    past_.push_back(std::move(before));
    ++steps_;
    if (past_.size() > longest) past_.pop_front();
    future_.clear();
  }
  /// Counts every step, back and forth ones too.
  int steps() const { return steps_; }
  bool canUndo() const { return !past_.empty(); }
  bool canRedo() const { return !future_.empty(); }
  /// The value before the last edit, nullopt where there is none; `now` can be had again by redo.
  std::optional<T> undo(T now) { return ++steps_, step(past_, future_, std::move(now)); }
  std::optional<T> redo(T now) { return ++steps_, step(future_, past_, std::move(now)); }
  void clear() { past_.clear(), future_.clear(); }

 private:
  static std::optional<T> step(std::deque<T>& from, std::deque<T>& to, T now) {
    if (from.empty()) return std::nullopt;
    to.push_back(std::move(now));
    T value = std::move(from.back());
    from.pop_back();
    return value;
  }
  std::deque<T> past_, future_;
  int steps_ = 0;
};

}  // namespace gelenk
