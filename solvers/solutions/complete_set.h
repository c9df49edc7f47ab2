#pragma once

#include "kinematics/skeleton.h"
#include "solvers/solutions/arm_solutions.h"

namespace gelenk {

/// What is asked of the tip of an arm.
enum class TipTask {
  Pose,      ///< place of a point and orientation: six conditions
  Position,  ///< place of a point: three
  Axis,      ///< place of a point and direction of an axis through it: five (a welding gun, a drill)
};

struct CompleteSetTask {
  TipTask task = TipTask::Pose;
  Eigen::Vector3d pointInTip = Eigen::Vector3d::Zero();  ///< metres
  Eigen::Vector3d axisInTip = Eigen::Vector3d::UnitZ();  ///< unit; Axis only
};

/// Smallest singular value of the geometric Jacobian (lengths over the chain's length, the tip's origin) and
/// the direction in which the joints can move all the same; n entries.
struct Singularity {
  double sigmaMin = 0.0;
  Eigen::VectorXd direction;
};
Singularity singularity(const SerialChain& chain, const Eigen::VectorXd& q);

/// Complete sets for arms of one to six joints, wherever the set is finite (with joints that slide, where
/// three that turn meet in a point, joints of no weight included): arms with fewer joints get the missing
/// ones as joints of no weight at the tip. Those that the task leaves free (the roll about an axis, the
/// orientation) turn about the point and may end anywhere; those beyond that stand askew and must end at
/// zero, or the target is none of the arm's.
class CompleteSet {
 public:
  /// The reason why there is no finite complete set (more joints than conditions, joints that slide and do
  /// not fit), in words for a person; empty where there is one. Throws std::invalid_argument where tipJoint
  /// is no joint.
  static std::string whyNot(const Skeleton& skeleton, int tipJoint, const CompleteSetTask& task = {});

  /// Throws std::invalid_argument with that reason.
  CompleteSet(const Skeleton& skeleton, int tipJoint, const CompleteSetTask& task = {});

  int joints() const { return chain_.n; }
  const SerialChain& chain() const { return chain_; }  ///< of the arm itself
  const SixJointArm& arm() const { return arm_; }      ///< with the joints of no weight
  const CompleteSetTask& task() const { return task_; }

  /// target: frame wanted of the tip's point and axes, world; Position uses the translation alone, Axis the
  /// translation and where the orientation takes axisInTip. q of the solutions: the arm's joints first, then
  /// zeros. Free bits of joints of no weight are dropped. Where an arm of fewer than six joints has a curve
  /// of solutions one member of it is told, its moving joints are free, and the set is not called complete;
  /// nor is it where the elimination finds nothing and a search one. Six joints: no allocation.
  void solve(const Eigen::Isometry3d& target, const Vector6d& reference, ArmSolutions& out) const;

  /// Of what the task asks for alone: how nearly the joints can move and leave it.
  Singularity singularity(const Eigen::VectorXd& q) const;

 private:
  bool isThere(const ArmSolutions& out, int count, const Vector6d& q) const;
  void tellFamily(const Eigen::Isometry3d& target, const Vector6d& reference, ArmSolution& s,
                  ArmSolutions& out) const;
  void search(const Eigen::Isometry3d& target, const Vector6d& reference, ArmSolutions& out) const;

  CompleteSetTask task_;
  SerialChain chain_;
  CompleteSetTask solved_;  ///< as the arm with joints of no weight solves it
  SixJointArm arm_;
  double reach_;     ///< of the task's point from the base at most, metres
  bool mayBeBlind_;  ///< the elimination, to curves of solutions and to roots where joints slide
};

}  // namespace gelenk
