// Lecture 10.1.1 and 10.2: scenes in space.

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <optional>

#include "apps/document/chain_models.h"
#include "apps/lecture/derivations.h"
#include "apps/lecture/leg_animation.h"
#include "apps/lecture/slide_data.h"
#include "apps/lecture/text.h"
#include "apps/render/mathematics.h"
#include "apps/sandbox/derivation_text.h"
#include "apps/sandbox/lecture_scene.h"
#include "apps/sandbox/plots.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/configuration.h"
#include "kinematics/io/dh_text.h"
#include "kinematics/io/text_file.h"
#include "kinematics/notation/euler.h"
#include "kinematics/notation/mannequin.h"
#include "kinematics/notation/robots.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double degree = M_PI / 180.0;
// --- 10.2: Euler angles and quaternions
// ---------------------------------------------------------------------------

class RotationsScene final : public LectureScene {
 public:
  LectureDrawing& drawing() override { return drawing_; }

  void open(Sandbox& sandbox) override {
    const std::string name = "balls:1,0.8,0.5";
    sandbox.openModel(*parseBallChain(name), {.nameOrFile = name});
    for (int i = 0; i < 3; ++i) setAngles(sandbox, i, slide::ballAngles[i]);
    sandbox.options().ground = false;  // it turns freely in space
    sandbox.camera().elevation = 0.45;
    frameView(sandbox, Eigen::AlignedBox3d(Vector3d(-0.5, -0.7, -0.5), Vector3d(1.9, 0.7, 0.9)));
  }

  void drawInspector(Sandbox& sandbox) override {
    for (int i = 0; i < 3; ++i) {
      if (i) ImGui::SameLine();
      if (ImGui::RadioButton(fmt::format("joint {}", i + 1).c_str(), drawing_.joint == i)) drawing_.joint = i;
    }
    ImGui::SetNextItemWidth(-60 * sandbox.scale());
    if (ImGui::BeginCombo("order", std::string(drawing_.eulerOrder().name).c_str())) {
      for (std::size_t i = 0; i < eulerOrders().size(); ++i)
        if (ImGui::Selectable(std::string(eulerOrders()[i].name).c_str(), i == drawing_.order))
          drawing_.order = i;
      ImGui::EndCombo();
    }
    tooltip(
        "R(a, b, c) = R_first(a) R_second(b) R_third(c), moving axes. The lecture's is xyz. The pose stays, "
        "the angles change.");
    Vector3d angles = drawing_.anglesOf(sandbox.session(), drawing_.joint);
    bool changed = false;
    for (int k = 0; k < 3; ++k) {
      float value = static_cast<float>(angles[k] / degree);
      ImGui::SetNextItemWidth(-60 * sandbox.scale());
      if (valueSlider(fmt::format("angle {}", k + 1).c_str(), value, -180.0f, 180.0f, "%.1f deg"))
        angles[k] = value * degree, changed = true;
    }
    if (ImGui::Button("To gimbal lock", {-1, 0}))
      angles[1] = drawing_.eulerOrder().isProper() ? 0.0 : M_PI / 2, changed = true;
    if (changed) setAngles(sandbox, drawing_.joint, angles);
    const double det = std::abs(eulerRates(drawing_.eulerOrder(), angles).determinant());
    headingRow(sandbox, "GIMBAL");
    valueRow(sandbox, drawing_.eulerOrder().isProper() ? "|det E| = |sin b|" : "|det E| = |cos b|",
             fmt::format("{:.4g}", det));
    if (det < 0.02) ImGui::TextColored(sandbox.state().colours().bad, "first and third axis are one line");
    headingRow(sandbox, "THE SAME ROTATION AS A UNIT QUATERNION");
    const Eigen::Quaterniond q =
        ballRotation(sandbox.session().skeleton(), sandbox.session().q(), drawing_.joint);
    std::vector<std::string> parts;
    text::append(parts, Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()), 5);
    drawTable(text::heads({"w", "x", "y", "z"}) + text::row(parts));
    valueRow(sandbox, "| ||q|| - 1 |", fmt::format("{:.1e}", std::abs(q.norm() - 1.0)));
    headingRow(sandbox, "IN EVERY ORDER, DEGREES");
    std::string rows;
    for (const EulerOrder& other : eulerOrders()) {
      std::vector<std::string> cells{std::string(other.name)};
      text::append(cells, eulerFromRotation(other, q.normalized().toRotationMatrix()) / degree, 2);
      rows += text::row(cells);
    }
    drawTable(rows);
  }

  std::string derivation(Sandbox& sandbox) override {
    std::array<Vector3d, 3> angles;
    for (int i = 0; i < 3; ++i)
      angles[i] = eulerFromRotation(lectureEulerOrder(),
                                    ballRotation(sandbox.session().skeleton(), sandbox.session().q(), i)
                                        .normalized()
                                        .toRotationMatrix());
    return rotationsDerivation(angles);
  }

 private:
  void setAngles(Sandbox& sandbox, int joint, const Vector3d& angles) {
    drawing_.typed[joint] = angles;
    VectorXd q = sandbox.session().q();
    setBallRotation(sandbox.session().skeleton(), q, joint,
                    Eigen::Quaterniond(rotationFromEuler(drawing_.eulerOrder(), angles)));
    sandbox.session().setPose(q);
  }

  RotationsDrawing drawing_;
};

// --- 10.2: Denavit-Hartenberg
// -------------------------------------------------------------------------------------

class DhScene final : public LectureScene {
 public:
  LectureDrawing& drawing() override { return drawing_; }

  void open(Sandbox& sandbox) override {
    drawing_.table = robotTable("panda");
    rebuild(sandbox);
  }

  void step(Sandbox& sandbox, double) override {
    if (!pending_) return;  // the window's own drawing must be over before the model changes
    pending_ = false;
    rebuild(sandbox);
  }

  bool moves(const Sandbox&) const override { return pending_; }

  void drawInspector(Sandbox& sandbox) override {
    ImGui::SetNextItemWidth(-1);
    if (ImGui::BeginCombo("##robot", drawing_.table.name.c_str())) {
      for (const Robot& robot : robots())
        if (ImGui::Selectable(std::string(robot.title).c_str(), robot.name == drawing_.table.name))
          change(robot.table());
      ImGui::EndCombo();
    }
    bool modified = drawing_.table.convention == DhConvention::Modified;
    if (ImGui::RadioButton("modified (lecture)", modified) && !modified)
      change(toConvention(drawing_.table, DhConvention::Modified));
    ImGui::SameLine();
    if (ImGui::RadioButton("standard", !modified) && modified)
      change(toConvention(drawing_.table, DhConvention::Standard));
    tooltip("Turns the table into the other convention: the robot stays the same.");
    ImGui::Checkbox("##frames", &drawing_.frames);
    mathLabel("Frames K_i");
    ImGui::SameLine();
    ImGui::TextColored(sandbox.state().colours().textDim, "%d parameters", parameterCount(drawing_.table));
    headingRow(sandbox, "KIND AND PARAMETERS");
    const float gap = 4 * sandbox.scale(), kind = 26 * sandbox.scale(),
                width = (ImGui::GetContentRegionAvail().x - kind) / 4 - gap, left = ImGui::GetCursorPosX();
    ImGui::PushFont(sandbox.state().gui.fonts().small);
    for (int k = 0; const char* head : {"a [m]", "alpha [deg]", "d [m]", "phi [deg]"}) {
      if (k > 0) ImGui::SameLine(0, 0);
      const float wide = mathExtent(ImGui::GetFont(), ImGui::GetFontSize(), head).width;
      ImGui::SetCursorPosX(left + kind + gap + (width + gap) * static_cast<float>(k++) +
                           0.5f * (width - wide));
      mathItem(head);
    }
    ImGui::PopFont();
    DhTable edited = drawing_.table;
    bool touched = false;
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {3 * sandbox.scale(), 2 * sandbox.scale()});
    for (std::size_t i = 0; i < edited.rows.size(); ++i) {
      DhRow& row = edited.rows[i];
      ImGui::PushID(static_cast<int>(i));
      const char* kinds[] = {"R", "P", "F"};
      if (ImGui::Button(kinds[static_cast<int>(row.kind)], {kind, 0})) {
        row.kind = static_cast<DhJoint>((static_cast<int>(row.kind) + 1) % 3);
        row.lower = row.kind == DhJoint::Prismatic ? 0.0 : -M_PI;
        row.upper = row.kind == DhJoint::Prismatic ? 0.3 : M_PI;
        if (row.kind == DhJoint::Fixed) row.lower = -unlimited, row.upper = unlimited;
        edited.rest.reset();
        change(edited);
      }
      tooltip("Revolute, prismatic, fixed: click to change");
      const auto number = [&](const char* id, double& value, double unit, float speed, const char* format) {
        ImGui::SameLine(0, gap);
        ImGui::SetNextItemWidth(width);
        float shown = static_cast<float>(value / unit);
        if (ImGui::DragFloat(id, &shown, speed, 0, 0, format)) value = shown * unit, touched = true;
      };
      number("##a", row.a, 1.0, 0.002f, "%.3f");
      number("##alpha", row.alpha, degree, 0.5f, "%.1f");
      number("##d", row.d, 1.0, 0.002f, "%.3f");
      number("##phi", row.phi, degree, 0.5f, "%.1f");
      ImGui::PopID();
    }
    ImGui::PopStyleVar();
    if (touched) change(edited);
    const float half = 0.5f * ImGui::GetContentRegionAvail().x - 4;
    if (ImGui::Button("Add a row", {half, 0})) {
      edited.rows.push_back({.a = 0.2, .lower = -M_PI, .upper = M_PI});
      edited.rest.reset();
      change(edited);
    }
    ImGui::SameLine();
    if (ImGui::Button("Remove the last", {-1, 0}) && edited.rows.size() > 1) {
      edited.rows.pop_back();
      edited.rest.reset();
      if (edited.variableCount() > 0) change(edited);
    }
    if (ImGui::Button("Save as .dh in this folder", {-1, 0})) {
      try {
        const std::string path = (drawing_.table.name.empty() ? "robot" : drawing_.table.name) + ".dh";
        writeFile(path, formatDhTable(drawing_.table));
        sandbox.say("Wrote " + path);
      } catch (const std::exception& error) {
        sandbox.say(error.what(), true);
      }
    }
    headingRow(sandbox, "TOOL");
    if (sandbox.session().q().size() == drawing_.table.variableCount()) {
      const Eigen::Isometry3d tool = dhFrames(drawing_.table, sandbox.session().q()).back();
      valueRow(sandbox, "position [m]",
               text::fixed(tool.translation().x(), 4) + ", " + text::fixed(tool.translation().y(), 4) + ", " +
                   text::fixed(tool.translation().z(), 4));
      const double apart = (tool.matrix() - sandbox.session().frames().back().matrix()).cwiseAbs().maxCoeff();
      valueRow(sandbox, "matrices against skeleton", fmt::format("{:.1e}", apart));
      tooltip("Product of the slide's matrices against the skeleton that the window drags.");
    }
    wrappedText(sandbox.state().colours().textDim,
                "Drag the tool; with T its orientation. Blue dashes: joint axes; orange: common normals a.");
  }

  std::string derivation(Sandbox& sandbox) override {
    const VectorXd& q = sandbox.session().q();
    return q.size() == drawing_.table.variableCount() ? dhDerivation(drawing_.table, q) : std::string();
  }

  bool takesAnyModel() const override { return true; }
  bool changesModel() const override { return reopening_; }

 private:
  /// The model changes before the next frame's solve, not while it is being drawn.
  void change(const DhTable& table) {
    if (table.variableCount() == 0) return;
    drawing_.table = table;
    pending_ = true;
  }
  void rebuild(Sandbox& sandbox) {
    const VectorXd q = sandbox.session().q();
    const Camera camera = sandbox.camera();
    const bool keep = opened_;
    opened_ = true;
    reopening_ = true;  // the Lecture panel then keeps this scene
    sandbox.openModel(dhModel(drawing_.table), {.nameOrFile = dhDescription(drawing_.table)});
    reopening_ = false;
    if (keep && q.size() == drawing_.table.variableCount()) sandbox.session().setPose(q);
    if (keep) sandbox.camera() = camera;
  }

  DhDrawing drawing_;
  bool pending_ = false, opened_ = false, reopening_ = false;
};

// --- 10.1.1: hierarchical animation of a leg
// ----------------------------------------------------------------------

class LegScene final : public LectureScene {
 public:
  LectureDrawing& drawing() override { return drawing_; }

  void open(Sandbox& sandbox) override {
    sandbox.open("figure");
    drawing_.animate(sandbox.session().skeleton());
    drawing_.time = slide::walkStart;
    sandbox.setPlaying(true);
    show(sandbox);
    Camera& camera = sandbox.camera();
    camera.azimuth = 1.15;
    camera.elevation = 0.2;
    const double z = sandbox.session().q()[2];
    frameView(sandbox, Eigen::AlignedBox3d(Vector3d(-0.4, 0.0, z - 0.6), Vector3d(0.4, 1.75, z + 0.6)));
  }

  void step(Sandbox& sandbox, double seconds) override {
    if (sandbox.playing() && !sandbox.session().dragged()) {
      drawing_.time = std::fmod(drawing_.time + seconds * speed_, drawing_.keyed.duration());
      show(sandbox);
    }
    if (sandbox.session().dragged() && drawing_.pins) standFirm(sandbox.session());
  }
  bool moves(const Sandbox& sandbox) const override { return sandbox.playing(); }

  void drawInspector(Sandbox& sandbox) override {
    if (ImGui::Button(sandbox.playing() ? "Pause (Space)" : "Play (Space)", {-1, 0}))
      sandbox.setPlaying(!sandbox.playing());
    float seconds = static_cast<float>(drawing_.time);
    ImGui::SetNextItemWidth(-46 * sandbox.scale());
    if (valueSlider("time", seconds, 0.0f, static_cast<float>(drawing_.keyed.duration()) - 1e-3f, "%.2f s")) {
      drawing_.time = seconds;
      sandbox.setPlaying(false);
      show(sandbox);
    }
    ImGui::SetNextItemWidth(-46 * sandbox.scale());
    valueSlider("speed", speed_, 0.05f, 1.5f, "%.2f");
    if (ImGui::Checkbox("Pinned feet: IK on top of the keyframes", &drawing_.pins)) show(sandbox);
    tooltip(
        "A foot on the ground stays where it came down: hip and knee by the two-link closed form, heel and "
        "toes turned out of the ground.");
    ImGui::Checkbox("Keyframes alone as a ghost", &drawing_.ghost);
    const LegKeys keys = lectureLegKeys();
    headingRow(sandbox, "KEYED ANGLES, LEFT LEG, DEGREES");
    const double phase = drawing_.frame() / drawing_.keyed.framesPerSecond / keys.cycle;
    valueRow(sandbox, "hip flexion", fmt::format("{:.1f}", keyedAngle(keys.hip, phase)));
    valueRow(sandbox, "knee flexion", fmt::format("{:.1f}", keyedAngle(keys.knee, phase)));
    valueRow(sandbox, "foot, plantar flexion", fmt::format("{:.1f}", keyedAngle(keys.foot, phase)));
    headingRow(sandbox, "THIS FRAME");
    const auto& feet = drawing_.feet()[drawing_.frame()];
    drawTable(text::heads({"", "left", "right"}) +
              text::row({"sliding [mm a frame]", text::fixed(1e3 * feet[0].sliding, 3),
                         text::fixed(1e3 * feet[1].sliding, 3)}) +
              text::row({"depth [mm]", text::fixed(1e3 * feet[0].penetration, 3),
                         text::fixed(1e3 * feet[1].penetration, 3)}));
    headingRow(sandbox, "WHOLE ANIMATION");
    const FootSummary keyed = summarise(drawing_.keyedFeet), pinned = summarise(drawing_.pinnedFeet);
    valueRow(sandbox, "worst sliding, keyframes", fmt::format("{:.1f} mm a frame", 1e3 * keyed.worstSliding));
    valueRow(sandbox, "worst sliding, pinned", fmt::format("{:.1e} mm", 1e3 * pinned.worstSliding));
    valueRow(sandbox, "worst depth, keyframes", fmt::format("{:.1f} mm", 1e3 * keyed.worstPenetration));
    valueRow(sandbox, "worst depth, pinned", fmt::format("{:.1e} mm", 1e3 * pinned.worstPenetration));
  }

  bool hasPlot() const override { return true; }
  void drawPlot(Sandbox& sandbox) override {
    const Palette& colours = sandbox.state().colours();
    std::vector<Curve> curves(4);
    for (std::size_t f = 0; f < drawing_.keyedFeet.size(); ++f) {
      curves[0].values.push_back(
          1e3 * std::max(drawing_.keyedFeet[f][0].penetration, drawing_.keyedFeet[f][1].penetration));
      curves[1].values.push_back(
          1e3 * std::max(drawing_.keyedFeet[f][0].sliding, drawing_.keyedFeet[f][1].sliding));
      curves[2].values.push_back(
          1e3 * std::max(drawing_.pinnedFeet[f][0].penetration, drawing_.pinnedFeet[f][1].penetration));
      curves[3].values.push_back(
          1e3 * std::max(drawing_.pinnedFeet[f][0].sliding, drawing_.pinnedFeet[f][1].sliding));
    }
    curves[0].colour = colours.bad, curves[1].colour = colours.held, curves[2].colour = colours.good,
    curves[3].colour = colours.good;
    curves[0].label = "depth", curves[1].label = "sliding", curves[2].label = "pinned";
    const ImVec2 at = ImGui::GetCursorScreenPos(), size = ImGui::GetContentRegionAvail();
    gelenk::drawPlot({.title = "Sinking and sliding of the feet, mm",
                      .xLabel = "frame",
                      .logarithmic = false,
                      .lowest = 0.0,
                      .highest = 70.0,
                      .leastCount = static_cast<int>(drawing_.keyedFeet.size())},
                     curves, at, size, colours, sandbox.state().gui.fonts(), sandbox.scale());
  }

  std::string derivation(Sandbox&) override {
    return legDerivation(drawing_.shown(), drawing_.feet()[drawing_.frame()], drawing_.frame());
  }

  void taken(Sandbox& sandbox) override {
    sandbox.setPlaying(false);
    show(sandbox);
  }

 private:
  /// Who drags the body while a foot stands pinned finds it pinned.
  void standFirm(Session& session) const {
    for (int side = 0; side < 2; ++side)
      if (const auto foot = session.findGoal(side == 0 ? "foot_l" : "foot_r");
          foot && drawing_.pinned.onGround[drawing_.frame()][side] &&
          session.goal(*foot).state == GoalState::Free)
        session.setState(*foot, GoalState::Pinned);
  }
  void show(Sandbox& sandbox) {
    for (const SceneGoal& goal : sandbox.session().goals())
      if (goal.handle) sandbox.session().setState(goal.id, GoalState::Free);
    const double before = sandbox.session().q()[2];
    sandbox.session().setPose(drawing_.shown().q[drawing_.frame()]);
    sandbox.camera().target.z() += sandbox.session().q()[2] - before;  // the camera walks along
  }

  LegDrawing drawing_;
  float speed_ = 0.5f;
};

}  // namespace

std::unique_ptr<LectureScene> makeRotationsScene() { return std::make_unique<RotationsScene>(); }
std::unique_ptr<LectureScene> makeDhScene() { return std::make_unique<DhScene>(); }
std::unique_ptr<LectureScene> makeLegScene() { return std::make_unique<LegScene>(); }

}  // namespace gelenk
