#pragma once

#include <Eigen/Geometry>
#include <array>
#include <span>
#include <vector>

#include "kinematics/skeleton.h"
#include "solvers/tree/tree_matrix.h"

namespace gelenk {

/// How a node of the tree moves.
enum class TreeMotion : unsigned char {
  RotationAxis,     ///< 1 dof, coordinate = angle (radians)
  TranslationAxis,  ///< 1 dof, coordinate = displacement (units)
  LimitedBall,      ///< 3 dof, coordinates c = (2x, 2y, tau) of rotation.h
  FreeBall,  ///< 3 dof, coordinates = quaternion (w, x, y, z); tangent in the moved frame, q <- q exp(d)
};

/// One axis or one ball of a joint that lies between a goal and the root.
struct TreeNode {
  TreeMotion motion = TreeMotion::FreeBall;
  int parent = -1;          ///< node, -1: fixed to the world
  int joint = 0;            ///< joint of the skeleton
  int qIndex = 0;           ///< first entry in q
  int dof = 0;              ///< first degree of freedom
  int coordinate = 0;       ///< first entry among the coordinates
  int depth = 0;            ///< degrees of freedom above
  int coordinateAxis = -1;  ///< 0, 1, 2 where the axis is +x, +y, +z; else -1
  bool offsetIsIdentity = false;
  bool offsetTurns = true;  ///< false where offsetRotation is the identity
  Eigen::Matrix3d offsetRotation = Eigen::Matrix3d::Identity();  ///< parentFromNode before the motion
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();              ///< units
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  double lower = -unlimited, upper = unlimited;  ///< of an axis (radians, units), or of the twist
  Eigen::Vector2d swingCentre = Eigen::Vector2d::Zero(), swingRadii = Eigen::Vector2d::Ones();

  int dofs() const { return motion >= TreeMotion::LimitedBall ? 3 : 1; }
  int coordinates() const {
    return motion == TreeMotion::FreeBall ? 4 : motion == TreeMotion::LimitedBall ? 3 : 1;
  }
};

/// The coordinate of a node that follows another one: c = multiplier * c of the source + offset.
struct TreeCoupling {
  int follower = 0, source = 0;  ///< nodes of one axis
  double multiplier = 1.0, offset = 0.0;
};

/// A point, or a direction, fixed to a node and drawn to a target t by the cost 1/2 weight |t - x|^2, which
/// goes on with the same slope where |t - x| > cut: weight cut (|t - x| - cut / 2). (Huber 1964)
struct TreePoint {
  int node = -1;           ///< -1: fixed to the world, cannot move
  bool direction = false;  ///< x = R local instead of R local + p
  double weight = 1.0;
  double cut = unlimited;  ///< units
  Eigen::Vector3d local = Eigen::Vector3d::Zero();
  Eigen::Vector3d target = Eigen::Vector3d::Zero();
};

/// A share of a point, or of a direction, fixed to a node: one term of a TreeSum.
struct TreeShare {
  int node = 0;
  bool direction = false;
  double share = 1.0;
  Eigen::Vector3d local = Eigen::Vector3d::Zero();  ///< units; directions: none
};

/// y = constant + sum of shares: the centre of mass, the difference of two points, a point. Units from the
/// origin; directions: none.
struct TreeSum {
  int first = 0, count = 0;  ///< among the shares
  bool direction = false;
  Eigen::Vector3d constant = Eigen::Vector3d::Zero();
  double scale = 1.0;                               ///< metres a unit; directions 1
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< scale y + shift is the sum in the world, metres
};

/// Where the nodes are.
struct TreePose {
  struct NodeFrame {
    Eigen::Matrix3d R;  ///< after the node's motion
    Eigen::Vector3d p;
    Eigen::Matrix3d zero;     ///< balls alone: rotation before the motion
    std::array<double, 4> q;  ///< balls alone: the motion as a unit quaternion (w, x, y, z)
  };
  std::vector<double> coordinates;
  std::vector<NodeFrame> frames;
};

/// The degrees of freedom of a skeleton that lie between some joints and the root, as flat arrays in
/// depth-first order: what gradient and Hessian of all goals are assembled on in one sweep. Lengths inside
/// are the caller's unit, points are relative to origin(); both are applied by load(), store() and toTree().
class GoalTree {
 public:
  /// skeleton must outlive the tree. unit: metres a unit of length, > 0.
  GoalTree(const Skeleton& skeleton, double unit);

  /// Rebuilds the structure for goals on these joints. Allocates only where it outgrows all earlier
  /// structures.
  void build(std::span<const int> joints, const Eigen::Vector3d& origin);

  const Skeleton& skeleton() const { return *skeleton_; }
  double unit() const { return unit_; }
  int nodeCount() const { return static_cast<int>(nodes_.size()); }
  int dofCount() const { return dofs_; }
  const TreeNode& node(int i) const { return nodes_[i]; }
  std::span<const TreeNode> nodes() const { return nodes_; }
  std::span<TreeNode> nodes() { return nodes_; }
  std::span<const int> dofParents() const { return dofParent_; }
  /// Of the nodes that follow others. Followers are dofs like all others here, without limits; place() holds
  /// them to their sources. A source beside the goals' paths is a node of its own that carries nothing.
  std::span<const TreeCoupling> couplings() const { return couplings_; }

  /// The last node at or above the joint, -1 where nothing moves it. The joint's path must be part of the
  /// structure.
  int carrier(int joint) const { return carrier_[joint]; }
  /// nodeFromJoint, units: a point of the joint seen from its carrier (from the origin where there is none).
  Eigen::Vector3d toCarrier(int joint, const Eigen::Vector3d& pointInJoint) const;
  Eigen::Matrix3d carrierFromJoint(int joint) const { return carrierFromJoint_[joint].linear(); }
  /// Whether the joint's way to the root is part of the structure, and the nearest joint above it of which
  /// this is true (-1: none).
  bool holds(int joint) const { return onPath_[joint] != 0; }
  int holderOf(int joint) const {
    while (joint >= 0 && !onPath_[joint]) joint = skeleton_->parent(joint);
    return joint;
  }
  const Eigen::Vector3d& origin() const { return origin_; }
  /// World point to units from the origin.
  Eigen::Vector3d toTree(const Eigen::Vector3d& world) const { return (world - origin_) / unit_; }

  /// Coordinates of q, moved into the limits; then place().
  void load(const Eigen::VectorXd& q, TreePose& pose) const;
  /// Writes the joints of the tree into q; all others stay as they are.
  void store(const TreePose& pose, Eigen::VectorXd& q) const;
  /// The frames from the coordinates, after followers took what their sources say.
  void place(TreePose& pose) const;

  /// Moves the node's coordinates into its limits: box, or nearest point of the swing's ellipse. True where
  /// they moved.
  static bool project(const TreeNode& node, double* coordinates);

  /// World position (or direction) of a point, units from the origin.
  Eigen::Vector3d at(const TreePose& pose, const TreePoint& point) const;
  /// Sum of the points' costs.
  double cost(const TreePose& pose, std::span<const TreePoint> points) const;

  Eigen::Vector3d at(const TreePose& pose, const TreeSum& sum, std::span<const TreeShare> shares) const;

  /// Sums over the goals below every node; gradientAndHessian needs them at the same pose.
  void gather(const TreePose& pose, std::span<const TreePoint> points);
  /// Adds a force on a sum (-d cost / dy): its part of the gradient and of beta's share of the Hessian. To
  /// be called between beginGather and endGather, which gather does by itself.
  void beginGather();
  void addPoints(const TreePose& pose, std::span<const TreePoint> points);
  void addForce(const TreePose& pose, const TreeSum& sum, std::span<const TreeShare> shares,
                const Eigen::Vector3d& force);
  void endGather();
  /// dy / d(dof), three numbers a dof, of a sum; after gradientAndHessian at the same pose.
  void slopeOf(const TreePose& pose, const TreeSum& sum, std::span<const TreeShare> shares,
               Eigen::Vector3d* slope);
  /// gradient: dofCount(); H: structure dofParents(). beta = 1: the exact Hessian of the cost; 0:
  /// Gauss-Newton.
  void gradientAndHessian(const TreePose& pose, double beta, double* gradient, TreeMatrix& H);

 private:
  /// m = sum w, h = sum w p, A = sum w p p^T (xx, yy, zz, xy, xz, yz), F = sum f, T = sum p x f, P = sum p
  /// f^T.
  struct Sums {
    double m;
    Eigen::Vector3d h, F, T;
    double A[6];
    Eigen::Matrix3d P;
  };

  void addCouplings();
  TreeNode& addNode(int joint, int k, int parent, const Eigen::Isometry3d& offset);

  const Skeleton* skeleton_;
  double unit_;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  int dofs_ = 0, coordinates_ = 0;
  std::vector<TreeNode> nodes_;
  std::vector<TreeCoupling> couplings_;
  std::vector<int> dofParent_, carrier_, order_;
  std::vector<char> onPath_;
  std::vector<Eigen::Isometry3d> carrierFromJoint_;
  std::vector<Sums> sums_;
  std::vector<std::array<Eigen::Vector3d, 2>> twistOfDof_;  ///< (omega, v)
  std::vector<Eigen::Vector4d> below_;                      ///< by node: first moment and share of a sum
  std::vector<double> twists_;  ///< w.x, w.y, w.z, v.x, v.y, v.z of the current path, each by depth
  int twistStride_ = 0;
};

}  // namespace gelenk
