#include "apps/sandbox/gui.h"

#include <GLFW/glfw3.h>
#include <imgui_impl_opengl3.h>

#include <algorithm>

namespace gelenk {
namespace {

void mapKeys(ImGuiIO& io) {
  io.KeyMap[ImGuiKey_Tab] = GLFW_KEY_TAB;
  io.KeyMap[ImGuiKey_LeftArrow] = GLFW_KEY_LEFT;
  io.KeyMap[ImGuiKey_RightArrow] = GLFW_KEY_RIGHT;
  io.KeyMap[ImGuiKey_UpArrow] = GLFW_KEY_UP;
  io.KeyMap[ImGuiKey_DownArrow] = GLFW_KEY_DOWN;
  io.KeyMap[ImGuiKey_PageUp] = GLFW_KEY_PAGE_UP;
  io.KeyMap[ImGuiKey_PageDown] = GLFW_KEY_PAGE_DOWN;
  io.KeyMap[ImGuiKey_Home] = GLFW_KEY_HOME;
  io.KeyMap[ImGuiKey_End] = GLFW_KEY_END;
  io.KeyMap[ImGuiKey_Insert] = GLFW_KEY_INSERT;
  io.KeyMap[ImGuiKey_Delete] = GLFW_KEY_DELETE;
  io.KeyMap[ImGuiKey_Backspace] = GLFW_KEY_BACKSPACE;
  io.KeyMap[ImGuiKey_Space] = GLFW_KEY_SPACE;
  io.KeyMap[ImGuiKey_Enter] = GLFW_KEY_ENTER;
  io.KeyMap[ImGuiKey_Escape] = GLFW_KEY_ESCAPE;
  io.KeyMap[ImGuiKey_KeyPadEnter] = GLFW_KEY_KP_ENTER;
  io.KeyMap[ImGuiKey_A] = GLFW_KEY_A;
  io.KeyMap[ImGuiKey_C] = GLFW_KEY_C;
  io.KeyMap[ImGuiKey_V] = GLFW_KEY_V;
  io.KeyMap[ImGuiKey_X] = GLFW_KEY_X;
  io.KeyMap[ImGuiKey_Y] = GLFW_KEY_Y;
  io.KeyMap[ImGuiKey_Z] = GLFW_KEY_Z;
}

#ifdef __EMSCRIPTEN__
constexpr const char* glslVersion = "#version 300 es";
#else
constexpr const char* glslVersion = "#version 330";
#endif

}  // namespace

Gui::Gui() {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // the sandbox keeps its own state
  io.LogFilename = nullptr;
  io.BackendPlatformName = "gelenk";
  io.ConfigWindowsMoveFromTitleBarOnly = true;
  mapKeys(io);
  ImGui_ImplOpenGL3_Init(glslVersion);
}

Gui::~Gui() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui::DestroyContext();
}

void Gui::setLook(Theme theme, float scale) {
  if (scale_ == scale && theme_ == theme) return;
  if (scale_ != scale) {
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    fonts_ = loadFonts(scale);
  }
  theme_ = theme;
  scale_ = scale;
  applyStyle(theme, scale);
}

void Gui::beginFrame(const Input& input, double dt) {
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = ImVec2(static_cast<float>(input.width), static_cast<float>(input.height));
  io.DeltaTime = static_cast<float>(std::max(dt, 1e-4));
  for (const InputEvent& event : input.events) {
    switch (event.kind) {
      case InputEvent::Kind::MouseMove:
        io.MousePos = ImVec2(static_cast<float>(event.x), static_cast<float>(event.y));
        break;
      case InputEvent::Kind::MouseButton:
        if (event.code >= 0 && event.code < 3) io.MouseDown[event.code] = event.down;
        break;
      case InputEvent::Kind::Wheel:
        io.MouseWheelH += static_cast<float>(event.x);
        io.MouseWheel += static_cast<float>(event.y);
        break;
      case InputEvent::Kind::Key:
        if (event.code >= 0 && event.code < 512) io.KeysDown[event.code] = event.down;
        break;
      case InputEvent::Kind::Character: io.AddInputCharacter(static_cast<unsigned>(event.code)); break;
      case InputEvent::Kind::Drop: break;
    }
  }
  io.KeyCtrl = io.KeysDown[GLFW_KEY_LEFT_CONTROL] || io.KeysDown[GLFW_KEY_RIGHT_CONTROL];
  io.KeyShift = io.KeysDown[GLFW_KEY_LEFT_SHIFT] || io.KeysDown[GLFW_KEY_RIGHT_SHIFT];
  io.KeyAlt = io.KeysDown[GLFW_KEY_LEFT_ALT] || io.KeysDown[GLFW_KEY_RIGHT_ALT];
  io.KeySuper = io.KeysDown[GLFW_KEY_LEFT_SUPER] || io.KeysDown[GLFW_KEY_RIGHT_SUPER];
  ImGui_ImplOpenGL3_NewFrame();
  ImGui::NewFrame();
}

void Gui::endFrame() {
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace gelenk
