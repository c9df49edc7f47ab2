#pragma once

#include "solvers/problem/goal_type.h"

// The centre of mass as a sum of carried points: shared by centre_of_mass.cpp and balance.cpp.
namespace gelenk::goal_parts {

/// Joints that carry a hundredth of the whole mass or more: the others are moved by them and move nothing.
inline void heavyJoints(const Goal& goal, const Skeleton& skeleton, std::vector<int>& out) {
  const double least = 0.01 * goal.masses->total();
  for (int i = 0; i < skeleton.jointCount(); ++i)
    if (goal.masses->mass[i] >= least) out.push_back(i);
}

inline void carriedMass(const Goal& goal, const Skeleton& skeleton, int, std::vector<Carried>& out) {
  const double total = goal.masses->total();
  for (int i = 0; i < skeleton.jointCount(); ++i)
    if (goal.masses->mass[i] > 0.0)
      out.push_back({.joint = i, .inJoint = goal.masses->centre[i], .share = goal.masses->mass[i] / total});
}

inline Eigen::Vector3d massReached(const Goal& goal, const GoalPlace& at) {
  return centreOfMass(*goal.masses, at.frames);
}

}  // namespace gelenk::goal_parts
