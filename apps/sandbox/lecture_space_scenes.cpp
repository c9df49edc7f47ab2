// Lecture 10.1.1 and 10.2: scenes in space.

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <optional>

#include "apps/document/chain_models.h"
#include "apps/lecture/derivations.h"
#include "apps/lecture/leg_animation.h"
#include "apps/lecture/slide_data.h"
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
constexpr Colour red{0.83f, 0.24f, 0.20f, 1}, green{0.20f, 0.60f, 0.25f, 1}, blue{0.15f, 0.38f, 0.80f, 1};
constexpr Colour axisColours[] = {red, green, blue};

void label(Sandbox& sandbox, const Vector3d& at, const std::string& text, const Colour& c) {
  sandbox.label(at, text, {c.r, c.g, c.b, 1.0f});
}

// --- 10.2: Euler angles and quaternions
// ---------------------------------------------------------------------------

class RotationsScene final : public LectureScene {
 public:
  void open(Sandbox& sandbox) override {
    const std::string name = "balls:1,0.8,0.5";
    sandbox.openModel(*parseBallChain(name), {.nameOrFile = name});
    for (int i = 0; i < 3; ++i) setAngles(sandbox, i, slide::ballAngles[i]);
    sandbox.options().ground = false;  // it turns freely in space
    sandbox.camera().elevation = 0.45;
    frameView(sandbox, Eigen::AlignedBox3d(Vector3d(-0.5, -0.7, -0.5), Vector3d(1.9, 0.7, 0.9)));
  }

  void overlay(Sandbox& sandbox) override {
    const Vector3d angles = anglesOf(sandbox, joint_);
    const Frames& frames = sandbox.session().frames();
    const Eigen::Matrix3d parent =
        joint_ == 0 ? Eigen::Matrix3d::Identity() : Eigen::Matrix3d(frames[joint_ - 1].linear());
    const Eigen::Matrix3d E = parent * eulerRates(order(), angles);
    const Vector3d at = frames[joint_].translation();
    const int axes[] = {order().first, order().second, order().third};
    for (int k = 0; k < 3; ++k) {
      const double length = 0.75 - 0.1 * k;
      sandbox.overlay().line(at - length * E.col(k), at + length * E.col(k), axisColours[axes[k]], 2.5f);
      label(sandbox, at + 1.08 * length * E.col(k), fmt::format("{}: {}", k + 1, "xyz"[axes[k]]),
            axisColours[axes[k]]);
    }
    sandbox.overlay().point(at, axisColours[axes[1]], 10.0f, Overlay::Shape::Ring);
  }

  void drawInspector(Sandbox& sandbox) override {
    for (int i = 0; i < 3; ++i) {
      if (i) ImGui::SameLine();
      if (ImGui::RadioButton(fmt::format("joint {}", i + 1).c_str(), joint_ == i)) joint_ = i;
    }
    ImGui::SetNextItemWidth(-60 * sandbox.scale());
    if (ImGui::BeginCombo("order", std::string(order().name).c_str())) {
      for (std::size_t i = 0; i < eulerOrders().size(); ++i)
        if (ImGui::Selectable(std::string(eulerOrders()[i].name).c_str(), i == order_)) order_ = i;
      ImGui::EndCombo();
    }
    tooltip(
        "R(a, b, c) = R_first(a) R_second(b) R_third(c), moving axes. The lecture's is xyz. The pose stays, "
        "the angles change.");
    Vector3d angles = anglesOf(sandbox, joint_);
    bool changed = false;
    for (int k = 0; k < 3; ++k) {
      float value = static_cast<float>(angles[k] / degree);
      ImGui::SetNextItemWidth(-60 * sandbox.scale());
      if (ImGui::SliderFloat(fmt::format("angle {}", k + 1).c_str(), &value, -180, 180, "%.1f deg"))
        angles[k] = value * degree, changed = true;
    }
    if (ImGui::Button("To gimbal lock", {-1, 0}))
      angles[1] = order().isProper() ? 0.0 : M_PI / 2, changed = true;
    if (changed) setAngles(sandbox, joint_, angles);
    const double det = std::abs(eulerRates(order(), angles).determinant());
    headingRow(sandbox, "GIMBAL");
    valueRow(sandbox, order().isProper() ? "|det E| = |sin b|" : "|det E| = |cos b|",
             fmt::format("{:.4g}", det));
    if (det < 0.02) ImGui::TextColored(sandbox.state().colours().bad, "first and third axis are one line");
    headingRow(sandbox, "THE SAME ROTATION AS A UNIT QUATERNION");
    const Eigen::Quaterniond q = ballRotation(sandbox.session().skeleton(), sandbox.session().q(), joint_);
    valueRow(sandbox, "w, x, y, z",
             fmt::format("{:.5f}, {:.5f}, {:.5f}, {:.5f}", q.w(), q.x(), q.y(), q.z()));
    valueRow(sandbox, "| ||q|| - 1 |", fmt::format("{:.1e}", std::abs(q.norm() - 1.0)));
    headingRow(sandbox, "IN EVERY ORDER, DEGREES");
    for (const EulerOrder& other : eulerOrders()) {
      const Vector3d a = eulerFromRotation(other, q.normalized().toRotationMatrix()) / degree;
      valueRow(sandbox, std::string(other.name), fmt::format("{:.2f}, {:.2f}, {:.2f}", a[0], a[1], a[2]));
    }
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
  const EulerOrder& order() const { return eulerOrders()[order_]; }
  Vector3d anglesOf(Sandbox& sandbox, int joint) {
    const Eigen::Quaterniond q = ballRotation(sandbox.session().skeleton(), sandbox.session().q(), joint);
    const Eigen::Matrix3d R = q.normalized().toRotationMatrix();
    // At the lock the sliders' own angles describe the same rotation better than the convention c = 0.
    if ((rotationFromEuler(order(), typed_[joint]) - R).norm() < 1e-6) return typed_[joint];
    return typed_[joint] = eulerFromRotation(order(), R);
  }
  void setAngles(Sandbox& sandbox, int joint, const Vector3d& angles) {
    typed_[joint] = angles;
    VectorXd q = sandbox.session().q();
    setBallRotation(sandbox.session().skeleton(), q, joint,
                    Eigen::Quaterniond(rotationFromEuler(order(), angles)));
    sandbox.session().setPose(q);
  }

  int joint_ = 0;
  std::size_t order_ = 0;
  std::array<Vector3d, 3> typed_{Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
};

// --- 10.2: Denavit-Hartenberg
// -------------------------------------------------------------------------------------

class DhScene final : public LectureScene {
 public:
  void open(Sandbox& sandbox) override {
    table_ = robotTable("panda");
    rebuild(sandbox);
  }

  void step(Sandbox& sandbox, double) override {
    if (!pending_) return;  // the window's own drawing must be over before the model changes
    pending_ = false;
    rebuild(sandbox);
  }

  bool moves(const Sandbox&) const override { return pending_; }

  void overlay(Sandbox& sandbox) override {
    const VectorXd q = sandbox.session().q();
    if (q.size() != table_.variableCount()) return;
    const Frames K = dhFrames(table_, q);
    const double size = 0.09 * sandbox.state().size();
    const Colour faint = lectureColours(sandbox.theme()).faint,
                 normal = lectureColours(sandbox.theme()).second;
    for (const AxisLine& axis : jointAxes(table_, q))
      sandbox.overlay().dashedLine(axis.point - 2.2 * size * axis.direction,
                                   axis.point + 2.2 * size * axis.direction, 0.25 * size,
                                   {blue.r, blue.g, blue.b, 0.8f}, 2.0f);
    std::vector<std::pair<Vector3d, std::string>> names;
    for (std::size_t i = 0; i + 1 < K.size(); ++i) {
      const Vector3d origin = K[i].translation();
      if (showFrames_) sandbox.overlay().axes(K[i], size, 2.0f);
      const auto same = std::find_if(names.begin(), names.end(),
                                     [&](const auto& n) { return (n.first - origin).norm() < 1e-6; });
      if (same == names.end())
        names.emplace_back(origin, fmt::format("K{}", i + 1));
      else
        same->second += fmt::format(", {}", i + 1);
      if (i + 2 < K.size() && i < table_.rows.size() &&
          std::abs(table_.rows[i].a) > 1e-9) {  // the common normal of length a
        const Vector3d x = table_.convention == DhConvention::Modified ? Vector3d(K[i].linear().col(0))
                                                                       : Vector3d(K[i + 1].linear().col(0));
        const Vector3d from = table_.convention == DhConvention::Modified
                                  ? origin
                                  : Vector3d(K[i + 1].translation() - table_.rows[i].a * x);
        sandbox.overlay().line(from, from + table_.rows[i].a * x, normal, 3.0f);
      }
    }
    for (const auto& [at, text] : names)
      label(sandbox, at + 0.35 * size * Vector3d(1, -1, 1), text,
            faint.r > 0.5f ? Colour{0.95f, 0.95f, 0.95f, 1} : Colour{0.1f, 0.1f, 0.15f, 1});
  }

  void drawInspector(Sandbox& sandbox) override {
    ImGui::SetNextItemWidth(-1);
    if (ImGui::BeginCombo("##robot", table_.name.c_str())) {
      for (const Robot& robot : robots())
        if (ImGui::Selectable(std::string(robot.title).c_str(), robot.name == table_.name))
          change(robot.table());
      ImGui::EndCombo();
    }
    bool modified = table_.convention == DhConvention::Modified;
    if (ImGui::RadioButton("modified (lecture)", modified) && !modified)
      change(toConvention(table_, DhConvention::Modified));
    ImGui::SameLine();
    if (ImGui::RadioButton("standard", !modified) && modified)
      change(toConvention(table_, DhConvention::Standard));
    tooltip("Turns the table into the other convention: the robot stays the same.");
    ImGui::Checkbox("Frames K_i", &showFrames_);
    ImGui::SameLine();
    ImGui::TextColored(sandbox.state().colours().textDim, "%d parameters", parameterCount(table_));
    headingRow(sandbox, "KIND     a [m]        alpha [deg]     d [m]        phi [deg]");
    const float width = (ImGui::GetContentRegionAvail().x - 34 * sandbox.scale()) / 4 - 4 * sandbox.scale();
    DhTable edited = table_;
    bool touched = false;
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {3 * sandbox.scale(), 2 * sandbox.scale()});
    for (std::size_t i = 0; i < edited.rows.size(); ++i) {
      DhRow& row = edited.rows[i];
      ImGui::PushID(static_cast<int>(i));
      const char* kinds[] = {"R", "P", "F"};
      if (ImGui::Button(kinds[static_cast<int>(row.kind)], {26 * sandbox.scale(), 0})) {
        row.kind = static_cast<DhJoint>((static_cast<int>(row.kind) + 1) % 3);
        row.lower = row.kind == DhJoint::Prismatic ? 0.0 : -M_PI;
        row.upper = row.kind == DhJoint::Prismatic ? 0.3 : M_PI;
        if (row.kind == DhJoint::Fixed) row.lower = -unlimited, row.upper = unlimited;
        edited.rest.reset();
        change(edited);
      }
      tooltip("Revolute, prismatic, fixed: click to change");
      const auto number = [&](const char* id, double& value, double unit, float speed, const char* format) {
        ImGui::SameLine(0, 4 * sandbox.scale());
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
        const std::string path = (table_.name.empty() ? "robot" : table_.name) + ".dh";
        writeFile(path, formatDhTable(table_));
        sandbox.say("Wrote " + path);
      } catch (const std::exception& error) {
        sandbox.say(error.what(), true);
      }
    }
    headingRow(sandbox, "TOOL");
    if (sandbox.session().q().size() == table_.variableCount()) {
      const Eigen::Isometry3d tool = dhFrames(table_, sandbox.session().q()).back();
      valueRow(sandbox, "position [m]",
               fmt::format("{:.4f}, {:.4f}, {:.4f}", tool.translation().x(), tool.translation().y(),
                           tool.translation().z()));
      const double apart = (tool.matrix() - sandbox.session().frames().back().matrix()).cwiseAbs().maxCoeff();
      valueRow(sandbox, "matrices against skeleton", fmt::format("{:.1e}", apart));
      tooltip("Product of the slide's matrices against the skeleton that the window drags.");
    }
    ImGui::PushTextWrapPos();
    ImGui::TextColored(
        sandbox.state().colours().textDim,
        "Drag the tool; with Alt its orientation. Blue dashes: joint axes; orange: common normals a.");
    ImGui::PopTextWrapPos();
  }

  std::string derivation(Sandbox& sandbox) override {
    const VectorXd& q = sandbox.session().q();
    return q.size() == table_.variableCount() ? dhDerivation(table_, q) : std::string();
  }

  bool changesModel() const override { return reopening_; }
  /// The table stands in the model's name.
  void load(Sandbox& sandbox, const std::string&) override {
    table_ = *dhTableNamed(sandbox.session().document().model.nameOrFile);
  }

 private:
  /// The model changes before the next frame's solve, not while it is being drawn.
  void change(const DhTable& table) {
    if (table.variableCount() == 0) return;
    table_ = table;
    pending_ = true;
  }
  void rebuild(Sandbox& sandbox) {
    const VectorXd q = sandbox.session().q();
    const Camera camera = sandbox.camera();
    const bool keep = opened_;
    opened_ = true;
    reopening_ = true;  // the Lecture panel then keeps this scene
    sandbox.openModel(dhModel(table_), {.nameOrFile = dhDescription(table_)});
    reopening_ = false;
    if (keep && q.size() == table_.variableCount()) sandbox.session().setPose(q);
    if (keep) sandbox.camera() = camera;
  }

  DhTable table_;
  bool pending_ = false, showFrames_ = true, opened_ = false, reopening_ = false;
};

// --- 10.1.1: hierarchical animation of a leg
// ----------------------------------------------------------------------

class LegScene final : public LectureScene {
 public:
  void open(Sandbox& sandbox) override {
    sandbox.open("figure");
    const Skeleton& figure = sandbox.session().skeleton();
    keyed_ = keyframedLegs(figure, lectureLegKeys());
    pinned_ = pinFeet(figure, keyed_);
    keyedFeet_ = measureFeet(figure, keyed_);
    pinnedFeet_ = measureFeet(figure, pinned_);
    time_ = slide::walkStart;
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
      time_ = std::fmod(time_ + seconds * speed_, keyed_.duration());
      show(sandbox);
    }
    if (sandbox.session().dragged() && usePins_) standFirm(sandbox.session());
  }
  bool moves(const Sandbox& sandbox) const override { return sandbox.playing(); }

  void overlay(Sandbox& sandbox) override {
    const LectureColours colours = lectureColours(sandbox.theme());
    const Skeleton& figure = sandbox.session().skeleton();
    const LegAnimation& shown = usePins_ ? pinned_ : keyed_;
    if (usePins_ && showGhost_)
      sandbox.ghosts().push_back({.worldFromJoint = forwardKinematics(figure, keyed_.q[frame()]),
                                  .tint = {0.85f, 0.35f, 0.25f},
                                  .opacity = 0.45f,
                                  .label = {}});
    for (int side = 0; side < 2; ++side) {
      const bool standing = shown.onGround[frame()][side];
      const auto sole = solePoints(figure, shown.q[frame()], side);
      for (const Vector3d& p : sole)
        sandbox.overlay().point(p,
                                p.y() < -1e-6 ? colours.linear
                                : standing    ? colours.truth
                                              : colours.faint,
                                8.0f);
      Vector3d before = Vector3d::Zero();
      for (std::size_t f = 0; f < shown.q.size();
           ++f) {  // where the ball of the foot stands: one spot, or a smear
        if (static_cast<std::size_t>(frame()) < f) break;
        const Vector3d ball = trail(figure, shown, side, f);
        if (f > 0 && shown.onGround[f][side] && shown.onGround[f - 1][side])
          sandbox.overlay().line(before, ball, usePins_ ? colours.truth : colours.linear, 4.0f);
        if (shown.onGround[f][side])
          sandbox.overlay().point({ball.x(), 0.0, ball.z()}, usePins_ ? colours.truth : colours.linear, 5.0f);
        before = ball;
      }
    }
  }

  void drawInspector(Sandbox& sandbox) override {
    if (ImGui::Button(sandbox.playing() ? "Pause (Space)" : "Play (Space)", {-1, 0}))
      sandbox.setPlaying(!sandbox.playing());
    float seconds = static_cast<float>(time_);
    ImGui::SetNextItemWidth(-46 * sandbox.scale());
    if (ImGui::SliderFloat("time", &seconds, 0.0f, static_cast<float>(keyed_.duration()) - 1e-3f, "%.2f s")) {
      time_ = seconds;
      sandbox.setPlaying(false);
      show(sandbox);
    }
    ImGui::SetNextItemWidth(-46 * sandbox.scale());
    ImGui::SliderFloat("speed", &speed_, 0.05f, 1.5f, "%.2f");
    if (ImGui::Checkbox("Pinned feet: IK on top of the keyframes", &usePins_)) show(sandbox);
    tooltip(
        "A foot on the ground stays where it came down: hip and knee by the two-link closed form, heel and "
        "toes turned out of the ground.");
    ImGui::Checkbox("Keyframes alone as a ghost", &showGhost_);
    const LegKeys keys = lectureLegKeys();
    headingRow(sandbox, "KEYED ANGLES, LEFT LEG, DEGREES");
    const double phase = frame() / keyed_.framesPerSecond / keys.cycle;
    valueRow(sandbox, "hip flexion", fmt::format("{:.1f}", keyedAngle(keys.hip, phase)));
    valueRow(sandbox, "knee flexion", fmt::format("{:.1f}", keyedAngle(keys.knee, phase)));
    valueRow(sandbox, "foot, plantar flexion", fmt::format("{:.1f}", keyedAngle(keys.foot, phase)));
    headingRow(sandbox, "THIS FRAME           LEFT          RIGHT");
    const auto& feet = (usePins_ ? pinnedFeet_ : keyedFeet_)[frame()];
    valueRow(sandbox, "sliding [mm a frame]",
             fmt::format("{:.3f}      {:.3f}", 1e3 * feet[0].sliding, 1e3 * feet[1].sliding));
    valueRow(sandbox, "depth [mm]",
             fmt::format("{:.3f}      {:.3f}", 1e3 * feet[0].penetration, 1e3 * feet[1].penetration));
    headingRow(sandbox, "WHOLE ANIMATION");
    const FootSummary keyed = summarise(keyedFeet_), pinned = summarise(pinnedFeet_);
    valueRow(sandbox, "worst sliding, keyframes", fmt::format("{:.1f} mm a frame", 1e3 * keyed.worstSliding));
    valueRow(sandbox, "worst sliding, pinned", fmt::format("{:.1e} mm", 1e3 * pinned.worstSliding));
    valueRow(sandbox, "worst depth, keyframes", fmt::format("{:.1f} mm", 1e3 * keyed.worstPenetration));
    valueRow(sandbox, "worst depth, pinned", fmt::format("{:.1e} mm", 1e3 * pinned.worstPenetration));
  }

  bool hasPlot() const override { return true; }
  void drawPlot(Sandbox& sandbox) override {
    const Palette& colours = sandbox.state().colours();
    std::vector<Curve> curves(4);
    for (std::size_t f = 0; f < keyedFeet_.size(); ++f) {
      curves[0].values.push_back(1e3 * std::max(keyedFeet_[f][0].penetration, keyedFeet_[f][1].penetration));
      curves[1].values.push_back(1e3 * std::max(keyedFeet_[f][0].sliding, keyedFeet_[f][1].sliding));
      curves[2].values.push_back(1e3 *
                                 std::max(pinnedFeet_[f][0].penetration, pinnedFeet_[f][1].penetration));
      curves[3].values.push_back(1e3 * std::max(pinnedFeet_[f][0].sliding, pinnedFeet_[f][1].sliding));
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
                      .leastCount = static_cast<int>(keyedFeet_.size())},
                     curves, at, size, colours, sandbox.state().gui.fonts(), sandbox.scale());
  }

  std::string derivation(Sandbox&) override {
    return legDerivation(usePins_ ? pinned_ : keyed_, (usePins_ ? pinnedFeet_ : keyedFeet_)[frame()],
                         frame());
  }

  std::string save() const override { return fmt::format("{} {}", time_, usePins_ ? 1 : 0); }
  void load(Sandbox& sandbox, const std::string& text) override {
    int pins = 1;
    if (std::sscanf(text.c_str(), "%lf %d", &time_, &pins) == 2 && time_ >= 0.0 && time_ < keyed_.duration())
      usePins_ = pins != 0;
    sandbox.setPlaying(false);
    show(sandbox);
  }

 private:
  /// Who drags the body while a foot stands pinned finds it pinned.
  void standFirm(Session& session) const {
    for (int side = 0; side < 2; ++side)
      if (const auto foot = session.findGoal(side == 0 ? "foot_l" : "foot_r");
          foot && pinned_.onGround[frame()][side] && session.goal(*foot).state == GoalState::Free)
        session.setState(*foot, GoalState::Pinned);
  }
  int frame() const {
    return std::clamp(static_cast<int>(time_ * keyed_.framesPerSecond), 0,
                      static_cast<int>(keyed_.q.size()) - 1);
  }
  void show(Sandbox& sandbox) {
    for (const SceneGoal& goal : sandbox.session().goals())
      if (goal.handle) sandbox.session().setState(goal.id, GoalState::Free);
    const double before = sandbox.session().q()[2];
    sandbox.session().setPose((usePins_ ? pinned_ : keyed_).q[frame()]);
    sandbox.camera().target.z() += sandbox.session().q()[2] - before;  // the camera walks along
  }
  const Vector3d& trail(const Skeleton& figure, const LegAnimation& shown, int side, std::size_t f) {
    auto& points = trails_[usePins_ ? 1 : 0][side];
    if (points.empty())
      for (const VectorXd& q : shown.q) points.push_back(solePoints(figure, q, side)[1]);
    return points[f];
  }

  LegAnimation keyed_, pinned_;
  std::vector<std::array<FootMeasure, 2>> keyedFeet_, pinnedFeet_;
  std::array<std::array<std::vector<Vector3d>, 2>, 2> trails_;
  double time_ = 0.0;
  float speed_ = 0.5f;
  bool usePins_ = true, showGhost_ = true;
};

}  // namespace

std::unique_ptr<LectureScene> makeRotationsScene() { return std::make_unique<RotationsScene>(); }
std::unique_ptr<LectureScene> makeDhScene() { return std::make_unique<DhScene>(); }
std::unique_ptr<LectureScene> makeLegScene() { return std::make_unique<LegScene>(); }

}  // namespace gelenk
