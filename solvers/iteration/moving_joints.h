#pragma once

#include <Eigen/Core>
#include <vector>

#include "solvers/problem/ik_problem.h"

namespace gelenk {

/// The joints that a problem's goals depend on: those on the way from the root to what a goal looks at, those
/// that such a joint follows, and their followers. All
/// others are none of a solver's business: they stay, bit for bit, where the start has them, or on the limit
/// next to it where the start is beyond.
class MovingJoints {
 public:
  explicit MovingJoints(const IkProblem& problem);

  bool moves(int joint) const { return moves_[joint]; }
  bool all() const { return all_; }

  /// q's joints off the goals' paths <- the start's. nq.
  void restore(Eigen::VectorXd& q) const;
  /// Their entries of a tangent vector <- 0. nv.
  void silence(Eigen::VectorXd& dq) const;

 private:
  const Skeleton* skeleton_;
  std::vector<char> moves_;  ///< per joint
  Eigen::VectorXd home_;     ///< nq: the start, within limits
  bool all_ = true;
};

}  // namespace gelenk
