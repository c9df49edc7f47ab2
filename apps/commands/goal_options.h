#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "solvers/problem/ik_problem.h"

namespace gelenk {

// Goals as a user types them.

/// What is asked of one joint: a place, an orientation, or both.
struct TypedGoal {
  int joint = 0;
  std::optional<Eigen::Vector3d> position = {};        ///< metres, world
  std::optional<Eigen::Quaterniond> orientation = {};  ///< unit
  Eigen::Vector3d point =
      Eigen::Vector3d::Zero();               ///< of the joint's frame, metres, that goes to the position
  std::optional<Eigen::Vector3d> axis = {};  ///< of the joint's frame, unit: only its direction is asked for
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< the axis shall have, world, unit
  double positionWeight = 1.0, orientationWeight = 1.0;
};

/// Three numbers: a position; four: an orientation QW QX QY QZ; seven: both. Throws std::invalid_argument
/// that begins with `what` for another count, numbers that are not finite, a quaternion that is not of
/// length 1.
void putNumbers(TypedGoal& goal, const std::vector<double>& numbers, const std::string& what);

/// "hand_r=0.1,1.2,0.3" with 3, 4 or 7 numbers; ":2" behind them is the weight. Throws likewise.
TypedGoal parseJointGoal(std::string_view text, const Skeleton& skeleton);

/// A JSON file: a list of {"joint", "target": [x, y, z], "orientation": [w, x, y, z], "point", "axis",
/// "direction", "weight", "orientation_weight"}. Throws ParseError or std::invalid_argument.
std::vector<TypedGoal> readGoals(const std::string& path, const Skeleton& skeleton);

/// "x", "-z" or "X,Y,Z": a unit vector. Throws std::invalid_argument.
Eigen::Vector3d parseAxis(const std::string& text);

/// The goals of a problem that ask for all of it; orientationFactor: on the weights of all turning parts.
std::vector<Goal> goalsOf(const std::vector<TypedGoal>& typed, double orientationFactor = 1.0);

}  // namespace gelenk
