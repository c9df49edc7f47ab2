// One slider for every panel: what it writes is never under its grab.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>

#include "apps/sandbox/sandbox_state.h"
#include "kinematics/io/text_file.h"
#include "skinning/mesh_look.h"
#include "tests/places.h"
#include "tests/sandbox/stage.h"

namespace gelenk {
namespace {

namespace fs = std::filesystem;

struct Stage : testing::Stage {
  Stage() : testing::Stage({.model = "planar", .width = 640, .height = 480}) { play("", 1); }
  /// What is drawn within a window of its own, so wide, in a frame of its own.
  template <typename Draw>
  void draw(float width, Draw draw) {
    ImGui::NewFrame();
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({width + 200, 200});
    ImGui::Begin("slider alone", nullptr, ImGuiWindowFlags_NoTitleBar);
    ImGui::SetWindowFocus();
    ImGui::SetNextItemWidth(width);
    draw();
    ImGui::End();
    ImGui::EndFrame();
  }
};

/// From where to where the present window drew in a colour of the style, left of x.
Span drawnIn(ImGuiCol colour, float below, float from = 0.0f) {
  Span span{std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};
  const ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImU32 wanted = ImGui::GetColorU32(colour);
  for (int i = 0; i + 3 < list.VtxBuffer.Size; ++i) {
    const ImDrawVert& v = list.VtxBuffer[i];
    if (v.col != wanted || v.pos.x > below || v.pos.x < from) continue;
    span.low = std::min(span.low, v.pos.x);
    span.high = std::max(span.high, v.pos.x);
  }
  return span;
}

TEST(Sliders, AValueHasRoomBesideTheGrabWhereverThatIs) {
  constexpr Span frame{100, 280};
  constexpr float gap = 8, grabWidth = 9, longest = (180 - 9) / 2.0f - 2 * gap;
  for (float grab = frame.low; grab <= frame.high - grabWidth; grab += 0.5f)
    for (float width = 5; width < 120; width += 5) {
      const Span place = placeOfValue(frame, {grab, grab + grabWidth}, width, gap);
      EXPECT_GE(place.low, frame.low + gap);
      EXPECT_LE(place.high, frame.high - gap);
      EXPECT_TRUE(place.high <= grab - gap || place.low >= grab + grabWidth + gap) << grab << " " << width;
      EXPECT_NEAR(place.high - place.low, width <= longest ? width : place.high - place.low, 1e-3)
          << grab << " " << width;
    }
}

/// Of every kind, from one end to the other: what is drawn of the text and what is drawn of the grab.
TEST(Sliders, NoValueIsDrawnUnderItsGrab) {
  Stage stage;
  struct Kind {
    const char* name;
    std::function<void(double)> slide;  // 0 at the lower end, 1 at the upper
  };
  const Kind kinds[] = {{"float",
                         [](double t) {
                           auto value = static_cast<float>(-2.0 + 6.0 * t);
                           valueSlider("Speed", value, -2.0f, 4.0f, "%.2f x");
                         }},
                        {"int",
                         [](double t) {
                           int value = static_cast<int>(240 * t);
                           valueSlider("Speed", value, 0, 240, "pose %d");
                         }},
                        {"double",
                         [](double t) {
                           double value = 100.0 * t;
                           valueSlider("Speed", value, 0.0, 100.0, "%.0f mm");
                         }},
                        {"logarithmic", [](double t) {
                           double value = 1e-6 * std::pow(1e7, t);
                           valueSlider("Speed", value, 1e-6, 10.0, "%.4g",
                                       ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
                         }}};
  for (const Kind& kind : kinds)
    for (const float width : {130.0f, 174.0f, 260.0f})
      for (int i = 0; i <= 60; ++i)
        stage.draw(width, [&] {
          kind.slide(i / 60.0);
          const float end = ImGui::GetItemRectMin().x + width;
          const Span grab = drawnIn(ImGuiCol_SliderGrab, end), text = drawnIn(ImGuiCol_Text, end),
                     label = drawnIn(ImGuiCol_Text, 1e6f, end);
          ASSERT_GT(grab.high, grab.low) << kind.name;
          ASSERT_GT(text.high, text.low + 5) << kind.name;
          EXPECT_TRUE(text.high <= grab.low || text.low >= grab.high)
              << kind.name << ", " << width << " wide, at " << i << "/60: text from " << text.low << " to "
              << text.high << ", grab from " << grab.low << " to " << grab.high;
          EXPECT_GT(label.high, label.low + 20) << kind.name;  // "Speed"
        });
}

/// What is cleared instead of filled looks the same, byte for byte.
TEST(FillRounded, LooksAsDearImGuisRectangle) {
  Stage stage;
  Gui& gui = stage.sandbox.state().gui;
  int cleared = 0;
  const auto picture = [&](const std::function<void(ImDrawList&)>& draw) {
    glBindFramebuffer(GL_FRAMEBUFFER, stage.target.framebuffer());
    glClearColor(0.2f, 0.3f, 0.4f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    gui.beginFrame({.width = stage.width, .height = stage.height}, 1.0 / 60.0);
    ImDrawList& list = *ImGui::GetForegroundDrawList();
    list.PushClipRect({20, 20}, {600, 400});
    draw(list);
    list.PopClipRect();
    gui.endFrame();
    cleared = static_cast<int>(std::count_if(list.CmdBuffer.begin(), list.CmdBuffer.end(),
                                             [](const ImDrawCmd& c) { return c.UserCallback; }));
    return readPixels(stage.target.framebuffer(), stage.width, stage.height);
  };
  struct Rectangle {
    ImVec2 low, high;
    ImU32 colour;
    float rounding;
    int cleared;
  };
  for (const Rectangle& r : {Rectangle{{40, 50}, {340, 185}, 0xffe0f0ff, 6.0f, 1},
                             Rectangle{{10, 50}, {340, 450}, 0xff304050, 7.5f, 1},
                             Rectangle{{40, 50}, {340, 185}, 0x80e0f0ff, 6.0f, 0},
                             Rectangle{{40.5f, 50}, {340, 185}, 0xffe0f0ff, 6.0f, 0},
                             Rectangle{{40, 50}, {340, 60}, 0xffe0f0ff, 6.0f, 0}}) {
    const auto expected =
        picture([&](ImDrawList& list) { list.AddRectFilled(r.low, r.high, r.colour, r.rounding); });
    EXPECT_EQ(cleared, 0);
    EXPECT_TRUE(picture([&](ImDrawList& list) { fillRounded(list, r.low, r.high, r.colour, r.rounding); }) ==
                expected)
        << r.low.x << " " << r.low.y;
    EXPECT_EQ(cleared, r.cleared) << r.low.x << " " << r.low.y;
  }
}

TEST(Sliders, CtrlAndAClickLetAValueBeTyped) {
  Stage stage;
  float value = 1.0f;
  bool typing = false;
  ImGuiIO& io = ImGui::GetIO();
  const auto frame = [&] {
    stage.draw(200, [&] {
      valueSlider("Speed", value, -2.0f, 4.0f, "%.2f x");
      typing = ImGui::IsItemActive() && io.WantTextInput;
    });
  };
  io.MousePos = {60, 24};
  frame(), frame();
  io.KeyCtrl = true, io.KeyMods = ImGuiKeyModFlags_Ctrl;
  io.MouseDown[0] = true;
  frame();
  io.MouseDown[0] = false, io.KeyCtrl = false, io.KeyMods = 0;
  frame(), frame();
  EXPECT_TRUE(typing);
  for (const char c : std::string("3.25")) io.AddInputCharacter(static_cast<unsigned>(c));
  frame(), frame();
  const int enter = io.KeyMap[ImGuiKey_Enter];
  io.KeysDown[enter] = true;
  frame();
  io.KeysDown[enter] = false;
  frame();
  EXPECT_FLOAT_EQ(value, 3.25f);
}

TEST(Sliders, NothingIsMinusZero) {
  Stage stage;
  const auto glyphs = [&](float value) {
    int count = 0;
    stage.draw(200, [&] {
      valueSlider("##a", value, -90.0f, 90.0f, "%.1f°");
      for (const ImDrawVert& v : ImGui::GetWindowDrawList()->VtxBuffer)
        count += v.col == ImGui::GetColorU32(ImGuiCol_Text);
    });
    return count / 4;
  };
  EXPECT_EQ(glyphs(0.0f), 4);    // 0.0°
  EXPECT_EQ(glyphs(-1e-7f), 4);  // likewise
  EXPECT_EQ(glyphs(-0.1f), 5);   // -0.1°
}

/// What a panel draws by ImGui::Slider... itself would lie under its grab again.
TEST(Sliders, EveryPanelUsesTheOneThatKeepsItsValueInSight) {
  int calls = 0;
  for (const auto& file :
       fs::recursive_directory_iterator(fs::path(testing::assetFolder()).parent_path() / "apps")) {
    if (file.path().extension() != ".cpp" && file.path().extension() != ".h") continue;
    const std::string text = readFile(file.path().string());
    for (std::size_t at = text.find("valueSlider("); at != std::string::npos;
         at = text.find("valueSlider(", at + 1))
      ++calls;
    if (file.path().filename() == "gui.cpp") continue;
    for (const char* direct : {"ImGui::Slider", "ImGui::VSlider"})
      EXPECT_EQ(text.find(direct), std::string::npos) << file.path() << " calls " << direct;
  }
  EXPECT_GT(calls, 15);
}

/// 4.5 to 1 is what WCAG 2 asks of text, 3 to 1 of what is no text.
TEST(Sliders, ValuesAndGrabsStandOutFromTheirFrameInBothThemes) {
  Stage stage;
  const auto luminance = [](const ImVec4& c) {
    return 0.2126f * linearFromSrgb(c.x) + 0.7152f * linearFromSrgb(c.y) + 0.0722f * linearFromSrgb(c.z);
  };
  for (const char* theme : {"light", "dark"}) {
    stage.play(std::string("0 theme ") + theme + "\n", 1);
    const ImVec4* colours = ImGui::GetStyle().Colors;
    const auto contrast = [&](int before, int behind) {
      const float a = luminance(colours[before]) + 0.05f, b = luminance(colours[behind]) + 0.05f;
      return std::max(a, b) / std::min(a, b);
    };
    for (const int frame : {ImGuiCol_FrameBg, ImGuiCol_FrameBgHovered, ImGuiCol_FrameBgActive})
      EXPECT_GT(contrast(ImGuiCol_Text, frame), 4.5f) << theme << " " << frame;
    EXPECT_GT(contrast(ImGuiCol_SliderGrab, ImGuiCol_FrameBg), 3.0f) << theme;
    EXPECT_GT(contrast(ImGuiCol_SliderGrab, ImGuiCol_FrameBgHovered), 3.0f) << theme;
    EXPECT_GT(contrast(ImGuiCol_SliderGrabActive, ImGuiCol_FrameBgActive), 3.0f) << theme;
  }
}

}  // namespace
}  // namespace gelenk
