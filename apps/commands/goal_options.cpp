#include "apps/commands/goal_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

std::vector<double> numbersOf(std::string_view text, const std::string& what) {
  std::vector<double> numbers;
  while (true) {
    const std::string_view word = text.substr(0, text.find(','));
    const auto value = parseNumber(word);
    if (!value)
      throw std::invalid_argument(what + ": expected numbers between commas, found '" + std::string(word) +
                                  "'");
    numbers.push_back(*value);
    if (word.size() == text.size()) return numbers;
    text.remove_prefix(word.size() + 1);
  }
}

Quaterniond unitQuaternion(const double* wxyz, const std::string& what) {
  Quaterniond q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  if (!(std::abs(q.norm() - 1.0) < 1e-3))
    throw std::invalid_argument(
        fmt::format("{}: the quaternion must have length 1, not {:.6g}", what, q.norm()));
  return q.normalized();
}

Vector3d unitVector(const Vector3d& v, const std::string& what) {
  if (!(v.norm() > 1e-9) || !v.allFinite())
    throw std::invalid_argument(what + ": a direction needs a length");
  return v.normalized();
}

}  // namespace

void putNumbers(TypedGoal& goal, const std::vector<double>& t, const std::string& what) {
  for (double value : t)
    if (!std::isfinite(value)) throw std::invalid_argument(what + " must be finite numbers");
  if (t.size() != 3 && t.size() != 4 && t.size() != 7)
    throw std::invalid_argument(
        fmt::format("{} wants X Y Z, or QW QX QY QZ, or X Y Z QW QX QY QZ; {} values given", what, t.size()));
  if (t.size() != 4) goal.position = Vector3d(t[0], t[1], t[2]);
  if (t.size() != 3) goal.orientation = unitQuaternion(&t[t.size() - 4], what);
}

TypedGoal parseJointGoal(std::string_view text, const Skeleton& skeleton) {
  const std::string what = "--goal " + std::string(text);
  const std::size_t equals = text.rfind('=');
  if (equals == std::string_view::npos || equals == 0)
    throw std::invalid_argument(what + ": expected JOINT=X,Y,Z or JOINT=X,Y,Z,QW,QX,QY,QZ");
  TypedGoal goal{.joint = skeleton.jointIndex(std::string(text.substr(0, equals)))};
  std::string_view numbers = text.substr(equals + 1);
  if (const std::size_t colon = numbers.find(':'); colon != std::string_view::npos) {
    const auto weight = parseNumber(numbers.substr(colon + 1));
    if (!weight || !(*weight > 0.0))
      throw std::invalid_argument(what + ": a weight must be a number above 0");
    goal.positionWeight = goal.orientationWeight = *weight;
    numbers = numbers.substr(0, colon);
  }
  putNumbers(goal, numbersOf(numbers, what), what);
  return goal;
}

std::vector<TypedGoal> readGoals(const std::string& path, const Skeleton& skeleton) {
  using nlohmann::json;
  std::vector<TypedGoal> goals;
  try {
    const std::string text = readFile(path);
    const json list = json::parse(plainText(text, path));
    if (!list.is_array()) throw ParseError(path, 0, "a list of goals", list.type_name());
    for (std::size_t i = 0; i < list.size(); ++i) {
      const json& one = list[i];
      const std::string what = fmt::format("{}, goal {}", path, i + 1);
      static constexpr std::string_view known[] = {"joint", "target",    "orientation", "point",
                                                   "axis",  "direction", "weight",      "orientation_weight"};
      if (!one.is_object()) throw std::invalid_argument(what + ": expected an object");
      for (const auto& [key, value] : one.items())
        if (std::find(std::begin(known), std::end(known), key) == std::end(known))
          throw std::invalid_argument(
              what + ": unknown entry '" + key +
              "'; there are: joint, target, orientation, point, axis, direction, weight, "
              "orientation_weight");
      TypedGoal goal{.joint = skeleton.jointIndex(one.at("joint").get<std::string>())};
      const auto vector = [&](const char* key) {
        const auto v = one.at(key).get<std::vector<double>>();
        if (v.size() != 3) throw std::invalid_argument(what + ": '" + key + "' wants three numbers");
        return Vector3d(v[0], v[1], v[2]);
      };
      if (one.contains("target")) goal.position = vector("target");
      if (one.contains("orientation"))
        putNumbers(goal, one.at("orientation").get<std::vector<double>>(), what);
      if (one.contains("point")) goal.point = vector("point");
      if (one.contains("axis")) {
        goal.axis = unitVector(vector("axis"), what);
        if (one.contains("direction")) goal.direction = unitVector(vector("direction"), what);
      }
      goal.positionWeight = one.value("weight", 1.0);
      goal.orientationWeight = one.value("orientation_weight", goal.positionWeight);
      if (!(goal.positionWeight > 0.0) || !(goal.orientationWeight > 0.0))
        throw std::invalid_argument(what + ": weights must be above 0");
      if (!goal.position && !goal.orientation && !goal.axis)
        throw std::invalid_argument(what + ": asks for nothing; give a target, an orientation or an axis");
      goals.push_back(goal);
    }
  } catch (const json::exception& error) {
    throw ParseError(path, 0, "a list of goals in JSON", error.what());
  }
  if (goals.empty()) throw ParseError(path, 0, "a list of goals", "none");
  return goals;
}

Vector3d parseAxis(const std::string& text) {
  const bool minus = text.starts_with('-');
  const std::string name = minus ? text.substr(1) : text;
  if (name == "x" || name == "y" || name == "z")
    return (minus ? -1.0 : 1.0) * Vector3d::Unit(name[0] - 'x') + Vector3d::Zero();  // 0 is not told as -0
  const std::vector<double> v = numbersOf(text, "--axis " + text);
  if (v.size() != 3)
    throw std::invalid_argument("--axis wants x, -z or the like, or X,Y,Z, not '" + text + "'");
  return unitVector({v[0], v[1], v[2]}, "--axis " + text);
}

std::vector<Goal> goalsOf(const std::vector<TypedGoal>& typed, double orientationFactor) {
  std::vector<Goal> goals;
  for (const TypedGoal& one : typed) {
    const double turning = orientationFactor * one.orientationWeight;
    Goal goal{.joint = one.joint, .pointInJoint = one.point, .weight = one.positionWeight};
    if (one.position) goal.target = *one.position;
    if (one.orientation && !one.axis) {
      goal.orientation = *one.orientation;
      goal.kind = one.position ? GoalKind::Pose : GoalKind::Orientation;
      if (one.position && turning != one.positionWeight) {  // two parts with weights of their own
        goal.kind = GoalKind::Position;
        goals.push_back(goal);
        goal.kind = GoalKind::Orientation;
      }
      if (goal.kind == GoalKind::Orientation) goal.weight = turning;
      goals.push_back(goal);
      continue;
    }
    if (one.position) goals.push_back(goal);
    if (!one.axis) continue;
    goals.push_back({.kind = GoalKind::Direction,
                     .joint = one.joint,
                     .axisInJoint = *one.axis,
                     .direction = one.orientation ? Vector3d(*one.orientation * *one.axis) : one.direction,
                     .weight = turning});
  }
  return goals;
}

}  // namespace gelenk
