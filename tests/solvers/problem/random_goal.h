#pragma once

#include "solvers/problem/goal_type.h"
#include "tests/kinematics/random_skeleton.h"

namespace gelenk::testing {

inline std::shared_ptr<const Masses> randomMasses(const Skeleton& skeleton, std::mt19937_64& random) {
  Masses masses;
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    masses.mass.push_back(i % 4 == 3 ? 0.0 : uniform01(random));
    masses.centre.push_back(0.3 * randomUnit(random));
  }
  return std::make_shared<const Masses>(std::move(masses));
}

/// A goal of the kind on a skeleton of three joints or more, at q: not met but in its orientation, whose
/// geometric Jacobian is the derivative only where it is met. Where `wholly`, orientations are not met
/// either.
inline Goal randomGoalOf(GoalKind kind, const Skeleton& skeleton, const Eigen::VectorXd& q,
                         const Frames& frames, std::mt19937_64& random, bool wholly = false) {
  using Eigen::Vector3d;
  const int n = skeleton.jointCount();
  Goal goal{.kind = kind, .masses = randomMasses(skeleton, random)};
  goal.joint = 1 + static_cast<int>(random() % (n - 1));
  do goal.otherJoint = static_cast<int>(random() % n);
  while (goal.otherJoint == goal.joint);
  goal.pointInJoint = 0.4 * randomUnit(random);
  goal.pointInOther = 0.4 * randomUnit(random);
  goal.axisInJoint = randomUnit(random);
  goal.direction = randomUnit(random);
  goal.posture = randomWithinLimits(skeleton, random);
  goal.weight = 0.3 + uniform01(random);
  if (kind == GoalKind::Pole)
    for (int i = n - 1; i > 0; --i)
      if (!skeleton.children(i).empty()) goal.joint = i;
  const GoalPlace at{skeleton, q, frames};
  const GoalType& type = goalType(kind);
  goal.polygon.clear();
  type.capture(goal, at);  // met
  const Vector3d x = frames[goal.joint] * goal.pointInJoint;
  const Vector3d centre = centreOfMass(*goal.masses, frames);
  switch (static_cast<int>(random() % 2)) {
    case 0: goal.length = 0.3 + uniform01(random); break;
    default: goal.length = 0.05; break;
  }
  if (kind == GoalKind::Aim) {
    const double distance = 0.5 + 2.0 * uniform01(random);
    goal.target =
        frames[goal.joint].translation() + distance * (frames[goal.joint].linear() * goal.axisInJoint);
    if (wholly) goal.target += distance * randomUnit(random);
  } else if (kind == GoalKind::KeepOut) {  // inside: beside the segment, or beyond its end
    const Vector3d out = randomUnit(random), along = out.unitOrthogonal();
    goal.length = 0.5;
    goal.target = x + (0.1 + 0.3 * uniform01(random)) * out + (random() % 2 ? 0.3 : -0.1) * along;
    goal.end = random() % 3 ? Vector3d(goal.target - 0.8 * along) : goal.target;
  } else if (kind == GoalKind::HalfSpace) {
    goal.target = x + (uniform01(random) + 0.1) * goal.direction + goal.direction.unitOrthogonal();
    goal.length = 0.05;
  } else if (kind == GoalKind::Balance) {  // outside: beside an edge, or at a corner
    const Vector3d a = goal.direction.unitOrthogonal(), b = goal.direction.cross(a);
    const double side = random() % 2 ? 0.2 : 0.7;
    goal.polygon.clear();
    for (const double u : {-0.5, 0.5})
      for (const double v : {-0.5, 0.5})
        goal.polygon.push_back(centre + (u + 1.0) * a + (v + side) * b - 0.7 * goal.direction);
    goal.length = 0.05;
  } else {
    goal.target += 0.4 * randomUnit(random);
    goal.pointInOther += 0.4 * randomUnit(random);
  }
  if (wholly && kind == GoalKind::Direction)
    goal.direction = expRotation(1.5 * randomUnit(random)) * goal.direction;
  if (wholly) goal.orientation = expRotation(1.5 * randomUnit(random)) * goal.orientation;
  return goal;
}

}  // namespace gelenk::testing
