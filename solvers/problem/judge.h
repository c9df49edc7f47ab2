#pragma once

#include <vector>

#include "solvers/problem/ik_problem.h"

namespace gelenk {

/// Errors of one goal, recomputed by forward kinematics outside any solver.
struct GoalError {
  double position = 0.0;     ///< metres; 0 where the goal has no position part
  double orientation = 0.0;  ///< radians; 0 where the goal has no orientation part
};

struct Judgement {
  std::vector<GoalError> goals;
  double limitViolation = 0.0;  ///< radians or metres, see configuration.h
  bool finite = false;          ///< q has the right length, no NaN, quaternions of unit length
  bool solved = false;          ///< finite, every goal within the problem's tolerances, limits kept to 1e-9
};

/// The one judge: what is true of q, whoever proposed it. Aim counts as orientation, Pole as position;
/// Posture goals are preferences and are not judged.
Judgement judge(const IkProblem& problem, const Eigen::VectorXd& q);

}  // namespace gelenk
