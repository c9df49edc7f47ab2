#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "kinematics/forward_kinematics.h"

namespace gelenk {

/// Where a row's fixed part stands.
/// Modified (Craig; the lecture's, 10.2): T = Rx(alpha) T(a, 0, d) Rz(phi): a, alpha lead to the axis that d,
/// phi move along. Standard (Denavit, Hartenberg 1955; Paul): T = Rz(phi) T(0, 0, d) T(a, 0, 0) Rx(alpha): a,
/// alpha come after the motion.
enum class DhConvention { Modified, Standard };
const char* toString(DhConvention convention);

enum class DhJoint { Revolute, Prismatic, Fixed };
const char* toString(DhJoint kind);

/// One row: metres, radians. The variable q is added to phi (revolute) or to d (prismatic); a fixed row has
/// none.
struct DhRow {
  DhJoint kind = DhJoint::Revolute;
  double a = 0.0;
  double alpha = 0.0;
  double d = 0.0;
  double phi = 0.0;
  double lower = -unlimited;  ///< of the variable, radians or metres
  double upper = unlimited;
};

/// An unbranched chain in Denavit-Hartenberg parameters: world = base, rows in order, then a fixed tool
/// frame.
struct DhTable {
  std::string name = {};
  DhConvention convention = DhConvention::Modified;
  std::vector<DhRow> rows = {};
  Eigen::Isometry3d base = Eigen::Isometry3d::Identity();  ///< worldFromBase
  Eigen::Isometry3d tool = Eigen::Isometry3d::Identity();  ///< lastRowFromTool
  std::optional<Eigen::VectorXd> rest =
      {};  ///< a pleasant pose, one value a variable; zeros moved into the limits where absent

  int variableCount() const;
};

/// Throws std::invalid_argument naming the row: no row, a parameter that is not finite, limits reversed, a
/// rest pose of the wrong length.
void validate(const DhTable& table);

/// 4 n + 3: four parameters a row and the base point P_1. Lecture 10.2, Denavit-Hartenberg.
int parameterCount(const DhTable& table);

/// T_{i -> i+1} of one row at the value q of its variable, as the product that the convention prescribes.
/// Lecture 10.2.
Eigen::Isometry3d dhTransform(const DhRow& row, DhConvention convention, double q);

/// The chain of matrices: base, base T_1, base T_1 T_2, ..., and last the tool. rows + 2 frames. q: one value
/// a variable. Throws std::invalid_argument when q has another length.
Frames dhFrames(const DhTable& table, const Eigen::VectorXd& q);

/// The same chain as a skeleton: the fixed root "base", one joint a row ("joint1", ...; fixed rows "frame1",
/// ...), the fixed "tool". The frame of joint i turns or slides along its own z. Modified: it is the row's
/// frame. Standard: the fixed part that follows the variable is carried into the next joint, so it is the
/// row's frame before T(a, 0, 0) Rx(alpha) (and, for a turning joint, before T(0, 0, d)); the tool agrees in
/// both.
Skeleton toSkeleton(const DhTable& table);

/// The same motion in the other convention, by regrouping the factors: nothing is approximated. Where the
/// fixed parts at the ends find no row they go into base and tool. Tool frames agree for every q.
DhTable toConvention(const DhTable& table, DhConvention convention);

/// A joint axis: a line with a direction (need not be a unit vector, may not be zero).
struct AxisLine {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
};

enum class AxisPair { Skew, Crossing, Parallel, Coincident };
const char* toString(AxisPair kind);

/// The shortest connection between two axes. Lecture 10.2: it always exists, but is unique only for skew
/// axes.
struct CommonNormal {
  AxisPair kind = AxisPair::Skew;
  Eigen::Vector3d footOnFirst, footOnSecond;  ///< its ends
  Eigen::Vector3d x;                          ///< unit, perpendicular to both axes
  double a = 0.0;                             ///< distance along x, >= 0
  double alpha = 0.0;  ///< angle from the first to the second direction about x, (-pi, pi]
};

/// Where the normal is not unique: crossing axes take x along first x second; parallel axes take the normal
/// through the point of the first axis nearest to `near`; coincident axes take x as near as possible to
/// `xHint`. Axes count as parallel below a sine of 1e-9, as meeting below a distance of 1e-9 m. Throws
/// std::invalid_argument for a direction that is zero or not finite.
CommonNormal commonNormal(const AxisLine& first, const AxisLine& second,
                          const Eigen::Vector3d& near = Eigen::Vector3d::Zero(),
                          const Eigen::Vector3d& xHint = Eigen::Vector3d::UnitX());

/// Frames and parameters (modified convention) of a chain of joint axes given as lines in its zero pose, by
/// common normals. K_i stands on axis i at the foot of the normal to axis i + 1, x_i along it; base is K_1
/// and the first row is zero; the last frame stands at the foot of the last normal with the last x.
/// Lecture 10.2. kinds: one an axis, or empty for revolute joints. Throws std::invalid_argument for no axis
/// or another count of kinds.
DhTable dhFromAxes(std::span<const AxisLine> axes, std::span<const DhJoint> kinds = {});

/// A serial chain of a skeleton as a table (modified convention), by the common normals of its axes in the
/// zero pose. Fixed joints go into base, rows and tool; the variables, their limits and the rest pose are the
/// skeleton's, and the tool is the frame of `end` (a joint; -1: the only leaf, else the last moving joint).
/// joints: the moving joints in order, one a row. Positions and orientations agree to 1e-9 m and rad, which
/// is checked at random poses. Throws std::invalid_argument: no moving joint, a joint with more than one
/// degree of freedom or a ball, moving joints beside the way to the default end (with an end given they are
/// left out), and axes so nearly parallel that their common normal is lost.
struct DhChain {
  DhTable table;
  std::vector<int> joints;
};
DhChain dhFromSkeleton(const Skeleton& skeleton, int end = -1);

/// The way back: the joint axes of the table's variables at q, as lines in the world.
std::vector<AxisLine> jointAxes(const DhTable& table, const Eigen::VectorXd& q);

}  // namespace gelenk
