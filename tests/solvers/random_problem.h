#pragma once

#include <memory>
#include <string>

#include "kinematics/forward_kinematics.h"
#include "solvers/ik_problem.h"
#include "tests/kinematics/random_skeleton.h"

namespace gelenk::testing {

/// A problem that owns its skeleton.
struct OwnedProblem {
  std::shared_ptr<const Skeleton> skeleton;
  IkProblem problem;
  std::string story;  ///< what makes it hard
};

inline Goal randomGoal(const Skeleton& skeleton, std::mt19937_64& random, const Frames& frames) {
  const int joint = static_cast<int>(random() % skeleton.jointCount());
  Goal goal{.kind = static_cast<GoalKind>(random() % 4), .joint = joint,
            .pointInJoint = 0.2 * uniform01(random) * randomUnit(random)};
  goal.axisInJoint = randomUnit(random);
  goal.orientation = Eigen::Quaterniond(frames[joint].linear());
  goal.target = goal.kind == GoalKind::Aim
                    ? Eigen::Vector3d(frames[joint].translation() + frames[joint].linear() * goal.axisInJoint)
                    : Eigen::Vector3d(frames[joint] * goal.pointInJoint);
  return goal;
}

/// A straight chain of n hinges about z with unit links along x: singular where it begins.
inline Skeleton straightChain(int n, double limit = unlimited) {
  std::vector<Joint> joints;
  for (int i = 0; i <= n; ++i) {
    Joint joint{.name = "l" + std::to_string(i), .parent = i - 1};
    if (i > 0) joint.parentFromZero.translation().x() = 1.0;
    if (i < n) joint.axes = {{AxisDof::Kind::Rotation, Eigen::Vector3d::UnitZ(), -limit, limit}};
    joints.push_back(joint);
  }
  return Skeleton(joints);
}

/// Trees of every joint kind, one to three goals; reachable, out of reach, in conflict, singular and degenerate in turn.
inline OwnedProblem randomProblem(std::mt19937_64& random, int number) {
  OwnedProblem owned;
  const int kind = number % 10;
  if (kind == 0) {  // straight arm, target on its axis: gradient zero
    owned.skeleton = std::make_shared<Skeleton>(straightChain(3, number % 20 == 0 ? unlimited : 1.5));
    owned.problem = {.skeleton = owned.skeleton.get(), .start = Eigen::VectorXd::Zero(3)};
    owned.problem.goals = {{.joint = 3, .target = {number % 3 ? 1.5 : 4.0, 0.0, 0.0}}};
    owned.story = "straight arm, target on its axis";
    return owned;
  }
  owned.skeleton = std::make_shared<Skeleton>(randomSkeleton(random, 2 + static_cast<int>(random() % 9)));
  const Skeleton& skeleton = *owned.skeleton;
  owned.problem = {.skeleton = &skeleton, .start = randomWithinLimits(skeleton, random)};
  Frames frames = forwardKinematics(skeleton, randomWithinLimits(skeleton, random));
  const int goals = 1 + static_cast<int>(random() % 3);
  for (int i = 0; i < goals; ++i) owned.problem.goals.push_back(randomGoal(skeleton, random, frames));
  owned.story = "reachable";
  if (kind == 1) {
    for (Goal& goal : owned.problem.goals) goal.target += 50.0 * randomUnit(random);
    owned.story = "out of reach";
  } else if (kind == 2) {
    Goal other = owned.problem.goals[0];
    other.target += randomUnit(random);
    other.orientation = expRotation(2.0 * randomUnit(random)) * other.orientation;
    owned.problem.goals.push_back(other);
    owned.story = "two goals in conflict";
  } else if (kind == 3) {
    owned.problem.goals.clear();
    owned.story = "no goals";
  } else if (kind == 4) {
    for (int k = 0; k < skeleton.nq(); ++k) owned.problem.start[k] += 3.0 * (uniform01(random) - 0.5);
    for (int i = 0; i < skeleton.jointCount(); ++i)
      if (skeleton.joint(i).ball)
        setBallRotation(skeleton, owned.problem.start, i, expRotation(3.0 * randomUnit(random)));
    owned.story = "start outside the limits";
  } else if (kind == 5) {  // half a turn away: the rotation vector is at its cut
    for (Goal& goal : owned.problem.goals) goal.orientation = expRotation(M_PI * randomUnit(random)) * goal.orientation;
    owned.story = "half a turn away";
  } else if (kind == 6) {
    const int joint = owned.problem.goals[0].joint;
    for (Goal& goal : owned.problem.goals) {
      goal.target = frames[joint].translation();
      goal.weight = 0.01 + 10.0 * uniform01(random);
      goal.priority = static_cast<int>(random() % 3);
    }
    owned.story = "targets at one point, weights and priorities";
  } else if (kind == 7) {
    owned.problem.goals.push_back({.kind = GoalKind::Posture, .posture = randomWithinLimits(skeleton, random), .weight = 1e-3});
    owned.story = "with a posture";
  }
  return owned;
}

}  // namespace gelenk::testing
