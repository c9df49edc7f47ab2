#pragma once

#include <string>
#include <vector>

#include "solvers/problem/goal_type.h"
#include "solvers/problem/ik_problem.h"
#include "solvers/problem/ik_report.h"

namespace gelenk {

/// Goals of one kind on one joint, each a problem of its own.
struct BatchProblem {
  const Skeleton& skeleton;
  int joint;
  std::vector<Eigen::VectorXd> starts;  ///< nq, within limits or moved there: one for all, or one a goal
  std::vector<Goal> goals;              ///< of one kind
  std::string solver;                   ///< text of a choice
  double tolerance = 1e-6;              ///< metres and radians
  Budget budget;
};
struct BatchAnswer {
  Eigen::VectorXd q;
  Stop why = Stop::Converged;
  GoalError error;
  bool solved = false;
};
/// Poses of a chain under the default solver go side by side through the lanes of the processor
/// (SerialPoseSolver::solveBatch); what stays unsolved, and all else, is solved alone. Every answer is judged
/// by forward kinematics. preparation: seconds before the first target, where wanted.
std::vector<BatchAnswer> solveGoals(const BatchProblem& problem, double* preparation = nullptr);

/// Many targets of one joint, each solved from the same start.
struct BatchRequest {
  const Skeleton& skeleton;
  int joint;
  Eigen::VectorXd start;         ///< nq, within limits or moved there
  std::string targets, answers;  ///< files of comma-separated values; answers "-": standard output
  std::string solver;            ///< text of a choice
  double tolerance = 1e-6;       ///< metres and radians
  Budget budget;
  bool degrees = false;  ///< rotations in the answers
};
struct BatchOutcome {
  int targets = 0, solved = 0;
  double seconds = 0.0;      ///< of everything: reading, solving, judging, writing
  double preparation = 0.0;  ///< seconds before the first target
};

/// Targets: a header x,y,z or x,y,z,qw,qx,qy,qz (or qw,qx,qy,qz) and a row a target, metres and unit
/// quaternions. Answers: row, status, solved, position_error, orientation_error and a column a coordinate,
/// named after its joint. Solved by solveGoals. Throws ParseError with the line for a target that is none.
BatchOutcome solveBatch(const BatchRequest& request);

/// "shoulder", or "shoulder.qw" and "hip.1" where a joint has several: one a coordinate of q.
std::vector<std::string> coordinateNames(const Skeleton& skeleton);
/// True where the coordinate is an angle (not a length, not a part of a quaternion).
std::vector<char> coordinateIsAngle(const Skeleton& skeleton);

}  // namespace gelenk
