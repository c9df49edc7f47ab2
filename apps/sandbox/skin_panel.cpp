#include <fmt/format.h>

#include <cmath>

#include "apps/sandbox/builtin_panels.h"
#include "apps/sandbox/sandbox_state.h"
#include "apps/sandbox/skin_comparison.h"
#include "skinning/blend/limb_chains.h"

namespace gelenk {
namespace {

class SkinPanel final : public Panel {
 public:
  std::string name() const override { return "Skin"; }
  bool hasInspector() const override { return true; }

  void drawInspector(Sandbox& sandbox) override {
    Sandbox::State& s = sandbox.state();
    ViewOptions& show = s.show();
    heading(s, "SHOW");
    const auto check = [](const char* label, bool& value, const char* explanation) {
      ImGui::Checkbox(label, &value);
      tooltip(explanation);
    };
    if (ImGui::BeginTable("##show", 2)) {
      const auto cell = [&](const char* label, bool& value, const char* explanation) {
        ImGui::TableNextColumn();
        check(label, value, explanation);
      };
      cell("Skin", show.skin, "The body, posed in the vertex shader by the method below.");
      cell("Skeleton", show.skeleton, "Slim bones seen through the body.");
      cell("Wireframe", show.wireframe, "The triangles' edges over the surface.");
      cell("Joint frames", show.jointFrames, "Axes of every joint's frame: x red, y green, z blue.");
      cell("Handles", show.handles,
           "What can be dragged: circles are positions, squares pins, rings orientations, diamonds poles.");
      cell("Limits", show.limits, "Cones and arcs of joints that press against their limit, in red.");
      cell("Ground", show.ground, "Grid and ground plane.");
      cell("Shadow", show.shadow, "Soft shadow of the key light (percentage closer filtering).");
      ImGui::EndTable();
    }
    if (!s.session->skin()) {
      ImGui::TextColored(s.colours().textDim, "This model has no body: its bones are drawn.");
      return;
    }
    const Skin& skin = *s.session->skin();
    heading(s, "BODY");
    ImGui::TextColored(s.colours().textDim, "%zu vertices · %zu triangles", skin.mesh.positions.size(),
                       skin.mesh.triangles.size());
    heading(s, "SKINNING");
    method(s);
    heading(s, "SIDE BY SIDE");
    drawSkinComparison(sandbox);
    heading(s, "WEIGHTS");
    check(
        "Colour by the selected joint's weight", show.weights,
        "w of each vertex, 0 to 1, in viridis. At most four joints carry a vertex; their weights sum to 1.");
    weights(sandbox, skin);
  }

 private:
  void method(Sandbox::State& s) {
    SkinChoice& choice = s.session->skinChoice();
    if (ImGui::BeginCombo("##method", std::string(skinMethod(choice.method).title).c_str())) {
      for (const SkinMethod* method : skinMethods()) {
        if (method->shader.empty()) continue;  // on the processor only: gelenk skins
        if (ImGui::Selectable(std::string(method->title).c_str(), method->kind == choice.method))
          choice.method = method->kind;
        tooltip(std::string(method->reference).c_str());
      }
      ImGui::EndCombo();
    }
    tooltip(
        "How the motions of a vertex's bones are blended: linearly, as dual quaternions, or about its centre "
        "of rotation.");
    const bool hasLimbs = !limbChains(s.session->skeleton()).empty();
    ImGui::BeginDisabled(!hasLimbs);
    ImGui::Checkbox("Spread twist along limbs", &choice.twist);
    ImGui::EndDisabled();
    tooltip(hasLimbs
                ? "A limb's bones take back their own axial turn where they begin and follow their child's "
                  "where they end."
                : "No arm or leg is known in this model by its joints' names.");
    double millimetres = 1e3 * choice.smoothing;
    if (!editing_) pending_ = millimetres;
    ImGui::SetNextItemWidth(0.55f * ImGui::GetContentRegionAvail().x);
    valueSlider("Weights smoothed", pending_, 0.0, 100.0, "%.0f mm");
    editing_ = ImGui::IsItemActive();
    if (ImGui::IsItemDeactivatedAfterEdit()) choice.smoothing = 1e-3 * std::round(pending_);
    tooltip(
        "Standard deviation of the smoothing along the surface; the radius of limbs that are thinner. Only "
        "with "
        "methods that blend rotations: linear blending's twists get worse.");
    ImGui::TextColored(s.colours().textDim, "%s", toString(choice).c_str());
    if (s.session->model().skinning != choice && ImGui::SmallButton("Back to the model's own"))
      choice = s.session->model().skinning;
  }

  double pending_ = 0.0;  ///< millimetres, while the slider is held
  bool editing_ = false;

  static void weights(Sandbox& sandbox, const Skin& skin) {
    Sandbox::State& s = sandbox.state();
    colourBar(s, "0", "1");
    if (!s.selectedJoint()) {
      ImGui::TextColored(s.colours().textDim, "Click the skin to select a joint.");
      return;
    }
    double sum = 0.0, largest = 0.0;
    int carried = 0;
    for (const Influences& v : skin.influences)
      for (int k = 0; k < 4; ++k)
        if (v.joints[k] == *s.selectedJoint() && v.weights[k] > 0.0) {
          ++carried;
          sum += v.weights[k];
          largest = std::max(largest, v.weights[k]);
        }
    wrappedText(fmt::format("{} carries {} vertices, mean weight {:.2f}, largest {:.2f}",
                            s.session->skeleton().joint(*s.selectedJoint()).name, carried,
                            carried > 0 ? sum / carried : 0.0, largest));
  }
};

}  // namespace

std::unique_ptr<Panel> makeSkinPanel() { return std::make_unique<SkinPanel>(); }

}  // namespace gelenk
