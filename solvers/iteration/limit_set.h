#pragma once

#include <Eigen/Core>
#include <vector>

#include "kinematics/skeleton.h"

namespace gelenk {

/// Joint limits inside a solve, as an active set. At a configuration every limit is a half space of the
/// tangent, normal . dq <= slack: a coordinate for an axis, a direction in the ball's three dimensions for a
/// swing cone or a twist. A locked limit takes its normal out of the tangent; what is left is the projection
/// P (nv x nv, orthogonal, block diagonal). Rotations with a full turn are never locked: they wrap (see
/// retract).
class LimitSet {
 public:
  explicit LimitSet(const Skeleton& skeleton);

  /// Slacks and normals at q (within limits). Nothing is locked afterwards.
  void moveTo(const Eigen::VectorXd& q);

  /// Locks every limit that q touches and that the direction leaves. direction: nv, for example the descent
  /// direction.
  void lockBlocked(const Eigen::VectorXd& direction);

  /// Locks every limit that q touches.
  void lockTouched();

  /// Locks every limit that the step dq crosses and adds the part of the step that leads to it to `fixed`,
  /// for a second solve in what is left: the residual of that solve is r - J fixed. False if nothing was
  /// crossed.
  bool lockCrossed(const Eigen::VectorXd& dq, Eigen::VectorXd& fixed);

  bool anyLocked() const { return lockedCount_ > 0; }

  /// x <- P x.
  void project(Eigen::Ref<Eigen::VectorXd> x) const;
  /// A <- A P. A: m x nv.
  void projectColumns(Eigen::MatrixXd& A) const;
  /// H <- P H P + (I - P): positive definite wherever H is so on the free dimensions. H: nv x nv.
  void projectBothSides(Eigen::MatrixXd& H) const;

  /// out <- q (+) dq, full-turn joints wrapped into their range, everything else projected to its limits.
  void retract(const Eigen::VectorXd& q, const Eigen::VectorXd& dq, Eigen::VectorXd& out) const;

  /// A limit as a half space normal . dq <= slack, slack >= 0; the normal is a unit vector at [first, first +
  /// count).
  struct Row {
    int first = 0, count = 1;
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< one entry for an axis
    double slack = 0.0;
    bool locked = false;
  };
  const std::vector<Row>& rows() const { return rows_; }

 private:
  void lock(Row& row);

  const Skeleton* skeleton_;
  std::vector<Row> rows_;
  struct Block {  ///< orthonormal normals taken out of a ball's dimensions
    int first;
    int taken = 0;
    Eigen::Matrix3d out;
  };
  std::vector<Block> blocks_;     ///< of limited balls
  std::vector<int> blockOf_;      ///< per tangent index: its block, -1 for axes
  std::vector<char> axisLocked_;  ///< per tangent index
  std::vector<int> wrapping_;     ///< q indices of full-turn axes with limits
  std::vector<double> wrapLower_, wrapUpper_;
  int lockedCount_ = 0;
};

}  // namespace gelenk
