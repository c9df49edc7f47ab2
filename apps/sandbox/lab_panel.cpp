#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <deque>
#include <future>
#include <nlohmann/json.hpp>

#include "apps/commands/reproductions.h"
#include "apps/render/lab_marks.h"
#include "apps/render/label_writer.h"
#include "apps/sandbox/builtin_panels.h"
#include "apps/sandbox/parameter_sliders.h"
#include "apps/sandbox/plots.h"
#include "apps/sandbox/sandbox_state.h"
#include "apps/sandbox/skin_comparison.h"
#include "apps/sandbox/work.h"
#include "kinematics/configuration.h"
#include "solvers/problem/judge.h"

namespace gelenk {
namespace {

using Eigen::VectorXd;

/// One solver that follows the same goals with a pose of its own.
struct Runner {
  std::string solver;  ///< with its parameters
  std::string name;    ///< short
  std::unique_ptr<FrameSolver> method;
  VectorXd q, begin;  ///< now, and when the comparison began
  IkReport report;
  std::string unsupported;
  double error = 0.0, seconds = 0.0, displacement = 0.0;
  std::vector<double> residuals;  ///< of the last frame that iterated
  std::deque<double> errors;      ///< metres, newest last
  Eigen::Vector3f colour = Eigen::Vector3f::Zero();
};

/// Up to four solvers side by side as ghosts on one set of goals.
class LabPanel final : public Panel {
 public:
  static constexpr std::size_t mostSolvers = LabSettings::mostSolvers, history = 240;

  std::string name() const override { return "Lab"; }
  bool hasInspector() const override { return true; }
  bool hasBottomStrip() const override { return true; }
  std::string stripTitle() const override { return "Comparison"; }

  void opened(Sandbox& sandbox, bool) override {
    runners_.clear();
    lab_ = &sandbox.session().lab();
  }

  double rests(const Sandbox&) const override {
    if (moving_) return 0.0;
    return running_.valid() ? 0.1 : std::numeric_limits<double>::infinity();
  }

  void overlay(Sandbox& sandbox) override {
    moving_ = false;
    if (!lab_->compare) return;
    const IkProblem problem = sandbox.session().problem();
    if (runners_.size() != lab_->solvers.size()) build(sandbox);
    if (problem.goals.empty()) return follow(sandbox);
    for (Runner& runner : runners_) {
      const VectorXd before = runner.q;
      solve(runner, problem);
      moving_ = moving_ || difference(*problem.skeleton, before, runner.q).lpNorm<Eigen::Infinity>() > 1e-7;
    }
    lab_->poses.clear();
    for (const Runner& runner : runners_)
      lab_->poses.push_back(runner.unsupported.empty() ? runner.q : VectorXd());
  }

  bool keyPressed(Sandbox& sandbox, int key, int) override {
    if (key != GLFW_KEY_L) return false;
    toggle(sandbox);
    return true;
  }

  void drawMenu(Sandbox& sandbox) override {
    if (ImGui::BeginMenu("Lab")) {
      if (ImGui::MenuItem("Compare solvers", "L", lab_->compare)) toggle(sandbox);
      ImGui::Separator();
      preset(sandbox, "Damping", {"pseudo-inverse", "dls", "sdls", "lm-sugihara"});
      preset(sandbox, "Order", {"lm-gain-ratio", "exact-hessian", "halley", "l-bfgs"});
      preset(sandbox, "Limits", {"pseudo-inverse", "qp", "task-priority", "ceres-lm"});
      ImGui::Separator();
      if (ImGui::BeginMenu("Reproduce")) {
        for (const Reproduction& entry : reproductions())
          if (ImGui::MenuItem(std::string(entry.title).c_str(), nullptr, false, !running_.valid()))
            reproduce(sandbox, std::string(entry.name));
        ImGui::EndMenu();
      }
      ImGui::EndMenu();
    }
    findingsWindow(sandbox);
  }

  void drawInspector(Sandbox& sandbox) override {
    Sandbox::State& s = sandbox.state();
    bool on = lab_->compare;
    if (ImGui::Checkbox("Compare on the same goals", &on)) {
      lab_->compare = on;
      startAgain();
    }
    tooltip(
        "Every chosen solver follows the goals with a pose of its own, 20 iterations a frame from where it "
        "ended; it shows as a tinted ghost.");
    ImGui::Checkbox("Stand side by side", &lab_->sideBySide);
    tooltip("Every solver's pose beside the model instead of through it.");
    std::optional<std::size_t> removed;
    for (std::size_t i = 0; i < lab_->solvers.size(); ++i) {
      ImGui::PushID(static_cast<int>(i));
      chip(toImVec4(colourOf(i)), s.scale);
      ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - 30 * s.scale);
      if (ImGui::BeginCombo("##solver",
                            std::string(solverEntry(solverSpec(lab_->solvers[i]).name).title).c_str(),
                            ImGuiComboFlags_HeightLarge)) {  // by the name that the Solve tab uses
        for (const std::string& solver : frameSolverNames())
          if (ImGui::Selectable(std::string(solverEntry(solver).title).c_str(),
                                solver == solverSpec(lab_->solvers[i]).name)) {
            lab_->solvers[i] = solver;
            startAgain();
          }
        ImGui::EndCombo();
      }
      tooltip(lab_->solvers[i].c_str());
      ImGui::SameLine(0, 4 * s.scale);
      if (ImGui::SmallButton("x") && lab_->solvers.size() > 1) removed = i;
      tooltip("Leaves this solver out");
      SolverSpec spec = solverSpec(lab_->solvers[i]);
      if (!spec.entry->parameters.empty() && ImGui::TreeNode("Parameters")) {
        if (parameterSliders("", spec.entry->parameters, spec.values)) {
          lab_->solvers[i] = toText(spec);
          startAgain();
        }
        ImGui::TreePop();
      }
      ImGui::PopID();
    }
    if (removed) {
      lab_->solvers.erase(lab_->solvers.begin() + static_cast<std::ptrdiff_t>(*removed));
      startAgain();
    }
    if (lab_->solvers.size() < mostSolvers && ImGui::Button("Add a solver")) {
      lab_->solvers.push_back("dls");
      startAgain();
    }
    if (lab_->solvers.size() < mostSolvers) ImGui::SameLine();
    if (ImGui::Button("Start again")) startAgain();
    tooltip("All solvers go back to the pose of the session; displacements count from there.");
    if (lab_->compare) table(s);
    if (!s.session->skin()) return;
    heading(s, "SKINS SIDE BY SIDE");
    drawSkinComparison(sandbox);
  }

  void drawBottomStrip(Sandbox& sandbox) override {
    Sandbox::State& s = sandbox.state();
    const ImVec2 at = ImGui::GetCursorScreenPos(), available = ImGui::GetContentRegionAvail();
    const float gap = 10 * s.scale, half = std::floor((available.x - gap) / 2.0f);
    const ImVec2 size(half, available.y - 2 * s.scale);
    std::vector<Curve> residuals, errors;
    for (const Runner& runner : runners_) {
      Curve residual{.values = runner.residuals,
                     .colour = toImVec4(runner.colour),
                     .width = 2.0f,
                     .label = runner.name,
                     .dots = true};
      residuals.push_back(residual);
      Curve error{.values = {runner.errors.begin(), runner.errors.end()},
                  .colour = toImVec4(runner.colour),
                  .width = 1.8f,
                  .label = runner.name};
      for (double& v : error.values) v *= 1e3;
      errors.push_back(error);
    }
    drawPlot({.title = "Residual per iteration",
              .xLabel = "iteration",
              .logarithmic = true,
              .lowest = 1e-6,
              .highest = 1.0,
              .leastCount = 6},
             residuals, at, size, s.colours(), s.gui.fonts(), s.scale);
    drawPlot({.title = "Goal error, mm",
              .xLabel = "frame",
              .logarithmic = true,
              .lowest = 1e-3,
              .highest = 1e2,
              .leastCount = 60},
             errors, {at.x + half + gap, at.y}, size, s.colours(), s.gui.fonts(), s.scale);
    ImGui::Dummy(available);
  }

 private:
  Eigen::Vector3f colourOf(std::size_t i) const { return comparedColours(*lab_)[i]; }

  static void chip(const ImVec4& colour, float scale) {
    const float size = ImGui::GetFrameHeight();
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::GetWindowDrawList()->AddCircleFilled({at.x + 6 * scale, at.y + 0.5f * size}, 5 * scale,
                                                colour32(colour));
    ImGui::Dummy({12 * scale, size});
    ImGui::SameLine(0, 4 * scale);
  }

  /// All go back to the pose of the session.
  void startAgain() {
    runners_.clear();
    lab_->poses.clear();
  }

  /// From where the document has them, else from its own pose.
  void build(Sandbox& sandbox) {
    runners_.clear();
    const std::vector<std::string> names = comparedNames(*lab_);
    const bool known = lab_->poses.size() == lab_->solvers.size();
    for (std::size_t i = 0; i < lab_->solvers.size(); ++i) {
      Runner& runner = runners_.emplace_back();
      runner.solver = lab_->solvers[i];
      runner.name = names[i];
      runner.method = makeFrameSolver(lab_->solvers[i], sandbox.session().sharedSkeleton());
      runner.q = runner.begin = sandbox.session().q();
      if (known && lab_->poses[i].size() > 0) runner.q = lab_->poses[i];
      runner.colour = colourOf(i);
    }
  }

  void toggle(Sandbox& sandbox) {
    lab_->compare = !lab_->compare;
    startAgain();
    if (!lab_->compare) return;
    sandbox.showInspector(name());
    sandbox.showBottomStrip(name());
  }

  /// Nothing to solve: everybody stands where the session stands.
  void follow(Sandbox& sandbox) {
    for (Runner& runner : runners_) {
      runner.q = runner.begin = sandbox.session().q();
      runner.method->reset();
      runner.displacement = 0.0;
    }
  }

  static void solve(Runner& runner, IkProblem problem) {
    problem.start = runner.q;
    if (!runner.solver.starts_with("drag"))
      runner.unsupported = makeSolver(runner.solver)->whyUnsupported(problem);
    const auto before = std::chrono::steady_clock::now();
    runner.report = runner.method->frame(problem);
    runner.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
    runner.q = runner.report.q;
    runner.displacement = difference(*problem.skeleton, runner.begin, runner.q).norm();
    runner.error = 0.0;
    for (const GoalError& goal : judge(problem, runner.q).goals)
      runner.error = std::max(runner.error, goal.position);
    if (runner.report.counters.iterations > 0) {
      runner.residuals.clear();
      for (const IterationRecord& record : runner.report.trace) runner.residuals.push_back(record.residual);
    }
    runner.errors.push_back(runner.error);
    if (runner.errors.size() > history) runner.errors.pop_front();
  }

  void table(const Sandbox::State& s) const {
    if (!ImGui::BeginTable("##lab", 5, ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingFixedFit)) return;
    ImGui::TableSetupColumn("solver", ImGuiTableColumnFlags_WidthStretch);
    for (const char* title : {"mm", "it.", "µs", "rad"}) ImGui::TableSetupColumn(title);
    ImGui::TableHeadersRow();
    ImGui::PushFont(s.gui.fonts().small);
    for (const Runner& runner : runners_) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::TextColored(inkOf(toImVec4(runner.colour), s.colours()), "%s", runner.name.c_str());
      tooltip(fmt::format("{}\n{}", runner.solver,
                          runner.unsupported.empty()
                              ? std::string("This frame ended: ") + toString(runner.report.why)
                              : runner.unsupported)
                  .c_str());
      const auto cell = [&](const std::string& text, const char* meaning) {
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(runner.unsupported.empty() ? text.c_str() : "–");
        tooltip(meaning);
      };
      cell(runner.error < 5e-7 ? std::string("< 0.001") : fmt::format("{:.3f}", 1e3 * runner.error),
           "Largest distance of a goal's point from its target, millimetres, by forward kinematics.");
      cell(std::to_string(runner.report.counters.iterations), "Iterations in this frame.");
      cell(fmt::format("{:.0f}", 1e6 * runner.seconds), "Time of this frame's solve, microseconds.");
      cell(fmt::format("{:.2f}", runner.displacement),
           "Joint displacement since the comparison began, |difference(start, now)|: radians, metres for "
           "translations.");
    }
    ImGui::PopFont();
    ImGui::EndTable();
  }

  /// Of the solvers those that this build has.
  void preset(Sandbox& sandbox, const char* about, std::vector<std::string> solvers) {
    const std::vector<std::string> known = frameSolverNames();
    std::erase_if(solvers, [&](const auto& name) { return std::ranges::find(known, name) == known.end(); });
    if (!ImGui::MenuItem(fmt::format("{}: {}", about, fmt::join(solvers, ", ")).c_str())) return;
    lab_->solvers = solvers;
    lab_->compare = false;
    toggle(sandbox);
  }

  // ---- experiments from the literature

  void reproduce(Sandbox& sandbox, const std::string& experiment) {
    experiment_ = experiment;
    findings_.reset();
    windowOpen_ = true;
    running_ = startWork([experiment] { return runExperiment(experiment); });
    sandbox.say("Running " + experiment + " ...");
  }

  void findingsWindow(Sandbox& sandbox) {
    if (running_.valid() && running_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
      try {
        findings_ = running_.get();
      } catch (const std::exception& error) {
        sandbox.say(error.what(), true);
        windowOpen_ = false;
      }
    }
    if (!windowOpen_) return;
    const float scale = sandbox.scale();
    ImGui::SetNextWindowSize({760 * scale, 0}, ImGuiCond_Appearing);
    ImGui::SetNextWindowPos({60 * scale, 70 * scale}, ImGuiCond_Appearing);
    if (ImGui::Begin(fmt::format("Reproduce: {}###reproduce", experiment_).c_str(), &windowOpen_,
                     ImGuiWindowFlags_NoCollapse)) {
      if (!findings_)
        ImGui::TextUnformatted("Running ...");
      else
        findingsTable(*findings_);
    }
    ImGui::End();
  }

  static void findingsTable(const Findings& findings) {
    wrappedText(findings.setting + ".");
    ImGui::Spacing();
    if (ImGui::BeginTable("##findings", static_cast<int>(findings.columns.size()),
                          ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp)) {
      for (const std::string& column : findings.columns) ImGui::TableSetupColumn(column.c_str());
      ImGui::TableHeadersRow();
      for (const auto& row : findings.rows) {
        ImGui::TableNextRow();
        for (const std::string& cell : row) {
          ImGui::TableNextColumn();
          ImGui::TextUnformatted(cell.c_str());
        }
      }
      ImGui::EndTable();
    }
    ImGui::Spacing();
    wrappedText("Published: " + findings.published + ".");
    wrappedText("What differs: " + findings.differs + ".");
  }

  LabSettings* lab_ = nullptr;  ///< the document's
  std::vector<Runner> runners_;
  bool moving_ = false;  ///< a solver's pose changed in this frame
  std::string experiment_;
  bool windowOpen_ = false;
  std::future<Findings> running_;
  std::optional<Findings> findings_;
};

}  // namespace

std::unique_ptr<Panel> makeLabPanel() { return std::make_unique<LabPanel>(); }

}  // namespace gelenk
