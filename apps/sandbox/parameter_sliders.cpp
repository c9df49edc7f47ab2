#include "apps/sandbox/parameter_sliders.h"

#include <fmt/format.h>
#include <imgui.h>

#include <cmath>

#include "apps/sandbox/sandbox_state.h"

namespace gelenk {
namespace {

/// A range of several powers of ten, or one that begins at 0 far below its end, is looked at by its
/// logarithm.
bool isLogarithmic(const Parameter& p) {
  return !p.whole && p.lower >= 0.0 && p.upper > 100.0 * std::max(p.lower, p.value);
}

bool slider(const Parameter& p, double& value) {
  const std::string label = "##" + std::string(p.name);
  ImGui::SetNextItemWidth(-1.0f);
  if (p.whole) {
    int number = static_cast<int>(value);
    const bool moved =
        valueSlider(label.c_str(), number, static_cast<int>(p.lower), static_cast<int>(p.upper), "%d",
                    ImGuiSliderFlags_AlwaysClamp | (p.upper > 100.0 ? ImGuiSliderFlags_Logarithmic : 0));
    if (moved) value = number;
    return moved;
  }
  const int flags = ImGuiSliderFlags_AlwaysClamp | (isLogarithmic(p) ? ImGuiSliderFlags_Logarithmic : 0);
  return valueSlider(label.c_str(), value, p.lower, p.upper, "%.4g", flags);
}

}  // namespace

bool parameterSliders(std::string_view id, std::span<const Parameter> parameters, ParameterValues& values) {
  if (parameters.empty()) return false;
  bool changed = false;
  ImGui::PushID(id.data(), id.data() + id.size());
  if (ImGui::BeginTable("##parameters", 2, ImGuiTableFlags_SizingStretchProp)) {
    for (const Parameter& p : parameters) {
      const std::string name(p.name);
      const auto set = values.find(name);
      double value = set == values.end() ? p.value : set->second;
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::AlignTextToFramePadding();
      if (set == values.end())
        ImGui::TextDisabled("%s", name.c_str());
      else
        ImGui::TextUnformatted(name.c_str());
      const std::string unit = p.unit == "1" ? "" : " " + std::string(p.unit);
      const auto explain = [&] {
        tooltip(fmt::format("{}\nDefault {:g}{} ({}); {:g} to {:g}. Right button: back to the default.",
                            p.meaning, p.value, unit, p.source, p.lower, p.upper)
                    .c_str());
      };
      explain();
      ImGui::TableNextColumn();
      bool moved = slider(p, value);
      explain();
      if (ImGui::IsItemClicked(ImGuiMouseButton_Right)) {
        value = p.value;
        moved = true;
      }
      if (!moved) continue;
      changed = true;
      if (value == p.value)
        values.erase(name);
      else
        values[name] = value;
    }
    ImGui::EndTable();
  }
  ImGui::BeginDisabled(values.empty());
  if (ImGui::SmallButton("Reset parameters")) {
    values.clear();
    changed = true;
  }
  ImGui::EndDisabled();
  tooltip("All of them as the method comes. A right click on one does the same for it alone.");
  ImGui::PopID();
  return changed;
}

}  // namespace gelenk
