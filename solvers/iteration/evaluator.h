#pragma once

#include <Eigen/Core>
#include <chrono>
#include <vector>

#include "kinematics/jacobian.h"
#include "solvers/problem/ik_problem.h"
#include "solvers/problem/ik_report.h"

namespace gelenk {

/// Rows that a goal contributes to the stacked residual.
int residualRows(const Goal& goal, const Skeleton& skeleton);

/// The residual of one goal at the given frames (rows as in GoalKind, target minus current, unweighted).
///
/// Pole: a, b, c = origins of the joint's parent, the joint (elbow, knee) and its first child, u = (c - a)/|c
/// - a|, s = target - a. The residual is u . ((b - a) x s) / |s - u u.s|: the distance of b from the half
/// plane through a, c and the target (metres, signed; also zero on the opposite side).
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
  /// of it is the matrix of Halley's method: (J + 1/2 dJ) d is the goal's motion to second order. Aim, Pole
  /// and Posture rows are 0.
  void jacobianDerivative(const Eigen::VectorXd& d, Eigen::MatrixXd& dJ);

  /// Second derivatives of cost() at q() in the tangent, nv x nv: exact for Position, Orientation, Pose and
  /// Posture, any joint kind; Aim and Pole enter by their Gauss-Newton part J^T J. For ball joints the block
  /// of joints i <= j from the root is (r_i . r_j) I - r_j r_i^T - [r_j e^T - (r_j . e) I], symmetrised for i
  /// = j, r = effector - joint, in world axes.
  const Eigen::MatrixXd& hessian();

  /// True when every goal is within the problem's tolerances, by the residual at q().
  bool withinTolerance() const;

  Counters& counters() { return counters_; }
  double seconds() const;  ///< since construction

 private:
  /// The tangent dimensions of one ball, or one axis, on the way from the root to a goal's joint.
  struct Group {
    int first, count;
  };
  void addPointDerivative(const std::vector<Group>& path, int row, const Eigen::VectorXd& d,
                          Eigen::MatrixXd& dJ) const;
  void addPointCurvature(const std::vector<Group>& path, int row, const Eigen::Vector3d& force);
  void addRotationCurvature(const std::vector<Group>& path, const Eigen::Vector3d& moment);
  void addPostureHessian(int row, double weight);

  const IkProblem& problem_;
  int rows_ = 0;
  std::vector<std::vector<Group>> paths_;  ///< per goal, from the root
  Eigen::VectorXd q_, r_;
  Frames frames_;
  Twists twists_;
  Eigen::MatrixXd J_, H_;
  Eigen::Matrix3Xd A_, B_, C_;  ///< scratch, 3 x nv
  bool jacobianIsCurrent_ = false;
  Counters counters_;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace gelenk
