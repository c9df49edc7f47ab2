#include "apps/document/clip_editor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinematics/configuration.h"
#include "kinematics/rotation.h"

namespace gelenk {
namespace {

using ::testing::ElementsAre;

/// A free root and a hinge that sweeps at a constant rate.
Skeleton sweeper() {
  Joint root{.name = "root"};
  for (int k = 0; k < 3; ++k) root.axes.push_back({AxisDof::Kind::Translation, Eigen::Vector3d::Unit(k)});
  root.ball = true;
  Joint hinge{.name = "hinge", .parent = 0, .axes = {{AxisDof::Kind::Rotation, Eigen::Vector3d::UnitX()}}};
  return Skeleton({root, hinge});
}
MotionClip sweep(const Skeleton& skeleton) {
  MotionClip clip{.framesPerSecond = 30, .q = neutral(skeleton).replicate(1, 60)};
  for (int f = 0; f < 60; ++f) clip.q(7, f) = 0.01 * f;
  return clip;
}

TEST(ClipEditor, KeysAreHitMovedTakenAwayAndUndone) {
  const Skeleton skeleton = sweeper();
  const MotionClip original = sweep(skeleton);
  ClipEditor editor(skeleton, original);
  const auto begin = editor.edits();
  Eigen::VectorXd pose = neutral(skeleton);
  pose[7] = 1.0;
  pose[1] = 0.5;
  editor.setKeys({1}, 20, pose);
  EXPECT_EQ(editor.clip().q(7, 20), 1.0);
  EXPECT_EQ(editor.clip().q(1, 20), 0.0);                // the root was not asked for
  EXPECT_EQ(editor.clip().q(7, 40), original.q(7, 40));  // beyond the fade of 0.25 s
  editor.setKeys({0, 1}, 40, pose);
  EXPECT_THAT(editor.keyFrames(), ElementsAre(20, 40));
  editor.moveKeys(20, 10);
  EXPECT_EQ(editor.clip().q(7, 10), 1.0);
  EXPECT_THAT(editor.keyFrames(), ElementsAre(10, 40));
  const auto before = editor.edits();
  editor.moveKeys(10, 40);  // replaces the hinge's key there
  EXPECT_THAT(editor.keyFrames(), ElementsAre(40));
  editor.setEdits(before);
  editor.removeKey(1, 40);
  EXPECT_FALSE(editor.hasKey(1, 40));
  EXPECT_TRUE(editor.hasKey(0, 40));
  editor.removeKeys(40);
  EXPECT_THAT(editor.keyFrames(), ElementsAre(10));
  editor.setEdits(begin);
  EXPECT_EQ(editor.clip().q, original.q);
  editor.setEdits(before);
  EXPECT_EQ(editor.clip().q(7, 10), 1.0);
}

TEST(ClipEditor, AnEditOfTheWholeClipTakesTheKeysIn) {
  const Skeleton skeleton = sweeper();
  ClipEditor editor(skeleton, sweep(skeleton));
  Eigen::VectorXd pose = neutral(skeleton);
  pose[7] = 1.0;
  editor.setKeys({1}, 20, pose);
  const auto before = editor.edits();
  editor.crossFade(sweep(skeleton), 0.5);
  EXPECT_EQ(editor.clip().frameCount(), 60 + 60 - 15);
  EXPECT_TRUE(editor.keys().empty());
  EXPECT_EQ(editor.clip().q(7, 20), 1.0);
  editor.lay({.clip = sweep(skeleton), .weight = 0.0});
  EXPECT_EQ(editor.clip().q(7, 20), 1.0);
  editor.backToOriginal();
  EXPECT_EQ(editor.clip().q, sweep(skeleton).q);
  editor.setEdits(before);
  EXPECT_TRUE(editor.hasKey(1, 20));
}

TEST(ClipEditor, RefusesWhatDoesNotFitAndStaysAsItWas) {
  const Skeleton skeleton = sweeper();
  ClipEditor editor(skeleton, sweep(skeleton));
  const int version = editor.version();
  Eigen::VectorXd bad = neutral(skeleton);
  bad[0] = std::nan("");
  EXPECT_THROW(editor.setKeys({1}, 60, neutral(skeleton)), std::invalid_argument);
  EXPECT_THROW(editor.setKeys({1}, 0, bad), std::invalid_argument);
  EXPECT_THROW(editor.setKeys({1}, 0, Eigen::VectorXd(3)), std::invalid_argument);
  EXPECT_THROW(editor.moveKeys(0, -1), std::invalid_argument);
  EXPECT_THROW(editor.crossFade(sweep(skeleton), 10.0), std::invalid_argument);
  EXPECT_THROW(editor.setFalloff(-1.0), std::invalid_argument);
  EXPECT_THROW(editor.setFrameRate(0.0), std::invalid_argument);
  ClipEdits foreign{.base = std::make_shared<MotionClip>(MotionClip{.q = Eigen::MatrixXd::Zero(3, 5)})};
  EXPECT_THROW(editor.setEdits(std::make_shared<ClipEdits>(foreign)), std::invalid_argument);
  EXPECT_EQ(editor.version(), version);
  EXPECT_EQ(editor.edits(), nullptr);
}

TEST(MovedJoints, AreThoseWhoseOwnMotionDiffers) {
  const Skeleton skeleton = sweeper();
  Eigen::VectorXd q = neutral(skeleton);
  EXPECT_TRUE(movedJoints(skeleton, neutral(skeleton), q).empty());
  q[7] = 1e-3;
  EXPECT_THAT(movedJoints(skeleton, neutral(skeleton), q), ElementsAre(1));
  setBallRotation(skeleton, q, 0, expRotation({0, 0.1, 0}));
  EXPECT_THAT(movedJoints(skeleton, neutral(skeleton), q), ElementsAre(0, 1));
}

}  // namespace
}  // namespace gelenk
