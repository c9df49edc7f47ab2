#include "apps/render/ui_style.h"

#ifndef __EMSCRIPTEN__
#include <imgui_freetype.h>
#endif

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace gelenk {
namespace {

ImVec4 rgb(unsigned hex, float alpha = 1.0f) {
  return {((hex >> 16) & 255) / 255.0f, ((hex >> 8) & 255) / 255.0f, (hex & 255) / 255.0f, alpha};
}

ImVec4 mix(const ImVec4& a, const ImVec4& b, float t) {
  return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z + t * (b.z - a.z), a.w + t * (b.w - a.w)};
}

Palette lightPalette() {
  const MarkColours& marks = markColours(Theme::Light);
  return {.panel = rgb(0xf7f6f3),
          .panelRaised = rgb(0xffffff),
          .panelSunken = rgb(0xeae8e3),
          .border = rgb(0xd9d6cf),
          .text = rgb(0x23262b),
          .textDim = toImVec4(marks.dim),
          .textFaint = rgb(0x9a9da3),
          .accent = toImVec4(marks.accent),
          .accentText = rgb(0xffffff),
          .held = toImVec4(marks.held),
          .pinned = toImVec4(marks.pinned),
          .pole = toImVec4(marks.pole),
          .free = toImVec4(marks.free),
          .good = toImVec4(marks.good),
          .warning = toImVec4(marks.warning),
          .bad = toImVec4(marks.bad),
          .plotBackground = rgb(0xffffff),
          .plotGrid = rgb(0xe6e3dd)};
}

Palette darkPalette() {
  const MarkColours& marks = markColours(Theme::Dark);
  return {.panel = rgb(0x1d2024),
          .panelRaised = rgb(0x272b31),
          .panelSunken = rgb(0x16181b),
          .border = rgb(0x343941),
          .text = rgb(0xe6e7ea),
          .textDim = toImVec4(marks.dim),
          .textFaint = rgb(0x6d737c),
          .accent = toImVec4(marks.accent),
          .accentText = rgb(0x0e1114),
          .held = toImVec4(marks.held),
          .pinned = toImVec4(marks.pinned),
          .pole = toImVec4(marks.pole),
          .free = toImVec4(marks.free),
          .good = toImVec4(marks.good),
          .warning = toImVec4(marks.warning),
          .bad = toImVec4(marks.bad),
          .plotBackground = rgb(0x16181b),
          .plotGrid = rgb(0x2b3037)};
}

void setColours(const Palette& p, Theme theme) {
  ImVec4* c = ImGui::GetStyle().Colors;
  const ImVec4 none(0, 0, 0, 0);
  const ImVec4 hover = mix(p.panelSunken, p.accent, theme == Theme::Light ? 0.14f : 0.25f);
  c[ImGuiCol_Text] = p.text;
  c[ImGuiCol_TextDisabled] = p.textFaint;
  c[ImGuiCol_WindowBg] = p.panel;
  c[ImGuiCol_ChildBg] = none;
  c[ImGuiCol_PopupBg] = p.panelRaised;
  c[ImGuiCol_Border] = p.border;
  c[ImGuiCol_BorderShadow] = none;
  // In the dark an empty box or circle must stand out from the panel.
  c[ImGuiCol_FrameBg] = theme == Theme::Light ? p.panelSunken : mix(p.panel, p.border, 0.7f);
  c[ImGuiCol_FrameBgHovered] = hover;
  c[ImGuiCol_FrameBgActive] = mix(p.panelSunken, p.accent, 0.3f);
  c[ImGuiCol_TitleBg] = c[ImGuiCol_TitleBgActive] = c[ImGuiCol_TitleBgCollapsed] = p.panelSunken;
  c[ImGuiCol_MenuBarBg] = p.panel;
  c[ImGuiCol_ScrollbarBg] = none;
  c[ImGuiCol_ScrollbarGrab] = p.border;
  c[ImGuiCol_ScrollbarGrabHovered] = p.textFaint;
  c[ImGuiCol_ScrollbarGrabActive] = p.textDim;
  c[ImGuiCol_CheckMark] = p.accent;
  c[ImGuiCol_SliderGrab] = mix(p.panelSunken, p.accent, 0.85f);
  c[ImGuiCol_SliderGrabActive] = p.accent;
  c[ImGuiCol_Button] = p.panelSunken;
  c[ImGuiCol_ButtonHovered] = hover;
  c[ImGuiCol_ButtonActive] = mix(p.panelSunken, p.accent, 0.4f);
  c[ImGuiCol_Header] = mix(p.panel, p.accent, 0.16f);
  c[ImGuiCol_HeaderHovered] = mix(p.panel, p.accent, 0.12f);
  c[ImGuiCol_HeaderActive] = mix(p.panel, p.accent, 0.25f);
  c[ImGuiCol_Separator] = p.border;
  c[ImGuiCol_SeparatorHovered] = c[ImGuiCol_SeparatorActive] = p.accent;
  c[ImGuiCol_ResizeGrip] = c[ImGuiCol_ResizeGripHovered] = c[ImGuiCol_ResizeGripActive] = none;
  c[ImGuiCol_Tab] = none;
  c[ImGuiCol_TabHovered] = hover;
  c[ImGuiCol_TabActive] = c[ImGuiCol_TabUnfocusedActive] = mix(p.panel, p.accent, 0.18f);
  c[ImGuiCol_TabUnfocused] = none;
  c[ImGuiCol_TableHeaderBg] = p.panelSunken;
  c[ImGuiCol_TableBorderStrong] = c[ImGuiCol_TableBorderLight] = p.border;
  c[ImGuiCol_TableRowBg] = none;
  c[ImGuiCol_TableRowBgAlt] = ImVec4(p.text.x, p.text.y, p.text.z, 0.03f);
  c[ImGuiCol_TextSelectedBg] = ImVec4(p.accent.x, p.accent.y, p.accent.z, 0.35f);
  c[ImGuiCol_NavHighlight] = p.accent;
  c[ImGuiCol_ModalWindowDimBg] = ImVec4(0, 0, 0, 0.3f);
}

}  // namespace

const Palette& palette(Theme theme) {
  static const Palette light = lightPalette(), dark = darkPalette();
  return theme == Theme::Light ? light : dark;
}

void applyStyle(Theme theme, float scale) {
  ImGuiStyle style;
  style.WindowPadding = {14, 12};
  style.FramePadding = {8, 4};
  style.CellPadding = {6, 3};
  style.ItemSpacing = {8, 7};
  style.ItemInnerSpacing = {7, 5};
  style.IndentSpacing = 14;
  style.ScrollbarSize = 10;
  style.GrabMinSize = 9;
  style.WindowBorderSize = 0;
  style.ChildBorderSize = 0;
  style.PopupBorderSize = 1;
  style.FrameBorderSize = 0;
  style.TabBorderSize = 0;
  style.WindowRounding = 0;
  style.ChildRounding = 6;
  style.FrameRounding = 5;
  style.PopupRounding = 7;
  style.ScrollbarRounding = 5;
  style.GrabRounding = 4;
  style.TabRounding = 5;
  style.DisabledAlpha = 0.45f;
  style.ScaleAllSizes(scale);
  ImGui::GetStyle() = style;
  setColours(palette(theme), theme);
}

Fonts loadFonts(float scale) {
  ImGuiIO& io = ImGui::GetIO();
  io.Fonts->Clear();
#ifndef __EMSCRIPTEN__  // there by Dear ImGui's own
  io.Fonts->FontBuilderIO = ImGuiFreeType::GetBuilderForFreeType();
  io.Fonts->FontBuilderFlags = ImGuiFreeTypeBuilderFlags_LightHinting;
#endif
  static const ImWchar ranges[] = {0x20,   0xff,   0x370,  0x3ff,  0x2010, 0x2044, 0x2070,
                                   0x209f, 0x2190, 0x2193, 0x2200, 0x22ff, 0};
  const std::string folder = "/usr/share/fonts/truetype/roboto/unhinted/RobotoTTF/";
  const auto load = [&](const char* file, float size) -> ImFont* {
    const std::string path = folder + file;
    if (std::filesystem::exists(path))
      if (ImFont* font =
              io.Fonts->AddFontFromFileTTF(path.c_str(), std::round(size * scale), nullptr, ranges))
        return font;
    ImFontConfig config;
    config.SizePixels = std::round(size * scale);
    return io.Fonts->AddFontDefault(&config);
  };
  Fonts fonts;
  fonts.regular = load("Roboto-Regular.ttf", 15.0f);
  fonts.medium = load("Roboto-Medium.ttf", 15.0f);
  fonts.small = load("Roboto-Regular.ttf", 13.0f);
  fonts.large = load("Roboto-Medium.ttf", 20.0f);
  fonts.script = load("Roboto-Regular.ttf", 11.0f);
  fonts.title = load("Roboto-Medium.ttf", 30.0f);
  return fonts;
}

}  // namespace gelenk
