#include <fmt/format.h>

#include <cmath>

#include "apps/sandbox/builtin_panels.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/configuration.h"
#include "kinematics/rotation.h"
#include "kinematics/symmetry.h"

namespace gelenk {
namespace {

constexpr double degrees = 180.0 / M_PI;

class ModelPanel final : public Panel {
 public:
  std::string name() const override { return "Model"; }
  bool hasInspector() const override { return true; }

  void opened(Sandbox& sandbox, bool) override {
    whyNotMirrored_ = whyNotMirrored(sandbox.session().skeleton());
  }

  void drawInspector(Sandbox& sandbox) override {
    Sandbox::State& s = sandbox.state();
    const Skeleton& skeleton = s.session->skeleton();
    ImGui::PushFont(s.gui.fonts().medium);
    ImGui::TextUnformatted(s.session->model().name.c_str());
    ImGui::PopFont();
    ImGui::TextColored(s.colours().textDim, "%d joints · %d degrees of freedom", skeleton.jointCount(),
                       skeleton.nv());
    const float half = 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
    if (ImGui::Button("Rest pose", {half, 0})) s.session->resetPose();
    tooltip("The bind pose (R). Handles pinned at the beginning are pinned again.");
    ImGui::SameLine();
    ImGui::BeginDisabled(!whyNotMirrored_.empty());
    if (ImGui::Button("Mirror", {half, 0})) mirrorPose(sandbox);
    ImGui::EndDisabled();
    tooltip(("Left and right change places (M): reflection in the plane x = 0." +
             (whyNotMirrored_.empty() ? "" : "\n\nNot this model: " + whyNotMirrored_))
                .c_str());
    if (ImGui::Button("Within limits, at random", {-1, 0})) {
      s.session->remember();
      Eigen::VectorXd q = randomWithinLimits(skeleton, random_);
      if (skeleton.joint(0).ball && skeleton.qCount(0) == 7)
        q.head(7) = s.session->q().head(7);  // a free root stays
      s.session->setPose(q);
    }
    tooltip(
        "Every joint uniform within its limits; a free root stays where it is. Seed 1 at the start of the "
        "program.");
    parts(s);
    notes(s);
    ImGui::Separator();
    const float sliders = s.selectedJoint() ? slidersHeight(s) : 0.0f;
    ImGui::BeginChild("tree", {0, std::max(120 * s.scale, ImGui::GetContentRegionAvail().y - sliders)});
    ImGui::PushStyleVar(ImGuiStyleVar_IndentSpacing,
                        8 * sandbox.scale());  // fingers stand twelve levels deep
    tree(sandbox, 0);
    ImGui::PopStyleVar();
    ImGui::EndChild();
    if (s.selectedJoint()) joint(sandbox, *s.selectedJoint());
  }

 private:
  /// What the body is made of, to be hidden.
  static void parts(Sandbox::State& s) {
    const auto& look = s.session->model().look;
    if (!look) return;
    std::set<std::string> names;
    for (const MeshLook::Part& part : look->parts) names.insert(part.name);
    if (names.size() < 2 ||
        !ImGui::CollapsingHeader(fmt::format("{} parts of the body###parts", names.size()).c_str()))
      return;
    std::set<std::string>& hidden = s.session->view().hidden;
    for (const std::string& name : names) {
      bool shown = hidden.count(name) == 0;
      if (!ImGui::Checkbox(name.empty() ? "(unnamed)" : name.c_str(), &shown)) continue;
      if (shown)
        hidden.erase(name);
      else
        hidden.insert(name);
    }
  }

  /// What its reader had to say of the file.
  static void notes(const Sandbox::State& s) {
    const std::vector<Note>& notes = s.session->model().notes;
    if (notes.empty() ||
        !ImGui::CollapsingHeader(notes.size() == 1
                                     ? "A note on the file###notes"
                                     : fmt::format("{} notes on the file###notes", notes.size()).c_str()))
      return;
    for (const Note& note : notes) wrappedText(note.lineWithoutRemedy());
  }

  static float slidersHeight(const Sandbox::State& s) {
    const Skeleton& skeleton = s.session->skeleton();
    const int i = *s.selectedJoint(), rows = skeleton.joint(i).coupling ? 2 : skeleton.vCount(i);
    const float row =
        ImGui::GetFrameHeightWithSpacing() + s.gui.fonts().small->FontSize + ImGui::GetStyle().ItemSpacing.y;
    return static_cast<float>(std::max(rows, 1)) * row + ImGui::GetTextLineHeightWithSpacing() + 22 * s.scale;
  }

  void tree(Sandbox& sandbox, int joint) {
    Sandbox::State& s = sandbox.state();
    const Skeleton& skeleton = s.session->skeleton();
    const auto& children = skeleton.children(joint);
    ImGuiTreeNodeFlags flags = ImGuiTreeNodeFlags_OpenOnArrow | ImGuiTreeNodeFlags_SpanAvailWidth;
    if (children.empty()) flags |= ImGuiTreeNodeFlags_Leaf;
    if (s.selectedJoint() == joint) flags |= ImGuiTreeNodeFlags_Selected;
    if (children.size() < 3 || joint == 0 || depthBelow(skeleton, joint) > 3)
      flags |= ImGuiTreeNodeFlags_DefaultOpen;
    if (s.selectedJoint() && *s.selectedJoint() != lastSelected_ &&
        skeleton.isAncestor(joint, *s.selectedJoint()) && *s.selectedJoint() != joint)
      ImGui::SetNextItemOpen(true);
    const bool atLimit = s.limitGlow[joint] > 0.3;
    if (atLimit) ImGui::PushStyleColor(ImGuiCol_Text, s.colours().bad);
    const bool open = ImGui::TreeNodeEx(skeleton.joint(joint).name.c_str(), flags);
    if (atLimit) ImGui::PopStyleColor();
    if (s.selectedJoint() == joint && lastSelected_ != joint) {
      ImGui::SetScrollHereY(0.4f);
      lastSelected_ = joint;
    }
    if (ImGui::IsItemClicked() && !ImGui::IsItemToggledOpen()) s.session->selectJoint(lastSelected_ = joint);
    tooltip(describe(skeleton, joint).c_str());
    if (!open) return;
    for (const int child : children) tree(sandbox, child);
    ImGui::TreePop();
  }

  static int depthBelow(const Skeleton& skeleton, int joint) {
    int deepest = 0;
    for (const int child : skeleton.children(joint))
      deepest = std::max(deepest, 1 + depthBelow(skeleton, child));
    return deepest;
  }

  static std::string describe(const Skeleton& skeleton, int i) {
    const Joint& joint = skeleton.joint(i);
    std::string motion;
    if (!joint.axes.empty())
      motion += fmt::format("{} {}", joint.axes.size(), joint.axes.size() == 1 ? "axis" : "axes");
    if (joint.ball)
      motion += (motion.empty() ? "" : ", then ") +
                std::string(joint.ballLimit ? "ball with swing and twist limits" : "free ball");
    return joint.name + ": " + (motion.empty() ? "fixed" : motion);
  }

  static bool slider(Sandbox& sandbox, const char* id, const std::string& label, double& value, double lower,
                     double upper, bool angle) {
    Sandbox::State& s = sandbox.state();
    const double unit = angle ? degrees : 1.0;
    const bool bounded = std::isfinite(lower) && std::isfinite(upper);
    const double low = bounded ? lower
                       : angle ? -M_PI
                               : value - 1.0,
                 high = bounded ? upper
                        : angle ? M_PI
                                : value + 1.0;
    const bool atLimit = bounded && upper - lower > 1e-9 &&
                         (value < lower + Session::limitMargin || value > upper - Session::limitMargin);
    ImGui::PushFont(s.gui.fonts().small);
    ImGui::TextColored(atLimit ? s.colours().bad : s.colours().textDim, "%s", label.c_str());
    if (bounded) {
      const std::string range = angle ? fmt::format("{:.0f}° to {:.0f}°", lower * unit, upper * unit)
                                      : fmt::format("{:.2f} to {:.2f} m", lower, upper);
      ImGui::SameLine(ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(range.c_str()).x +
                      ImGui::GetCursorPosX() - ImGui::GetCursorStartPos().x);
      ImGui::TextColored(s.colours().textFaint, "%s", range.c_str());
    }
    ImGui::PopFont();
    float shown = static_cast<float>(value * unit);
    ImGui::SetNextItemWidth(-1);
    const bool changed = valueSlider(id, shown, static_cast<float>(low * unit),
                                     static_cast<float>(high * unit), angle ? "%.1f°" : "%.3f m");
    tooltip(angle ? "Angle in degrees; inside the program radians. Ctrl+click to type."
                  : "Displacement in metres. Ctrl+click to type.");
    if (ImGui::IsItemActivated()) s.session->remember();
    if (changed) value = shown / unit;
    return changed;
  }

  static void joint(Sandbox& sandbox, int i) {
    Sandbox::State& s = sandbox.state();
    const Skeleton& skeleton = s.session->skeleton();
    const Joint& joint = skeleton.joint(i);
    ImGui::Separator();
    ImGui::PushFont(s.gui.fonts().medium);
    ImGui::TextUnformatted(joint.name.c_str());
    ImGui::PopFont();
    Eigen::VectorXd q = s.session->q();
    bool changed = false;
    for (std::size_t k = 0; k < joint.axes.size(); ++k) {
      const AxisDof& axis = joint.axes[k];
      const bool angle = axis.kind == AxisDof::Kind::Rotation;
      const std::string label = fmt::format("{} ({:.2g}, {:.2g}, {:.2g})", angle ? "turn about" : "along",
                                            axis.axis.x(), axis.axis.y(), axis.axis.z());
      const std::string id = fmt::format("##axis{}", k);
      if (!joint.coupling) {
        changed |= slider(sandbox, id.c_str(), label, q[skeleton.qIndex(i) + static_cast<int>(k)], axis.lower,
                          axis.upper, angle);
        continue;
      }
      double value = q[skeleton.qIndex(i)];
      const auto [lower, upper] = rangeOf(skeleton, i);
      if (slider(sandbox, id.c_str(), label, value, lower, upper, angle)) {
        setJointValue(skeleton, q, i, value);
        changed = true;
      }
      ImGui::TextColored(s.colours().textDim, "moves with %s",
                         skeleton.joint(joint.coupling->source).name.c_str());
    }
    if (joint.ball) changed |= ball(sandbox, i, q);
    if (joint.axes.empty() && !joint.ball)
      ImGui::TextColored(s.colours().textDim, "A fixed frame: nothing to move.");
    if (changed) s.session->setPose(q);
  }

  /// What a follower's source allows it.
  static std::pair<double, double> rangeOf(const Skeleton& skeleton, int follower) {
    const Coupling& c = *skeleton.joint(follower).coupling;
    const AxisDof& source = skeleton.joint(c.source).axes[0];
    return std::minmax({c.multiplier * source.lower + c.offset, c.multiplier * source.upper + c.offset});
  }

  /// Swing x, swing y and twist of a ball joint, as angles 2 asin(c / 2).
  static bool ball(Sandbox& sandbox, int i, Eigen::VectorXd& q) {
    const Skeleton& skeleton = sandbox.session().skeleton();
    const std::optional<BallLimit>& limit = skeleton.joint(i).ballLimit;
    Eigen::Vector3d c = swingTwistCoordinates(ballRotation(skeleton, q, i));
    const auto toAngle = [](double x) { return 2.0 * std::asin(std::clamp(0.5 * x, -1.0, 1.0)); };
    bool changed = false;
    for (int k = 0; k < 2; ++k) {
      double angle = toAngle(c[k]);
      const double low = limit ? toAngle(limit->swingCentre[k] - limit->swingRadii[k]) : -2.8;
      const double high = limit ? toAngle(limit->swingCentre[k] + limit->swingRadii[k]) : 2.8;
      if (slider(sandbox, k == 0 ? "##swing x" : "##swing y", k == 0 ? "swing about x" : "swing about y",
                 angle, low, high, true)) {
        c[k] = 2.0 * std::sin(0.5 * angle);
        if (c.head<2>().norm() > 1.98) c.head<2>() *= 1.98 / c.head<2>().norm();
        changed = true;
      }
    }
    changed |= slider(sandbox, "##twist", "twist about z", c[2], limit ? limit->twistLower : -M_PI,
                      limit ? limit->twistUpper : M_PI, true);
    if (changed) setBallRotation(skeleton, q, i, fromSwingTwistCoordinates(c));
    return changed;
  }

  std::mt19937_64 random_{1};
  std::string whyNotMirrored_;  ///< of the model; empty: it can be
  int lastSelected_ = -1;
};

}  // namespace

std::unique_ptr<Panel> makeModelPanel() { return std::make_unique<ModelPanel>(); }

}  // namespace gelenk
