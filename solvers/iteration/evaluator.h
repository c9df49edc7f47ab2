#pragma once

#include <Eigen/Core>
#include <chrono>
#include <optional>
#include <vector>

#include "kinematics/jacobian.h"
#include "solvers/problem/goal_type.h"
#include "solvers/problem/ik_problem.h"
#include "solvers/problem/ik_report.h"

namespace gelenk {

/// Rows that a goal contributes to the stacked residual.
int residualRows(const Goal& goal, const Skeleton& skeleton);

/// The residual of one goal at the given frames: target minus current, unweighted; its file in problem/goals
/// says what the rows are.
void goalResidual(const Goal& goal, const Skeleton& skeleton, const Eigen::VectorXd& q, const Frames& frames,
                  Eigen::Ref<Eigen::VectorXd> r);

/// What every iterative solver works through: the stacked, weighted residual r (target minus current, m rows)
/// and its Jacobian J with dr = -J dq, m x nv. Orientation rows use the geometric Jacobian, which is the
/// derivative of the rotation vector where the error is small and the usual direction everywhere. Counts the
/// work, so that solvers can be compared by it. Storage is reused: after the first call nothing allocates.
class CountedEvaluator {
 public:
  explicit CountedEvaluator(const IkProblem& problem);

  int rows() const { return rows_; }
  const IkProblem& problem() const { return problem_; }
  const Skeleton& skeleton() const { return *problem_.skeleton; }

  /// Moves to q: forward kinematics and residual.
  void moveTo(const Eigen::VectorXd& q);
  const Eigen::VectorXd& q() const { return q_; }
  const Frames& frames() const { return frames_; }
  const Eigen::VectorXd& residual() const { return r_; }
  double cost() const { return 0.5 * r_.squaredNorm(); }

  /// The Jacobian at q(); computed when asked for, once a place.
  const Eigen::MatrixXd& jacobian();

  /// d/dt jacobian() while q moves along d: the contraction of the geometric Hessian with d, m x nv. J + 1/2
  /// of it is the matrix of Halley's method: (J + 1/2 dJ) d is the goal's motion to second order. Rows of
  /// types that do not say it (GoalType::addJacobianDerivative) are 0.
  void jacobianDerivative(const Eigen::VectorXd& d, Eigen::MatrixXd& dJ);

  /// Second derivatives of cost() at q() in the tangent, nv x nv: exact for types that say them
  /// (GoalType::addHessian: Position, Orientation, Pose, Posture), any joint kind; the others enter by their
  /// Gauss-Newton part J^T J. For ball joints the block of joints i <= j from the root is (r_i . r_j) I - r_j
  /// r_i^T - [r_j e^T - (r_j . e) I], symmetrised for i = j, r = effector - joint, in world axes.
  const Eigen::MatrixXd& hessian();

  /// True when every goal is within the problem's tolerances, by the residual at q().
  bool withinTolerance() const;

  Counters& counters() { return counters_; }
  double seconds() const;  ///< since construction

 private:
  /// One goal's part of the stacked rows.
  struct Part {
    const GoalType* type;
    int row, rows;
    double rootWeight;
    std::vector<DofGroup> path;  ///< from the root to Goal::joint
  };
  std::vector<DofGroup> pathTo(int joint) const;
  GoalBend bendOf(std::size_t goal);
  /// Goals are looked at where every follower has a dimension of its own; what they say there is added up by
  /// the dimensions that move.
  const Skeleton& free() const { return uncoupled_ ? *uncoupled_ : *problem_.skeleton; }
  void foldColumns(const Eigen::MatrixXd& ofFree, Eigen::MatrixXd& out) const;

  const IkProblem& problem_;
  int rows_ = 0;
  std::vector<Part> parts_;  ///< per goal
  Eigen::VectorXd q_, r_;
  Frames frames_;
  Twists twists_;
  Eigen::MatrixXd J_, H_;
  std::optional<Skeleton> uncoupled_;  ///< where the skeleton has couplings
  std::vector<int> moves_;      ///< by dimension of free(): the one of skeleton() that it moves with ...
  std::vector<double> factor_;  ///< ... and times what
  Eigen::MatrixXd foldedJ_, foldedH_;
  Eigen::VectorXd unfolded_;
  Eigen::Matrix3Xd A_, B_, C_;  ///< scratch, 3 x nv
  bool jacobianIsCurrent_ = false;
  Counters counters_;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace gelenk
