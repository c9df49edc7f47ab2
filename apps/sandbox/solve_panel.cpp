#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "apps/commands/solver_colour.h"
#include "apps/render/mathematics.h"
#include "apps/sandbox/builtin_panels.h"
#include "apps/sandbox/parameter_sliders.h"
#include "apps/sandbox/sandbox_state.h"
#include "apps/sandbox/solver_lessons.h"
#include "kinematics/jacobian.h"
#include "kinematics/rotation.h"
#include "solvers/problem/goal_text.h"

namespace gelenk {
namespace {

/// Singular values of the 3 x nv position Jacobian of a goal's point, descending.
Eigen::Vector3d singularValues(const Session& session, const Goal& goal) {
  const Eigen::Matrix3Xd J =
      pointJacobian(session.skeleton(), session.q(), session.frames(), goal.joint, goal.pointInJoint);
  const Eigen::Matrix3d JJt = J * J.transpose();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(JJt, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .reverse()
      .cwiseMax(0.0)
      .cwiseSqrt();
}

class SolvePanel final : public Panel {
 public:
  std::string name() const override { return "Solve"; }
  bool hasInspector() const override { return true; }

  void drawInspector(Sandbox& sandbox) override {
    solverChoice(sandbox);
    result(sandbox);
    goals(sandbox);
    addGoal(sandbox);
    selected(sandbox);
  }

  /// "goal KIND FIELD=VALUE ..." adds a goal, "add KIND" one as the list does, "balance on" or "balance off".
  void act(Sandbox& sandbox, const std::vector<std::string>& words) override {
    Session& session = *sandbox.state().session;
    if (words.size() == 2 && words[0] == "balance" && (words[1] == "on" || words[1] == "off")) {
      session.setBalance(words[1] == "on");
    } else if (words.size() == 2 && words[0] == "add") {
      addGoalOf(sandbox, goalType(words[1]));
    } else if (words.size() > 1 && words[0] == "goal") {
      std::string text;
      for (std::size_t i = 1; i < words.size(); ++i) text += (i > 1 ? " " : "") + words[i];
      Goal goal = goalFromText(text, session.skeleton(), session.model().masses);
      if (goal.name.empty()) goal.name = goalType(goal.kind).title;
      session.remember();
      const bool pinned = goal.role == Role::Pin;
      const GoalId added = session.addGoal(std::move(goal));
      if (pinned) session.setState(added, GoalState::Pinned);
      sandbox.state().selectedGoal = added;
    } else {
      throw std::invalid_argument("Solve takes 'add KIND', 'goal KIND FIELD=VALUE ...' and 'balance on|off'");
    }
  }

 private:
  static void dot(const ImVec4& colour, float scale) {
    const float size = ImGui::GetTextLineHeight();
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::GetWindowDrawList()->AddCircleFilled({at.x + 5 * scale, at.y + 0.55f * size}, 4.5f * scale,
                                                colour32(colour));
    ImGui::Dummy({12 * scale, size});
    ImGui::SameLine(0, 4 * scale);
  }

  static void solverChoice(Sandbox& sandbox) {
    Sandbox::State& s = sandbox.state();
    heading(sandbox.state(), "SOLVER  (Tab)");
    const std::string current = s.session->solver();
    const SolverEntry& entry = solverEntry(current);
    if (ImGui::BeginCombo("##solver", std::string(entry.title).c_str(), ImGuiComboFlags_HeightLarge)) {
      for (const std::string& name : frameSolverNames())
        solverRow(sandbox, solverEntry(name), name == current);
      ImGui::EndCombo();
    }
    tooltip(
        "The method that follows the goals in every frame. The drag solver keeps its state from frame to "
        "frame; "
        "every other solver starts at the present pose with 20 iterations.");
    ImGui::PushFont(s.gui.fonts().small);
    if (const SolverLesson* lesson = solverLesson(current)) mathItem(std::string(lesson->formula));
    dot(toImVec4(solverColour(current)), s.scale);
    wrappedText(s.colours().textDim, std::string(entry.reference));
    ImGui::PopFont();
    ParameterValues values = s.session->parameters();
    if (parameterSliders(current, entry.parameters, values)) s.session->setParameters(values);
  }

  /// One method of the list; those that cannot do the present goals stand grey, with the reason.
  static void solverRow(Sandbox& sandbox, const SolverEntry& entry, bool isCurrent) {
    Sandbox::State& s = sandbox.state();
    const std::string name(entry.name), why = s.session->whyUnsupported(name);
    const bool wouldDoWithoutPins =
        !why.empty() && s.session->whyUnsupported(name, Session::Pins::Freed).empty();
    dot(toImVec4(solverColour(name)), s.scale);
    ImGui::PushStyleColor(ImGuiCol_Text, why.empty() ? s.colours().text : s.colours().textFaint);
    const auto flags =
        why.empty() || wouldDoWithoutPins ? ImGuiSelectableFlags_None : ImGuiSelectableFlags_Disabled;
    if (ImGui::Selectable(fmt::format("{}##{}", entry.title, name).c_str(), isCurrent, flags))
      chooseSolver(sandbox, name);
    ImGui::PopStyleColor();
    if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
      teach(entry, why.empty()          ? std::string()
                   : wouldDoWithoutPins ? "Not for these goals: " + why + ". A click frees the pins."
                                        : "Not for these goals: " + why);
  }

  /// At the mouse: formula, what it does, where it is from and where more is said.
  static void teach(const SolverEntry& entry, const std::string& whyNot) {
    const SolverLesson* lesson = solverLesson(entry.name);
    std::string words = lesson ? std::string(lesson->sentence) + "\n\n" : std::string();
    words += entry.reference;
    if (lesson) words += fmt::format("\ndocs/solvers/{}.md, --solver {}", lesson->page, entry.name);
    if (!whyNot.empty()) words += "\n\n" + whyNot;
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, ImGui::GetStyle().PopupRounding);
    ImGui::BeginTooltip();
    if (lesson) {
      mathItem(std::string(lesson->formula));
      ImGui::Spacing();
    }
    ImGui::TextUnformatted(brokenAtBlanks(words, ImGui::GetFontSize() * 22.0f).c_str());
    ImGui::EndTooltip();
    ImGui::PopStyleVar();
  }

  static void row(const char* label, const std::string& value, const char* explanation) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(label);
    tooltip(explanation);
    ImGui::TableNextColumn();
    const float width = mathExtent(ImGui::GetFont(), ImGui::GetFontSize(), value).width;
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + std::max(0.0f, ImGui::GetContentRegionAvail().x - width));
    mathItem(value);
    tooltip(explanation);
  }

  static void result(Sandbox& sandbox) {
    Sandbox::State& s = sandbox.state();
    const FrameSolve& solve = s.session->lastSolve();
    heading(sandbox.state(), "THIS FRAME");
    const bool bad = solve.why == Stop::Failure || solve.why == Stop::Unsupported;
    const std::string sentence = describeSolve(*s.session);
    const ImVec4& colour = !solve.ran      ? s.colours().textDim
                           : bad           ? s.colours().bad
                           : solve.reached ? s.colours().good
                                           : s.colours().warning;
    ImGui::PushFont(s.gui.fonts().medium);
    wrappedText(colour, sentence);
    ImGui::PopFont();
    if (solve.why == Stop::Unsupported && solve.ran) {
      if (s.session->whyUnsupported(s.session->solver(), Session::Pins::Freed).empty()) {
        if (ImGui::Button("Free the pins and try")) chooseSolver(sandbox, s.session->solver());
        tooltip("The solver moves one chain; undo (Ctrl+Z) brings the pins back.");
      } else if (ImGui::Button("Back to the drag solver")) {
        s.session->setSolver("drag");
      }
    }
    if (!ImGui::BeginTable("##facts", 2)) return;
    row("Iterations", solve.ran ? std::to_string(solve.iterations) : "–",
        "Steps of the solver in this frame.");
    row("Solve time", solve.ran ? fmt::format("{:.0f} µs", 1e6 * solve.seconds) : "–",
        "Wall-clock time of the solve alone, in microseconds.");
    row("Joint motion", solve.ran ? fmt::format("{:.2g} rad", solve.jointMotion) : "–",
        "Largest change of a joint in this frame, radians (metres for translations).");
    const SceneGoal* goal = goalOfInterest(s);
    const bool measured = goal && hasPoint(goal->goal);
    Eigen::Vector3d sigma = Eigen::Vector3d::Zero();
    if (measured) sigma = singularValues(*s.session, goal->goal);
    const int rank = s.session->model().planar ? 2 : 3;
    row("σ min", measured ? fmt::format("{:.4f}", sigma[rank - 1]) : "–",
        "Smallest singular value of the goal's position Jacobian J (3 x n; 2 x n in the plane): metres a "
        "radian in the direction that moves least. 0 at a singularity.");
    row("Manipulability", measured ? fmt::format("{:.3g}", sigma.head(rank).prod()) : "–",
        "w = √det(J Jt), Jt the transpose of J: the product of the singular values of the goal's position "
        "Jacobian (Yoshikawa "
        "1985): volume of the velocity ellipsoid.");
    ImGui::EndTable();
  }

  static const SceneGoal* goalOfInterest(const Sandbox::State& s) {
    if (s.session->dragged()) return &s.session->goal(*s.session->dragged());
    if (const auto selected = s.goalSelected()) return &s.session->goal(*selected);
    for (const SceneGoal& goal : s.session->goals())
      if (goal.state == GoalState::Held) return &goal;
    return s.session->goals().empty() ? nullptr : &s.session->goals().front();
  }

  static const char* stateWord(GoalState state) {
    switch (state) {
      case GoalState::Free: return "free";
      case GoalState::Held: return "held";
      case GoalState::Dragged: return "drag";
      case GoalState::Pinned: return "pin";
    }
    return "";
  }

  /// Millimetres, or degrees where the goal asks for an angle alone or the angle is what is missed.
  static void showError(const Sandbox::State& s, const SceneGoal& goal) {
    const GoalError error = s.session->judged(goal.id);
    const bool isAngle =
        (error.position == 0.0 && error.orientation > 0.0) ||
        (error.position < s.session->reachedWithin() && error.orientation > Session::reachedAngle);
    const double missed = std::max(error.position, isAngle ? 0.1 * error.orientation : 0.0);
    ImGui::TextColored(toImVec4(distanceColour(markColours(s.theme()), missed)), "%s",
                       isAngle ? fmt::format("{:.2f}°", error.orientation * 180.0 / M_PI).c_str()
                               : formatLength(error.position).c_str());
  }

  static void goals(Sandbox& sandbox) {
    Sandbox::State& s = sandbox.state();
    heading(sandbox.state(), "GOALS");
    std::optional<GoalId> toPin, toFree;
    if (ImGui::BeginTable("##goals", 4, ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingFixedFit)) {
      ImGui::TableSetupColumn("name", ImGuiTableColumnFlags_WidthStretch);
      for (const SceneGoal& goal : s.session->goals()) {
        if (!isGoalShown(sandbox.session(), goal)) continue;
        ImGui::PushID(static_cast<int>(goal.id));
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        const GoalType& type = goalType(goal.goal.kind);
        const ImVec4& colour = goal.state == GoalState::Pinned ? s.colours().pinned
                               : type.preference < 1.0         ? s.colours().pole
                               : goal.state == GoalState::Free ? s.colours().textFaint
                                                               : s.colours().held;
        dot(colour, s.scale);
        if (ImGui::Selectable(goal.goal.name.c_str(), s.selectedGoal == goal.id)) {
          s.selectedGoal = goal.id;
          s.session->selectJoint(goal.goal.joint);
        }
        tooltip(fmt::format("{}: {}", type.title, type.asks).c_str());
        ImGui::TableNextColumn();
        if (goal.state != GoalState::Free) {
          showError(s, goal);
          tooltip(
              "Distance between target and the point reached, by forward kinematics. Poles: distance of the "
              "elbow or knee from the half plane of the pole. Orientation and aim: the angle.");
        }
        ImGui::TableNextColumn();
        if (ImGui::SmallButton(stateWord(goal.state))) toPin = goal.id;
        static const std::string states = fmt::format(
            "Click to pin or free (P). free: goes with the body. held: kept at its target, weight 1 on the "
            "squared error. pin: weight {:g}.",
            pinWeight);
        tooltip(states.c_str());
        ImGui::TableNextColumn();
        if (goal.state == GoalState::Held || !goal.handle) {
          if (ImGui::SmallButton("×")) toFree = goal.id;
          tooltip("Let go (Delete)");
        }
        ImGui::PopID();
      }
      ImGui::EndTable();
    }
    if (toPin) s.session->togglePin(*toPin);
    if (toFree && !s.session->dragged()) {
      s.session->remember();
      s.session->removeGoal(*toFree);
    }
  }

  static bool hasPoint(const Goal& goal) {
    for (const GoalField& field : goalType(goal.kind).fields)
      if (field.meaning == GoalField::Meaning::PointInJoint) return true;
    return false;
  }

  /// On the joint that is selected or the first handle's; it asks for what the model does now.
  static void addGoalOf(Sandbox& sandbox, const GoalType& type) {
    Sandbox::State& s = sandbox.state();
    Session& session = *s.session;
    const int joint =
        session.selectedJoint().value_or(session.goals().empty() ? 0 : session.goals().front().goal.joint);
    int other = 0;  // the next handle on another joint
    for (const SceneGoal& goal : session.goals())
      if (goal.handle && goal.goal.joint != joint && other == 0) other = goal.goal.joint;
    const Edits before = session.edits();
    const GoalId added = session.addGoalOf(type.kind, joint, other);
    session.rememberAs(before);
    s.selectedGoal = added;
  }

  /// One new goal of any kind.
  static void addGoal(Sandbox& sandbox) {
    Session& session = *sandbox.state().session;
    ImGui::SetNextItemWidth(-1);
    if (ImGui::BeginCombo("##add", "Add a goal ...", ImGuiComboFlags_HeightLarge)) {
      for (const GoalType* type : goalTypes()) {
        if (ImGui::Selectable(std::string(type->title).c_str())) try {
            addGoalOf(sandbox, *type);
          } catch (const std::invalid_argument& error) {
            sandbox.say(error.what(), true);
          }
        tooltip(std::string(type->asks).c_str());
      }
      ImGui::EndCombo();
    }
    tooltip("A goal of any kind, on the joint that is selected. It asks for what the model does now.");
    if (!session.canBalance()) return;
    bool balance = session.balance();
    if (ImGui::Checkbox("Balance", &balance)) session.setBalance(balance);
    tooltip("The centre of mass stays over the feet.");
  }

  static bool edit(const Sandbox::State& s, const GoalField& field, int& joint) {
    const Skeleton& skeleton = s.session->skeleton();
    bool changed = false;
    ImGui::SetNextItemWidth(-80 * s.scale);
    if (ImGui::BeginCombo(std::string(field.name).c_str(), skeleton.joint(joint).name.c_str())) {
      for (int i = 0; i < skeleton.jointCount(); ++i)
        if (ImGui::Selectable(skeleton.joint(i).name.c_str(), i == joint)) {
          joint = i;
          changed = true;
        }
      ImGui::EndCombo();
    }
    return changed;
  }
  static bool edit(const Sandbox::State& s, const GoalField& field, double& value) {
    float shown = static_cast<float>(value);
    ImGui::SetNextItemWidth(-80 * s.scale);
    if (!ImGui::DragFloat(std::string(field.name).c_str(), &shown, static_cast<float>(1e-3 * s.size()), 0.0f,
                          1e6f, "%.3f"))
      return false;
    value = std::max(0.0f, shown);
    return true;
  }
  static bool edit(const Sandbox::State& s, const GoalField& field, Eigen::Vector3d& value) {
    float shown[3];
    for (int k = 0; k < 3; ++k) shown[k] = static_cast<float>(value[k]);
    ImGui::SetNextItemWidth(-80 * s.scale);
    if (!ImGui::DragFloat3(std::string(field.name).c_str(), shown, static_cast<float>(1e-3 * s.size()), 0, 0,
                           "%.3f"))
      return false;
    for (int k = 0; k < 3; ++k)
      if (static_cast<float>(value[k]) != shown[k]) value[k] = shown[k];
    return true;
  }
  static bool edit(const Sandbox::State& s, const GoalField& field, Eigen::Quaterniond& value) {
    const Eigen::Vector3d w = logRotation(value) * (180.0 / M_PI);
    float shown[3];
    for (int k = 0; k < 3; ++k) shown[k] = static_cast<float>(w[k]);
    ImGui::SetNextItemWidth(-80 * s.scale);
    if (!ImGui::DragFloat3(std::string(field.name).c_str(), shown, 0.5f, -180.0f, 180.0f, "%.1f°"))
      return false;
    value = expRotation(Eigen::Vector3d(shown[0], shown[1], shown[2]) * (M_PI / 180.0));
    return true;
  }
  static bool edit(const Sandbox::State&, const GoalField& field, Eigen::VectorXd& value) {
    ImGui::Text("%s: %d values", std::string(field.name).c_str(), static_cast<int>(value.size()));
    return false;
  }
  static bool edit(const Sandbox::State&, const GoalField& field, std::vector<Eigen::Vector3d>& value) {
    ImGui::Text("%s: %d corners", std::string(field.name).c_str(), static_cast<int>(value.size()));
    return false;
  }

  static void selected(Sandbox& sandbox) {
    Sandbox::State& s = sandbox.state();
    if (!s.goalSelected()) return;
    const SceneGoal& goal = s.session->goal(*s.selectedGoal);
    const GoalType& type = goalType(goal.goal.kind);
    heading(sandbox.state(), fmt::format("{}", type.title).c_str());
    wrappedText(s.colours().textDim, std::string(type.asks));
    Goal asked = goal.goal;
    bool changed = false;
    for (const GoalField& field : type.fields) {
      ImGui::PushID(field.name.data());
      changed =
          std::visit([&](auto member) { return edit(s, field, asked.*member); }, field.member) || changed;
      if (ImGui::IsItemActivated()) s.session->remember();
      tooltip(fmt::format("{}: {}", field.name, field.explain).c_str());
      ImGui::PopID();
    }
    if (goal.state != GoalState::Free) {
      float weight = static_cast<float>(goal.weight);
      ImGui::SetNextItemWidth(-80 * s.scale);
      const bool moved = valueSlider("weight", weight, 0.05f, 20.0f, "%.2f",
                                     ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
      if (ImGui::IsItemActivated()) s.session->remember();
      tooltip(
          "On the squared error of this goal, times what its state brings (a pin weighs more). A heavier "
          "goal is missed by less where not all can be reached. Default 1.");
      if (moved) s.session->setWeight(goal.id, weight);
    }
    if (changed) try {
        s.session->changeGoal(goal.id, asked);
      } catch (const std::invalid_argument& error) {
        sandbox.say(error.what(), true);
      }
    if (!type.movesWithPose) {
      if (ImGui::SmallButton("As it is now")) {
        s.session->remember();
        Goal now = s.session->goal(goal.id).goal;
        type.capture(now, {s.session->skeleton(), s.session->q(), s.session->frames()});
        s.session->changeGoal(goal.id, now);
      }
      tooltip("Ask for what the model does in this pose.");
    }
    if (goal.goal.kind == GoalKind::Position || goal.goal.kind == GoalKind::Pose) {
      bool oriented = goal.goal.kind == GoalKind::Pose;
      if (ImGui::Checkbox("Keep orientation", &oriented)) {
        s.session->remember();
        if (oriented)
          s.session->setOrientation(goal.id,
                                    Eigen::Quaterniond(s.session->frames()[goal.goal.joint].linear()));
        else
          s.session->clearOrientation(goal.id);
      }
      tooltip(
          "Solve for the orientation of the joint's frame too: the rotation vector of R_target R⁻¹, in "
          "radians, joins the residual.");
    }
  }
};

}  // namespace

std::unique_ptr<Panel> makeSolvePanel() { return std::make_unique<SolvePanel>(); }

}  // namespace gelenk
