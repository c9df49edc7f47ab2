#include "apps/sandbox/skin_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/sandbox/sandbox_state.h"

namespace gelenk {
namespace {

/// What can be ticked: the methods plain, with all that keeps their shape, and under muscle layers.
const std::vector<SkinChoice>& offered() {
  static const std::vector<SkinChoice> list = [] {
    std::vector<SkinChoice> choices;
    for (const char* name :
         {"lbs", "lbs+twist", "dqs", "dqs+twist+smooth", "cor", "cor+twist+smooth", "lbs+layers",
          "lbs+layers=muscle", "cor+twist+smooth+layers", "cor+twist+smooth+layers=muscle"})
      choices.push_back(parseSkinChoice(name));
    return choices;
  }();
  return list;
}

const char* explanation(SkinLayers layers) {
  switch (layers) {
    case SkinLayers::None: return "The method alone.";
    case SkinLayers::Volumes: return "The method under free-form deformation volumes round arms and legs.";
    case SkinLayers::Muscles: return "The same volumes with their muscles, as the Muscles tab has set them.";
  }
  return "";
}

void facts(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  const float width = ImGui::GetContentRegionAvail().x;
  ImGui::BeginGroup();
  for (const SkinFacts& skin : s.view->skinFacts()) {
    const std::string name = toString(skin.choice);
    ImGui::TextColored(s.colours().textDim, "%s", name.c_str());
    const double percent = std::round(1000.0 * skin.volume) / 10.0 + 0.0;  // no -0.0
    ImGui::TextUnformatted(fmt::format("volume {:+.1f} %", percent).c_str());
    ImGui::SameLine(0.38f * width);
    ImGui::TextUnformatted(fmt::format("section {:.2f}", skin.section).c_str());
    ImGui::SameLine(0.7f * width);
    ImGui::TextUnformatted(fmt::format("{:.1f} mm off", 1e3 * skin.farthest).c_str());
  }
  ImGui::EndGroup();
  tooltip(
      "Of the body, or of the limb that is shown alone: change of volume since rest; smallest section across "
      "a limb's bone, of rest's; largest distance of a vertex from the body's own skin. The colours: "
      "distance, up to 20 mm.");
}

}  // namespace

void drawSkinComparison(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  std::vector<SkinChoice>& beside = s.session->lab().skins;
  const bool hasLimbs = s.session->edits().muscles != nullptr;
  std::string names;
  for (const SkinChoice& choice : beside) names += (names.empty() ? "" : ", ") + toString(choice);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::BeginCombo("##beside", names.empty() ? "Up to three other skins" : names.c_str(),
                        ImGuiComboFlags_HeightLargest)) {
    for (const SkinChoice& choice : offered()) {
      if (choice.layers != SkinLayers::None && !hasLimbs) continue;
      const auto found = std::find(beside.begin(), beside.end(), choice);
      bool shown = found != beside.end();
      if (!shown && choice == s.view->drawnSkin(*s.session)) continue;  // stands there already
      ImGui::BeginDisabled(!shown && beside.size() >= LabSettings::mostSkins);
      if (ImGui::Checkbox(toString(choice).c_str(), &shown)) {
        if (shown)
          beside.push_back(choice);
        else
          beside.erase(found);
      }
      ImGui::EndDisabled();
      tooltip(explanation(choice.layers));
    }
    ImGui::EndCombo();
  }
  tooltip("Drawn beside the body in its pose, coloured by the distance from the body's own skin.");
  if (beside.empty()) return;
  colourBar(s, "0", "20 mm");
  facts(sandbox);
}

}  // namespace gelenk
