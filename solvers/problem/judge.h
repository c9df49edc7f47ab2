#pragma once

#include <vector>

#include "solvers/problem/goal_type.h"
#include "solvers/problem/ik_problem.h"

namespace gelenk {

struct Judgement {
  std::vector<GoalError> goals;  ///< recomputed by forward kinematics outside any solver
  double limitViolation = 0.0;   ///< radians or metres, see configuration.h
  bool finite = false;           ///< q has the right length, no NaN, quaternions of unit length
  bool solved = false;           ///< finite, every goal within the problem's tolerances, limits kept to 1e-9
};

/// The one judge: what is true of q, whoever proposed it. What counts as which error
/// says GoalType::error; preferences (GoalType::judged) are not judged.
Judgement judge(const IkProblem& problem, const Eigen::VectorXd& q);

}  // namespace gelenk
