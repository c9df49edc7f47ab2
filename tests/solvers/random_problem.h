#pragma once

#include <array>
#include <memory>
#include <string>

#include "kinematics/forward_kinematics.h"
#include "kinematics/notation/dh_table.h"
#include "kinematics/notation/robots.h"
#include "solvers/problem/ik_problem.h"
#include "tests/kinematics/random_skeleton.h"

namespace gelenk::testing {

/// A problem that owns its skeleton.
struct OwnedProblem {
  std::shared_ptr<const Skeleton> skeleton;
  IkProblem problem = {};
  std::string story = {};  ///< what makes it hard
};

inline Goal randomGoal(const Skeleton& skeleton, std::mt19937_64& random, const Frames& frames) {
  const int joint = static_cast<int>(random() % skeleton.jointCount());
  Goal goal{.kind = static_cast<GoalKind>(random() % 4),
            .joint = joint,
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

/// One to three goals on a model: reachable, out of reach, in conflict, singular and degenerate in turn.
inline OwnedProblem problemOn(std::shared_ptr<const Skeleton> model, std::mt19937_64& random, int number) {
  OwnedProblem owned{.skeleton = std::move(model)};
  const int kind = number % 10;
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
    for (Goal& goal : owned.problem.goals)
      goal.orientation = expRotation(M_PI * randomUnit(random)) * goal.orientation;
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
    owned.problem.goals.push_back(
        {.kind = GoalKind::Posture, .posture = randomWithinLimits(skeleton, random), .weight = 1e-3});
    owned.story = "with a posture";
  }
  return owned;
}

/// Trees of every joint kind with goals as above, and straight arms whose target lies on their axis: gradient
/// zero.
inline OwnedProblem randomProblem(std::mt19937_64& random, int number) {
  if (number % 10 != 0)
    return problemOn(std::make_shared<Skeleton>(randomSkeleton(random, 2 + static_cast<int>(random() % 9))),
                     random, number);
  OwnedProblem owned{.skeleton =
                         std::make_shared<Skeleton>(straightChain(3, number % 20 == 0 ? unlimited : 1.5))};
  owned.problem = {.skeleton = owned.skeleton.get(), .start = Eigen::VectorXd::Zero(3)};
  owned.problem.goals = {{.joint = 3, .target = {number % 3 ? 1.5 : 4.0, 0.0, 0.0}}};
  owned.story = "straight arm, target on its axis";
  return owned;
}

/// One goal on the end of a chain, as the solvers of chains want it; singular, unreachable and degenerate in
/// turn.
inline OwnedProblem chainProblem(std::shared_ptr<const Skeleton> model, std::mt19937_64& random, int number) {
  OwnedProblem owned{.skeleton = std::move(model)};
  const Skeleton& skeleton = *owned.skeleton;
  const int tip = skeleton.jointCount() - 1, kind = number % 8;
  constexpr std::array kinds{GoalKind::Position, GoalKind::Pose, GoalKind::Pose, GoalKind::Orientation};
  owned.problem = {.skeleton = &skeleton, .start = randomWithinLimits(skeleton, random)};
  Eigen::VectorXd there = randomWithinLimits(skeleton, random);
  owned.story = "reachable";
  if (kind == 1 || kind == 2) {
    there = neutral(skeleton);
    owned.story = "the model's neutral pose, where its joints are often in line";
  }
  const Eigen::Isometry3d frame = forwardKinematics(skeleton, there)[tip];
  Goal goal{.kind = kinds[random() % kinds.size()],
            .joint = tip,
            .target = frame.translation(),
            .orientation = Eigen::Quaterniond(frame.linear())};
  if (random() % 4 == 0) {
    goal.pointInJoint = 0.2 * randomUnit(random);
    goal.target = frame * goal.pointInJoint;
  }
  if (kind == 2) {
    owned.problem.start = neutral(skeleton);
    if (number % 3) goal.target *= 0.7;
    owned.story = "from the neutral pose, straight towards the base";
  } else if (kind == 3) {
    goal.target *= 1.0 + 100.0 * uniform01(random);
    owned.story = "out of reach";
  } else if (kind == 4) {
    goal.orientation = expRotation(M_PI * randomUnit(random)) *
                       Eigen::Quaterniond(forwardKinematics(skeleton, owned.problem.start)[tip].linear());
    owned.story = "half a turn away";
  } else if (kind == 5) {
    for (double& q : owned.problem.start) q += 20.0 * (uniform01(random) - 0.5);
    for (int i = 0; i < skeleton.jointCount(); ++i)
      if (skeleton.joint(i).ball)
        setBallRotation(skeleton, owned.problem.start, i, expRotation(3.0 * randomUnit(random)));
    owned.story = "start outside the limits";
  } else if (kind == 6) {
    goal.target = forwardKinematics(skeleton, there)[0].translation();
    owned.story = "target at the base";
  } else if (kind == 7) {
    owned.problem.start = there;
    owned.story = "already there";
  }
  goal.weight = number % 5 ? 1.0 : 0.01 + 10.0 * uniform01(random);
  owned.problem.goals = {goal};
  return owned;
}

/// Chains of hinges and sliders in Denavit-Hartenberg form: general, with parallel and intersecting axes,
/// lengths and ranges of zero.
inline Skeleton randomDhChain(std::mt19937_64& random, int dofs) {
  const auto oneOf = [&](std::initializer_list<double> values) {
    return values.begin()[random() % values.size()];
  };
  const auto signedRandom = [&] { return 2.0 * uniform01(random) - 1.0; };
  DhTable table{.convention = random() % 2 ? DhConvention::Modified : DhConvention::Standard};
  for (int i = 0; i < dofs; ++i) {
    DhRow row{.kind = random() % 5 ? DhJoint::Revolute : DhJoint::Prismatic,
              .a = oneOf({0.0, 0.0, 0.3, signedRandom()}),
              .alpha = oneOf({0.0, M_PI / 2, -M_PI / 2, 3.0 * signedRandom()}),
              .d = oneOf({0.0, 0.2, signedRandom()}),
              .phi = oneOf({0.0, 0.0, M_PI / 2, 3.0 * signedRandom()})};
    const double half = oneOf({0.0, 0.3, 1.0, 2.5, 4.0, unlimited}), middle = signedRandom();
    if (row.kind == DhJoint::Prismatic || half < unlimited) {
      row.lower = middle - std::min(half, 1.5);
      row.upper = middle + std::min(half, 1.5);
      if (row.kind == DhJoint::Revolute) row.lower = middle - half, row.upper = middle + half;
    }
    table.rows.push_back(row);
  }
  return toSkeleton(table);
}

/// Six-joint arms with a spherical wrist: the parameters of the PUMA 560, its lengths drawn anew.
inline Skeleton randomWristArm(std::mt19937_64& random) {
  DhTable table = robotTable("puma560");
  for (DhRow& row : table.rows) {
    if (row.a != 0.0) row.a *= 0.5 + uniform01(random);
    if (row.d != 0.0) row.d *= 0.5 + uniform01(random);
  }
  return toSkeleton(table);
}

/// A finger whose last two joints bend as the second does: turned sideways by the first, or all in one plane.
inline Skeleton tendonFinger(bool inPlane) {
  std::vector<Joint> joints;
  for (int i = 0; i <= 4; ++i) {
    Joint joint{.name = "f" + std::to_string(i), .parent = i - 1};
    if (i > 0) joint.parentFromZero.translation().x() = i < 3 ? 0.5 : 0.3;
    if (i < 4)
      joint.axes = {{AxisDof::Kind::Rotation,
                     i == 0 && !inPlane ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ(), -1.5, 1.6}};
    if (i == 2 || i == 3) joint.coupling = {.source = 1, .multiplier = i == 2 ? 0.7 : 0.5, .offset = 0.1};
    joints.push_back(joint);
  }
  return Skeleton(joints);
}

/// Balls in a row, all unlimited or all with a swing cone and a twist range; one bone in eight has no length.
inline Skeleton randomBallChain(std::mt19937_64& random) {
  const int bones = 1 + static_cast<int>(random() % 12);
  const bool limited = random() % 3 == 0;
  std::vector<Joint> joints;
  for (int i = 0; i <= bones; ++i) {
    Joint joint{.name = "b" + std::to_string(i), .parent = i - 1, .ball = i < bones};
    if (i > 0)
      joint.parentFromZero.translation() =
          (random() % 8 ? 1.0 : 0.0) *
          (random() % 2 ? Eigen::Vector3d(Eigen::Vector3d::UnitZ()) : randomUnit(random));
    if (limited && joint.ball) joint.ballLimit = BallLimit{{0.1, -0.2}, {0.9, 0.5}, -0.7, 1.1};
    joints.push_back(joint);
  }
  return Skeleton(joints);
}

/// A trunk with two arms of three joints and their tips: hinges about z and y in turn, or balls.
inline Skeleton fork(bool balls) {
  std::vector<Joint> joints{{.name = "trunk", .parent = -1, .ball = balls}};
  if (!balls) joints[0].axes = {{AxisDof::Kind::Rotation, Eigen::Vector3d::UnitY(), -1.0, 1.0}};
  for (const double side : {-1.0, 1.0})
    for (int i = 0; i <= 3; ++i) {
      Joint joint{.name = (side < 0.0 ? "l" : "r") + std::to_string(i),
                  .parent = i == 0 ? 0 : static_cast<int>(joints.size()) - 1,
                  .ball = balls && i < 3};
      joint.parentFromZero.translation() = Eigen::Vector3d(side * 0.3, i == 0 ? 0.5 : 0.1, 0.0);
      if (!balls && i < 3)
        joint.axes = {{AxisDof::Kind::Rotation, i % 2 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ(),
                       -2.0, 2.0}};
      joints.push_back(joint);
    }
  return Skeleton(joints);
}

/// One position on the tip of the first arm, within reach or not: the second arm is nobody's business.
inline OwnedProblem forkProblem(std::shared_ptr<const Skeleton> model, std::mt19937_64& random, int number) {
  OwnedProblem owned{.skeleton = std::move(model)};
  const Skeleton& skeleton = *owned.skeleton;
  owned.problem = {.skeleton = &skeleton, .start = randomWithinLimits(skeleton, random)};
  const int tip = skeleton.jointIndex("l3");
  const Eigen::Vector3d there =
      forwardKinematics(skeleton, randomWithinLimits(skeleton, random))[tip].translation();
  owned.problem.goals = {{.joint = tip, .target = (number % 3 ? 1.0 : 4.0) * there}};
  owned.story = number % 3 ? "one arm of two" : "one arm of two, out of reach";
  return owned;
}

}  // namespace gelenk::testing
