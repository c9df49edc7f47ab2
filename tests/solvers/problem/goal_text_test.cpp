#include "solvers/problem/goal_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/solvers/problem/random_goal.h"

namespace gelenk {
namespace {

using ::testing::HasSubstr;

std::string refusal(std::string_view text, const Skeleton& skeleton) {
  try {
    goalFromText(text, skeleton);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(GoalText, EveryKindIsReadBackAsItWasWritten) {
  std::mt19937_64 random(61);
  const Skeleton skeleton = testing::randomSkeleton(random, 8);
  const Eigen::VectorXd q = randomWithinLimits(skeleton, random);
  const Frames frames = forwardKinematics(skeleton, q);
  for (const GoalType* type : goalTypes()) {
    Goal goal = testing::randomGoalOf(type->kind, skeleton, q, frames, random);
    goal.role = Role::Pin;
    goal.priority = 3;
    goal.axisInJoint.normalize();
    goal.orientation.normalize();
    const Goal back = goalFromText(goalToText(goal, skeleton), skeleton, goal.masses);
    EXPECT_EQ(goalToText(back, skeleton), goalToText(goal, skeleton)) << type->name;
    EXPECT_EQ(back.weight, goal.weight);
    EXPECT_EQ(back.role, Role::Pin);
    EXPECT_EQ(back.servedAs(), 3);
  }
}

TEST(GoalText, SaysWhatIsWrongAndWhatThereIs) {
  const Skeleton skeleton({{.name = "a"}, {.name = "b", .parent = 0}});
  EXPECT_THAT(refusal("", skeleton), HasSubstr("its kind"));
  EXPECT_THAT(refusal("positon joint=b", skeleton), HasSubstr("position"));
  EXPECT_THAT(refusal("position joint=b", skeleton), HasSubstr("needs target"));
  EXPECT_THAT(refusal("position joint=c target=0,0,0", skeleton), HasSubstr("a, b"));
  EXPECT_THAT(refusal("position joint=b target=0,0", skeleton), HasSubstr("X,Y,Z"));
  EXPECT_THAT(refusal("position joint=b target=0,0,nan", skeleton), HasSubstr("'nan'"));
  EXPECT_THAT(refusal("position joint=b target=0,0,0 length=1", skeleton), HasSubstr("no field 'length'"));
  EXPECT_THAT(refusal("position joint=b target=0,0,0 role=nail", skeleton), HasSubstr("drag, hold, pin"));
  EXPECT_THAT(refusal("position joint=b joint=b target=0,0,0", skeleton), HasSubstr("twice"));
  EXPECT_THAT(refusal("distance joint=b other=b length=1", skeleton), HasSubstr("different"));
  EXPECT_THAT(refusal("distance joint=a other=b length=-1", skeleton), HasSubstr("below 0"));
  EXPECT_THAT(refusal("centre-of-mass target=0,0,0", skeleton), HasSubstr("no masses"));
  EXPECT_EQ(refusal("keep-out joint=b target=0,0,1 radius=0.5", skeleton), "accepted");
}

}  // namespace
}  // namespace gelenk
