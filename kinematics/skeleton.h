#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gelenk {

inline constexpr double unlimited = std::numeric_limits<double>::infinity();

/// One degree of freedom: a rotation about, or a translation along, a fixed unit axis of the joint's own
/// frame.
struct AxisDof {
  enum class Kind { Rotation, Translation };
  Kind kind = Kind::Rotation;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  double lower = -unlimited;  ///< radians or metres
  double upper = unlimited;

  /// A rotation whose range holds a full turn: angles that differ by 2 pi are the same pose, and both may be
  /// legal.
  bool isFullTurn() const;
};

/// Range of a ball joint in the swing-twist coordinates c = (2x, 2y, tau) of rotation.h, measured from the
/// joint's zero:
/// ((c.x - centre.x) / radii.x)^2 + ((c.y - centre.y) / radii.y)^2 <= 1 and twistLower <= tau <= twistUpper.
/// The twist turns about z, so the bone of a limited ball joint runs along z of the joint's frame.
struct BallLimit {
  Eigen::Vector2d swingCentre = Eigen::Vector2d::Zero();
  Eigen::Vector2d swingRadii = Eigen::Vector2d::Ones();
  double twistLower = -unlimited;
  double twistUpper = unlimited;
};

/// A joint that follows another one, as the second finger of a gripper does:
///     its value = multiplier * value of the source + offset.
/// Both have one axis and no ball; the source follows none. Radians and metres.
struct Coupling {
  int source = 0;
  double multiplier = 1.0, offset = 0.0;
  bool operator==(const Coupling&) const = default;
};

/// A joint is a fixed offset from its parent followed by a motion:
///     parentFromJoint(q) = parentFromZero * axis_1(q_1) * ... * axis_n(q_n) * [ball rotation]
/// No axes and no ball: a fixed frame, such as an end site. Three translations and a ball: a free root.
struct Joint {
  std::string name;
  int parent =
      -1;  ///< index of the parent, smaller than this joint's own; -1 for the root, whose parent is the world
  Eigen::Isometry3d parentFromZero = Eigen::Isometry3d::Identity();
  std::vector<AxisDof> axes = {};
  bool ball = false;
  std::optional<BallLimit> ballLimit = {};
  std::optional<Coupling> coupling = {};
};

/// An articulated model: a tree of joints, validated on construction and constant afterwards.
///
/// Configuration q (length nq): for each joint in order one value an axis (radians, metres), then, for a
/// ball, a unit quaternion as (w, x, y, z). Tangent dq (length nv): one value an axis, then three for a ball:
/// a rotation vector in the joint's own moved frame, q <- q * exp(dq).
///
/// A follower (Joint::coupling) has its value in q like every joint, but no dimension of its own in dq: it
/// moves with its source's. What makes or moves a q keeps couplings as it keeps quaternions of unit length:
/// integrate, randomWithinLimits, projectToLimits, couple. A source's range is what it and all its followers
/// allow.
class Skeleton {
 public:
  Skeleton() = default;  ///< no joints; useful only as a place to assign to

  /// rest: the configuration of the bind pose; neutral (zeros and identities) where not given.
  /// Throws std::invalid_argument, naming the joint, on: no joint, a parent that does not come earlier, a
  /// second root, an empty or repeated name, non-finite or non-rigid offsets, axes that are not unit vectors,
  /// reversed limits, a coupling of or to a joint that has not one axis, of a source that follows itself, or
  /// whose limits leave its source no value, a rest configuration of the wrong length or with a quaternion
  /// that is not of unit length. The rest configuration is coupled.
  explicit Skeleton(std::vector<Joint> joints, std::optional<Eigen::VectorXd> rest = {});

  int jointCount() const { return static_cast<int>(joints_.size()); }
  int nq() const { return nq_; }
  int nv() const { return nv_; }

  const Joint& joint(int i) const { return joints_[i]; }
  const std::vector<Joint>& joints() const { return joints_; }
  int parent(int i) const { return joints_[i].parent; }
  const std::vector<int>& children(int i) const { return children_[i]; }

  /// First entry of joint i in q and in dq, and how many it has there. A follower's vIndex is its source's.
  int qIndex(int i) const { return qIndex_[i]; }
  int vIndex(int i) const { return vIndex_[i]; }
  int qCount(int i) const { return static_cast<int>(joints_[i].axes.size()) + (joints_[i].ball ? 4 : 0); }
  int vCount(int i) const {
    return joints_[i].coupling ? 0 : static_cast<int>(joints_[i].axes.size()) + (joints_[i].ball ? 3 : 0);
  }

  /// Joints that follow another one, in order.
  const std::vector<int>& followers() const { return followers_; }
  /// True for a follower and for a source of one.
  bool isCoupled(int i) const { return coupled_[i] != 0; }
  /// Sets every follower's value from its source's. q: nq.
  void couple(Eigen::VectorXd& q) const {
    for (const int i : followers_) {
      const Coupling& c = *joints_[i].coupling;
      q[qIndex_[i]] = c.multiplier * q[qIndex_[c.source]] + c.offset;
    }
  }
  /// The same joints without couplings: every follower has a dimension of its own. q means the same.
  Skeleton uncoupled() const;

  std::optional<int> findJoint(std::string_view name) const;
  /// Throws std::invalid_argument that lists the names there are.
  int jointIndex(std::string_view name) const;

  /// True if a == j or a lies on the path from j to the root.
  bool isAncestor(int a, int j) const;

  const Eigen::VectorXd& rest() const { return rest_; }

 private:
  void addCouplings();

  std::vector<Joint> joints_;
  std::vector<std::vector<int>> children_;
  std::vector<int> qIndex_, vIndex_, followers_;
  std::vector<char> coupled_;
  int nq_ = 0, nv_ = 0;
  Eigen::VectorXd rest_;
};

}  // namespace gelenk
