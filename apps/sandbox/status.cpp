#include <nlohmann/json.hpp>

#include "apps/sandbox/sandbox_state.h"

namespace gelenk {
namespace {

using json = nlohmann::ordered_json;

json point(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }

json goalStatus(const Sandbox::State& s, const SceneGoal& goal) {
  const Eigen::Vector3d reached = s.session->reached(goal.id);
  const GoalError error = s.session->judged(goal.id);
  const Projected p = s.toWindow(reached);
  json entry{{"name", goal.goal.name},
             {"state", toString(goal.state)},
             {"target", point(goal.state == GoalState::Free ? reached : goal.goal.target)},
             {"reached", point(reached)},
             {"error", error.position},
             {"pixel", {p.pixel.x(), p.pixel.y()}}};
  if (goal.goal.kind == GoalKind::Pose || goal.goal.kind == GoalKind::Orientation) {
    entry["orientation"] = {goal.goal.orientation.w(), goal.goal.orientation.x(), goal.goal.orientation.y(),
                            goal.goal.orientation.z()};
  }
  if (error.orientation > 0.0) entry["orientation_error"] = error.orientation;
  return entry;
}

}  // namespace

std::string Sandbox::status() const {
  const State& s = *state_;
  const FrameSolve& solve = s.session->lastSolve();
  json goals = json::array();
  for (const SceneGoal& goal : s.session->goals()) goals.push_back(goalStatus(s, goal));
  json q = json::array();
  for (Eigen::Index i = 0; i < s.session->q().size(); ++i) q.push_back(s.session->q()[i]);
  json tree{{"frame", s.frameNumber},
            {"renderer", renderer()},
            {"model", s.session->model().name},
            {"solver", s.session->solver()},
            {"q", q},
            {"goals", goals},
            {"dragging",
             s.session->dragged() ? json(s.session->goal(*s.session->dragged()).goal.name) : json(nullptr)},
            {"iterations", solve.iterations},
            {"stop", solve.ran ? json(toString(solve.why)) : json(nullptr)},
            {"error", solve.error},
            {"orientation_error", solve.orientationError},
            {"reached", solve.ran && solve.reached},
            {"joint_motion", solve.jointMotion},
            {"view",
             {{"x", s.layout.view.x},
              {"y", s.layout.view.y},
              {"width", s.layout.view.width},
              {"height", s.layout.view.height}}},
            {"mouse", {s.mouse.x(), s.mouse.y()}}};
  tree["example"] = document().lecture.topic;
  tree["recording"] = s.recorder.isRunning();
  json shown = json::array();
  for (const ViewOptionName& option : viewOptionNames())
    if (s.session->document().view.show.*option.option) shown.push_back(option.name);
  tree["shown"] = shown;
  for (const auto& panel : s.panels)
    if (const std::string text = panel->status(); !text.empty())
      tree["panels"][panel->name()] = json::parse(text);
  return tree.dump(1) + "\n";
}

}  // namespace gelenk
