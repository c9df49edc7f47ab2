#include "apps/commands/arm_request.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "kinematics/configuration.h"

namespace gelenk {

using Eigen::VectorXd;

int effectorOf(const Model& model, const std::string& name) {
  if (!name.empty()) return model.skeleton.jointIndex(name);
  std::vector<int> ends;
  for (int i = 0; i < model.skeleton.jointCount(); ++i)
    if (model.skeleton.children(i).empty()) ends.push_back(i);
  if (ends.size() == 1) return ends.front();
  std::string names;
  for (int end : ends) names += (names.empty() ? "" : ", ") + model.skeleton.joint(end).name;
  throw std::invalid_argument(
      fmt::format("'{}' has several ends; choose one with --joint: {}", model.name, names));
}

Goal targetGoal(const std::vector<double>& t, int joint) {
  if (t.size() != 3 && t.size() != 7)
    throw std::invalid_argument(
        fmt::format("--target wants X Y Z or X Y Z QW QX QY QZ, {} values given", t.size()));
  for (double value : t)
    if (!(std::abs(value) <= 1e9))
      throw std::invalid_argument(
          fmt::format("--target wants numbers up to 1e9 in size (metres), found {}", value));
  Goal goal{.joint = joint, .target = {t[0], t[1], t[2]}};
  if (t.size() == 3) return goal;
  goal.kind = GoalKind::Pose;
  goal.orientation = Eigen::Quaterniond(t[3], t[4], t[5], t[6]);
  if (!(std::abs(goal.orientation.norm() - 1.0) < 1e-3))
    throw std::invalid_argument(
        fmt::format("the target's quaternion must have length 1, not {:.6g}", goal.orientation.norm()));
  goal.orientation.normalize();
  return goal;
}

VectorXd startConfiguration(const std::vector<double>& values, const Skeleton& skeleton,
                            const std::string& option) {
  if (values.empty()) return skeleton.rest();
  const std::optional<VectorXd> given = configurationFrom(skeleton, values);
  if (!given)
    throw std::invalid_argument(
        fmt::format("{} needs {} values for this model, {} given", option, skeleton.nq(), values.size()));
  const VectorXd& q = *given;
  if (!q.allFinite()) throw std::invalid_argument(option + " must be finite numbers");
  for (int i = 0; i < skeleton.jointCount(); ++i)
    if (skeleton.joint(i).ball && !(std::abs(ballRotation(skeleton, q, i).norm() - 1.0) < 1e-3))
      throw std::invalid_argument(
          fmt::format("{}: the quaternion of '{}' must have length 1", option, skeleton.joint(i).name));
  return q;
}

}  // namespace gelenk
