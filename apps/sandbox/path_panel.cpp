// A path of the effector, drawn with the mouse in the plane through it that faces the viewer; the joints
// follow it with the fewest jumps (solvers/solutions/path_planner.h).
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/document/model_files.h"
#include "apps/sandbox/builtin_panels.h"
#include "apps/sandbox/plots.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/io/text_file.h"
#include "solvers/solutions/path_planner.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double secondsAPath = 4.0;
constexpr int mostPoses = 240;

class PathPanel final : public Panel {
 public:
  std::string name() const override { return "Path"; }
  bool hasInspector() const override { return true; }
  bool hasBottomStrip() const override { return true; }
  std::string stripTitle() const override { return "Along the path"; }

  void drawInspector(Sandbox& sandbox) override {
    Sandbox::State& s = sandbox.state();
    shownAt_ = sandbox.frameNumber();
    heading(s, "PATH OF THE EFFECTOR");
    const std::string whyNot = plan_.q.empty() ? prepare(sandbox) : std::string();
    ImGui::BeginDisabled(!whyNot.empty());
    ImGui::Checkbox("Draw with the mouse", &drawing_);
    ImGui::EndDisabled();
    tooltip(
        "Press, draw, release: the effector follows the line in the plane through it that faces you, and "
        "keeps its orientation. Fewest jumps first, then least motion (docs/solutions.md).");
    if (!whyNot.empty()) {
      drawing_ = false;
      wrappedText(s.colours().textDim, whyNot);
    } else if (!reason_.empty()) {
      wrappedText(s.colours().warning, reason_);
    }
    if (plan_.q.empty()) return;
    ImGui::Text("%zu poses, %zu jumps, %.3f rad", plan_.q.size(), plan_.jumps.size(), plan_.length);
    for (const PathJump& jump : plan_.jumps)
      wrappedText(s.colours().warning,
                  fmt::format("jump after pose {}: {:.2f} rad; {}", jump.pose + 1, jump.turn, jump.reason));
    int at = pose();
    if (valueSlider("##pose", at, 0, last(), "pose %d")) goTo(sandbox, at);
    if (ImGui::IsItemActivated()) {
      following_ = false;
      sandbox.session().remember();
    }
    if (ImGui::Button(following_ ? "Stop" : "Follow again")) follow(sandbox, !following_);
    ImGui::SameLine();
    if (ImGui::Button("Write as .glb")) write(sandbox, nextFileName(".glb"));
    tooltip("The motion of the whole model, 30 poses a second.");
  }

  void drawBottomStrip(Sandbox& sandbox) override {
    Sandbox::State& s = sandbox.state();
    const ImVec2 at = ImGui::GetCursorScreenPos(), size = ImGui::GetContentRegionAvail();
    std::vector<Curve> curves;
    double most = 1.0;
    for (std::size_t j = 0; !plan_.q.empty() && j < static_cast<std::size_t>(plan_.q[0].size()); ++j) {
      const Colour tint =
          viridis(0.1f + 0.8f * static_cast<float>(j) / static_cast<float>(plan_.q[0].size()));
      Curve curve{.values = {}, .colour = toImVec4(tint), .label = fmt::format("q{}", j + 1)};
      for (const VectorXd& q : plan_.q) curve.values.push_back(q[static_cast<Eigen::Index>(j)]);
      for (const double x : curve.values) most = std::max(most, std::abs(x));
      curves.push_back(std::move(curve));
    }
    drawPlot({.title = plan_.q.empty() ? "Joints along the path: none is drawn yet"
                                       : fmt::format("Joints along the path, rad (pose {}{})", pose() + 1,
                                                     branch_.empty() ? "" : ": " + branch_),
              .xLabel = "pose",
              .lowest = -most,
              .highest = most},
             curves, at, size, s.colours(), s.gui.fonts(), s.scale);
    ImGui::Dummy(size);
  }

  bool takesMouse(const Sandbox& sandbox) const override {
    return drawing_ && sandbox.frameNumber() - shownAt_ <= 1;
  }

  std::string mouseHint() const override {
    return "Draw a line: let go, and the effector follows it · Esc ends it";
  }

  bool pressed(Sandbox& sandbox, const Vector2d& pixel) override {
    Sandbox::State& s = sandbox.state();
    forget();
    reason_ = prepare(sandbox);
    if (!reason_.empty()) return false;
    pointInJoint_ = TeachingPictures::effectorOf(sandbox.session(), s.selectedGoal)->pointInJoint;
    start_ = sandbox.session().frames()[joint_] * pointInJoint_;
    add(sandbox, pixel);
    return true;
  }

  void moved(Sandbox& sandbox, const Vector2d& pixel) override { add(sandbox, pixel); }

  void released(Sandbox& sandbox) override {
    if (drawn_.size() > 1) plan(sandbox);
  }

  void step(Sandbox& sandbox, double dt) override {
    if (!following_) return;
    at_ = std::min(at_ + dt / secondsAPath * last(), static_cast<double>(last()));
    goTo(sandbox, pose());
    following_ = at_ < last();
  }
  double rests(const Sandbox&) const override {
    return following_ ? 0.0 : std::numeric_limits<double>::infinity();
  }

  void overlay(Sandbox& sandbox) override {
    if (drawn_.empty() || sandbox.frameNumber() - shownAt_ > 1) return;
    const MarkColours& colours = markColours(sandbox.theme());
    sandbox.overlay().polyline(drawn_, colours.accent, 2.0f);
    for (const PathJump& jump : plan_.jumps)
      sandbox.overlay().point(poses_[jump.pose] * pointInJoint_, colours.bad, 9.0f, Overlay::Shape::Diamond);
    if (!plan_.q.empty())
      sandbox.overlay().point(poses_[pose()] * pointInJoint_, colours.accent, 9.0f, Overlay::Shape::Disc);
  }

  void opened(Sandbox&, bool) override {
    forget();
    planner_.reset();
    joint_ = -1;
    drawing_ = false;
  }

  bool keyPressed(Sandbox& sandbox, int key, int) override {
    if (key != GLFW_KEY_ESCAPE || !takesMouse(sandbox)) return false;
    drawing_ = false;
    return true;
  }

  /// "draw on|off", "pose N", "follow", "write FILE".
  void act(Sandbox& sandbox, const std::vector<std::string>& words) override {
    if (words.size() == 2 && words[0] == "draw" && (words[1] == "on" || words[1] == "off")) {
      drawing_ = words[1] == "on";
    } else if (words.size() == 2 && words[0] == "pose" && !plan_.q.empty()) {
      const auto n = parseInteger(words[1]);
      if (!n || *n < 0 || *n > last())
        throw std::invalid_argument(
            fmt::format("expected a pose from 0 to {}, found '{}'", last(), words[1]));
      sandbox.session().remember();
      following_ = false;
      goTo(sandbox, *n);
    } else if (words.size() == 1 && words[0] == "follow" && !plan_.q.empty()) {
      follow(sandbox, true);
    } else if (words.size() == 2 && words[0] == "write" && !plan_.q.empty()) {
      write(sandbox, words[1]);
    } else {
      throw std::invalid_argument(
          "Path takes 'draw on|off' and, with a path, 'pose N', 'follow' and 'write FILE'");
    }
  }

  std::string status() const override {
    if (plan_.q.empty() && reason_.empty()) return {};
    return nlohmann::json{{"poses", plan_.q.size()}, {"jumps", plan_.jumps.size()}, {"length", plan_.length},
                          {"pose", pose()},          {"branch", branch_},           {"reason", reason_}}
        .dump();
  }

 private:
  int last() const { return std::max(0, static_cast<int>(plan_.q.size()) - 1); }
  int pose() const { return std::clamp(static_cast<int>(std::lround(at_)), 0, last()); }

  void forget() {
    drawn_.clear();
    poses_.clear();
    plan_ = {};
    reason_.clear();
    branch_.clear();
    following_ = false;
    at_ = 0.0;
  }

  /// The mouse in the plane through the effector that faces the viewer.
  void add(Sandbox& sandbox, const Vector2d& pixel) {
    Sandbox::State& s = sandbox.state();
    const auto place =
        dragTarget(s.camera(), s.viewport(), s.toView(pixel), start_, DragConstraint::ViewPlane);
    if (place && (drawn_.empty() || (*place - drawn_.back()).norm() > 0.004 * s.size()))
      drawn_.push_back(*place);
  }

  /// Why the present effector can follow no line; empty: it can.
  std::string prepare(Sandbox& sandbox) {
    const Session& session = sandbox.session();
    const auto effector = TeachingPictures::effectorOf(session, sandbox.state().selectedGoal);
    if (!effector) return "no goal of a point says which effector is meant";
    if (joint_ == effector->joint) return whyNoPlanner_;
    joint_ = effector->joint;
    whyNoPlanner_.clear();
    planner_.reset();
    try {
      planner_.emplace(session.skeleton(), joint_);
    } catch (const std::invalid_argument& error) {
      whyNoPlanner_ = error.what();
    }
    return whyNoPlanner_;
  }

  void plan(Sandbox& sandbox) {
    Session& session = sandbox.session();
    double length = 0.0;
    std::vector<Isometry3d> keys;
    for (std::size_t k = 0; k < drawn_.size(); ++k) {
      if (k > 0) length += (drawn_[k] - drawn_[k - 1]).norm();
      Isometry3d key = session.frames()[joint_];
      key.translation() = drawn_[k] - key.linear() * pointInJoint_;
      keys.push_back(key);
    }
    const int count = std::clamp(static_cast<int>(length / (0.005 * sandbox.state().size())), 30, mostPoses);
    poses_ = splineThrough(keys, count);
    const SerialChain& chain = planner_->chain();
    VectorXd now(chain.n);
    for (int i = 0; i < chain.n; ++i) now[i] = session.q()[chain.qIndex[i]];
    plan_ = planner_->plan(poses_, {}, &now);
    if (plan_.unreachable) {
      reason_ = fmt::format("no joint angles within limits at {:.0f} % of the path",
                            100.0 * *plan_.unreachable / count);
      plan_ = {};
      return;
    }
    follow(sandbox, true);
    sandbox.showBottomStrip(name());
  }

  void follow(Sandbox& sandbox, bool on) {
    following_ = on;
    if (!on) return;
    at_ = 0.0;
    sandbox.session().remember();
  }

  VectorXd whole(const Sandbox& sandbox, int k) const {
    VectorXd q = sandbox.session().q();
    const SerialChain& chain = planner_->chain();
    for (int i = 0; i < chain.n; ++i) q[chain.qIndex[i]] = plan_.q[k][i];
    sandbox.session().skeleton().couple(q);
    return q;
  }
  void goTo(Sandbox& sandbox, int k) {
    if (k != pose()) at_ = k;
    branch_ = planner_->branchOf(poses_[k], plan_.q[k]);
    sandbox.session().setPose(whole(sandbox, k));
  }

  void write(Sandbox& sandbox, const std::string& path) {
    MotionClip clip;
    clip.framesPerSecond = 30.0;
    clip.q.resize(sandbox.session().skeleton().nq(), static_cast<Eigen::Index>(plan_.q.size()));
    for (int k = 0; k <= last(); ++k) clip.q.col(k) = whole(sandbox, k);
    try {
      const Model& model = sandbox.session().model();
      exportMotion(path, model.skeleton, sandbox.session().skin(), model.name, clip);
      sandbox.say("Wrote " + path);
    } catch (const std::exception& error) {
      sandbox.say(error.what(), true);
    }
  }

  bool drawing_ = false, following_ = false;
  int shownAt_ = -2, joint_ = -1;  ///< the effector's, that planner_ is of
  double at_ = 0.0;                ///< pose
  Vector3d pointInJoint_ = Vector3d::Zero(), start_ = Vector3d::Zero();
  std::vector<Vector3d> drawn_;  ///< world
  std::vector<Isometry3d> poses_;
  std::optional<PathPlanner> planner_;
  std::string whyNoPlanner_;
  PathPlan plan_;
  std::string branch_;  ///< of the pose shown
  std::string reason_;  ///< why there is no motion; empty: nothing amiss
};

}  // namespace

std::unique_ptr<Panel> makePathPanel() { return std::make_unique<PathPanel>(); }

}  // namespace gelenk
