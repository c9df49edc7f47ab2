#include "apps/commands/arm_path.h"

#include <fmt/format.h>

namespace gelenk {
namespace {

void demandWithinLimits(const SerialChain& chain, const Eigen::VectorXd& start) {
  constexpr double rounding = 1e-9;  // limits are often typed in degrees, a start read from a printed answer
  for (int i = 0; i < chain.n; ++i)
    if (start[i] < chain.lower[i] - rounding || start[i] > chain.upper[i] + rounding)
      throw std::invalid_argument(
          fmt::format("start: joint {} of the arm is at {:.6g}, outside its limits {:.6g} to {:.6g}", i + 1,
                      start[i], chain.lower[i], chain.upper[i]));
}

void addWayFrom(const Eigen::VectorXd& start, double jump, PathPlan& plan) {
  const Eigen::VectorXd way = plan.q.front() - start;
  const double turn = way.cwiseAbs().maxCoeff();
  plan.length += way.norm();
  if (turn > jump)
    plan.jumps.insert(plan.jumps.begin(), {.pose = -1, .turn = turn, .reason = "the start lies so far away"});
  else
    plan.largestStep = std::max(plan.largestStep, turn);
}

}  // namespace

PathPlan planArmPath(const PathPlanner& planner, std::span<const Eigen::Isometry3d> poses,
                     const PathOptions& options, const Eigen::VectorXd* start) {
  if (poses.size() < 2)
    throw std::invalid_argument(fmt::format("a path has two poses at least, found {}", poses.size()));
  if (start) demandWithinLimits(planner.chain(), *start);
  PathPlan plan = planner.plan(poses, options, start);
  if (plan.unreachable) {
    const Eigen::Vector3d p = poses[*plan.unreachable].translation();
    throw NoPath(
        fmt::format("pose {} of {} at ({:.4f}, {:.4f}, {:.4f}) has no solution within limits: no path",
                    *plan.unreachable + 1, poses.size(), p.x(), p.y(), p.z()));
  }
  if (start) addWayFrom(*start, options.jump, plan);
  return plan;
}

}  // namespace gelenk
