#pragma once

#include <Eigen/Core>
#include <chrono>

#include "kinematics/jacobian.h"
#include "solvers/ik_problem.h"
#include "solvers/ik_report.h"

namespace gelenk {

/// Rows that a goal contributes to the stacked residual.
int residualRows(const Goal& goal, const Skeleton& skeleton);

/// The residual of one goal at the given frames (rows as in GoalKind, target minus current, unweighted).
///
/// Pole: a, b, c = origins of the joint's parent, the joint (elbow, knee) and its first child, u = (c - a)/|c - a|,
/// s = target - a. The residual is u . ((b - a) x s) / |s - u u.s|: the distance of b from the half plane through a, c and
/// the target (metres, signed; also zero on the opposite side).
void goalResidual(const Goal& goal, const Skeleton& skeleton, const Eigen::VectorXd& q, const Frames& frames,
                  Eigen::Ref<Eigen::VectorXd> r);

/// What every iterative solver works through: the stacked, weighted residual r (target minus current, m rows) and its
/// Jacobian J with dr = -J dq, m x nv. Orientation rows use the geometric Jacobian, which is the derivative of the rotation
/// vector where the error is small and the usual direction everywhere. Counts the work, so that solvers can be compared by it. Storage is reused: after the
/// first call nothing allocates.
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

  /// True when every goal is within the problem's tolerances, by the residual at q().
  bool withinTolerance() const;

  Counters& counters() { return counters_; }
  double seconds() const;  ///< since construction

 private:
  const IkProblem& problem_;
  int rows_ = 0;
  Eigen::VectorXd q_, r_;
  Frames frames_;
  Twists twists_;
  Eigen::MatrixXd J_;
  bool jacobianIsCurrent_ = false;
  Counters counters_;
  std::chrono::steady_clock::time_point begin_;
};

}  // namespace gelenk
