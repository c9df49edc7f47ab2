#include "kinematics/motion/motion_retarget.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/io/bvh.h"
#include "kinematics/notation/mannequin.h"
#include "kinematics/rotation.h"
#include "kinematics/skeleton_transform.h"
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
  EXPECT_EQ(result.sourceUp, Vector3d::UnitZ());  // MakeHuman's files stand along z
  const Eigen::Matrix3d upright = Eigen::AngleAxisd(-M_PI / 2, Vector3d::UnitX()).toRotationMatrix();
  double worst = 0.0;
  for (int f = 0; f < bvh.clip.frameCount(); ++f) {
    const Frames a = forwardKinematics(bvh.skeleton, bvh.clip.q.col(f)),
                 b = forwardKinematics(figure, result.clip.q.col(f));
    for (const auto& [from, to, start, end] :
         {std::tuple{"UpLeg_L", "LoLeg_L", "thigh_l", "calf_l"},
          std::tuple{"UpLeg_R", "LoLeg_R", "thigh_r", "calf_r"},
          std::tuple{"UpArm_L", "LoArm_L", "upperarm_l", "lowerarm_l"},
          std::tuple{"UpArm_R", "LoArm_R", "upperarm_r", "lowerarm_r"}}) {
      const Vector3d u = upright * (a[bvh.skeleton.jointIndex(to)].translation() -
                                    a[bvh.skeleton.jointIndex(from)].translation());
      const Vector3d v = b[figure.jointIndex(end)].translation() - b[figure.jointIndex(start)].translation();
      worst = std::max(worst, std::acos(std::clamp(u.normalized().dot(v.normalized()), -1.0, 1.0)));
    }
  }
  EXPECT_LE(worst, 1e-6);  // hips and shoulders are balls: only rounding of acos near 1
}

const std::string inputs = testing::inputFolder() + "/";

Vector3d place(const Skeleton& skeleton, const MotionClip& clip, int frame, const char* joint) {
  return forwardKinematics(skeleton, clip.q.col(frame))[skeleton.jointIndex(joint)].translation();
}

TEST(Retarget, AZeroPoseThatIsNoStanceChangesNothingButTheNames) {
  const BvhMotion source = readBvh(inputs + "lying_zero_pose.bvh"), target = readBvh(inputs + "apose.bvh");
  const RetargetedClip result = retargeted(source.skeleton, source.clip, target.skeleton);
  EXPECT_NEAR(result.scale, 1.0, 1e-9);
  EXPECT_EQ(result.standingFrame, 0);
  // Both bodies have the same bones, so every joint stays where the source has it.
  for (int f = 0; f < 2; ++f)
    for (const char* joint : {"Hips", "Spine", "Head", "LeftArm", "LeftForeArm", "LeftHand", "RightHand",
                              "LeftUpLeg", "LeftLeg", "LeftFoot", "RightFoot"})
      EXPECT_LT((place(target.skeleton, result.clip, f, (std::string("mixamorig:") + joint).c_str()) -
                 place(source.skeleton, source.clip, f, joint))
                    .norm(),
                1e-6)
          << joint << " in frame " << f + 1;
  EXPECT_LT((place(target.skeleton, result.clip, 1, "mixamorig:Hips") - Vector3d(0.3, 0.85, 0)).norm(), 1e-9);
  EXPECT_NEAR(place(target.skeleton, result.clip, 1, "mixamorig:LeftFoot").y(), 0.05, 1e-9);
}

/// CMU has lowerback, upperback and thorax, Unreal's mannequin spine_01 to spine_03, Mixamo Spine to Spine2.
TEST(Retarget, SpinesAreMatchedFromBelowWhateverTheirJointsAreCalled) {
  const auto body = [](const std::vector<std::string>& names) {
    std::vector<Joint> joints;
    for (const std::string& name : names) {
      Joint joint{.name = name, .parent = static_cast<int>(joints.size()) - 1, .ball = true};
      joint.parentFromZero.translation().y() = joints.empty() ? 0.0 : 0.1;
      joints.push_back(joint);
    }
    return Skeleton(joints);
  };
  const auto pairs = [&](const std::vector<std::string>& from, const std::vector<std::string>& onto) {
    const Skeleton source = body(from), target = body(onto);
    const MotionClip clip{.framesPerSecond = 1.0, .q = source.rest()};
    std::string text;
    const JointMatching matching = retargeted(source, clip, target).matching;
    for (const JointMatch& match : matching.matches)
      text += source.joint(match.source).name + '-' + target.joint(match.target).name + ' ';
    for (const std::string& name : matching.unmatchedTarget) text += '+' + name;
    for (const std::string& name : matching.unmatchedSource) text += '-' + name;
    return text;
  };
  EXPECT_EQ(pairs({"root", "lowerback", "upperback", "thorax", "lowerneck"},
                  {"pelvis", "spine_01", "spine_02", "spine_03", "neck_01"}),
            "root-pelvis lowerback-spine_01 upperback-spine_02 thorax-spine_03 lowerneck-neck_01 ");
  EXPECT_EQ(pairs({"Hips", "Spine", "Spine1", "Spine2", "Spine3", "Neck"}, {"pelvis", "low", "high", "neck"}),
            "Hips-pelvis Spine-low Spine2-high Neck-neck -Spine1-Spine3");
  EXPECT_EQ(pairs({"Hips", "waist", "Chest", "Neck"}, {"pelvis", "a", "b", "chest", "c", "neck"}),
            "Hips-pelvis waist-a Chest-chest Neck-neck +b+c");
}

/// Collar bones that begin deeper in the chest of the one rig than of the other shrug no shoulders.
TEST(Retarget, TheTrunkOfABodyThatStandsKeepsItsShapeAndLimbsPointAlike) {
  const auto body = [](double slope, double armDown) {
    std::vector<Joint> joints;
    const auto add = [&](const char* name, int parent, const Vector3d& offset) {
      Joint joint{.name = name, .parent = parent, .ball = true};
      joint.parentFromZero.translation() = offset;
      joints.push_back(joint);
      return static_cast<int>(joints.size()) - 1;
    };
    const int hips = add("Hips", -1, {0, 0.9, 0}), spine = add("Spine", hips, {0, 0.3, 0.1 * slope}),
              neck = add("Neck", spine, {0, 0.2, -0.1 * slope});
    add("Head", neck, {0, 0.2, 0});
    for (const double side : {1.0, -1.0}) {
      const std::string name = side > 0 ? "Left" : "Right";
      const int collar = add((name + "Shoulder").c_str(), spine, {0.02 * side, 0.1, 0}),
                arm = add((name + "Arm").c_str(), collar, {0.15 * side, slope, 0}),
                elbow = add((name + "ForeArm").c_str(), arm, {0.3 * side, -armDown, 0});
      add((name + "Hand").c_str(), elbow, {0.3 * side, -armDown, 0});
      const int thigh = add((name + "UpLeg").c_str(), hips, {0.1 * side, 0, 0}),
                knee = add((name + "Leg").c_str(), thigh, {0, -0.45, 0});
      add((name + "Foot").c_str(), knee, {0, -0.45, 0});
    }
    return Skeleton(joints);
  };
  const Skeleton source = body(0.15, 0.1), target = body(0.0, 0.0);
  MotionClip clip{.framesPerSecond = 1.0, .q = source.rest().replicate(1, 2)};
  Eigen::VectorXd bent = source.rest();
  const Eigen::Quaterniond bow(Eigen::AngleAxisd(0.4, Vector3d::UnitX()));
  setJointRotation(source, bent, source.jointIndex("Spine"), bow);
  clip.q.col(1) = bent;
  const RetargetedClip result = retargeted(source, clip, target);
  const Frames rest = restFrames(target), stands = forwardKinematics(target, result.clip.q.col(0)),
               bows = forwardKinematics(target, result.clip.q.col(1));
  for (const char* joint : {"Spine", "Neck", "LeftShoulder", "RightShoulder"}) {
    const int j = target.jointIndex(joint);
    EXPECT_TRUE(stands[j].linear().isApprox(rest[j].linear(), 1e-9)) << joint;
    EXPECT_TRUE(bows[j].linear().isApprox(bow.toRotationMatrix() * rest[j].linear(), 1e-9)) << joint;
  }
  const Vector3d arm =
      place(target, result.clip, 0, "LeftForeArm") - place(target, result.clip, 0, "LeftArm");
  EXPECT_LT((arm.normalized() - Vector3d(0.3, -0.1, 0).normalized()).norm(), 1e-9);
}

TEST(Retarget, ATargetWhoseZeroPoseIsNoStanceMovesAsTheSource) {
  const BvhMotion source = readBvh(inputs + "apose.bvh"), lying = readBvh(inputs + "lying_zero_pose.bvh");
  MotionClip clip = source.clip;
  const int leg = source.skeleton.qIndex(source.skeleton.jointIndex("mixamorig:LeftLeg"));
  clip.q(leg + 1, clip.frameCount() - 1) += 0.5;
  for (const double turned : {0.0, 1.0, M_PI / 2}) {  // its pelvis and chest have bones in several directions
    const Skeleton target = rotated(
        lying.skeleton, Eigen::Quaterniond(Eigen::AngleAxisd(turned, Vector3d(2, 1, 2).normalized())));
    const RetargetedClip result = retargeted(source.skeleton, clip, target);
    EXPECT_NEAR(result.scale, 1.0, 1e-9);
    for (int f = 0; f < clip.frameCount(); ++f)
      for (const char* joint : {"Hips", "Spine", "Head", "LeftArm", "LeftForeArm", "LeftHand", "RightHand",
                                "LeftUpLeg", "LeftLeg", "LeftFoot", "RightFoot"})
        EXPECT_LT((place(target, result.clip, f, joint) -
                   place(source.skeleton, clip, f, (std::string("mixamorig:") + joint).c_str()))
                      .norm(),
                  1e-6)
            << joint << " in frame " << f + 1 << " turned by " << turned;
  }
}

/// The clip with the whole source turned and placed otherwise.
BvhMotion zUp(const std::string& file) {
  BvhMotion bvh = readBvh(file);
  bvh.skeleton = rotated(bvh.skeleton, Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitX())));
  return bvh;
}

TEST(Retarget, TheAxisThatPointsUpIsFoundInSourceAndToldOfTheTarget) {
  const BvhMotion target = readBvh(inputs + "apose.bvh");
  for (const char* file : {"lying_zero_pose.bvh", "forearm.bvh"}) {
    const BvhMotion plain = readBvh(inputs + file), turned = zUp(inputs + file);
    const RetargetedClip a = retargeted(plain.skeleton, plain.clip, target.skeleton),
                         b = retargeted(turned.skeleton, turned.clip, target.skeleton);
    EXPECT_EQ(a.sourceUp, Vector3d::UnitY()) << file;
    EXPECT_EQ(b.sourceUp, Vector3d::UnitZ()) << file;
    EXPECT_LT((a.clip.q - b.clip.q).cwiseAbs().maxCoeff(), 1e-9) << file;
    const Skeleton standing =
        rotated(target.skeleton, Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitX())));
    const RetargetedClip c =
        retargeted(plain.skeleton, plain.clip, standing, {.targetUp = Vector3d::UnitZ()});
    EXPECT_LT((a.clip.q - c.clip.q).cwiseAbs().maxCoeff(), 1e-9) << file;
  }
}

TEST(Retarget, HingesReachTheirDirectionByTheTwistOfTheBallAbove) {
  const BvhMotion source = readBvh(inputs + "forearm.bvh");
  const Skeleton figure = mannequin();
  const RetargetedClip result = retargeted(source.skeleton, source.clip, figure);
  const std::vector<Vector3d> expected{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int f = 0; f < 3; ++f) {
    const Vector3d forearm =
        (place(figure, result.clip, f, "hand_l") - place(figure, result.clip, f, "lowerarm_l")).normalized();
    EXPECT_LT((forearm - expected[f]).norm(), 1e-6) << "frame " << f + 1 << ": " << forearm.transpose();
    const Vector3d upper =
        (place(figure, result.clip, f, "lowerarm_l") - place(figure, result.clip, f, "upperarm_l"))
            .normalized();
    EXPECT_LT((upper - Vector3d::UnitX()).norm(), 1e-6);
    EXPECT_LE(limitViolation(figure, result.clip.q.col(f), figure.jointIndex("lowerarm_l")), 0.1) << f;
  }
}

TEST(Retarget, ElbowsAndKneesPointAsTheSourcesDoInEveryDirection) {
  // Random directions of forearm and shank on balls; the figure's are hinges.
  const BvhMotion source = readBvh(inputs + "forearm.bvh");
  MotionClip clip = source.clip;
  clip.q = source.clip.q.col(0).replicate(1, 200);
  std::mt19937_64 random(5);
  for (int f = 0; f < 200; ++f)
    for (const char* joint : {"LeftArm", "LeftForeArm", "RightArm", "RightForeArm", "LeftUpLeg", "LeftLeg"})
      for (int k = 0; k < 3; ++k)
        clip.q(source.skeleton.qIndex(source.skeleton.jointIndex(joint)) + k, f) =
            2.0 * (2.0 * uniform01(random) - 1.0);
  const Skeleton figure = mannequin();
  const RetargetedClip result = retargeted(source.skeleton, clip, figure);
  int hinges = 0;
  for (const RemainingAngle& angle : result.remaining)
    for (const char* name : {"upperarm_l", "lowerarm_l", "lowerarm_r", "calf_l"})
      if (figure.joint(angle.joint).name == name) {
        EXPECT_LT(angle.mean, 1e-6) << name;
        ++hinges;
      }
  EXPECT_EQ(hinges, 4);
}

TEST(Retarget, TheScaleComesFromTheLegsBonesWhateverThePoseAndUnit) {
  const BvhMotion source = readBvh(inputs + "lying_zero_pose.bvh", {.metresPerUnit = 0.1}),
                  target = readBvh(inputs + "apose.bvh");
  EXPECT_NEAR(retargeted(source.skeleton, source.clip, target.skeleton).scale, 10.0, 1e-9);
  const RetargetedClip given = retargeted(source.skeleton, source.clip, target.skeleton, {.scale = 2.0});
  EXPECT_NEAR(place(target.skeleton, given.clip, 1, "mixamorig:Hips").x(), 0.06, 1e-9);
  EXPECT_THROW(retargeted(source.skeleton, source.clip, target.skeleton, {.scale = -1.0}),
               std::invalid_argument);
}

TEST(Retarget, KeptFeetStayInTheirScaledPlaces) {
  // A source that squats: its feet stand still while the hips go down. The target's shanks are longer.
  BvhMotion source = readBvh(inputs + "forearm.bvh");
  MotionClip clip{.framesPerSecond = 30.0, .q = source.clip.q.col(0).replicate(1, 20)};
  const auto angle = [&](const char* joint) {
    return source.skeleton.qIndex(source.skeleton.jointIndex(joint)) + 1;
  };
  for (int f = 0; f < 20; ++f) {
    const double bend = 0.04 * f;
    clip.q(1, f) -= 0.8 * (1.0 - std::cos(bend));
    for (const char* side : {"Left", "Right"}) {
      clip.q(angle((std::string(side) + "UpLeg").c_str()), f) = -bend;
      clip.q(angle((std::string(side) + "Leg").c_str()), f) = 2.0 * bend;
      clip.q(angle((std::string(side) + "Foot").c_str()), f) = -bend;
    }
  }
  std::vector<Joint> joints = readBvh(inputs + "apose.bvh").skeleton.joints();
  for (Joint& joint : joints)
    if (joint.name.ends_with("Foot")) joint.parentFromZero.translation().y() = -0.5;
  const Skeleton target(joints);
  const RetargetedClip loose = retargeted(source.skeleton, clip, target),
                       kept = retargeted(source.skeleton, clip, target, {.keepFeet = true});
  const auto slid = [&](const RetargetedClip& result) {
    return (place(target, result.clip, 19, "mixamorig:LeftFoot") -
            place(target, result.clip, 0, "mixamorig:LeftFoot"))
        .norm();
  };
  EXPECT_GT(slid(loose), 0.01);
  constexpr double straight = 2e-4;  // at its full length a leg's last tenth of a millimetre takes many steps
  EXPECT_LT(slid(kept), straight);
  ASSERT_EQ(kept.kept.size(), 2u);
  EXPECT_LT(kept.kept[0].largest, straight);
  EXPECT_EQ(kept.kept[0].contactFrames, 19);
  EXPECT_LT(kept.kept[0].targetSlide, 1e-6);
}

/// Arms that lie straight, nearly so, or bent, on arms of other lengths; both bodies have the same legs.
TEST(Retarget, KeptHandsAreReachedByArmsThatAreLongEnough) {
  const BvhMotion source = readBvh(inputs + "forearm.bvh");
  MotionClip clip{.framesPerSecond = 30.0, .q = source.clip.q.col(0).replicate(1, 60)};
  std::mt19937_64 random(12);
  for (int f = 1; f < 60; ++f)  // frame 0: straight to the last bit
    for (const char* joint : {"LeftForeArm", "RightForeArm"})
      clip.q(source.skeleton.qIndex(source.skeleton.jointIndex(joint)) + static_cast<int>(random() % 2), f) +=
          2.0 * std::pow(10.0, -9.0 * uniform01(random));
  for (const double longer : {0.8, 1.0, 1.02, 1.3}) {
    std::vector<Joint> joints = readBvh(inputs + "apose.bvh").skeleton.joints();
    double arm = 0.0;
    for (Joint& joint : joints)
      if (joint.name.ends_with("ForeArm") || joint.name.ends_with("Hand")) {
        joint.parentFromZero.translation() *= longer;
        arm += 0.5 * joint.parentFromZero.translation().norm();
      }
    const Skeleton target(joints);
    const RetargetedClip kept = retargeted(source.skeleton, clip, target, {.keepHands = true});
    ASSERT_EQ(kept.kept.size(), 2u);
    for (const KeptPlace& hand : kept.kept) {
      const std::string name = target.joint(hand.joint).name, side = name.substr(name.find(':') + 1);
      const std::string shoulder = name.substr(0, name.size() - 4) + "Arm";
      int beyond = 0;
      for (int f = 0; f < 60; ++f) {
        const Vector3d wanted = place(source.skeleton, clip, f, side.c_str());
        const double way = (wanted - place(target, kept.clip, f, shoulder.c_str())).norm(),
                     left = (wanted - place(target, kept.clip, f, name.c_str())).norm();
        beyond += way > arm * (1.0 + 1e-12);
        // at its full length an arm's last tenth of a millimetre takes many steps
        EXPECT_NEAR(left, std::max(0.0, way - arm), way < 0.9999 * arm ? 1e-6 : 2e-4)
            << name << " in frame " << f << ", arms of " << longer;
      }
      EXPECT_NEAR(hand.framesBeyond, beyond, longer == 1.0 ? 60 : 0);  // rounding decides at equal lengths
      EXPECT_LT(hand.largestWithin, 2e-4);
    }
  }
}

}  // namespace
}  // namespace gelenk
