#pragma once

#include "apps/python/binding.h"
#include "solvers/problem/goal_type.h"

namespace gelenk::python {

/// A goal as Python makes it, before it is asked of a model: joints by name.
struct GoalValue {
  Goal goal;
  std::string joint, other;  ///< names; empty where given by index or not at all
  bool hasJoint = false, hasOther = false;

  /// The goal on that model's joints. masses: for kinds that need them. Throws std::invalid_argument.
  Goal on(const Skeleton& skeleton, const std::shared_ptr<const Masses>& masses) const;
};

/// Goals from whatever solve() takes for one problem: a GoalValue, a text, a target of `joint`, a dict of
/// joints and targets, or a list of these.
std::vector<Goal> goalsFrom(const SharedModel& model, py::handle value, py::handle joint,
                            const std::shared_ptr<const Masses>& masses);
/// A target of one joint: 3 numbers a position, 4 an orientation (w, x, y, z), 3 x 3 likewise, 7 and 4 x 4 a
/// pose.
Goal targetGoalOf(int joint, py::handle value);
/// The joint asked for, or the model's only end.
int effector(const SharedModel& model, py::handle joint);

}  // namespace gelenk::python
