#include "apps/render/lab_marks.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "apps/commands/solver_colour.h"
#include "apps/render/scene_view.h"
#include "kinematics/configuration.h"
#include "solvers/problem/judge.h"

namespace gelenk {

std::vector<Eigen::Vector3f> comparedColours(const LabSettings& lab) {
  std::vector<Eigen::Vector3f> colours;
  for (std::size_t i = 0; i < lab.solvers.size(); ++i) {
    Eigen::Vector3f colour = solverColour(lab.solvers[i]);
    for (std::size_t k = 0; k < i; ++k)
      if (solverColour(lab.solvers[k]) == solverColour(lab.solvers[i])) colour *= 0.6f;
    colours.push_back(colour);
  }
  return colours;
}

std::vector<std::string> comparedNames(const LabSettings& lab) {
  std::vector<std::string> names;
  std::map<std::string, int> count;
  for (const std::string& solver : lab.solvers) {
    const std::string name(solverSpec(solver).name);
    const int n = ++count[name];
    names.push_back(n == 1 ? name : fmt::format("{} ({})", name, n));
  }
  return names;
}

void addComparedSolvers(const Session& session, double size, std::vector<Ghost>& ghosts,
                        std::vector<SceneLabel>& labels) {
  const LabSettings& lab = session.document().lab;
  const IkProblem problem = session.problem();
  if (!lab.compare || lab.poses.size() != lab.solvers.size() || problem.goals.empty()) return;
  const std::vector<Eigen::Vector3f> colours = comparedColours(lab);
  const std::vector<std::string> names = comparedNames(lab);
  for (std::size_t i = 0; i < lab.solvers.size(); ++i) {
    const Eigen::VectorXd& q = lab.poses[i];
    if (q.size() != session.q().size()) continue;  // it cannot do these goals
    if (!lab.sideBySide && difference(session.skeleton(), session.q(), q).lpNorm<Eigen::Infinity>() < 5e-3)
      continue;
    Frames frames = forwardKinematics(session.skeleton(), q);
    if (lab.sideBySide) {
      const Eigen::Vector3d right = session.document().view.camera.axes().col(0);
      const double places = (i % 2 == 0 ? -1.0 : 1.0) * (1.0 + static_cast<double>(i / 2));
      for (Eigen::Isometry3d& frame : frames) frame.translation() += places * 0.36 * size * right;
      double error = 0.0;
      for (const GoalError& goal : judge(problem, q).goals) error = std::max(error, goal.position);
      labels.push_back({.at = frames[problem.goals.front().joint].translation(),
                        .text = fmt::format("{}  {:.1f} mm", names[i], 1e3 * error),
                        .colour = {colours[i].x(), colours[i].y(), colours[i].z(), 1.0f},
                        .isName = true});
    }
    ghosts.push_back(
        {.worldFromJoint = std::move(frames), .tint = colours[i], .opacity = lab.sideBySide ? 0.9f : 0.55f});
  }
}

}  // namespace gelenk
