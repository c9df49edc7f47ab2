#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "kinematics/skeleton.h"

namespace gelenk {

/// What a goal asks for. The residual rows it contributes are in brackets; all are zero when the goal is met.
enum class GoalKind {
  Position,     ///< pointInJoint is at target [3, metres]
  Orientation,  ///< the joint's frame has the orientation; rotation vector of target * current^-1, world axes
                ///< [3, radians]
  Pose,         ///< both [6]
  Aim,      ///< axisInJoint points from the joint's origin at target; current x wanted direction [3, about
            ///< radians]
  Pole,     ///< the joint (an elbow, a knee) lies on the side of target: see CountedEvaluator [1, metres]
  Posture,  ///< the configuration is near posture; difference(q, posture) [nv, radians and metres]
};

struct Goal {
  GoalKind kind = GoalKind::Position;
  std::string name = {};
  int joint = 0;                                           ///< the joint that carries the end-effector
  Eigen::Vector3d pointInJoint = Eigen::Vector3d::Zero();  ///< metres, frame of the joint
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  ///< metres, world; Pole: a point on the wanted side
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();  ///< worldFromJoint wanted
  Eigen::Vector3d axisInJoint = Eigen::Vector3d::UnitZ();           ///< Aim only, unit
  Eigen::VectorXd posture = {};                                     ///< Posture only, nq
  double weight = 1.0;  ///< on the squared residual; a metre and a radian count alike
  int priority = 0;     ///< 0 is served first by solvers that know priorities; others ignore it
};

/// Find q within the skeleton's limits that meets all goals, beginning at start.
struct IkProblem {
  const Skeleton* skeleton = nullptr;
  Eigen::VectorXd start = {};  ///< nq
  std::vector<Goal> goals = {};
  double positionTolerance = 1e-6;     ///< metres, on the distance itself (not its square)
  double orientationTolerance = 1e-6;  ///< radians, on the angle itself
};

}  // namespace gelenk
