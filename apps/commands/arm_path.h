#pragma once

#include <span>
#include <stdexcept>
#include <string>

#include "solvers/solutions/path_planner.h"

namespace gelenk {

/// A pose of a path that the arm cannot take; the sentence says which, where and why.
class NoPath : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// The planner's plan, with the way from `start` (where given: of the chain's joints) told as the way between
/// two poses is: in length, largest step, and jumps, where pose -1 is the start. Throws std::invalid_argument
/// for fewer than two poses and a start outside limits, NoPath for a pose without a solution within limits.
PathPlan planArmPath(const PathPlanner& planner, std::span<const Eigen::Isometry3d> poses,
                     const PathOptions& options, const Eigen::VectorXd* start);

}  // namespace gelenk
