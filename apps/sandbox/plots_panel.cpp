#include <fmt/format.h>

#include <cmath>

#include "apps/commands/solver_colour.h"
#include "apps/sandbox/builtin_panels.h"
#include "apps/sandbox/plots.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/configuration.h"
#include "kinematics/rotation.h"
#include "solvers/problem/ik_solver.h"

namespace gelenk {
namespace {

class PlotsPanel final : public Panel {
 public:
  std::string name() const override { return "Plots"; }
  bool hasBottomStrip() const override { return true; }

  void drawBottomStrip(Sandbox& sandbox) override {
    Sandbox::State& s = sandbox.state();
    const ImVec2 at = ImGui::GetCursorScreenPos(), available = ImGui::GetContentRegionAvail();
    const float gap = 10 * s.scale, third = std::floor((available.x - 2 * gap) / 3.0f);
    const ImVec2 size(third, available.y - 2 * s.scale);
    residuals(s, at, size);
    errors(s, {at.x + third + gap, at.y}, size);
    ranges(s, {at.x + 2 * (third + gap), at.y}, size);
    ImGui::Dummy(available);
  }

 private:
  static void hint(ImVec2 at, ImVec2 size, const char* words) {
    if (ImGui::IsMouseHoveringRect(at, {at.x + size.x, at.y + size.y})) showTooltip(words);
  }

  static void residuals(const Sandbox::State& s, ImVec2 at, ImVec2 size) {
    std::vector<Curve> curves;
    for (std::size_t i = 0; i < s.plots.earlier.size(); ++i)
      curves.push_back(
          {.values = s.plots.earlier[i].residuals,
           .colour = toImVec4(solverColour(s.plots.earlier[i].solver), 0.18f + 0.1f * static_cast<float>(i)),
           .width = 1.4f});
    const std::string name = s.session->solver(), title(solverEntry(name).title);
    curves.push_back({.values = s.plots.residuals,
                      .colour = toImVec4(solverColour(name)),
                      .width = 2.0f,
                      .label = ImGui::CalcTextSize(title.c_str()).x < 0.7f * size.x ? title : name,
                      .dots = true});
    drawPlot({.title = "Residual per iteration",
              .xLabel = "iteration",
              .logarithmic = true,
              .lowest = 1e-6,
              .highest = 1.0,
              .leastCount = 6},
             curves, at, size, s.colours(), s.gui.fonts(), s.scale);
    hint(at, size,
         "‖r‖ = √Σ w |target − reached|² before each iteration and after the last: metres and radians alike, "
         "on a logarithmic axis. Faint: the longest frame of the last three drags.");
  }

  static void errors(const Sandbox::State& s, ImVec2 at, ImVec2 size) {
    std::vector<Curve> curves{{.values = s.plots.errors, .colour = s.colours().held, .width = 1.8f}};
    for (double& v : curves[0].values) v *= 1e3;
    drawPlot({.title = "Goal error, mm",
              .xLabel = "frame",
              .logarithmic = true,
              .lowest = 1e-3,
              .highest = 1e2,
              .leastCount = 60},
             curves, at, size, s.colours(), s.gui.fonts(), s.scale);
    hint(at, size,
         "Largest |target − reached| of all goals in each of the last 240 frames, millimetres, recomputed by "
         "forward kinematics outside the solver.");
  }

  static std::vector<RangeRow> rowsOf(const Sandbox::State& s) {
    const Session& session = *s.session;
    const Skeleton& skeleton = session.skeleton();
    const std::vector<bool> atLimit = session.jointsAtLimit();
    int end = s.selectedJoint().value_or(-1);
    if (session.dragged()) end = session.goal(*session.dragged()).goal.joint;
    std::vector<RangeRow> rows;
    for (int i = skeleton.jointCount() - 1; i >= 0; --i) {
      if (end >= 0 && !skeleton.isAncestor(i, end)) continue;
      const Joint& joint = skeleton.joint(i);
      for (std::size_t k = 0; k < joint.axes.size(); ++k) {
        const AxisDof& axis = joint.axes[k];
        if (axis.kind != AxisDof::Kind::Rotation) continue;
        rows.push_back(
            {joint.axes.size() > 1 ? fmt::format("{} {}", joint.name, k + 1) : joint.name,
             session.q()[skeleton.qIndex(i) + static_cast<int>(k)],
             std::isfinite(axis.lower) ? axis.lower : -M_PI, std::isfinite(axis.upper) ? axis.upper : M_PI,
             atLimit[i] &&
                 onBound(session.q()[skeleton.qIndex(i) + static_cast<int>(k)], axis.lower, axis.upper)});
      }
      if (joint.ballLimit) {
        const Eigen::Vector3d c = swingTwistCoordinates(ballRotation(skeleton, session.q(), i));
        const BallLimit& limit = *joint.ballLimit;
        const double swing = (c.head<2>() - limit.swingCentre).cwiseQuotient(limit.swingRadii).norm();
        rows.push_back({joint.name + " swing", swing, 0.0, 1.0, swing > 1.0 - Session::limitMargin});
        rows.push_back({joint.name + " twist", c.z(), limit.twistLower, limit.twistUpper,
                        onBound(c.z(), limit.twistLower, limit.twistUpper)});
      }
    }
    return rows;
  }

  static bool onBound(double value, double lower, double upper) {
    return value <= lower + Session::limitMargin || value >= upper - Session::limitMargin;
  }

  static void ranges(const Sandbox::State& s, ImVec2 at, ImVec2 size) {
    drawRanges("Joints within their limits", rowsOf(s), at, size, s.colours(), s.gui.fonts(), s.scale);
    hint(at, size,
         "Every joint on the way to what is dragged or selected. Axes and twists: the angle between its "
         "lower and upper limit. Swings: 0 in the middle of the cone, 1 on its rim. Red: at the limit.");
  }
};

}  // namespace

std::unique_ptr<Panel> makePlotsPanel() { return std::make_unique<PlotsPanel>(); }

}  // namespace gelenk
