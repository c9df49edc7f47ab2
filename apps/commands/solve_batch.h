#pragma once

#include <memory>
#include <string>
#include <vector>

#include "solvers/problem/goal_type.h"
#include "solvers/problem/ik_problem.h"
#include "solvers/problem/ik_report.h"

namespace gelenk {

class SerialPoseSolver;

/// What many problems ask of one joint: positions, orientations or poses, one a target.
struct BatchTargets {
  GoalKind kind = GoalKind::Position;          ///< Position, Orientation or Pose
  std::vector<Eigen::Vector3d> places = {};    ///< of the joint's origin, metres; empty for Orientation
  std::vector<Eigen::Quaterniond> turns = {};  ///< unit; empty for Position
  std::size_t count() const { return kind == GoalKind::Orientation ? turns.size() : places.size(); }
};
/// Targets from rows of 3 (positions), 4 (orientations w, x, y, z), 7 (both) or 16 numbers (4 x 4 matrices,
/// row by row). Throws std::invalid_argument that begins with `what` for numbers that are not finite,
/// quaternions not of length 1 to 1e-3, matrices that are no poses to 1e-6.
BatchTargets targetsFromRows(const double* rows, std::size_t count, int width, const char* what);

/// A chain's solver with its table of starts, which takes some tenths of a second to make: a caller that
/// keeps it has the next batch on that joint without. For one skeleton.
struct BatchMemory {
  int joint = -1;
  std::shared_ptr<const SerialPoseSolver> lanes = {};
};
struct BatchProblem {
  const Skeleton& skeleton;
  int joint;
  Eigen::MatrixXd starts;  ///< nq x 1 for all, or nq x targets; within limits or moved there
  const BatchTargets& targets;
  std::string solver;       ///< text of a choice
  double tolerance = 1e-6;  ///< metres and radians
  Budget budget;
};
struct BatchAnswers {
  Eigen::MatrixXd q;             ///< nq x targets
  std::vector<GoalError> error;  ///< the judge's
  std::vector<Stop> why;
  std::vector<char> solved;
};
/// Poses of a chain under the default solver go side by side through the lanes of the processor
/// (SerialPoseSolver::solveBatch); what stays unsolved, and all else, is solved alone. Every answer is judged
/// by forward kinematics. preparation: seconds before the first target, where wanted. memory: read, and
/// filled where the batch is large enough for a table; the answers' bits do not depend on it.
BatchAnswers solveTargets(const BatchProblem& problem, double* preparation = nullptr,
                          BatchMemory* memory = nullptr);

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
/// named after its joint. Solved by solveTargets. Throws ParseError with the line for a target that is none.
BatchOutcome solveBatch(const BatchRequest& request);

/// "shoulder", or "shoulder.qw" and "hip.1" where a joint has several: one a coordinate of q.
std::vector<std::string> coordinateNames(const Skeleton& skeleton);
/// True where the coordinate is an angle (not a length, not a part of a quaternion).
std::vector<char> coordinateIsAngle(const Skeleton& skeleton);

}  // namespace gelenk
