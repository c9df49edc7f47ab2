#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "apps/document/muscle_settings.h"
#include "apps/lecture/text.h"
#include "apps/sandbox/builtin_panels.h"
#include "apps/sandbox/limb_bend.h"
#include "apps/sandbox/sandbox_state.h"
#include "apps/sandbox/skin_comparison.h"
#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double degree = M_PI / 180.0;

/// A slider over a double, one edit a move; true when moved.
bool slider(Sandbox& sandbox, const char* label, double& value, double lower, double upper,
            const char* format, const char* explanation) {
  float shown = static_cast<float>(value);
  ImGui::SetNextItemWidth(0.55f * ImGui::GetContentRegionAvail().x);
  const bool moved = valueSlider(label, shown, static_cast<float>(lower), static_cast<float>(upper), format);
  tooltip(explanation);
  if (ImGui::IsItemActivated()) sandbox.session().remember();
  if (moved) value = shown;
  return moved;
}

/// Chadwick's muscle layers (lecture 10.3): lattices drawn, planes shaped, muscle curves, a plain skin
/// beside.
class MusclePanel final : public Panel {
 public:
  std::string name() const override { return "Muscles"; }
  bool hasInspector() const override { return true; }

  void opened(Sandbox& sandbox, bool) override {
    limbs_ = limbsOf(sandbox.session().model());
    shownSettings_.reset();
    settings_ = {};
    under_.reset();
    dragged_.reset();
    shownLimb_ = 0;
    selectedPlane_ = 2;
    selectedLink_ = 0;
  }

  void step(Sandbox& sandbox, double) override {
    takeUp(sandbox);
    if (const std::string& fault = sandbox.state().view->muscleFault(); !fault.empty() && fault != told_)
      sandbox.say(fault, true);
    told_ = sandbox.state().view->muscleFault();
  }

  void drawInspector(Sandbox& sandbox) override {
    Sandbox::State& s = sandbox.state();
    shownAt_ = sandbox.frameNumber();
    if (limbs_.empty()) {
      wrappedText(
          sandbox.session().model().skin
              ? "No limb of a known name (upperarm_l, lowerarm_l, hand_l, ...) was found in this model."
              : "This model has no body to deform.");
      return;
    }
    if (ImGui::Checkbox("Muscle layers", &settings_.enabled)) edit(sandbox);
    tooltip(
        "Free-form deformation volumes between skeleton and skin (Chadwick 1989). Each link carries two "
        "tri-cubic Bezier "
        "volumes; a limb acts as one bone in the skinning sum: x' = Σ w T x + W F(u, v, w).");
    if (!settings_.enabled) {
      ImGui::TextColored(s.colours().textDim, "Off: the skin as the Skin tab has it.");
      return;
    }
    if (ImGui::Checkbox("Lattice", &settings_.lattice)) look(sandbox);
    tooltip(
        "The control planes of the chosen limb: seven a link, 4 x 4 points each. Teal: connecting planes, "
        "amber: inner planes. Click "
        "a plane to select it; drag one of planes 2 and 4 to scale it, with Shift to turn it about the "
        "bone.");
    ImGui::SameLine();
    if (ImGui::Checkbox("Plain skin beside", &settings_.split)) look(sandbox);
    tooltip("Split view: to the left the same pose without layers, by the method of the Skin tab.");

    heading(s, "LIMB");
    limbChoice(sandbox);
    if (ImGui::Checkbox("This limb alone", &settings_.alone)) showAlone(sandbox);
    tooltip(
        "The rest of the body is not drawn: beside this limb, with muscles, stand linear blending and the "
        "volumes without muscles, or what is chosen under SIDE BY SIDE.");
    LimbSettings& limb = settings_.limbs[shownLimb_].second;
    measures(sandbox);

    heading(s, "SIDE BY SIDE");
    drawSkinComparison(sandbox);

    heading(s, "MUSCLES");
    bool changed = slider(sandbox, "Activation", limb.control.activation, 0.0, 1.0, "%.2f",
                          "Contraction without motion, 0 to 1: swells flexor and extensor.");
    if (ImGui::Checkbox("Keep volume", &limb.control.keepVolume)) edit(sandbox);
    tooltip(
        "Scales planes 2 and 4 by a common s so that the limb encloses its rest volume (quadratic in s).");
    linkChoice();
    MuscleCurve& curve = limb.control.curves[selectedLink_];
    changed |=
        slider(sandbox, "Flexor", curve.flexor, -0.5, 1.0, "%.2f",
               "Bulge k of the inside at full bend, dimensionless: S = diag(1 + k, 1 + k/4), offset k r.");
    changed |= slider(sandbox, "Extensor", curve.extensor, -0.5, 1.0, "%.2f",
                      "Bulge of the outside: grows with activation, slackens with the bend.");
    changed |= slider(sandbox, "Near joint", curve.nearJoint, 0.0, 1.0, "%.2f",
                      "Share of the bulge at the plane nearer the joint: the belly sits away from it.");
    changed |= slider(sandbox, "Tendon", curve.tendon, 0.0, 0.6, "%.2f",
                      "Share by which the plane nearer the joint thins at full bend.");
    double fullBend = curve.fullBend / degree;
    if (slider(sandbox, "Full bend", fullBend, 30.0, 180.0, "%.0f°",
               "Total bend (straight = 0) at which the muscle is fully contracted, degrees.")) {
      curve.fullBend = fullBend * degree;
      changed = true;
    }
    curvePlot(s, curve);

    heading(s, "PLANE");
    changed |= planeEditor(sandbox);

    heading(s, "JOINT");
    bool proportions = slider(sandbox, "Gap", limb.jointGap, 0.05, 0.30, "%.2f L",
                              "Distance of the connecting planes from the joint, of the shorter link. "
                              "Larger: rounder, like a hose.");
    proportions |= slider(sandbox, "Wedge", limb.wedge, 0.0, 0.45, "%.2f",
                          "Adaptation: the connecting planes turn by (1/2 - wedge) θ against their bones.");
    if (ImGui::Button("Reset limb")) {
      limb = defaultLimbSettings(limbs_[shownLimb_]);
      edit(sandbox);
    }
    tooltip("Default proportions and muscles of this limb.");
    ImGui::SameLine();
    if (ImGui::Button("Mirror")) mirrorLimb(sandbox);
    tooltip("Copies this limb's settings to the same limb of the other side.");
    if (changed || proportions) look(sandbox);
  }

  /// "layers on|off"; "alone on|off" and "bend DEGREES" of the limb that is shown; "limb NAME" shows another.
  void act(Sandbox& sandbox, const std::vector<std::string>& words) override {
    if (limbs_.empty()) throw std::invalid_argument("this model has no limb of a known name");
    takeUp(sandbox);
    const MuscleRig* rig = sandbox.muscles();
    if (words.size() == 2 && words[0] == "layers" && (words[1] == "on" || words[1] == "off")) {
      settings_.enabled = words[1] == "on";
      return edit(sandbox);
    }
    if (words.size() == 2 && words[0] == "alone" && (words[1] == "on" || words[1] == "off")) {
      settings_.alone = words[1] == "on";
      return showAlone(sandbox);
    }
    if (words.size() >= 2 && words[0] == "limb") {  // names have blanks
      const int limb = indexOf(fmt::format("{}", fmt::join(words.begin() + 1, words.end(), " ")));
      if (limb < static_cast<int>(limbs_.size())) return showLimb(sandbox, limb);
    }
    const auto degrees = words.size() == 2 && words[0] == "bend" ? parseNumber(words[1]) : std::nullopt;
    if (!degrees || !rig || shownLimb_ >= static_cast<int>(rig->body().limbs.size()))
      throw std::invalid_argument(
          "the panel Muscles knows layers on|off, limb NAME and, with layers, alone on|off and bend DEGREES");
    Session& session = sandbox.session();
    const Limb& limb = rig->body().limbs[shownLimb_];
    const auto range = limbBend(session.skeleton(), limb, session.q());
    if (!range) throw std::invalid_argument("no hinge bends the limb '" + limb.name + "'");
    session.remember();
    session.setPose(bentBy(session.skeleton(), limb, *range, session.q(), *degrees * degree));
  }

  void overlay(Sandbox& sandbox) override {
    if (!dragged_) under_.reset();
    if (!sandbox.muscles() || shownLimb_ >= static_cast<int>(sandbox.limbPoses().size())) return;
    const Sandbox::State& s = sandbox.state();
    const bool inFront = sandbox.frameNumber() - shownAt_ <= 1;
    if (settings_.lattice && !dragged_ && inFront && s.layout.view.contains(s.mouse.x(), s.mouse.y()) &&
        !handleAt(s, s.mouse))
      under_ = pickLattice(sandbox.limbPoses()[shownLimb_], s.camera(), s.viewport(), s.toView(s.mouse),
                           8.0 * s.scale);
    if (inFront)
      sandbox.markLattice(under_ ? under_->plane : 6 * selectedLink_ + selectedPlane_,
                          under_ ? under_->point : -1);
  }

  /// Near a line of the lattice the mouse is the lattice's, but for handles.
  bool takesMouse(const Sandbox& sandbox) const override {
    const Sandbox::State& s = const_cast<Sandbox&>(sandbox).state();
    return dragged_ || (under_ && !handleAt(s, s.mouse));
  }

  std::string mouseHint() const override {
    return "Drag: the plane of the lattice grows or shrinks · Shift turns it";
  }

  bool pressed(Sandbox& sandbox, const Vector2d& pixel) override {
    const int links = static_cast<int>(limbs_[shownLimb_].shape.links.size());
    selectedLink_ = std::min(under_->plane / 6, links - 1);
    selectedPlane_ = under_->plane - 6 * selectedLink_;
    if (MusclePlane* plane = selectedMuscle())
      dragged_ = {.before = *plane, .from = fromCentre(sandbox, pixel), .moved = false};
    return true;
  }

  /// Scales the plane by the mouse's distance from its middle, or with Shift turns it with the mouse about
  /// its middle.
  void moved(Sandbox& sandbox, const Vector2d& pixel) override {
    MusclePlane* plane = selectedMuscle();
    if (!dragged_ || !plane || !sandbox.muscles()) return;
    const Vector2d from = dragged_->from, to = fromCentre(sandbox, pixel);
    if (from.norm() < 2.0) return;
    if (!std::exchange(dragged_->moved, true)) sandbox.session().remember();
    if (sandbox.state().shift) {
      const double angle = std::atan2(from.x() * to.y() - from.y() * to.x(),
                                      from.dot(to));  // clockwise on the screen: y points down
      const FfdPlane shown = sandbox.limbPoses()[shownLimb_].turnedPlane(6 * selectedLink_ + selectedPlane_);
      const Vector3d normal = shown.axes.col(0).cross(shown.axes.col(1));
      const double facing = normal.dot(sandbox.camera().axes().col(2)) > 0.0 ? -1.0 : 1.0;
      plane->stretch = Eigen::Rotation2Dd(facing * angle).toRotationMatrix() * dragged_->before.stretch;
    } else {
      plane->stretch = std::clamp(to.norm() / from.norm(), 0.3, 2.0) * dragged_->before.stretch;
    }
    look(sandbox);
  }

  void released(Sandbox&) override { dragged_.reset(); }

 private:
  /// A plane under the mouse between press and release.
  struct DraggedPlane {
    MusclePlane before;
    Vector2d from;  ///< the press, seen from the plane's middle, pixels
    bool moved = false;
  };

  /// What undo, a file or the model's opening made of the settings.
  void takeUp(Sandbox& sandbox) {
    const auto& muscles = sandbox.session().edits().muscles;
    if (!muscles || muscles == shownSettings_) return;
    shownSettings_ = muscles;
    settings_ = *muscles;
    if (const int limb = indexOf(settings_.shownLimb); limb < static_cast<int>(limbs_.size()))
      shownLimb_ = limb;
  }

  /// The hand's edits of the selected plane; nullptr for planes that follow from others.
  MusclePlane* selectedMuscle() {
    if (selectedPlane_ != 2 && selectedPlane_ != 4) return nullptr;
    MuscleState& state = settings_.limbs[shownLimb_].second.control.sculpted[selectedLink_];
    return selectedPlane_ == 2 ? &state.plane2 : &state.plane4;
  }

  Vector2d fromCentre(Sandbox& sandbox, const Vector2d& pixel) const {
    const FfdPlane plane = sandbox.limbPoses()[shownLimb_].turnedPlane(6 * selectedLink_ + selectedPlane_);
    return pixel - sandbox.state().toWindow(plane.point(0.5, 0.5)).pixel;
  }

  int indexOf(const std::string& limb) const {
    return static_cast<int>(
        std::find_if(limbs_.begin(), limbs_.end(), [&](const Limb& l) { return l.name == limb; }) -
        limbs_.begin());
  }

  /// What was changed here goes into the document; step() takes it up from there.
  void look(Sandbox& sandbox) {
    sandbox.session().setMuscles(std::make_shared<const MuscleSettings>(settings_));
  }
  void edit(Sandbox& sandbox) {
    sandbox.session().remember();
    look(sandbox);
  }

  void limbChoice(Sandbox& sandbox) {
    ImGui::SetNextItemWidth(-1);
    if (!ImGui::BeginCombo("##limb", limbs_[shownLimb_].name.c_str())) return;
    for (int l = 0; l < static_cast<int>(limbs_.size()); ++l)
      if (ImGui::Selectable(limbs_[l].name.c_str(), l == shownLimb_)) showLimb(sandbox, l);
    ImGui::EndCombo();
  }

  void showLimb(Sandbox& sandbox, int limb) {
    shownLimb_ = limb;
    settings_.shownLimb = limbs_[limb].name;
    selectedLink_ = std::min<int>(selectedLink_, static_cast<int>(limbs_[limb].shape.links.size()) - 1);
    look(sandbox);
    if (settings_.alone) frameShown(sandbox);
  }

  /// The limb alone, or the body again. With the limb come the two skins that explain it, where none are
  /// beside it yet.
  void showAlone(Sandbox& sandbox) {
    edit(sandbox);
    std::vector<SkinChoice>& beside = sandbox.session().lab().skins;
    if (settings_.alone && beside.empty()) beside = {parseSkinChoice("lbs"), parseSkinChoice("lbs+layers")};
    frameShown(sandbox);
  }

  static void frameShown(Sandbox& sandbox) {
    sandbox.state().afterFrame = [](Sandbox& s) { frameEverything(s, true); };
  }

  void linkChoice() {
    for (int i = 0; i < static_cast<int>(limbs_[shownLimb_].shape.links.size()); ++i) {
      if (i > 0) ImGui::SameLine();
      if (ImGui::RadioButton(fmt::format("Link {}", i + 1).c_str(), selectedLink_ == i)) selectedLink_ = i;
      tooltip("The link whose muscle is shown: 1 is the upper one.");
    }
  }

  void measures(Sandbox& sandbox) {
    const MuscleRig* rig = sandbox.muscles();
    if (!rig || shownLimb_ >= static_cast<int>(sandbox.limbPoses().size())) return;
    const Frames& frames = sandbox.shownFrames();
    const LimbFrames limb = limbFrames(rig->body().limbs[shownLimb_], frames);
    if (limb.rotations.size() > 1) {
      const JointBend bend = jointBend(limb, 1);
      bendSlider(sandbox, rig->body().limbs[shownLimb_], bend.bend / degree);
      ImGui::Text("Twist %s°", text::fixed(bend.twist / degree, 1).c_str());
      tooltip("Twist of the joint between the links about the bone, degrees.");
    }
    const double volume =
        limbVolume(rig->body(), rig->surface(shownLimb_), frames, sandbox.limbPoses()[shownLimb_]);
    ImGui::Text("Volume %.4f of rest", volume / rig->restVolume(shownLimb_));
    tooltip("Volume that the limb's surface encloses, relative to the rest pose.");
  }

  /// Bends elbow or knee, whatever held it; where no hinge does, the bend is told.
  void bendSlider(Sandbox& sandbox, const Limb& limb, double degrees) {
    Session& session = sandbox.session();
    const auto range = limbBend(session.skeleton(), limb, session.q());
    if (!range) {
      ImGui::Text("Bend %s°", text::fixed(degrees, 1).c_str());
      return;
    }
    if (slider(sandbox, "Bend", degrees, range->least / degree, range->most / degree, "%.1f°",
               "Total bend of the joint between the links, straight = 0, degrees: moves it."))
      session.setPose(bentBy(session.skeleton(), limb, *range, session.q(), degrees * degree));
    if (ImGui::IsItemDeactivatedAfterEdit() && settings_.alone) frameShown(sandbox);
  }

  /// Scale of planes 2 and 4 against the joint's bend.
  void curvePlot(const Sandbox::State& s, const MuscleCurve& curve) const {
    const Limb& limb = limbs_[shownLimb_];
    if (limb.bendAtRest.empty()) return;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float width = ImGui::GetContentRegionAvail().x, height = 64 * s.scale;
    ImDrawList* draw = ImGui::GetWindowDrawList();
    fillRounded(*draw, at, {at.x + width, at.y + height}, colour32(s.colours().plotBackground), 4 * s.scale);
    const double rest = limb.bendAtRest[0];
    const auto fraction = [&](double theta) {
      const double whole = 1.0 - std::cos(curve.fullBend - rest);
      return whole > 1e-9 ? std::clamp((1.0 - std::cos(theta - rest)) / whole, 0.0, 1.5) : 0.0;
    };
    const auto curveOf = [&](double k, const ImVec4& colour) {
      std::vector<ImVec2> points;
      for (int i = 0; i <= 48; ++i) {
        const double theta = M_PI * i / 48.0, scale = 1.0 + k * fraction(theta);
        points.push_back(
            {at.x + width * static_cast<float>(i) / 48.0f,
             at.y + height * static_cast<float>(std::clamp(0.75 - 0.75 * (scale - 1.0), 0.04, 0.96))});
      }
      draw->AddPolyline(points.data(), static_cast<int>(points.size()), colour32(colour), 0, 1.6f * s.scale);
    };
    curveOf(curve.flexor, s.colours().accent);
    curveOf(curve.nearJoint * curve.flexor, s.colours().held);
    curveOf(-curve.extensor, s.colours().textDim);
    ImGui::Dummy({width, height});
    tooltip(
        "Scale of the planes against the bend, 0 to 180 degrees: blue the belly, amber the plane nearer the "
        "joint, grey the outside.");
  }

  bool planeEditor(Sandbox& sandbox) {
    for (const int plane : {2, 4}) {
      if (plane == 4) ImGui::SameLine();
      if (ImGui::RadioButton(fmt::format("Plane {}", plane).c_str(), selectedPlane_ == plane))
        selectedPlane_ = plane;
      tooltip("The free inner planes 2 and 4; plane 3 stays their middle, so the seam stays smooth.");
    }
    if (!selectedMuscle()) {
      wrappedText(selectedPlane_ == 3
                      ? "Plane 3 is the middle of planes 2 and 4, so that the seam stays smooth."
                      : "Connecting planes follow from the joint's pose and the seam's constraints; "
                        "Gap and Wedge below place them.");
      return false;
    }
    MusclePlane& plane = *selectedMuscle();
    double angle =
        std::atan2(plane.stretch(1, 0) - plane.stretch(0, 1), plane.stretch(0, 0) + plane.stretch(1, 1));
    const Eigen::Matrix2d S =
        Eigen::Rotation2Dd(-angle).toRotationMatrix() * plane.stretch;  // polar: rotation times symmetric
    double across = S(0, 0), sideways = S(1, 1), shear = 0.5 * (S(0, 1) + S(1, 0)), turned = angle / degree;
    double x = 1000.0 * plane.offset.x(), y = 1000.0 * plane.offset.y();
    bool changed =
        slider(sandbox, "Scale x", across, 0.3, 2.0, "%.2f", "Stretch towards the inside of the bend.");
    changed |= slider(sandbox, "Scale y", sideways, 0.3, 2.0, "%.2f", "Stretch along the bend axis.");
    changed |=
        slider(sandbox, "Shear", shear, -0.5, 0.5, "%.2f", "Off-diagonal entry of the symmetric stretch.");
    changed |= slider(sandbox, "Rotate", turned, -60.0, 60.0, "%.0f°", "Turn about the bone, degrees.");
    changed |=
        slider(sandbox, "Offset x", x, -60.0, 60.0, "%.1f mm", "Shift towards the inside of the bend.");
    changed |= slider(sandbox, "Offset y", y, -60.0, 60.0, "%.1f mm", "Shift along the bend axis.");
    if (changed) {
      Eigen::Matrix2d stretch;
      stretch << across, shear, shear, sideways;
      plane.stretch = Eigen::Rotation2Dd(turned * degree).toRotationMatrix() * stretch;
      plane.offset = Eigen::Vector2d(x, y) / 1000.0;
    }
    return changed;
  }

  void mirrorLimb(Sandbox& sandbox) {
    std::string other = limbs_[shownLimb_].name;
    if (other.starts_with("left"))
      other.replace(0, 4, "right");
    else if (other.starts_with("right"))
      other.replace(0, 5, "left");
    const int target = indexOf(other);
    if (target >= static_cast<int>(limbs_.size()) || target == shownLimb_) return;
    LimbSettings copy = settings_.limbs[shownLimb_].second;
    for (MuscleState& state : copy.control.sculpted)
      for (MusclePlane* plane : {&state.plane2, &state.plane4}) {  // the mirrored section has its y reversed
        plane->stretch(0, 1) = -plane->stretch(0, 1);
        plane->stretch(1, 0) = -plane->stretch(1, 0);
        plane->offset.y() = -plane->offset.y();
      }
    settings_.limbs[target].second = copy;
    edit(sandbox);
    sandbox.say("Copied to the " + other);
  }

  std::vector<Limb> limbs_;
  std::shared_ptr<const MuscleSettings> shownSettings_;  ///< the document's that was taken up last
  MuscleSettings settings_;                              ///< a copy to work on
  std::string told_;                                     ///< the fault that was said last
  std::optional<LatticePoint> under_;                    ///< the mouse
  std::optional<DraggedPlane> dragged_;
  int shownAt_ = -10;  ///< frame in which the inspector was drawn last
  int shownLimb_ = 0, selectedLink_ = 0, selectedPlane_ = 2;
};

}  // namespace

std::unique_ptr<Panel> makeMusclePanel() { return std::make_unique<MusclePanel>(); }

}  // namespace gelenk
