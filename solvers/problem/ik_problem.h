#pragma once

#include <Eigen/Core>
#include <vector>

#include "kinematics/skeleton.h"
#include "solvers/problem/goal.h"

namespace gelenk {

/// Find q within the skeleton's limits that meets all goals, beginning at start.
struct IkProblem {
  const Skeleton* skeleton = nullptr;
  Eigen::VectorXd start = {};  ///< nq
  std::vector<Goal> goals = {};
  double positionTolerance = 1e-6;     ///< metres, on the distance itself (not its square)
  double orientationTolerance = 1e-6;  ///< radians, on the angle itself
};

}  // namespace gelenk
