#include "apps/sandbox/window.h"

#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "skinning/gpu/driver.h"

namespace gelenk {
namespace {

constexpr const char* wayOut =
    "; without a window: gelenk sandbox --offscreen --screenshot picture.png --status status.json";

std::string lastError() {
  const char* description = nullptr;
  glfwGetError(&description);
  return description ? description : "no reason given";
}

InputQueue& queueOf(GLFWwindow* window) {
  return *static_cast<InputQueue*>(glfwGetWindowUserPointer(window));
}

/// Mouse positions come in screen coordinates, pictures are made of framebuffer pixels; on some systems they
/// differ.
double pixelRatio(GLFWwindow* window) {
  int width = 1, height = 1, pixels = 1, pixelsHigh = 1;
  glfwGetWindowSize(window, &width, &height);
  glfwGetFramebufferSize(window, &pixels, &pixelsHigh);
  return width > 0 ? static_cast<double>(pixels) / width : 1.0;
}

void connect(GLFWwindow* window) {
  glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) {
    const double ratio = pixelRatio(w);
    queueOf(w).add({.kind = InputEvent::Kind::MouseMove, .x = ratio * x, .y = ratio * y});
  });
  // A button belongs to the place of the last move before it: glfwGetCursorPos would tell where the mouse is
  // by now.
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int) {
    queueOf(w).add({.kind = InputEvent::Kind::MouseButton, .code = button, .down = action == GLFW_PRESS});
  });
  glfwSetScrollCallback(window, [](GLFWwindow* w, double x, double y) {
    queueOf(w).add({.kind = InputEvent::Kind::Wheel, .x = x, .y = y});
  });
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int) {
    if (action != GLFW_REPEAT)
      queueOf(w).add({.kind = InputEvent::Kind::Key, .code = key, .down = action == GLFW_PRESS});
  });
  glfwSetCharCallback(window, [](GLFWwindow* w, unsigned c) {
    queueOf(w).add({.kind = InputEvent::Kind::Character, .code = static_cast<int>(c)});
  });
  glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
    queueOf(w).add({.kind = InputEvent::Kind::Drop, .paths = {paths, paths + count}});
  });
}

}  // namespace

Window::Window(int width, int height, const std::string& title) {
  if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY"))
    throw std::runtime_error(std::string("there is no display (DISPLAY is not set)") + wayOut);
  if (!glfwInit()) throw std::runtime_error("cannot open a display: " + lastError() + wayOut);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (!window_) {
    const std::string reason = lastError();
    glfwTerminate();
    throw std::runtime_error("cannot open a window with OpenGL 3.3: " + reason +
                             "; try the software renderer (LIBGL_ALWAYS_SOFTWARE=1)" + wayOut);
  }
  glfwMakeContextCurrent(window_);
  try {
    requireOpenGl33();
  } catch (...) {
    glfwDestroyWindow(window_);
    glfwTerminate();
    throw;
  }
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(window_, &queue_);
  connect(window_);
}

Window::~Window() {
  glfwDestroyWindow(window_);
  glfwTerminate();
}

bool Window::shouldClose() const { return glfwWindowShouldClose(window_); }

bool Window::takeCloseRequest() {
  const bool asked = shouldClose();
  glfwSetWindowShouldClose(window_, GLFW_FALSE);
  return asked;
}

Input Window::poll(double scale, Keys keys) {
  glfwPollEvents();
  Input input{.scale = scale, .events = queue_.take(keys)};
  glfwGetFramebufferSize(window_, &input.width, &input.height);
  while ((input.width == 0 || input.height == 0) && !shouldClose()) {  // minimised
    glfwWaitEvents();
    glfwGetFramebufferSize(window_, &input.width, &input.height);
  }
  if (scale <= 0.0) {
    float x = 1.0f, y = 1.0f;
    glfwGetWindowContentScale(window_, &x, &y);
    input.scale = std::max(1.0f, std::round(4.0f * std::max(x, y)) / 4.0f);
  }
  return input;
}

void Window::wait(double seconds) {
  if (std::isfinite(seconds))
    glfwWaitEventsTimeout(seconds);
  else
    glfwWaitEvents();
}

void Window::wake() { glfwPostEmptyEvent(); }
void Window::swap() { glfwSwapBuffers(window_); }
void Window::setTitle(const std::string& title) { glfwSetWindowTitle(window_, title.c_str()); }

}  // namespace gelenk
