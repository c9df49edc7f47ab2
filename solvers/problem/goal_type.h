#pragma once

#include <Eigen/Geometry>
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "kinematics/jacobian.h"
#include "solvers/problem/goal.h"

namespace gelenk {

// ---- fields: what a file, a command line or a panel must say of a goal -----------------------------------

/// One field of Goal that a type reads.
struct GoalField {
  /// Where it is measured, which says how it is shown, dragged and checked.
  enum class Meaning {
    Joint,         ///< index of a joint
    PointInJoint,  ///< metres, frame of Goal::joint
    PointInOther,  ///< metres, frame of Goal::otherJoint
    Target,        ///< metres, world; what is dragged
    End,           ///< metres, world; a second point that is dragged
    Rotation,      ///< unit quaternion
    AxisInJoint,   ///< unit, frame of Goal::joint
    Direction,     ///< unit, world
    Length,        ///< metres, not below 0
    Polygon,       ///< three or more points, metres, world
    Posture,       ///< nq
  };
  using Member =
      std::variant<int Goal::*, double Goal::*, Eigen::Vector3d Goal::*, Eigen::Quaterniond Goal::*,
                   Eigen::VectorXd Goal::*, std::vector<Eigen::Vector3d> Goal::*>;
  std::string_view name;     ///< as typed in files and on the command line
  std::string_view explain;  ///< a phrase for a person
  Meaning meaning;
  Member member;
  bool optional = false;  ///< what Goal begins with is sensible; End: where the target is
};

// ---- evaluation ------------------------------------------------------------------------------------------

/// Where a goal is looked at.
struct GoalPlace {
  const Skeleton& skeleton;
  const Eigen::VectorXd& q;  ///< nq
  const Frames& frames;      ///< of q
};

/// The same with its first derivatives, and storage for those who need some.
struct GoalMotion {
  const Skeleton& skeleton;
  const Eigen::VectorXd& q;
  const Frames& frames;
  const Twists& twists;
  Eigen::Matrix3Xd &A, &B, &C;  ///< 3 x nv, to be overwritten
};

/// The tangent dimensions of one ball, or one axis, on the way from the root to a joint.
struct DofGroup {
  int first, count;
};

/// What second derivatives are made of.
struct GoalBend {
  const Twists& twists;
  std::span<const DofGroup> path;       ///< from the root to Goal::joint
  Eigen::Ref<const Eigen::MatrixXd> J;  ///< rows of this goal, times sqrt(weight)
  Eigen::Ref<const Eigen::VectorXd> r;  ///< likewise
  double weight;                        ///< > 0
  const Skeleton& skeleton;
  Eigen::Matrix3Xd& A;  ///< 3 x nv, to be overwritten
};

/// Errors of one goal.
struct GoalError {
  double position = 0.0;     ///< metres; 0 where the goal has no position part
  double orientation = 0.0;  ///< radians; 0 where the goal has no orientation part
};

// ---- the drag solver's view: costs of carried points -----------------------------------------------------

/// A point (or, with direction, a vector that only turns) fixed to a joint, with a share.
struct Carried {
  int joint = 0;
  Eigen::Vector3d inJoint = Eigen::Vector3d::Zero();  ///< metres; directions: no unit
  bool direction = false;
  double share = 1.0;
};

/// 1/2 share |target - x|^2. Directions are laid on an arm of the solver's choice.
struct DragPoint {
  Carried at;
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  ///< metres, world; directions: unit
};
struct DragPoints {
  std::array<DragPoint, 4> points;
  int count = 0;
  void add(const DragPoint& point) { points[count++] = point; }
};

/// A smooth cost phi(y_1 ... y_m) of sums y_j of carried points, m <= 4, in metres^2: its value, its slope
/// and its curvature as rows, d^2 phi = sum over rows of sign (c . dy)^2. With `exact` all of it, without the
/// part that is never negative and exact where the goal is met (Gauss-Newton, signs +1).
struct DragModel {
  static constexpr int mostVectors = 4, mostRows = 12;
  struct Row {
    std::array<Eigen::Vector3d, mostVectors> c;  ///< of each y_j
    double sign;
  };
  double cost;
  std::array<Eigen::Vector3d, mostVectors> force;  ///< -d phi / dy_j
  std::array<double, mostVectors> stiffness;       ///< force / stiffness is how far y_j is off; 0: not by y_j
  std::array<Row, mostRows> row;
  int rows;

  void clear(int vectors) {
    cost = 0.0;
    rows = 0;
    for (int j = 0; j < vectors; ++j) force[j].setZero(), stiffness[j] = 1.0;
  }
  /// A row that looks at y_j alone, of a model of `vectors` sums.
  void addRow(int vectors, int j, const Eigen::Vector3d& c, double sign = 1.0) {
    Row& to = row[rows++];
    for (int k = 0; k < vectors; ++k) to.c[k].setZero();
    to.c[j] = c;
    to.sign = sign;
  }
};

/// How the drag solver serves a type: by points with targets, or by a smooth cost of sums of carried points.
struct DragForm {
  /// Points, at most four.
  void (*points)(const Goal&, const Skeleton&, DragPoints& out) = nullptr;
  /// Of types whose first point's target follows the pose: what it depends on, and where it is (world).
  void (*references)(const Goal&, const Skeleton&, std::array<Carried, 3>& out) = nullptr;
  Eigen::Vector3d (*follow)(const Goal&, const std::array<Eigen::Vector3d, 3>& at) = nullptr;
  /// Or sums: one list of carried points for each y_j.
  int sums = 0;
  void (*carried)(const Goal&, const Skeleton&, int sum, std::vector<Carried>& out) = nullptr;
  /// arm: metres that stand for a radian.
  void (*model)(const Goal&, std::span<const Eigen::Vector3d> y, double arm, bool exact,
                DragModel& out) = nullptr;
  /// Pulls from afar with full force, takes part in "out of reach" and in the pins' tolerance.
  bool measured = true;
};

// ---- marks -----------------------------------------------------------------------------------------------

/// What a goal looks like: plain geometry, metres, world. Whoever draws it chooses colour and width.
struct GoalMark {
  enum class Stress { Main, Faint };
  struct Segment {
    Eigen::Vector3d from, to;
    Stress stress;
  };
  struct Ring {
    Eigen::Vector3d centre, normal;
    double radius;
  };
  struct Polygon {
    std::vector<Eigen::Vector3d> corners;
    bool filled;
  };
  std::vector<Eigen::Vector3d> points;
  std::vector<Segment> segments;
  std::vector<Ring> rings;
  std::vector<Polygon> polygons;
};

// ---- the type --------------------------------------------------------------------------------------------

/// Everything that the program knows of a kind of goal.
struct GoalType {
  GoalKind kind;
  std::string_view name;   ///< as typed
  std::string_view title;  ///< as shown
  std::string_view asks;   ///< what it asks for, a sentence
  std::span<const GoalField> fields;
  bool judged = true;     ///< false: a preference
  bool oneSided = false;  ///< met in a whole region
  bool needsMasses = false;
  bool movesWithPose = false;   ///< a pose that is set directly takes it along: it asks for what is then
  bool handleAtTarget = false;  ///< taken with the mouse where its target is, not where it was reached
  double preference = 1.0;      ///< weight beside others where a person adds it: less for a wish

  /// Rows of the residual (target minus current) and of its Jacobian, dr = -J dq.
  int (*rows)(const Skeleton&);
  void (*residual)(const Goal&, const GoalPlace&, Eigen::Ref<Eigen::VectorXd> r);
  void (*jacobian)(const Goal&, const GoalMotion&, Eigen::Ref<Eigen::MatrixXd> J);
  /// Adds the second derivative of 1/2 |r|^2 to H (nv x nv); none: J^T J.
  void (*addHessian)(const Goal&, const GoalBend&, Eigen::MatrixXd& H) = nullptr;
  /// Adds the change of J while q moves along d; none: 0.
  void (*addJacobianDerivative)(const Goal&, const GoalBend&, const Eigen::VectorXd& d,
                                Eigen::Ref<Eigen::MatrixXd> dJ) = nullptr;
  /// Of an unweighted residual.
  GoalError (*error)(const Eigen::Ref<const Eigen::VectorXd>& r);
  /// Beyond what the fields say: why such a goal makes no sense on the skeleton. Empty where it does.
  std::string (*whyNot)(const Goal&, const Skeleton&) = nullptr;

  /// Joints whose way to the root takes part: the others stay. None: all take part.
  void (*joints)(const Goal&, const Skeleton&, std::vector<int>& out) = nullptr;
  DragForm drag;

  /// The point that is drawn to the target, world.
  Eigen::Vector3d (*reached)(const Goal&, const GoalPlace&);
  /// Changes the goal so that it is met, or just met, where the model is.
  void (*capture)(Goal&, const GoalPlace&);
  void (*mark)(const Goal&, const GoalPlace&, GoalMark&);
};

#define GELENK_DECLARE(Kind, type) extern const GoalType type;
GELENK_GOAL_TYPES(GELENK_DECLARE)
#undef GELENK_DECLARE

/// All of them, in the order of GoalKind.
std::span<const GoalType* const> goalTypes();
const GoalType& goalType(GoalKind kind);
/// By its name. Throws std::invalid_argument that lists the names there are.
const GoalType& goalType(std::string_view name);

/// Why the goal cannot be asked of the skeleton: a joint that is not there, a number that is not finite, a
/// missing polygon, posture or mass, or GoalType::whyNot. Empty where nothing is wrong.
std::string whyInvalid(const Goal& goal, const Skeleton& skeleton);
/// The part of it that numbers do not change: joints, masses and GoalType::whyNot.
std::string whyMisplaced(const Goal& goal, const Skeleton& skeleton);
/// All numbers of the goal that count are finite.
bool isFinite(const Goal& goal);
/// Kind and all fields that count are the same.
bool asksTheSame(const Goal& a, const Goal& b);

// ---- what the files in goals/ share ----------------------------------------------------------------------

namespace goal_fields {
using Meaning = GoalField::Meaning;
inline constexpr GoalField joint{"joint", "the joint", Meaning::Joint, &Goal::joint};
inline constexpr GoalField point{"point", "the point of the joint", Meaning::PointInJoint,
                                 &Goal::pointInJoint, true};
inline constexpr GoalField target{"target", "where it shall be", Meaning::Target, &Goal::target};
inline constexpr GoalField orientation{"orientation", "worldFromJoint wanted", Meaning::Rotation,
                                       &Goal::orientation};
inline constexpr GoalField other{"other", "the other joint", Meaning::Joint, &Goal::otherJoint};
inline constexpr GoalField otherPoint{"other_point", "the point of the other joint", Meaning::PointInOther,
                                      &Goal::pointInOther, true};
}  // namespace goal_fields

namespace goal_parts {

inline GoalError positionError(const Eigen::Ref<const Eigen::VectorXd>& r) { return {.position = r.norm()}; }
inline GoalError orientationError(const Eigen::Ref<const Eigen::VectorXd>& r) {
  return {.orientation = r.norm()};
}
inline GoalError poseError(const Eigen::Ref<const Eigen::VectorXd>& r) {
  return {.position = r.head<3>().norm(), .orientation = r.tail<3>().norm()};
}
template <int n>
int rows(const Skeleton&) {
  return n;
}
void oneJoint(const Goal& goal, const Skeleton&, std::vector<int>& out);
void twoJoints(const Goal& goal, const Skeleton&, std::vector<int>& out);
Eigen::Vector3d pointReached(const Goal& goal, const GoalPlace& at);

/// J <- d(point of joint)/dq and d(rotation of joint)/dq into three rows.
void putPointRows(const GoalMotion& at, int joint, const Eigen::Vector3d& world,
                  Eigen::Ref<Eigen::MatrixXd> J);
void putRotationRows(const GoalMotion& at, int joint, Eigen::Ref<Eigen::MatrixXd> J);

/// Rotation vector of wanted * current^-1, world axes.
Eigen::Vector3d rotationError(const Eigen::Quaterniond& wanted, const Eigen::Isometry3d& worldFromJoint);

/// H -= force . d^2 p for the point of three rows of J (geometric Hessian of a point on a path), and
/// H += 1/2 d^2 |rotation vector|^2 for three rotation rows. row: first of the goal's.
void addPointHessian(const GoalBend& at, int row, Eigen::MatrixXd& H);
void addRotationHessian(const GoalBend& at, int row, Eigen::MatrixXd& H);
/// The change of three point or rotation rows while q moves along d.
void addPointDerivative(const GoalBend& at, int row, const Eigen::VectorXd& d,
                        Eigen::Ref<Eigen::MatrixXd> dJ);
void addRotationDerivative(const GoalBend& at, int row, const Eigen::VectorXd& d,
                           Eigen::Ref<Eigen::MatrixXd> dJ);

/// Three axes of a frame as a mark.
void addTriad(const Eigen::Vector3d& at, const Eigen::Quaterniond& orientation, double size, GoalMark& mark);
/// Metres of a mark's details: a share of the skeleton's reach.
double markSize(const Skeleton& skeleton);

}  // namespace goal_parts

}  // namespace gelenk
