#include "apps/sandbox/skin_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "apps/sandbox/sandbox_state.h"

namespace gelenk {
namespace {

/// What can be ticked: the methods plain, and with all that keeps their shape.
const std::vector<SkinChoice>& offered() {
  static const std::vector<SkinChoice> list = [] {
    std::vector<SkinChoice> choices;
    for (const char* name : {"lbs", "lbs+twist", "dqs", "dqs+twist+smooth", "cor", "cor+twist+smooth"})
      choices.push_back(parseSkinChoice(name));
    return choices;
  }();
  return list;
}

void facts(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  const std::vector<SkinFacts>& all = s.view->skinFacts();
  if (all.empty() || !ImGui::BeginTable("##skins", 4, ImGuiTableFlags_SizingStretchProp)) return;
  for (const char* title : {"skin", "volume", "section", "farthest"}) ImGui::TableSetupColumn(title);
  ImGui::TableHeadersRow();
  for (const SkinFacts& skin : all) {
    const std::string name = toString(skin.choice);
    const std::array<std::string, 4> cells{name, fmt::format("{:+.1f} %", 100.0 * skin.volume),
                                           fmt::format("{:.2f}", skin.section),
                                           fmt::format("{:.1f} mm", 1e3 * skin.farthest)};
    for (const std::string& cell : cells) {
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(cell.c_str());
    }
    sandbox.label(skin.above, name,
                  {s.colours().textDim.x, s.colours().textDim.y, s.colours().textDim.z, 1.0f});
  }
  ImGui::EndTable();
  tooltip(
      "Change of the body's volume since rest; smallest section across a limb's bone, of rest's; largest "
      "distance "
      "of a vertex from the body's own skin. The colours: distance, up to 20 mm.");
}

}  // namespace

void drawSkinComparison(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  std::vector<SkinChoice>& beside = s.session->lab().skins;
  for (const SkinChoice& choice : offered()) {
    const auto found = std::find(beside.begin(), beside.end(), choice);
    bool shown = found != beside.end();
    ImGui::BeginDisabled(!shown && beside.size() >= LabSettings::mostSkins);
    if (ImGui::Checkbox(toString(choice).c_str(), &shown)) {
      if (shown)
        beside.push_back(choice);
      else
        beside.erase(found);
    }
    ImGui::EndDisabled();
  }
  facts(sandbox);
}

}  // namespace gelenk
