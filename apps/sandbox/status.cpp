#include <nlohmann/json.hpp>

#include "apps/sandbox/sandbox_state.h"
#include "kinematics/rotation.h"

namespace gelenk {
namespace {

using json = nlohmann::ordered_json;

json point(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }

json goalStatus(const Sandbox::State& s, int index) {
  const SceneGoal& goal = s.session->goals()[index];
  const Eigen::Vector3d reached = s.session->reached(index);
  const Projected p = s.toWindow(reached);
  json entry{{"name", goal.goal.name},
             {"state", toString(goal.state)},
             {"target", point(goal.state == GoalState::Free ? reached : goal.goal.target)},
             {"reached", point(reached)},
             {"error", s.session->error(index)},
             {"pixel", {p.pixel.x(), p.pixel.y()}}};
  if (goal.goal.kind == GoalKind::Pose || goal.goal.kind == GoalKind::Orientation) {
    const Eigen::Quaterniond now(s.session->frames()[goal.goal.joint].linear());
    entry["orientation"] = {goal.goal.orientation.w(), goal.goal.orientation.x(), goal.goal.orientation.y(),
                            goal.goal.orientation.z()};
    entry["orientation_error"] = logRotation(goal.goal.orientation * now.conjugate()).norm();
  }
  return entry;
}

}  // namespace

std::string Sandbox::status() const {
  const State& s = *state_;
  const FrameSolve& solve = s.session->lastSolve();
  json goals = json::array();
  for (int i = 0; i < static_cast<int>(s.session->goals().size()); ++i) goals.push_back(goalStatus(s, i));
  json q = json::array();
  for (Eigen::Index i = 0; i < s.session->q().size(); ++i) q.push_back(s.session->q()[i]);
  json tree{{"frame", s.frameNumber},
            {"renderer", renderer()},
            {"model", s.session->model().name},
            {"solver", s.session->solver()},
            {"q", q},
            {"goals", goals},
            {"dragging", s.session->dragged() ? json(s.session->goals()[*s.session->dragged()].goal.name)
                                              : json(nullptr)},
            {"iterations", solve.iterations},
            {"stop", solve.ran ? json(toString(solve.why)) : json(nullptr)},
            {"error", solve.error},
            {"joint_motion", solve.jointMotion},
            {"view",
             {{"x", s.layout.view.x},
              {"y", s.layout.view.y},
              {"width", s.layout.view.width},
              {"height", s.layout.view.height}}},
            {"mouse", {s.mouse.x(), s.mouse.y()}}};
  for (const auto& panel : s.panels)
    if (const std::string text = panel->status(); !text.empty())
      tree["panels"][panel->name()] = json::parse(text);
  return tree.dump(1) + "\n";
}

}  // namespace gelenk
