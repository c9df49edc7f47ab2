#pragma once

#include <future>
#include <utility>

namespace gelenk {

/// Work that takes seconds, beside the frames, or, where there are no threads (the page of a browser), at
/// once: then the picture stands meanwhile.
template <class Function>
auto startWork(Function function) {
#ifdef __EMSCRIPTEN__
  std::packaged_task<decltype(function())()> task(std::move(function));
  auto result = task.get_future();
  task();
  return result;
#else
  return std::async(std::launch::async, std::move(function));
#endif
}

}  // namespace gelenk
