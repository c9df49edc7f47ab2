#include "apps/sandbox/gui.h"

#include <GLFW/glfw3.h>
#include <imgui_impl_opengl3.h>
#include <imgui_internal.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "skinning/gpu/gl.h"

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
  ImGui_ImplOpenGL3_Init(imguiShaderVersion);
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
  awaited_ = keys() == Keys::Awaited ? awaited_ - 1 : 0;
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
        // Tab is the next solver's: Dear ImGui, which would turn the next slider into a field, has it in
        // fields alone.
        if (event.code == GLFW_KEY_TAB && keys() != Keys::Text)
          io.KeysDown[event.code] = false;
        else if (event.code >= 0 && event.code < 512)
          io.KeysDown[event.code] = event.down;
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

namespace {

bool isWhole(float x) { return x == std::floor(x); }

/// A draw command that clears its clip rectangle to the colour which it carries: a processor that draws does
/// so several times as fast as it fills.
void clearClipped(const ImDrawList*, const ImDrawCmd* command) {
  const ImVec4& area = command->ClipRect;  // x0, y0, x1, y1, from the top left
  const ImVec2 size = ImGui::GetDrawData()->DisplaySize;
  const ImVec4 c = ImGui::ColorConvertU32ToFloat4(
      static_cast<ImU32>(reinterpret_cast<std::uintptr_t>(command->UserCallbackData)));
  const bool everything = area.x <= 0 && area.y <= 0 && area.z >= size.x && area.w >= size.y;
  if (everything) glDisable(GL_SCISSOR_TEST);  // faster still
  glScissor(static_cast<int>(area.x), static_cast<int>(size.y - area.w), static_cast<int>(area.z - area.x),
            static_cast<int>(area.w - area.y));
  glClearColor(c.x, c.y, c.z, 1.0f);
  glClear(GL_COLOR_BUFFER_BIT);
  if (everything) glEnable(GL_SCISSOR_TEST);
}

void* carried(ImU32 colour) { return reinterpret_cast<void*>(static_cast<std::uintptr_t>(colour)); }
bool isOpaque(ImU32 colour) { return colour >> IM_COL32_A_SHIFT == 255; }

/// Where a window begins with an opaque rectangle, its background, that is cleared instead.
void clearBackgrounds(ImDrawData& data) {
  for (int l = 0; l < data.CmdListsCount; ++l) {
    ImDrawList& list = *data.CmdLists[l];
    if (list.CmdBuffer.empty() || list.VtxBuffer.Size < 4) continue;
    ImDrawCmd& first = list.CmdBuffer[0];
    if (first.UserCallback || first.ElemCount < 6 || first.VtxOffset != 0 || first.IdxOffset != 0) continue;
    const ImDrawVert *v = list.VtxBuffer.Data, &a = v[0], &c = v[2];  // clockwise from the upper left
    const bool isRectangle =
        std::all_of(list.IdxBuffer.Data, list.IdxBuffer.Data + 6, [](auto i) { return i < 4; }) &&
        v[1].pos.x == c.pos.x && v[1].pos.y == a.pos.y && v[3].pos.x == a.pos.x && v[3].pos.y == c.pos.y &&
        isWhole(a.pos.x) && isWhole(a.pos.y) && isWhole(c.pos.x) && isWhole(c.pos.y);
    const bool isPlain = std::all_of(v, v + 4, [&](const ImDrawVert& corner) {
      return corner.col == a.col && corner.uv.x == a.uv.x && corner.uv.y == a.uv.y;
    });
    if (!isRectangle || !isPlain || !isOpaque(a.col)) continue;
    const ImVec4 area(std::max(a.pos.x, first.ClipRect.x), std::max(a.pos.y, first.ClipRect.y),
                      std::min(c.pos.x, first.ClipRect.z), std::min(c.pos.y, first.ClipRect.w));
    if (!(area.x < area.z && area.y < area.w)) continue;
    const ImU32 colour = a.col;
    first.IdxOffset += 6;
    first.ElemCount -= 6;
    ImDrawCmd callback = first;
    callback.ElemCount = 0;
    callback.UserCallback = clearClipped;
    callback.ClipRect = area;
    callback.UserCallbackData = carried(colour);
    list.CmdBuffer.insert(list.CmdBuffer.begin(), callback);
  }
}

}  // namespace

void Gui::endFrame() {
  ImGui::Render();
  clearBackgrounds(*ImGui::GetDrawData());
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void fillRounded(ImDrawList& draw, ImVec2 low, ImVec2 high, ImU32 colour, float rounding) {
  const float band = std::ceil(rounding) + 1;  // Dear ImGui rounds no further
  const float edges[] = {low.x, low.y, high.x, high.y};
  if (!isOpaque(colour) || !std::all_of(edges, edges + 4, isWhole) || high.y - low.y <= 2 * band)
    return draw.AddRectFilled(low, high, colour, rounding);
  const ImVec2 middleLow(low.x, low.y + band), middleHigh(high.x, high.y - band);
  draw.AddRectFilled(low, {high.x, middleLow.y}, colour, rounding, ImDrawFlags_RoundCornersTop);
  draw.AddRectFilled({low.x, middleHigh.y}, high, colour, rounding, ImDrawFlags_RoundCornersBottom);
  draw.PushClipRect(middleLow, middleHigh, true);
  draw.AddCallback(clearClipped, carried(colour));
  draw.PopClipRect();
}

void Gui::focusText() {
  ImGui::SetKeyboardFocusHere();
  awaited_ = 4;
}

/// By what is active, not by WantTextInput, which is a frame late when Enter or a click ends or begins it.
Keys Gui::keys() const {
  const ImGuiContext& g = *ImGui::GetCurrentContext();
  if (g.ActiveId != 0 && g.ActiveId == g.InputTextState.ID) return Keys::Text;
  return awaited_ > 0 ? Keys::Awaited : Keys::Commands;
}

Span placeOfValue(const Span& frame, const Span& grab, float width, float gap) {
  const Span right{grab.high + gap, frame.high - gap}, left{frame.low + gap, grab.low - gap};
  if (right.high - right.low >= width) return {right.high - width, right.high};
  if (left.high - left.low >= width) return {left.low, left.low + width};
  return right.high - right.low >= left.high - left.low ? right : left;
}

namespace {

bool slider(const char* label, ImGuiDataType type, void* value, const void* lower, const void* upper,
            const char* format, ImGuiSliderFlags flags) {
  const ImGuiID id = ImGui::GetID(label), another = id + 1;
  const auto typed = [&] { return ImGui::TempInputIsActive(id); };
  const float width = ImGui::CalcItemWidth();
  const bool writes = !typed();
  if (writes) ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(0, 0, 0, 0));  // written below, beside the grab
  const bool moved = ImGui::SliderScalar(label, type, value, lower, upper, format, flags);
  if (writes) ImGui::PopStyleColor();
  if (!writes || typed() || !ImGui::IsItemVisible()) return moved;
  const ImGuiStyle& style = ImGui::GetStyle();
  const ImVec2 corner = ImGui::GetItemRectMin();
  const ImRect frame(corner.x, corner.y, corner.x + width, ImGui::GetItemRectMax().y);
  ImRect grab;  // where it was just drawn; asked for by a name that nobody can hold
  ImGui::SliderBehavior(frame, another, type, value, lower, upper, format, flags, &grab);
  char text[64];
  const char *begin = text, *end = text + ImGui::DataTypeFormatString(text, sizeof text, type, value, format);
  if (*begin == '-' && !std::strpbrk(begin, "123456789")) ++begin;  // no "-0.0"
  const ImVec2 size = ImGui::CalcTextSize(begin, end);
  const Span place = placeOfValue({frame.Min.x, frame.Max.x}, {grab.Min.x, grab.Max.x}, size.x,
                                  std::min(style.FramePadding.x, 0.06f * width));
  const float y = corner.y + style.FramePadding.y;
  ImGui::RenderTextClipped({place.low, y}, {place.high, frame.Max.y}, begin, end, &size);
  ImGui::RenderText({frame.Max.x + style.ItemInnerSpacing.x, y}, label);
  return moved;
}

}  // namespace

bool valueSlider(const char* label, float& value, float lower, float upper, const char* format,
                 ImGuiSliderFlags flags) {
  return slider(label, ImGuiDataType_Float, &value, &lower, &upper, format, flags);
}
bool valueSlider(const char* label, double& value, double lower, double upper, const char* format,
                 ImGuiSliderFlags flags) {
  return slider(label, ImGuiDataType_Double, &value, &lower, &upper, format, flags);
}
bool valueSlider(const char* label, int& value, int lower, int upper, const char* format,
                 ImGuiSliderFlags flags) {
  return slider(label, ImGuiDataType_S32, &value, &lower, &upper, format, flags);
}

}  // namespace gelenk
