#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "kinematics/skeleton.h"
#include "solvers/solutions/complete_set.h"
#include "solvers/solutions/self_motion.h"

namespace gelenk {

struct PathOptions {
  double jump = 0.5;  ///< radians: a joint that turns farther from one pose to the next has jumped
  int slices = 48;  ///< seven joints without a closed form: values of the held joint looked at for each pose
  double step = 0.3;  ///< seven joints with a closed form: radians between solutions looked at on a curve
  int rounds = 20;    ///< seven joints: of the refinement along the self-motions, at most
};

/// A jump that no choice of solutions avoids at this place (another choice may put it elsewhere).
struct PathJump {
  int pose = 0;        ///< between this pose and the next
  double turn = 0.0;   ///< the farthest that a joint turns, radians
  std::string reason;  ///< what ends the solution that was followed: a limit, a singularity, the slices
};

struct PathPlan {
  std::vector<Eigen::VectorXd> q;  ///< of the chain's joints, a pose each; empty where a pose has no solution
  std::vector<PathJump> jumps;
  double length = 0.0;             ///< sum of the distances from pose to pose, jumps included, radians
  std::optional<int> unreachable;  ///< the first pose without a solution within limits
  double largestStep = 0.0;        ///< of a joint, jumps left out, radians
};

/// Joint motion along poses of the tip with the fewest jumps and, among these, the least motion: dynamic
/// programming over the complete sets of all poses (whole turns within limits are solutions of their own;
/// for seven joints slices of the self-motions), then, for seven joints, relaxation along the self-motions.
/// The fewest jumps hold for the solutions that were looked at, which for six joints and fewer is all of
/// them. `start`, where given, is the pose of the joints before the first: motion from there counts too.
class PathPlanner {
 public:
  /// Throws std::invalid_argument for a chain that has neither a finite complete set nor seven revolute
  /// joints.
  PathPlanner(const Skeleton& skeleton, int tipJoint);

  const SerialChain& chain() const { return seven_ ? seven_->chain() : finite_->chain(); }
  PathPlan plan(std::span<const Eigen::Isometry3d> worldFromTip, const PathOptions& options = {},
                const Eigen::VectorXd* start = nullptr) const;

  /// The name of the branch that q is on (branchName); empty where it has none.
  std::string branchOf(const Eigen::Isometry3d& worldFromTip, const Eigen::VectorXd& q) const;

  /// Every solution within limits that the planner looks at for a pose; n x count.
  Eigen::MatrixXd candidates(const Eigen::Isometry3d& worldFromTip, const PathOptions& options = {}) const;

 private:
  void refine(std::span<const Eigen::Isometry3d> poses, const PathOptions& options, PathPlan& plan) const;
  std::string whyItEnds(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to,
                        const Eigen::VectorXd& q) const;
  void measure(std::span<const Eigen::Isometry3d> poses, const PathOptions& options, PathPlan& plan) const;

  std::optional<CompleteSet> finite_;
  std::optional<SevenJointArm> seven_;
};

/// Pose between two: straight line and the shorter arc, s in [0, 1].
Eigen::Isometry3d between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double s);

/// A path through key poses: Catmull-Rom splines of the places, arcs of the orientations, `count` poses at
/// equal arc length of the places (equal parameter where they stand still). Throws std::invalid_argument for
/// fewer than two keys or poses.
std::vector<Eigen::Isometry3d> splineThrough(std::span<const Eigen::Isometry3d> keys, int count);

}  // namespace gelenk
