#include "kinematics/motion/motion_retarget.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "kinematics/forward_kinematics.h"
#include "kinematics/io/bvh.h"
#include "kinematics/notation/mannequin.h"
#include "tests/kinematics/random_skeleton.h"
#include "tests/places.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

/// A free pelvis at a height, a leg down, an arm to the side or down; every joint a ball. `frame` turns the
/// joints' own frames without moving them.
Skeleton body(double height, const Vector3d& arm, const Eigen::Matrix3d& frame,
              const std::vector<std::string>& names) {
  std::vector<Joint> joints(5);
  for (int i = 0; i < 5; ++i) joints[i] = {.name = names[i], .parent = i - 1, .ball = true};
  joints[3].parent = 0;
  const std::vector<Vector3d> from{Vector3d(0, height, 0), Vector3d(0.1, 0, 0) * height,
                                   Vector3d(0, -height, 0), Vector3d(0, 0.5 * height, 0), arm * height};
  for (int i = 0; i < 5; ++i) {
    joints[i].parentFromZero.translation() = i == 0 ? from[i] : Vector3d(frame.transpose() * from[i]);
    if (i == 0) joints[i].parentFromZero.linear() = frame;
  }
  for (int k = 0; k < 3; ++k) joints[0].axes.push_back({AxisDof::Kind::Translation, Vector3d::Unit(k)});
  return Skeleton(joints);
}

MotionClip randomClip(const Skeleton& skeleton, int frames) {
  std::mt19937_64 random(11);
  MotionClip clip{.framesPerSecond = 30, .q = Eigen::MatrixXd(skeleton.nq(), frames)};
  for (int f = 0; f < frames; ++f) clip.q.col(f) = randomWithinLimits(skeleton, random);
  return clip;
}

const std::vector<std::string> someNames{"pelvis", "thigh_l", "foot_l", "upperarm_l", "hand_l"},
    otherNames{"Hips", "LeftUpLeg", "LeftFoot", "LeftArm", "LeftHand"};

TEST(Retarget, OnTheSameSkeletonIsTheSameMotion) {
  const Skeleton skeleton = body(1.0, Vector3d::UnitX(), Eigen::Matrix3d::Identity(), someNames);
  const MotionClip clip = randomClip(skeleton, 50);
  const RetargetedClip result = retargeted(skeleton, clip, skeleton);
  EXPECT_NEAR(result.scale, 1.0, 1e-15);
  for (int f = 0; f < 50; ++f) {
    const Frames a = forwardKinematics(skeleton, clip.q.col(f)),
                 b = forwardKinematics(skeleton, result.clip.q.col(f));
    for (int i = 0; i < 5; ++i) EXPECT_LE((a[i].matrix() - b[i].matrix()).norm(), 1e-12);
  }
}

TEST(Retarget, BonesPointAlikeWhateverRestPoseFramesAndSize) {
  for (const Eigen::Matrix3d& sourceFrame : {Eigen::Matrix3d(Eigen::Matrix3d::Identity()),
                                             expRotation(Vector3d(-0.4, 0.9, 0.2)).toRotationMatrix()}) {
    const Skeleton source = body(1.0, Vector3d::UnitX(), sourceFrame, someNames);  // the arm to the side
    const Skeleton target = body(0.5, Vector3d(0.6, -0.8, 0),
                                 expRotation(Vector3d(0.3, -0.7, 1.1)).toRotationMatrix(), otherNames);
    const MotionClip clip = randomClip(source, 50);
    const RetargetedClip result = retargeted(source, clip, target);
    EXPECT_EQ(result.matching.matches.size(), 5u);
    EXPECT_NEAR(result.scale, 0.5, 1e-12);
    EXPECT_TRUE(result.rootMoves);
    for (int f = 0; f < 50; ++f) {
      const Frames a = forwardKinematics(source, clip.q.col(f)),
                   b = forwardKinematics(target, result.clip.q.col(f));
      for (const auto& [from, to] : {std::pair{1, 2}, std::pair{3, 4}})
        EXPECT_LE(((a[to].translation() - a[from].translation()).normalized() -
                   (b[to].translation() - b[from].translation()).normalized())
                      .norm(),
                  1e-12);
      EXPECT_LE((0.5 * a[0].translation() - b[0].translation()).norm(), 1e-12);  // both stand on y = 0
    }
  }
}

TEST(Retarget, NeedsTwoJointsOfEqualNames) {
  const Skeleton source = body(1.0, Vector3d::UnitX(), Eigen::Matrix3d::Identity(), someNames);
  const Skeleton target =
      body(1.0, Vector3d::UnitX(), Eigen::Matrix3d::Identity(), {"a", "b", "c", "d", "hand_l"});
  EXPECT_THROW(retargeted(source, randomClip(source, 2), target), std::invalid_argument);
}

TEST(Retarget, WalkOfTheTrialDataGoesOnTheFigureWithLimbsThatPointAlike) {
  const std::string file = testing::dataFolder() + "/mocap/bvh/mh_walk1.bvh";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no trial data at " << file;
  const BvhMotion bvh = readBvh(file, {.metresPerUnit = 0.1});
  const Skeleton figure = mannequin();
  const RetargetedClip result = retargeted(bvh.skeleton, bvh.clip, figure);
  EXPECT_GE(result.matching.matches.size(), 40u);
  double worst = 0.0;
  for (int f = 0; f < bvh.clip.frameCount(); ++f) {
    const Frames a = forwardKinematics(bvh.skeleton, bvh.clip.q.col(f)),
                 b = forwardKinematics(figure, result.clip.q.col(f));
    for (const auto& [from, to, start, end] :
         {std::tuple{"UpLeg_L", "LoLeg_L", "thigh_l", "calf_l"},
          std::tuple{"UpLeg_R", "LoLeg_R", "thigh_r", "calf_r"},
          std::tuple{"UpArm_L", "LoArm_L", "upperarm_l", "lowerarm_l"},
          std::tuple{"UpArm_R", "LoArm_R", "upperarm_r", "lowerarm_r"}}) {
      const Vector3d u =
          a[bvh.skeleton.jointIndex(to)].translation() - a[bvh.skeleton.jointIndex(from)].translation();
      const Vector3d v = b[figure.jointIndex(end)].translation() - b[figure.jointIndex(start)].translation();
      worst = std::max(worst, std::acos(std::clamp(u.normalized().dot(v.normalized()), -1.0, 1.0)));
    }
  }
  EXPECT_LE(worst, 1e-6);  // hips and shoulders are balls: only rounding of acos near 1
}

}  // namespace
}  // namespace gelenk
