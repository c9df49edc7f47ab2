// Lecture 10.1: scenes in the plane, seen from above.

#include <fmt/format.h>

#include <algorithm>

#include "apps/document/chain_models.h"
#include "apps/lecture/derivations.h"
#include "apps/lecture/slide_data.h"
#include "apps/lecture/text.h"
#include "apps/render/mathematics.h"
#include "apps/sandbox/derivation_text.h"
#include "apps/sandbox/lecture_scene.h"
#include "apps/sandbox/plots.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/notation/planar_chain.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double degree = M_PI / 180.0;

Vector3d inSpace(const Vector2d& p) { return {p.x(), p.y(), 0.0}; }

/// Radius of the hole in the workspace: what the longest link keeps when all others are folded against it.
double holeOf(const PlanarChain& chain) {
  return std::max(0.0, 2.0 * *std::max_element(chain.lengths.begin(), chain.lengths.end()) - chain.reach());
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

/// What all planar scenes share: the arm. The workspace is shaded by the view itself.
class PlanarScene : public LectureScene {
 protected:
  void openArm(Sandbox& sandbox, const PlanarChain& chain, const VectorXd& phi) {
    sandbox.openModel(planarModel(chain), {.nameOrFile = nameOf(chain)});
    sandbox.session().setPose(phi);
    sandbox.options().shadow = false;
    const double r = 1.04 * chain.reach();
    frameView(sandbox, Eigen::AlignedBox3d(inSpace(chain.base) - Vector3d(r, r, 0),
                                           inSpace(chain.base) + Vector3d(r, r, 0)));
  }
};

// --- 10.1.2: forward kinematics
// -----------------------------------------------------------------------------------

class ForwardScene final : public PlanarScene {
 public:
  LectureDrawing& drawing() override { return drawing_; }
  void open(Sandbox& sandbox) override { openArm(sandbox, drawing_.chain, slide::forwardDegrees * degree); }

  void drawInspector(Sandbox& sandbox) override {
    if (ImGui::Button("The slide's pose", {-1, 0})) {
      sandbox.session().remember();
      sandbox.session().setPose(slide::forwardDegrees * degree);
    }
    ImGui::Checkbox("##frames", &drawing_.frames);
    mathLabel("Frames K_i of the hierarchy");
    headingRow(sandbox, "STATE VECTOR");
    VectorXd phi = sandbox.session().q();
    for (int i = 0; i < drawing_.chain.linkCount(); ++i) {
      float angle = static_cast<float>(phi[i] / degree);
      ImGui::SetNextItemWidth(-46 * sandbox.scale());
      const std::string name = fmt::format("phi_{}", i + 1);
      if (valueSlider(("##" + name).c_str(), angle, -360.0f, 360.0f, "%.1f deg")) {
        phi[i] = angle * degree;
        sandbox.session().setPose(phi);
      }
      mathLabel(name);
    }
    headingRow(sandbox, "POINTS, P_(i+1) = P_i + l_i (cos, sin)(phi_1 + ... + phi_i)");
    const auto P = linkPoints(drawing_.chain, sandbox.session().q());
    std::string rows = text::heads({"", "x", "y"});
    for (std::size_t i = 0; i < P.size(); ++i)
      rows += text::row({fmt::format("P_{}", i + 1), text::fixed(P[i].x(), 6), text::fixed(P[i].y(), 6)});
    drawTable(rows);
  }

  std::string derivation(Sandbox& sandbox) override {
    return forwardDerivation(drawing_.chain, sandbox.session().q());
  }

 private:
  ForwardDrawing drawing_;
};

// --- 10.1.3: two links
// --------------------------------------------------------------------------------------------

class TwoLinkScene final : public PlanarScene {
 public:
  LectureDrawing& drawing() override { return drawing_; }
  void open(Sandbox& sandbox) override {
    openArm(sandbox, drawing_.chain, slide::twoLinkDegrees * degree);
    sandbox.session().setSolver("two-link");
    toTarget(sandbox, slide::armTarget);
  }

  void drawInspector(Sandbox& sandbox) override {
    const TwoLinkSolution solution = drawing_.solve(sandbox.session());
    if (ImGui::Button("The slide's target (10, 0)", {-1, 0})) {
      sandbox.session().remember();
      toTarget(sandbox, slide::armTarget);
    }
    if (ImGui::Button("Other elbow", {-1, 0}) && solution.count == 2) {
      sandbox.session().remember();
      const double now = sandbox.session().q()[1];
      const TwoLinkBranch& b = solution.branch[now >= 0.0 ? 1 : 0];
      sandbox.session().setPose(Vector2d(b.phi1, b.phi2));
      toTarget(sandbox, drawing_.lastTarget);
    }
    ImGui::Checkbox("Candidates of the arctangent that miss", &drawing_.candidates);
    const Vector2d X = drawing_.target(sandbox.session());
    headingRow(sandbox, "TARGET");
    valueRow(sandbox, "X", pair(X, "({:.4f}, {:.4f})"));
    valueRow(sandbox, "|X - P1|", fmt::format("{:.5f}", (X - drawing_.chain.base).norm()));
    valueRow(sandbox, "reachable",
             fmt::format("{:g} to {:g}", holeOf(drawing_.chain), drawing_.chain.reach()));
    valueRow(sandbox, "case", toString(solution.kind));
    if (solution.gap > 0) valueRow(sandbox, "distance to the workspace", fmt::format("{:.4g}", solution.gap));
    headingRow(sandbox, "BRANCHES");
    std::string rows = text::heads({"", "phi_1 [deg]", "phi_2 [deg]"});
    for (const TwoLinkBranch& b : solution.branches())
      rows +=
          text::row({b.exact ? "exact" : "nearest", text::fixed(std::remainder(b.phi1, 2 * M_PI) / degree, 4),
                     text::fixed(b.phi2 / degree, 4)});
    drawTable(rows);
  }

  std::string derivation(Sandbox& sandbox) override {
    return twoLinkDerivation(drawing_.chain, drawing_.target(sandbox.session()));
  }

 private:
  void toTarget(Sandbox& sandbox, const Vector2d& X) {
    drawing_.lastTarget = X;
    if (const auto goal = sandbox.session().findGoal("end-effector"))
      sandbox.session().setTarget(*goal, inSpace(X));
  }

  TwoLinkDrawing drawing_;
};

// --- 10.1.4: one dimension
// ----------------------------------------------------------------------------------------

class OneDimensionScene final : public PlanarScene {
 public:
  LectureDrawing& drawing() override { return drawing_; }

  void open(Sandbox& sandbox) override {
    openArm(sandbox, drawing_.chain, VectorXd::Constant(1, drawing_.start));
    restart(sandbox);
  }

  void step(Sandbox& sandbox, double) override {
    if (!sandbox.session().dragged()) return;
    drawing_.start = sandbox.session().q()[0];  // the arm that is dragged is the new start
    drawing_.restart();
  }

  void drawInspector(Sandbox& sandbox) override {
    bool changed = false;
    float start = static_cast<float>(drawing_.start), target = static_cast<float>(drawing_.target);
    ImGui::SetNextItemWidth(-60 * sandbox.scale());
    if (valueSlider("start", start, -3.1f, 3.1f, "%.3f rad")) drawing_.start = start, changed = true;
    ImGui::SetNextItemWidth(-60 * sandbox.scale());
    if (valueSlider("X", target, -12.0f, 12.0f, "%.2f")) drawing_.target = target, changed = true;
    tooltip(
        "The height that the end-effector should have. Above l = 10 there is no zero, and the iteration "
        "wanders for ever.");
    int exponent = static_cast<int>(std::lround(std::log10(drawing_.delta)));
    ImGui::SetNextItemWidth(-60 * sandbox.scale());
    constexpr const char* powers[] = {"10⁻⁸", "10⁻⁷", "10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²", "10⁻¹"};
    if (valueSlider("Δ", exponent, -8, -1, powers[std::clamp(exponent, -8, -1) + 8]))
      drawing_.delta = std::pow(10.0, exponent), changed = true;
    tooltip("What the difference quotient is taken over.");
    if (ImGui::Button("Converging", {0.5f * ImGui::GetContentRegionAvail().x - 4, 0}))
      drawing_.start = slide::oneLinkStart, drawing_.target = oneLinkTarget, drawing_.delta = 1e-6,
      changed = true;
    ImGui::SameLine();
    if (ImGui::Button("Diverging", {-1, 0}))
      drawing_.start = 1.2, drawing_.target = 0.0, drawing_.delta = 1e-6, changed = true;
    if (changed) restart(sandbox);
    const float half = 0.5f * ImGui::GetContentRegionAvail().x - 4;
    if (ImGui::Button("< back", {half, 0}) && drawing_.at > 0) show(sandbox, drawing_.at - 1);
    ImGui::SameLine();
    if (ImGui::Button("Newton step >", {-1, 0}) && drawing_.at + 1 < drawing_.run.size())
      show(sandbox, drawing_.at + 1);
    headingRow(sandbox, "ITERATION");
    std::string rows = text::heads({"i", "phi^i", "f(phi^i) - X", "quotient"});
    for (std::size_t i = 0; i < drawing_.run.size() && i < 14; ++i)
      rows += text::row({std::to_string(i), text::fixed(drawing_.run[i].phi, 6),
                         text::scientific(drawing_.run[i].g, 2), text::fixed(drawing_.run[i].slope, 4)});
    drawTable(rows, static_cast<int>(drawing_.at) + 1);
    std::vector<double> errors;
    for (const NewtonStep1d& s : drawing_.run) errors.push_back(s.phi - drawing_.run.back().phi);
    errors.pop_back();
    if (std::abs(drawing_.run.back().g) < 1e-12)
      valueRow(sandbox, "order of convergence", fmt::format("{:.3f}", convergenceOrder(errors, 1e-11)));
  }

  bool hasPlot() const override { return true; }

  /// f over phi with X, the iterates, and the secants that the difference quotient gives.
  void drawPlot(Sandbox& sandbox) override {
    const Palette& colours = sandbox.state().colours();
    const float scale = sandbox.scale();
    ImFont* small = sandbox.state().gui.fonts().small;
    ImDrawList* draw = ImGui::GetWindowDrawList();
    const ImVec2 corner = ImGui::GetCursorScreenPos(), whole = ImGui::GetContentRegionAvail();
    fillRounded(*draw, corner, {corner.x + whole.x, corner.y + whole.y}, colour32(colours.plotBackground),
                6 * scale);
    const auto write = [&](float x, float y, float share,
                           const std::string& text) {  // of its width lies left of x
      const float width = mathExtent(small, small->FontSize, text).width;
      drawMathematics(*draw, small, small->FontSize, {x - share * width, y}, colour32(colours.textDim), text);
    };
    write(corner.x + 10 * scale, corner.y + 6 * scale, 0.0f, "f(phi) = l sin phi, the tangents and X");
    const ImVec2 at{corner.x + 36 * scale, corner.y + small->FontSize + 11 * scale},
        size{whole.x - 44 * scale, whole.y - 2 * small->FontSize - 19 * scale};
    double low = -M_PI, high = M_PI;
    for (std::size_t i = 0; i <= drawing_.at && i < drawing_.run.size(); ++i)
      low = std::min(low, drawing_.run[i].phi - 0.3), high = std::max(high, drawing_.run[i].phi + 0.3);
    low = std::max(low, -20.0), high = std::min(high, 20.0);
    const auto px = [&](double phi) {
      return at.x + static_cast<float>((phi - low) / (high - low)) * size.x;
    };
    const auto py = [&](double value) { return at.y + size.y * (0.5f - static_cast<float>(value / 24.0)); };
    for (const int value : {-10, -5, 0, 5, 10}) {
      const float y = std::round(py(value)) + 0.5f;
      draw->AddLine({at.x, y}, {at.x + size.x, y}, colour32(value == 0 ? colours.border : colours.plotGrid),
                    1.0f);
      write(at.x - 6 * scale, y - 0.55f * small->FontSize, 1.0f, std::to_string(value));
    }
    const double tick = high - low < 4.0 * M_PI ? 0.5 : high - low < 9.0 * M_PI ? 1.0 : 2.0;  // pi
    for (double n = std::ceil(low / M_PI / tick) * tick; n * M_PI <= high; n += tick) {
      const float x = std::round(px(n * M_PI)) + 0.5f;
      draw->AddLine({x, at.y + size.y}, {x, at.y + size.y + 3 * scale}, colour32(colours.border), 1.0f);
      const double halves = std::round(2.0 * n);
      const bool isWhole = std::fmod(halves, 2.0) == 0.0;
      const double count = isWhole ? 0.5 * halves : halves;  // of pi or of pi/2
      write(x, at.y + size.y + 4 * scale, 0.5f,
            count == 0.0 ? "0"
                         : (count < 0.0 ? "-" : "") +
                               (std::abs(count) == 1.0 ? "" : fmt::format("{:g} ", std::abs(count))) +
                               (isWhole ? "pi" : "pi/2"));
    }
    draw->PushClipRect(at, {at.x + size.x, at.y + size.y}, true);
    draw->AddLine({at.x, py(drawing_.target)}, {at.x + size.x, py(drawing_.target)},
                  colour32(colours.bad, 0.8f), 1.5f * scale);
    std::vector<ImVec2> curve;
    for (int i = 0; i <= 300; ++i) {
      const double phi = low + (high - low) * i / 300.0;
      curve.push_back({px(phi), py(oneLinkHeight(phi))});
    }
    draw->AddPolyline(curve.data(), static_cast<int>(curve.size()), colour32(colours.accent), 0,
                      2.0f * scale);
    for (std::size_t i = 0; i <= drawing_.at && i < drawing_.run.size(); ++i) {
      const NewtonStep1d& s = drawing_.run[i];
      const double f = s.g + drawing_.target;
      draw->AddCircleFilled({px(s.phi), py(f)}, 4.0f * scale, colour32(colours.held));
      draw->AddLine({px(s.phi), py(drawing_.target)}, {px(s.phi), py(f)}, colour32(colours.textFaint), 1.0f);
      if (i + 1 < drawing_.run.size() && i < drawing_.at)
        draw->AddLine({px(s.phi), py(f)}, {px(drawing_.run[i + 1].phi), py(drawing_.target)},
                      colour32(colours.held), 1.8f * scale);
    }
    draw->PopClipRect();
    ImGui::Dummy(whole);
  }

  std::string derivation(Sandbox&) override {
    return oneDimensionDerivation(drawing_.start, drawing_.target, drawing_.delta);
  }

  void taken(Sandbox& sandbox) override { show(sandbox, drawing_.at); }

 private:
  void restart(Sandbox& sandbox) {
    drawing_.restart();
    show(sandbox, 0);
  }
  void show(Sandbox& sandbox, std::size_t i) {
    drawing_.at = i;
    sandbox.session().setPose(VectorXd::Constant(1, drawing_.run[i].phi));
  }

  OneDimensionDrawing drawing_;
};

// --- 10.1.4: several dimensions
// -----------------------------------------------------------------------------------

class NewtonScene final : public PlanarScene {
 public:
  explicit NewtonScene(NewtonExample example) : drawing_(example) {}
  LectureDrawing& drawing() override { return drawing_; }

  void open(Sandbox& sandbox) override {
    openArm(sandbox, drawing_.chain, drawing_.start);
    sandbox.session().setPose(drawing_.run.steps[drawing_.at].phi);
  }

  void step(Sandbox& sandbox, double seconds) override {
    Session& session = sandbox.session();
    if (session.dragged()) {
      drawing_.start = session.q();
      drawing_.restart();
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
    session.setPose(VectorXd(from_ + s * (drawing_.run.steps[drawing_.at].phi - from_)));
  }

  bool moves(const Sandbox&) const override { return progress_ < 1.0; }

  void drawInspector(Sandbox& sandbox) override {
    const float half = 0.5f * ImGui::GetContentRegionAvail().x - 4;
    if (ImGui::Button("< back", {half, 0}) && drawing_.at > 0) show(sandbox, drawing_.at - 1);
    ImGui::SameLine();
    if (ImGui::Button("Newton step >", {-1, 0}) && drawing_.at + 1 < drawing_.run.steps.size())
      show(sandbox, drawing_.at + 1);
    tooltip("Takes phi^(i+1) = phi^i - D^+ (f(phi^i) - X). Drag the arm to choose another start.");
    if (ImGui::Button("The slide's example", {half, 0})) {
      drawing_.setSlide();
      restart(sandbox);
    }
    ImGui::SameLine();
    if (ImGui::Button("X = where the arm is", {-1, 0})) {
      drawing_.target = endEffector(drawing_.chain, sandbox.session().q());
      restart(sandbox);
    }
    float target[2] = {static_cast<float>(drawing_.target.x()), static_cast<float>(drawing_.target.y())};
    ImGui::SetNextItemWidth(-46 * sandbox.scale());
    const bool moved = ImGui::DragFloat2("##X^neu", target,
                                         0.002f * static_cast<float>(drawing_.chain.reach()), 0, 0, "%.2f");
    mathLabel("X^neu");
    if (moved) {
      drawing_.target = {target[0], target[1]};
      restart(sandbox);
    }
    const NewtonStep& now = drawing_.run.steps[drawing_.at];
    headingRow(
        sandbox,
        fmt::format("STEP {} OF {}   ({})", drawing_.at, drawing_.run.iterations(), stopText()).c_str());
    matrixRows(sandbox, "phi^i, radians", now.phi.transpose(), "%.5f");
    valueRow(sandbox, "g = f - X", pair(now.g, "({:.4g}, {:.4g})"));
    valueRow(sandbox, "|g|", fmt::format("{:.4g}", now.g.norm()));
    matrixRows(sandbox, "D_f", now.D, "%.2f");
    if (now.Dplus.size() > 0)
      matrixRows(sandbox, drawing_.chain.linkCount() == 2 ? "D_f^-1" : "D_f^+", now.Dplus, "%.6f");
    else
      ImGui::TextColored(sandbox.state().colours().bad, "D_f has no inverse here");
    valueRow(sandbox, "singular values",
             fmt::format("{:.4g}, {:.4g}", now.singularValues[0], now.singularValues[1]));
    if (now.step.size() > 0) {
      matrixRows(sandbox, "step", now.step.transpose(), "%.5f");
      const double missed = (drawing_.run.steps[drawing_.at + 1].f - now.linearised).norm();
      valueRow(sandbox, "linear function against arm", fmt::format("{:.3g} apart", missed));
    }
    if (drawing_.example == NewtonExample::Shortest) {
      headingRow(sandbox, "THE WHOLE WAY, ||phi_new - phi_old||");
      const double newton = (drawing_.run.steps.back().phi - drawing_.start).norm();
      valueRow(sandbox, "Newton's end (blue)", fmt::format("{:.7f}", newton));
      valueRow(sandbox, "minimum (green)", fmt::format("{:.7f}", drawing_.best().distance));
      valueRow(sandbox, "Newton is longer by",
               fmt::format("{:.4f} %", 100 * (newton / drawing_.best().distance - 1)));
    }
  }

  bool hasPlot() const override { return true; }
  void drawPlot(Sandbox& sandbox) override {
    Curve curve{.values = {}, .colour = sandbox.state().colours().accent, .width = 2.0f, .dots = true};
    for (const NewtonStep& s : drawing_.run.steps) curve.values.push_back(s.g.norm());
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
    return drawing_.example == NewtonExample::Shortest
               ? shortestDerivation(drawing_.chain, drawing_.start, drawing_.run.steps.back().phi,
                                    drawing_.best())
               : newtonDerivation(drawing_.chain, drawing_.target, drawing_.run, drawing_.at);
  }

  void taken(Sandbox& sandbox) override { show(sandbox, drawing_.at); }

 private:
  void restart(Sandbox& sandbox) {
    drawing_.restart();
    progress_ = 1.0;
    sandbox.session().setPose(drawing_.start);
  }
  void show(Sandbox& sandbox, std::size_t i) {
    drawing_.at = i;
    from_ = sandbox.session().q();
    progress_ = 0.0;
  }
  const char* stopText() const {
    switch (drawing_.run.why) {
      case NewtonStop::Converged: return "converged";
      case NewtonStop::Singular: return "singular";
      case NewtonStop::Budget: return "not converged";
      case NewtonStop::NotFinite: return "not finite";
    }
    return "";
  }

  NewtonDrawing drawing_;
  VectorXd from_;
  double progress_ = 1.0;
  bool wasDragged_ = false;
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
