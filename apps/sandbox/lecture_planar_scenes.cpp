// Lecture 10.1: scenes in the plane, seen from above.

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <numeric>
#include <optional>

#include "apps/document/chain_models.h"
#include "apps/lecture/derivations.h"
#include "apps/lecture/newton_runs.h"
#include "apps/lecture/slide_data.h"
#include "apps/sandbox/lecture_scene.h"
#include "apps/sandbox/mathematics.h"
#include "apps/sandbox/plots.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/notation/planar_chain.h"
#include "solvers/ceres/nearest_solution.h"
#include "solvers/methods/two_link.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double degree = M_PI / 180.0;
const Vector3d ex = Vector3d::UnitX(), ey = Vector3d::UnitY();

Vector3d inSpace(const Vector2d& p) { return {p.x(), p.y(), 0.0}; }

double reachOf(const PlanarChain& chain) {
  return std::accumulate(chain.lengths.begin(), chain.lengths.end(), 0.0);
}
/// Radius of the hole in the workspace: what the longest link keeps when all others are folded against it.
double holeOf(const PlanarChain& chain) {
  return std::max(0.0, 2.0 * *std::max_element(chain.lengths.begin(), chain.lengths.end()) - reachOf(chain));
}

std::string nameOf(const PlanarChain& chain) {
  std::string name = fmt::format("planar:{:g},{:g}:", chain.base.x(), chain.base.y());
  for (std::size_t i = 0; i < chain.lengths.size(); ++i)
    name += fmt::format("{}{:g}", i ? "," : "", chain.lengths[i]);
  return name;
}

std::string pair(const Vector2d& p, const char* format = "({:.5g}, {:.5g})") {
  return fmt::format(fmt::runtime(format), std::abs(p.x()) < 1e-12 ? 0.0 : p.x(),
                     std::abs(p.y()) < 1e-12 ? 0.0 : p.y());
}

/// What all planar scenes share: the arm, labels at its points. The workspace is shaded by the view itself
/// (marks.cpp).
class PlanarScene : public LectureScene {
 protected:
  explicit PlanarScene(PlanarChain chain) : chain_(std::move(chain)) {}

  void openArm(Sandbox& sandbox, const VectorXd& phi) {
    sandbox.openModel(planarModel(chain_), {.nameOrFile = nameOf(chain_)});
    sandbox.session().setPose(phi);
    sandbox.options().shadow = false;
    const double r = 1.04 * reachOf(chain_);
    frameView(sandbox, Eigen::AlignedBox3d(inSpace(chain_.base) - Vector3d(r, r, 0),
                                           inSpace(chain_.base) + Vector3d(r, r, 0)));
  }

  /// The chain as thin links with dots at the joints.
  void links(Overlay& overlay, const VectorXd& phi, const Colour& colour, float width = 2.5f) const {
    std::vector<Vector3d> points;
    for (const Vector2d& p : linkPoints(chain_, phi)) points.push_back(inSpace(p));
    overlay.polyline(points, colour, width);
    for (std::size_t i = 0; i + 1 < points.size(); ++i) overlay.point(points[i], colour, 7.0f);
    overlay.point(points.back(), colour, 9.0f, Overlay::Shape::Ring);
  }

  /// A cross at a target.
  void cross(Sandbox& sandbox, const Vector2d& at, const std::string& text) const {
    const LectureColours colours = lectureColours(sandbox.theme());
    const double a = 0.022 * reachOf(chain_);
    const Vector3d p = inSpace(at);
    sandbox.overlay().line(p - a * (ex + ey), p + a * (ex + ey), colours.target, 2.5f);
    sandbox.overlay().line(p - a * (ex - ey), p + a * (ex - ey), colours.target, 2.5f);
    label(sandbox, p + 1.4 * a * (ex + ey), text, colours.target);
  }

  static void label(Sandbox& sandbox, const Vector3d& at, const std::string& text, const Colour& c) {
    sandbox.label(at, text, {c.r, c.g, c.b, 1.0f});
  }
  static Colour textColour(Sandbox& sandbox) {
    const ImVec4& c = sandbox.state().colours().text;
    return {c.x, c.y, c.z, 1.0f};
  }

  PlanarChain chain_;
};

// --- 10.1.2: forward kinematics
// -----------------------------------------------------------------------------------

class ForwardScene final : public PlanarScene {
 public:
  ForwardScene()
      : PlanarScene({.base = Vector2d::Zero(),
                     .lengths = {slide::forwardLengths.begin(), slide::forwardLengths.end()}}) {}

  void open(Sandbox& sandbox) override { openArm(sandbox, slide::forwardDegrees * degree); }

  void overlay(Sandbox& sandbox) override {
    const LectureColours colours = lectureColours(sandbox.theme());
    const VectorXd& phi = sandbox.session().q();
    const auto P = linkPoints(chain_, phi);
    const auto K = hierarchicalFrames(chain_, phi);
    double sum = 0.0;
    for (int i = 0; i < chain_.linkCount(); ++i) {  // the angle from the link before, and the frame K_i
      const double radius = 0.28 * chain_.lengths[i];
      sandbox.overlay().dashedLine(inSpace(P[i]),
                                   inSpace(P[i]) + 1.5 * radius * (std::cos(sum) * ex + std::sin(sum) * ey),
                                   0.12 * radius, colours.faint);
      const double turn = std::remainder(phi[i], 2.0 * M_PI);
      sandbox.overlay().arc(inSpace(P[i]), ex, ey, radius, colours.second, 2.0f, std::min(sum, sum + turn),
                            std::max(sum, sum + turn));
      sum += phi[i];
      if (showFrames_) {
        Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
        frame.linear().topLeftCorner<2, 2>() = K[i].linear();
        frame.translation() = inSpace(P[i]);
        const double length = 0.12 * reachOf(chain_);
        sandbox.overlay().line(frame.translation(), frame.translation() + length * frame.linear().col(0),
                               {0.83f, 0.24f, 0.20f, 1}, 2.5f);
        sandbox.overlay().line(frame.translation(), frame.translation() + length * frame.linear().col(1),
                               {0.20f, 0.60f, 0.25f, 1}, 2.5f);
      }
    }
    links(sandbox.overlay(), phi, colours.first);
    for (std::size_t i = 0; i < P.size(); ++i)
      label(
          sandbox,
          inSpace(P[i]) + reachOf(chain_) * (i % 2 ? Vector3d(0.035, 0.045, 0) : Vector3d(0.035, -0.075, 0)),
          fmt::format("{}{} {}", i + 1 < P.size() ? "P" : "X = P", i + 1, pair(P[i], "({:.3f}, {:.3f})")),
          textColour(sandbox));
  }

  void drawInspector(Sandbox& sandbox) override {
    if (ImGui::Button("The slide's pose", {-1, 0})) {
      sandbox.session().remember();
      sandbox.session().setPose(slide::forwardDegrees * degree);
    }
    ImGui::Checkbox("Frames K_i of the hierarchy", &showFrames_);
    headingRow(sandbox, "STATE VECTOR");
    VectorXd phi = sandbox.session().q();
    for (int i = 0; i < chain_.linkCount(); ++i) {
      float angle = static_cast<float>(phi[i] / degree);
      ImGui::SetNextItemWidth(-46 * sandbox.scale());
      const std::string name = fmt::format("phi_{}", i + 1);
      if (ImGui::SliderFloat(("##" + name).c_str(), &angle, -360.0f, 360.0f, "%.1f deg")) {
        phi[i] = angle * degree;
        sandbox.session().setPose(phi);
      }
      mathLabel(name);
    }
    headingRow(sandbox, "POINTS, P_(i+1) = P_i + l_i (cos, sin)(phi_1 + ... + phi_i)");
    const auto P = linkPoints(chain_, sandbox.session().q());
    for (std::size_t i = 0; i < P.size(); ++i)
      valueRow(sandbox, fmt::format("P{}", i + 1), pair(P[i], "({:.6f}, {:.6f})"));
  }

  std::string derivation(Sandbox& sandbox) override {
    return forwardDerivation(chain_, sandbox.session().q());
  }

 private:
  bool showFrames_ = true;
};

// --- 10.1.3: two links
// --------------------------------------------------------------------------------------------

class TwoLinkScene final : public PlanarScene {
 public:
  TwoLinkScene() : PlanarScene({.base = Vector2d::Zero(), .lengths = {slide::armLength, slide::armLength}}) {}

  void open(Sandbox& sandbox) override {
    openArm(sandbox, slide::twoLinkDegrees * degree);
    sandbox.session().setSolver("two-link");
    toTarget(sandbox, slide::armTarget);
  }

  void overlay(Sandbox& sandbox) override {
    const LectureColours colours = lectureColours(sandbox.theme());
    const TwoLinkSolution solution = solve(sandbox);
    const Colour branchColours[] = {colours.second, colours.first};
    for (int i = 0; i < solution.count; ++i) {
      const TwoLinkBranch& b = solution.branch[i];
      links(sandbox.overlay(), Vector2d(b.phi1, b.phi2), branchColours[i], 3.0f);
      label(sandbox, inSpace(linkPoints(chain_, Vector2d(b.phi1, b.phi2))[1]) + Vector3d(0.6, 0.6, 0),
            fmt::format("phi = ({:.1f}, {:.1f}) deg", std::remainder(b.phi1, 2 * M_PI) / degree,
                        b.phi2 / degree),
            branchColours[i]);
    }
    if (showCandidates_)
      for (const ArctangentCandidate& c :
           arctangentCandidates(chain_.base, chain_.lengths[0], chain_.lengths[1], target(sandbox)))
        if (c.distance > 1e-6 && std::isfinite(c.distance)) {
          const auto P = linkPoints(chain_, Vector2d(c.phi1, c.phi2));
          for (int i = 0; i < 2; ++i)
            sandbox.overlay().dashedLine(inSpace(P[i]), inSpace(P[i + 1]), 0.35, colours.linear, 1.5f);
          label(sandbox, inSpace(P[1]) + Vector3d(0.6, -0.8, 0), "arctangent, misses", colours.linear);
        }
    cross(sandbox, target(sandbox), "X " + pair(target(sandbox), "({:.2f}, {:.2f})"));
  }

  void drawInspector(Sandbox& sandbox) override {
    const TwoLinkSolution solution = solve(sandbox);
    if (ImGui::Button("The slide's target (10, 0)", {-1, 0})) {
      sandbox.session().remember();
      toTarget(sandbox, slide::armTarget);
    }
    if (ImGui::Button("Other elbow", {-1, 0}) && solution.count == 2) {
      sandbox.session().remember();
      const double now = sandbox.session().q()[1];
      const TwoLinkBranch& b = solution.branch[now >= 0.0 ? 1 : 0];
      sandbox.session().setPose(Vector2d(b.phi1, b.phi2));
      toTarget(sandbox, target_);
    }
    ImGui::Checkbox("Candidates of the arctangent that miss", &showCandidates_);
    const Vector2d X = target(sandbox);
    headingRow(sandbox, "TARGET");
    valueRow(sandbox, "X", pair(X, "({:.4f}, {:.4f})"));
    valueRow(sandbox, "|X - P1|", fmt::format("{:.5f}", (X - chain_.base).norm()));
    valueRow(sandbox, "reachable", fmt::format("{:g} to {:g}", holeOf(chain_), reachOf(chain_)));
    valueRow(sandbox, "case", toString(solution.kind));
    if (solution.gap > 0) valueRow(sandbox, "distance to the workspace", fmt::format("{:.4g}", solution.gap));
    headingRow(sandbox, "BRANCHES  phi_1, phi_2 in degrees");
    for (const TwoLinkBranch& b : solution.branches())
      valueRow(sandbox, b.exact ? "exact" : "nearest",
               fmt::format("{:.4f}, {:.4f}", std::remainder(b.phi1, 2 * M_PI) / degree, b.phi2 / degree));
  }

  std::string derivation(Sandbox& sandbox) override { return twoLinkDerivation(chain_, target(sandbox)); }

 private:
  Vector2d target(const Sandbox& sandbox) {
    if (const auto goal = sandbox.session().findGoal("end-effector")) {
      const SceneGoal& g = sandbox.session().goal(*goal);
      if (g.state != GoalState::Free) target_ = g.goal.target.head<2>();
    }
    return target_;
  }
  TwoLinkSolution solve(const Sandbox& sandbox) {
    return solveTwoLink(chain_.base, chain_.lengths[0], chain_.lengths[1], target(sandbox));
  }
  void toTarget(Sandbox& sandbox, const Vector2d& X) {
    target_ = X;
    if (const auto goal = sandbox.session().findGoal("end-effector"))
      sandbox.session().setTarget(*goal, inSpace(X));
  }

  Vector2d target_ = slide::armTarget;
  bool showCandidates_ = true;
};

// --- 10.1.4: one dimension
// ----------------------------------------------------------------------------------------

class OneDimensionScene final : public PlanarScene {
 public:
  OneDimensionScene() : PlanarScene({.base = Vector2d::Zero(), .lengths = {slide::armLength}}) {}

  void open(Sandbox& sandbox) override {
    openArm(sandbox, VectorXd::Constant(1, start_));
    restart(sandbox);
  }

  void step(Sandbox& sandbox, double) override {
    if (sandbox.session().dragged()) {  // the arm that is dragged is the new start
      start_ = sandbox.session().q()[0];
      at_ = 0;
      run_ = newton1d(oneLinkHeight, start_, target_, delta_, 1e-13);
    }
  }

  void overlay(Sandbox& sandbox) override {
    const LectureColours colours = lectureColours(sandbox.theme());
    const double r = 1.1 * reachOf(chain_);
    sandbox.overlay().dashedLine({-r, target_, 0}, {r, target_, 0}, 0.3, colours.target, 2.0f);
    label(sandbox, {-r, target_ + 0.5, 0}, fmt::format("height X = {:g}", target_), colours.target);
    for (std::size_t i = 0; i < run_.size() && i <= at_; ++i) {
      const Vector3d end = inSpace(endEffector(chain_, VectorXd::Constant(1, run_[i].phi)));
      const bool now = i == at_;
      sandbox.overlay().line(Vector3d::Zero(), end, now ? colours.first : colours.faint, now ? 3.0f : 1.5f);
      sandbox.overlay().point(end, now ? colours.first : colours.faint, now ? 10.0f : 7.0f);
      label(sandbox, 1.05 * end, fmt::format("phi^{}", i), now ? colours.first : textColour(sandbox));
    }
  }

  void drawInspector(Sandbox& sandbox) override {
    bool changed = false;
    float start = static_cast<float>(start_), target = static_cast<float>(target_);
    ImGui::SetNextItemWidth(-60 * sandbox.scale());
    if (ImGui::SliderFloat("start", &start, -3.1f, 3.1f, "%.3f rad")) start_ = start, changed = true;
    ImGui::SetNextItemWidth(-60 * sandbox.scale());
    if (ImGui::SliderFloat("X", &target, -12.0f, 12.0f, "%.2f")) target_ = target, changed = true;
    tooltip(
        "The height that the end-effector should have. Above l = 10 there is no zero, and the iteration "
        "wanders for ever.");
    int exponent = static_cast<int>(std::lround(std::log10(delta_)));
    ImGui::SetNextItemWidth(-60 * sandbox.scale());
    if (ImGui::SliderInt("Delta", &exponent, -8, -1, "10^%d"))
      delta_ = std::pow(10.0, exponent), changed = true;
    if (ImGui::Button("Converging", {0.5f * ImGui::GetContentRegionAvail().x - 4, 0}))
      start_ = slide::oneLinkStart, target_ = oneLinkTarget, delta_ = 1e-6, changed = true;
    ImGui::SameLine();
    if (ImGui::Button("Diverging", {-1, 0})) start_ = 1.2, target_ = 0.0, delta_ = 1e-6, changed = true;
    if (changed) restart(sandbox);
    const float half = 0.5f * ImGui::GetContentRegionAvail().x - 4;
    if (ImGui::Button("< back", {half, 0}) && at_ > 0) show(sandbox, at_ - 1);
    ImGui::SameLine();
    if (ImGui::Button("Newton step >", {-1, 0}) && at_ + 1 < run_.size()) show(sandbox, at_ + 1);
    headingRow(sandbox, "ITERATION      phi^i            f(phi^i) - X        quotient");
    for (std::size_t i = 0; i < run_.size() && i < 14; ++i) {
      const std::string row = fmt::format("{}{:<3} {:12.8f}    {:11.2e}    {:9.4f}", i == at_ ? "> " : "   ",
                                          i, run_[i].phi, run_[i].g, run_[i].slope);
      ImGui::TextColored(i <= at_ ? sandbox.state().colours().text : sandbox.state().colours().textFaint,
                         "%s", row.c_str());
    }
    std::vector<double> errors;
    for (const NewtonStep1d& s : run_) errors.push_back(s.phi - run_.back().phi);
    errors.pop_back();
    if (std::abs(run_.back().g) < 1e-12)
      valueRow(sandbox, "order of convergence", fmt::format("{:.3f}", convergenceOrder(errors, 1e-11)));
  }

  bool hasPlot() const override { return true; }

  /// f over phi with X, the iterates, and the secants that the difference quotient gives.
  void drawPlot(Sandbox& sandbox) override {
    const Palette& colours = sandbox.state().colours();
    ImDrawList* draw = ImGui::GetWindowDrawList();
    const ImVec2 at = ImGui::GetCursorScreenPos(), size = ImGui::GetContentRegionAvail();
    double low = -M_PI, high = M_PI;
    for (std::size_t i = 0; i <= at_ && i < run_.size(); ++i)
      low = std::min(low, run_[i].phi - 0.3), high = std::max(high, run_[i].phi + 0.3);
    low = std::max(low, -20.0), high = std::min(high, 20.0);
    const auto px = [&](double phi) {
      return at.x + static_cast<float>((phi - low) / (high - low)) * size.x;
    };
    const auto py = [&](double value) { return at.y + size.y * (0.5f - static_cast<float>(value / 26.0)); };
    draw->AddRectFilled(at, {at.x + size.x, at.y + size.y}, colour32(colours.plotBackground),
                        6 * sandbox.scale());
    draw->PushClipRect(at, {at.x + size.x, at.y + size.y}, true);
    draw->AddLine({at.x, py(0)}, {at.x + size.x, py(0)}, colour32(colours.plotGrid), 1.0f);
    draw->AddLine({at.x, py(target_)}, {at.x + size.x, py(target_)}, colour32(colours.bad, 0.8f), 1.5f);
    std::vector<ImVec2> curve;
    for (int i = 0; i <= 300; ++i) {
      const double phi = low + (high - low) * i / 300.0;
      curve.push_back({px(phi), py(oneLinkHeight(phi))});
    }
    draw->AddPolyline(curve.data(), static_cast<int>(curve.size()), colour32(colours.accent), 0,
                      2.0f * sandbox.scale());
    for (std::size_t i = 0; i <= at_ && i < run_.size(); ++i) {
      const NewtonStep1d& s = run_[i];
      const double f = s.g + target_;
      draw->AddCircleFilled({px(s.phi), py(f)}, 4.0f * sandbox.scale(), colour32(colours.held));
      draw->AddLine({px(s.phi), py(target_)}, {px(s.phi), py(f)}, colour32(colours.textFaint), 1.0f);
      if (i + 1 < run_.size() && i < at_)
        draw->AddLine({px(s.phi), py(f)}, {px(run_[i + 1].phi), py(target_)}, colour32(colours.held),
                      1.8f * sandbox.scale());
    }
    draw->PopClipRect();
    draw->AddText({at.x + 8, at.y + 4}, colour32(colours.textDim), "f(phi) = l sin phi, the tangents and X");
    ImGui::Dummy(size);
  }

  std::string derivation(Sandbox&) override { return oneDimensionDerivation(start_, target_, delta_); }

  std::string save() const override { return fmt::format("{} {} {} {}", start_, target_, delta_, at_); }
  void load(Sandbox& sandbox, const std::string& text) override {
    std::size_t at = 0;
    if (std::sscanf(text.c_str(), "%lf %lf %lf %zu", &start_, &target_, &delta_, &at) == 4)
      restart(sandbox), show(sandbox, std::min(at, run_.size() - 1));
  }

 private:
  void restart(Sandbox& sandbox) {
    run_ = newton1d(oneLinkHeight, start_, target_, delta_, 1e-13);
    show(sandbox, 0);
  }
  void show(Sandbox& sandbox, std::size_t i) {
    at_ = i;
    sandbox.session().setPose(VectorXd::Constant(1, run_[i].phi));
  }

  double start_ = slide::oneLinkStart, target_ = oneLinkTarget, delta_ = 1e-6;
  std::vector<NewtonStep1d> run_;
  std::size_t at_ = 0;
};

// --- 10.1.4: several dimensions
// -----------------------------------------------------------------------------------

enum class NewtonExample { Square, PseudoInverse, Shortest };

class NewtonScene final : public PlanarScene {
 public:
  explicit NewtonScene(NewtonExample example)
      : PlanarScene(
            example == NewtonExample::Square
                ? PlanarChain{.base = Vector2d::Zero(), .lengths = {slide::armLength, slide::armLength}}
                : lecturePlanarChain()),
        example_(example) {
    setSlide();
  }

  void open(Sandbox& sandbox) override {
    openArm(sandbox, start_);
    restart(sandbox);
    if (example_ != NewtonExample::Shortest) return;
    at_ = run_.steps.size() - 1;
    sandbox.session().setPose(run_.steps[at_].phi);
  }

  void step(Sandbox& sandbox, double seconds) override {
    Session& session = sandbox.session();
    if (session.dragged()) {
      start_ = session.q();
      run_ = planarNewton(chain_, start_, target_, tolerance());
      best_.reset();
      at_ = 0;
      progress_ = 1.0;
      wasDragged_ = true;
      return;
    }
    if (wasDragged_) {  // let go: the arm stays where it is, nothing holds it
      wasDragged_ = false;
      if (const auto goal = session.findGoal("end-effector")) session.setState(*goal, GoalState::Free);
    }
    if (progress_ >= 1.0) return;
    progress_ = std::min(1.0, progress_ + seconds / 0.6);
    const double s = progress_ * progress_ * (3.0 - 2.0 * progress_);
    session.setPose(VectorXd(from_ + s * (run_.steps[at_].phi - from_)));
  }

  bool moves(const Sandbox&) const override { return progress_ < 1.0; }

  void overlay(Sandbox& sandbox) override {
    const LectureColours colours = lectureColours(sandbox.theme());
    Overlay& over = sandbox.overlay();
    const NewtonStep& now = run_.steps[at_];
    for (std::size_t i = 0; i < at_; ++i) {  // where it came from
      over.point(inSpace(run_.steps[i].f), colours.faint, 7.0f);
      truePath(over, i, colours.faint, 1.5f);
    }
    if (example_ == NewtonExample::Shortest && best().phi.size() > 0)
      links(over, best().phi, colours.truth, 7.0f);
    links(over, now.phi, colours.first, 3.0f);
    if (now.step.size() > 0) {
      links(over, now.phi + now.step, colours.second, 2.0f);
      over.dashedLine(inSpace(now.f), inSpace(now.linearised), 0.018 * reachOf(chain_), colours.linear, 2.5f);
      truePath(over, at_, colours.truth, 2.5f);
      const Vector2d end = run_.steps[at_ + 1].f;
      if (now.step.norm() > 0.05)
        label(sandbox, inSpace(end) + Vector3d(0, -0.05 * reachOf(chain_), 0),
              fmt::format("f(phi^{}) {}", at_ + 1, pair(end, "({:.2f}, {:.2f})")), colours.truth);
    }
    if (now.g.norm() > 0.1 * reachOf(chain_))
      label(sandbox, inSpace(now.f) + Vector3d(-0.02, 0.045, 0) * reachOf(chain_),
            fmt::format("f(phi^{}) {}", at_, pair(now.f, "({:.2f}, {:.2f})")), colours.first);
    cross(sandbox, target_, "X^neu " + pair(target_, "({:g}, {:g})"));
  }

  void drawInspector(Sandbox& sandbox) override {
    const NewtonStep& now = run_.steps[at_];
    const float half = 0.5f * ImGui::GetContentRegionAvail().x - 4;
    if (ImGui::Button("< back", {half, 0}) && at_ > 0) show(sandbox, at_ - 1);
    ImGui::SameLine();
    if (ImGui::Button("Newton step >", {-1, 0}) && at_ + 1 < run_.steps.size()) show(sandbox, at_ + 1);
    tooltip("Takes phi^(i+1) = phi^i - D^+ (f(phi^i) - X). Drag the arm to choose another start.");
    if (ImGui::Button("The slide's example", {half, 0})) {
      setSlide();
      restart(sandbox);
    }
    ImGui::SameLine();
    if (ImGui::Button("X = where the arm is", {-1, 0})) {
      target_ = endEffector(chain_, sandbox.session().q());
      best_.reset();
      restart(sandbox);
    }
    float target[2] = {static_cast<float>(target_.x()), static_cast<float>(target_.y())};
    ImGui::SetNextItemWidth(-46 * sandbox.scale());
    const bool moved =
        ImGui::DragFloat2("##X^neu", target, 0.002f * static_cast<float>(reachOf(chain_)), 0, 0, "%.2f");
    mathLabel("X^neu");
    if (moved) {
      target_ = {target[0], target[1]};
      best_.reset();
      restart(sandbox);
    }
    headingRow(sandbox, fmt::format("STEP {} OF {}   ({})", at_, run_.iterations(), stopText()).c_str());
    matrixRows(sandbox, "phi^i, radians", now.phi.transpose(), "%.5f");
    valueRow(sandbox, "g = f - X", pair(now.g, "({:.4g}, {:.4g})"));
    valueRow(sandbox, "|g|", fmt::format("{:.3e}", now.g.norm()));
    matrixRows(sandbox, "D_f", now.D, "%.2f");
    if (now.Dplus.size() > 0)
      matrixRows(sandbox, chain_.linkCount() == 2 ? "D_f^-1" : "D_f^+", now.Dplus, "%.6f");
    else
      ImGui::TextColored(sandbox.state().colours().bad, "D_f has no inverse here");
    valueRow(sandbox, "singular values",
             fmt::format("{:.4g}, {:.4g}", now.singularValues[0], now.singularValues[1]));
    if (now.step.size() > 0) {
      matrixRows(sandbox, "step", now.step.transpose(), "%.5f");
      const double missed = (run_.steps[at_ + 1].f - now.linearised).norm();
      valueRow(sandbox, "linear function against arm", fmt::format("{:.3g} apart", missed));
    }
    if (example_ == NewtonExample::Shortest) {
      headingRow(sandbox, "THE WHOLE WAY, ||phi_new - phi_old||");
      const double newton = (run_.steps.back().phi - start_).norm();
      valueRow(sandbox, "Newton's end (blue)", fmt::format("{:.7f}", newton));
      valueRow(sandbox, "minimum (green)", fmt::format("{:.7f}", best().distance));
      valueRow(sandbox, "Newton is longer by", fmt::format("{:.4f} %", 100 * (newton / best().distance - 1)));
    }
  }

  bool hasPlot() const override { return true; }
  void drawPlot(Sandbox& sandbox) override {
    Curve curve{.values = {},
                .colour = sandbox.state().colours().accent,
                .width = 2.0f,
                .label = "|g|",
                .dots = true};
    for (const NewtonStep& s : run_.steps) curve.values.push_back(s.g.norm());
    gelenk::drawPlot({.title = "|f(phi^i) - X|",
                      .xLabel = "iteration",
                      .logarithmic = true,
                      .lowest = 1e-12,
                      .highest = 1e2,
                      .leastCount = 6},
                     {curve}, ImGui::GetCursorScreenPos(), ImGui::GetContentRegionAvail(),
                     sandbox.state().colours(), sandbox.state().gui.fonts(), sandbox.scale());
  }

  std::string derivation(Sandbox&) override {
    return example_ == NewtonExample::Shortest
               ? shortestDerivation(chain_, start_, run_.steps.back().phi, best())
               : newtonDerivation(chain_, target_, run_, at_);
  }

  std::string save() const override { return fmt::format("{}", at_); }
  void load(Sandbox& sandbox, const std::string& text) override {
    show(sandbox, std::min<std::size_t>(std::strtoul(text.c_str(), nullptr, 10), run_.steps.size() - 1));
  }

 private:
  void setSlide() {
    if (example_ == NewtonExample::Square) {
      start_ = slide::squareStart;
      target_ = slide::armTarget;
    } else {
      start_ = slide::startAngles;
      target_ = slide::newTarget;
    }
    best_.reset();
  }
  double tolerance() const { return 1e-12 * reachOf(chain_); }
  void restart(Sandbox& sandbox) {
    run_ = planarNewton(chain_, start_, target_, tolerance());
    at_ = 0;
    progress_ = 1.0;
    sandbox.session().setPose(start_);
  }
  void show(Sandbox& sandbox, std::size_t i) {
    at_ = i;
    from_ = sandbox.session().q();
    progress_ = 0.0;
  }
  const char* stopText() const {
    switch (run_.why) {
      case NewtonStop::Converged: return "converged";
      case NewtonStop::Singular: return "singular";
      case NewtonStop::Budget: return "not converged";
      case NewtonStop::NotFinite: return "not finite";
    }
    return "";
  }
  /// The end-effector's real way while phi moves straight from phi^i to phi^(i+1).
  void truePath(Overlay& over, std::size_t i, const Colour& colour, float width) const {
    const NewtonStep& s = run_.steps[i];
    if (s.step.size() == 0) return;
    std::vector<Vector3d> path;
    for (int k = 0; k <= 40; ++k) path.push_back(inSpace(endEffector(chain_, s.phi + s.step * (k / 40.0))));
    over.polyline(path, colour, width);
  }
  const NearestSolution& best() {
    if (!best_) best_ = nearestSolution(chain_, start_, target_, run_.steps.back().phi);
    return *best_;
  }

  NewtonExample example_;
  VectorXd start_, from_;
  Vector2d target_;
  NewtonRun run_;
  std::size_t at_ = 0;
  double progress_ = 1.0;
  bool wasDragged_ = false;
  std::optional<NearestSolution> best_;
};

}  // namespace

std::unique_ptr<LectureScene> makeForwardScene() { return std::make_unique<ForwardScene>(); }
std::unique_ptr<LectureScene> makeTwoLinkScene() { return std::make_unique<TwoLinkScene>(); }
std::unique_ptr<LectureScene> makeOneDimensionScene() { return std::make_unique<OneDimensionScene>(); }
std::unique_ptr<LectureScene> makeNewtonSquareScene() {
  return std::make_unique<NewtonScene>(NewtonExample::Square);
}
std::unique_ptr<LectureScene> makePseudoInverseScene() {
  return std::make_unique<NewtonScene>(NewtonExample::PseudoInverse);
}
std::unique_ptr<LectureScene> makeShortestScene() {
  return std::make_unique<NewtonScene>(NewtonExample::Shortest);
}

}  // namespace gelenk
