#pragma once

#include <functional>
#include <string>

#include "apps/sandbox/input.h"

struct GLFWwindow;

namespace gelenk {

/// The GLFW window: an OpenGL 3.3 context that is current while it lives, and the events of its user.
class Window {
 public:
  /// Throws std::runtime_error that says what is missing and the way out: no display, OpenGL older than 3.3.
  Window(int width, int height, const std::string& title);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  bool shouldClose() const;
  /// Whether its close button was pressed since the last call.
  bool takeCloseRequest();
  /// Collects events; returns what the next frame sees. scale 0: the monitor's.
  Input poll(double scale, Keys keys = Keys::Commands);
  /// Sleeps until something happens, or for so many seconds (infinity: as long as it takes).
  void wait(double seconds);
  /// Ends a wait; from any thread.
  static void wake();
  bool hasEvents() const { return !queue_.empty(); }
  void swap();
  void setTitle(const std::string& title);

 private:
  GLFWwindow* window_ = nullptr;
  InputQueue queue_;
};

}  // namespace gelenk
