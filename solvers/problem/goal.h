#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kinematics/masses.h"

/// Every type of goal there is. A new one is a line here and a file goals/NAME.cpp, which defines the
/// GoalType of that name: enumerators, declarations and the table are made from this list.
#define GELENK_GOAL_TYPES(ROW)                \
  ROW(Position, positionGoal)                 \
  ROW(Orientation, orientationGoal)           \
  ROW(Pose, poseGoal)                         \
  ROW(Aim, aimGoal)                           \
  ROW(Direction, directionGoal)               \
  ROW(Pole, poleGoal)                         \
  ROW(Posture, postureGoal)                   \
  ROW(CentreOfMass, centreOfMassGoal)         \
  ROW(Balance, balanceGoal)                   \
  ROW(Distance, distanceGoal)                 \
  ROW(RelativePosition, relativePositionGoal) \
  ROW(RelativePose, relativePoseGoal)         \
  ROW(KeepOut, keepOutGoal)                   \
  ROW(HalfSpace, halfSpaceGoal)

namespace gelenk {

#define GELENK_ENUMERATOR(Kind, type) Kind,
/// What a goal asks for; goalType(kind) says the rest: rows, residual, Jacobian, judged error, mark.
enum class GoalKind { GELENK_GOAL_TYPES(GELENK_ENUMERATOR) };
#undef GELENK_ENUMERATOR

/// How firmly a goal stands against others.
enum class Role : unsigned char {
  Drag,  ///< follows a moving target as far as the body lets it
  Hold,  ///< stays at its target and gives way like a drag
  Pin,   ///< stays where it is
};

/// On the squared error of a pin, times Goal::weight: it yields a thousand times less than the hand that
/// pulls.
inline constexpr double pinWeight = 1000.0;

/// What the model shall do. Which of the fields count depends on the kind: GoalType::fields.
struct Goal {
  GoalKind kind = GoalKind::Position;
  std::string name = {};
  int joint = 0;                                           ///< the joint that carries the end-effector
  Eigen::Vector3d pointInJoint = Eigen::Vector3d::Zero();  ///< metres, frame of the joint
  Eigen::Vector3d target = Eigen::Vector3d::Zero();        ///< metres, world
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< wanted, of the joint's frame
  Eigen::Vector3d axisInJoint = Eigen::Vector3d::UnitZ();           ///< unit
  Eigen::VectorXd posture = {};                                     ///< nq

  int otherJoint = 0;                                      ///< of goals between two joints
  Eigen::Vector3d pointInOther = Eigen::Vector3d::Zero();  ///< metres, frame of the other joint
  double length = 0.0;                                     ///< metres: a distance, a radius, a margin
  Eigen::Vector3d end = Eigen::Vector3d::Zero();           ///< metres, world: where a segment ends
  Eigen::Vector3d direction = Eigen::Vector3d::UnitY();    ///< unit, world: upwards, outwards, along an axis
  std::vector<Eigen::Vector3d> polygon = {};               ///< metres, world
  std::shared_ptr<const Masses> masses = {};               ///< of the model

  double weight = 1.0;  ///< on the squared residual; a metre and a radian count alike
  Role role = Role::Drag;
  /// For solvers that serve goals in order, 0 first; others ignore it. Not given: pins first, drags next,
  /// holds last.
  std::optional<int> priority = {};

  int servedAs() const { return priority ? *priority : role == Role::Pin ? 0 : role == Role::Drag ? 1 : 2; }
};

}  // namespace gelenk
