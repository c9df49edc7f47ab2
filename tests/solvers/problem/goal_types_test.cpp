#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "solvers/iteration/evaluator.h"
#include "solvers/problem/goal_type.h"
#include "solvers/problem/judge.h"
#include "solvers/problem/support.h"
#include "tests/solvers/problem/random_goal.h"

namespace gelenk {

void PrintTo(const GoalType* type, std::ostream* out) { *out << type->name; }

namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// Every type that joins the table inherits these.
class EveryGoalType : public ::testing::TestWithParam<const GoalType*> {
 protected:
  const GoalType& type = *GetParam();
};

TEST_P(EveryGoalType, JacobianMatchesCentralDifferencesOnEveryKindOfJoint) {
  std::mt19937_64 random(31);
  constexpr double h = 1e-6;
  int pressed = 0;
  for (int i = 0; i < 60; ++i) {
    const Skeleton skeleton = testing::randomSkeleton(random, 10);
    const VectorXd q = randomWithinLimits(skeleton, random);
    const Frames frames = forwardKinematics(skeleton, q);
    const Goal goal = testing::randomGoalOf(type.kind, skeleton, q, frames, random);
    if (!whyInvalid(goal, skeleton).empty()) continue;
    if (type.kind == GoalKind::Posture) continue;  // J = I only where q is the posture: difference() bends
    const IkProblem problem{.skeleton = &skeleton, .start = q, .goals = {goal}};
    CountedEvaluator at(problem);
    at.moveTo(q);
    pressed += at.residual().norm() > 1e-3;
    const Eigen::MatrixXd J = at.jacobian();
    for (int k = 0; k < skeleton.nv(); ++k) {
      const VectorXd dq = h * VectorXd::Unit(skeleton.nv(), k);
      at.moveTo(integrate(skeleton, q, dq));
      const VectorXd plus = at.residual();
      at.moveTo(integrate(skeleton, q, -dq));
      const VectorXd slope = (plus - at.residual()) / (2 * h);
      EXPECT_LE((slope + J.col(k)).norm(), 1e-7 * std::max(1.0, J.norm()))
          << "skeleton " << i << ", column " << k;  // h^2 and rounding / h
    }
  }
  if (type.kind != GoalKind::Posture && type.kind != GoalKind::Orientation && type.kind != GoalKind::Aim &&
      type.kind != GoalKind::Direction)
    EXPECT_GE(pressed, 50);  // these differences mean something
}

TEST_P(EveryGoalType, IsMetWhereItWasCaptured) {
  std::mt19937_64 random(32);
  for (int i = 0; i < 40; ++i) {
    const Skeleton skeleton = testing::randomSkeleton(random, 8);
    const VectorXd q = randomWithinLimits(skeleton, random);
    const Frames frames = forwardKinematics(skeleton, q);
    Goal goal{.kind = type.kind, .joint = 7, .pointInJoint = {0.1, 0.2, 0}, .otherJoint = 2};
    goal.masses = testing::randomMasses(skeleton, random);
    type.capture(goal, {skeleton, q, frames});
    if (!whyInvalid(goal, skeleton).empty()) continue;  // a pole on an end
    const IkProblem problem{.skeleton = &skeleton, .start = q, .goals = {goal}};
    EXPECT_TRUE(judge(problem, q).solved) << "skeleton " << i;
  }
}

TEST_P(EveryGoalType, HasAMarkAndFiniteOnes) {
  std::mt19937_64 random(33);
  for (int i = 0; i < 20; ++i) {
    const Skeleton skeleton = testing::randomSkeleton(random, 8);
    const VectorXd q = randomWithinLimits(skeleton, random);
    const Frames frames = forwardKinematics(skeleton, q);
    const Goal goal = testing::randomGoalOf(type.kind, skeleton, q, frames, random);
    if (!whyInvalid(goal, skeleton).empty()) continue;
    GoalMark mark;
    type.mark(goal, {skeleton, q, frames}, mark);
    for (const Vector3d& p : mark.points) EXPECT_TRUE(p.allFinite());
    for (const auto& s : mark.segments) EXPECT_TRUE(s.from.allFinite() && s.to.allFinite());
    for (const auto& r : mark.rings) EXPECT_TRUE(r.centre.allFinite() && r.radius >= 0.0);
    if (type.judged)
      EXPECT_GT(mark.points.size() + mark.segments.size() + mark.rings.size() + mark.polygons.size(), 0u);
  }
}

TEST_P(EveryGoalType, SaysWhatIsWrongWithIt) {
  std::mt19937_64 random(34);
  const Skeleton skeleton = testing::randomSkeleton(random, 8);
  const VectorXd q = randomWithinLimits(skeleton, random);
  const Frames frames = forwardKinematics(skeleton, q);
  const Goal good = testing::randomGoalOf(type.kind, skeleton, q, frames, random);
  ASSERT_EQ(whyInvalid(good, skeleton), "");
  for (const GoalField& field : type.fields) {
    Goal bad = good;
    using Meaning = GoalField::Meaning;
    if (field.meaning == Meaning::Joint)
      bad.*std::get<int Goal::*>(field.member) = 99;
    else if (field.meaning == Meaning::Length)
      bad.*std::get<double Goal::*>(field.member) = -1.0;
    else if (field.meaning == Meaning::Polygon)
      bad.polygon.resize(2);
    else if (field.meaning == Meaning::Posture)
      bad.posture.resize(2);
    else if (field.meaning == Meaning::Rotation)
      bad.orientation.coeffs().setZero();
    else
      (bad.*std::get<Vector3d Goal::*>(field.member))[1] = std::nan("");
    EXPECT_THAT(whyInvalid(bad, skeleton), ::testing::HasSubstr(std::string(field.name))) << field.name;
  }
  if (type.needsMasses) {
    Goal bad = good;
    bad.masses.reset();
    EXPECT_THAT(whyInvalid(bad, skeleton), ::testing::HasSubstr("masses"));
  }
}

INSTANTIATE_TEST_SUITE_P(Table, EveryGoalType, ::testing::ValuesIn(goalTypes().begin(), goalTypes().end()),
                         [](const auto& info) {
                           std::string name(info.param->name);
                           std::erase(name, '-');
                           return name;
                         });

TEST(GoalTypes, StandInTheTableUnderTheirKindAndEachNameIsOne) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < goalTypes().size(); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(goalTypes()[i]->kind), i);
    EXPECT_TRUE(names.insert(goalTypes()[i]->name).second);
    EXPECT_EQ(&goalType(goalTypes()[i]->name), goalTypes()[i]);
  }
  EXPECT_THROW(goalType("positon"), std::invalid_argument);
}

TEST(GoalTypes, WhatMovesTwoJointsAlikeIsNothingBetweenThem) {
  std::mt19937_64 random(35);
  for (int i = 0; i < 30; ++i) {
    const Skeleton skeleton = testing::randomSkeleton(random, 9);
    const VectorXd q = randomWithinLimits(skeleton, random);
    const Frames frames = forwardKinematics(skeleton, q);
    for (const GoalKind kind : {GoalKind::Distance, GoalKind::RelativePosition, GoalKind::RelativePose}) {
      Goal goal = testing::randomGoalOf(kind, skeleton, q, frames, random);
      const double length = goal.length;
      goalType(kind).capture(goal, {skeleton, q, frames});
      if (kind == GoalKind::Distance) goal.length = length;
      const IkProblem problem{.skeleton = &skeleton, .start = q, .goals = {goal}};
      CountedEvaluator at(problem);
      at.moveTo(q);
      for (int joint = 0; joint < skeleton.jointCount(); ++joint) {
        if (!skeleton.isAncestor(joint, goal.joint) || !skeleton.isAncestor(joint, goal.otherJoint)) continue;
        if (joint == goal.joint || joint == goal.otherJoint) continue;
        const auto columns = at.jacobian().middleCols(skeleton.vIndex(joint), skeleton.vCount(joint));
        EXPECT_LE(columns.norm(), 1e-13 * std::max(1.0, at.jacobian().norm())) << goalType(kind).name;
      }
    }
  }
}

TEST(SupportPolygon, HullInsetAndNearestOfASquareByHand) {
  const Vector3d up = Vector3d::UnitY();
  const SupportPolygon square =
      SupportPolygon::hull({{0, 0, 0}, {2, 0.3, 0}, {2, 0, 2}, {0, 0, 2}, {1, 5, 1}, {1, 0, 0}}, up);
  ASSERT_EQ(square.corners.size(), 4u);
  EXPECT_TRUE(SupportPolygon::isConvex(square.corners, up));
  EXPECT_TRUE(square.nearest({1, 9, 1}).way.isZero(0.0));
  EXPECT_LE((square.nearest({3, 7, 1}).way - Vector3d(-1, 0, 0)).norm(), 1e-15);
  EXPECT_LE((square.nearest({3, 7, 1}).outward - Vector3d(1, 0, 0)).norm(), 1e-15);
  EXPECT_LE((square.nearest({3, 7, 4}).way - Vector3d(-1, 0, -2)).norm(), 1e-15);
  EXPECT_TRUE(square.nearest({3, 7, 4}).corner);
  const SupportPolygon smaller = square.inset(0.25);
  EXPECT_LE((smaller.nearest({3, 0, 1}).way - Vector3d(-1.25, 0, 0)).norm(), 1e-15);
  EXPECT_NEAR(square.outside({1, 0, 0.5}), -0.5, 1e-15);
  EXPECT_LE((square.inset(3.0).nearest({1, 0, 4}).way - Vector3d(0, 0, -3)).norm(), 1e-15);  // its middle
}

}  // namespace
}  // namespace gelenk
