#include "kinematics/motion/skeleton_transfer.h"

#include <filesystem>

#include "kinematics/configuration.h"
#include "kinematics/io/pinocchio_skeleton.h"
#include "tests/kinematics/io/bad_input.h"
#include "tests/kinematics/random_skeleton.h"
#include "tests/places.h"

namespace gelenk {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

/// Root, two bones up, one bone down, a bone that is in no path, a bone without length.
const std::string stick =
    ":units\nlength 0.0254\nangle deg\n:root\norder TX TY TZ RX RY RZ\naxis XYZ\n:bonedata\n"
    "begin\nname low\ndirection 0 1 0\nlength 1\naxis 10 20 30 XYZ\ndof rx ry rz\nend\n"
    "begin\nname high\ndirection 0.6 0.8 0\nlength 2\naxis 0 0 40 XYZ\ndof rx\nend\n"
    "begin\nname hat\ndirection 0 0 1\nlength 0.5\naxis 0 0 0 XYZ\ndof rz\nend\n"
    "begin\nname leg\ndirection 0 -1 0\nlength 1\naxis 0 0 0 XYZ\ndof rx\nend\n"
    "begin\nname nothing\ndirection 0 -1 0\nlength 0\naxis 0 0 0 XYZ\nend\n"
    ":hierarchy\nbegin\nroot low leg\nlow high\nhigh hat\nleg nothing\nend\n";

struct Fit {
  AsfSkeleton asf = parseAsf(stick, "stick.asf");
  Skeleton fitted = parsePinocchioSkeleton(
      "hip 1 5 0 -1\nmiddle 1 6 0 hip\ntop 2 7 0 middle\nfoot 1 7 0.5 hip\n", "fit.skel");
  std::vector<BonePath> paths{{{"low", "high"}, {"hip", "middle", "top"}}, {{"leg"}, {"hip", "foot"}}};
};

void expectDirectionsInTheirOwnFramesUnchanged(const AsfSkeleton& asf, const TransferredSkeleton& result) {
  for (const AsfSkeleton::Bone& bone : asf.bones) {
    const Vector3d along =
        result.bindFrames[bone.endJoint].translation() - result.bindFrames[bone.joint].translation();
    if (bone.joint == 0 || bone.length == 0.0 || along.norm() == 0.0) continue;
    const Vector3d before = bone.axis.conjugate() * bone.direction.normalized();  // O_old^-1 dir_old
    const Vector3d after =
        result.bindFrames[bone.joint].linear().transpose() * along.normalized();  // O_new^-1 dir_new
    EXPECT_LE((before - after).norm(), 1e-12) << bone.name;
    // and A dir_old = dir_new
    EXPECT_LE((result.turns[bone.joint] * bone.direction.normalized() - along.normalized()).norm(), 1e-12)
        << bone.name;
  }
}

TEST(SkeletonTransfer, BoneDirectionInItsOwnFrameIsUnchanged) {
  const Fit fit;
  expectDirectionsInTheirOwnFramesUnchanged(fit.asf, transferSkeleton(fit.asf, fit.fitted, fit.paths));
}

TEST(SkeletonTransfer, BonesEndOnTheFittedPathInTheProportionOfTheirLengths) {
  const Fit fit;
  const TransferredSkeleton result = transferSkeleton(fit.asf, fit.fitted, fit.paths);
  const auto end = [&](const char* name) {
    return Vector3d(result.bindFrames[fit.asf.bones[*fit.asf.findBone(name)].endJoint].translation());
  };
  const double total = 1.0 + std::sqrt(2.0);
  // One third of the way: still on the first, vertical piece of length 1.
  EXPECT_LE((end("low") - Vector3d(1, 5 + total / 3.0, 0)).norm(), 1e-12);
  EXPECT_LE((end("high") - Vector3d(2, 7, 0)).norm(), 1e-12);
  EXPECT_LE((end("leg") - Vector3d(1, 7, 0.5)).norm(), 1e-12);  // nearly antiparallel to where it hung
  EXPECT_EQ(result.unmatchedBones, (std::vector<std::string>{"hat", "nothing"}));
  EXPECT_TRUE(result.unmatchedJoints.empty());
}

TEST(SkeletonTransfer, AntiparallelBonesTurnByAHalfTurnAboutSomePerpendicularAxis) {
  Fit fit;
  fit.fitted = parsePinocchioSkeleton("hip 0 0 0 -1\nmiddle 0 1 0 hip\ntop 0 3 0 middle\nfoot 0 1.5 0 hip\n",
                                      "fit.skel");
  const TransferredSkeleton result = transferSkeleton(fit.asf, fit.fitted, fit.paths);
  expectDirectionsInTheirOwnFramesUnchanged(fit.asf, result);
  const int leg = *fit.asf.findBone("leg");
  EXPECT_NEAR(logRotation(result.turns[leg]).norm(), M_PI, 1e-6);
  EXPECT_NEAR(logRotation(result.turns[leg]).y(), 0.0, 1e-12);
}

TEST(SkeletonTransfer, AMotionTurnsTheBonesAsOnTheOriginalSkeleton) {
  const Fit fit;
  const TransferredSkeleton result = transferSkeleton(fit.asf, fit.fitted, fit.paths);
  std::mt19937_64 random(4);
  const Eigen::VectorXd q = randomWithinLimits(fit.asf.skeleton, random);
  const Frames original = forwardKinematics(fit.asf.skeleton, q),
               laid = forwardKinematics(result.skeleton, q);
  for (const AsfSkeleton::Bone& bone : fit.asf.bones) {
    EXPECT_LE((original[bone.joint].linear() - laid[bone.joint].linear()).norm(), 1e-12);
    if (bone.joint == 0 || bone.length == 0.0) continue;
    const Vector3d a = original[bone.endJoint].translation() - original[bone.joint].translation();
    const Vector3d b = laid[bone.endJoint].translation() - laid[bone.joint].translation();
    EXPECT_LE((a.normalized() - b.normalized()).norm(), 1e-12) << bone.name;
    const double bound =
        (result.bindFrames[bone.endJoint].translation() - result.bindFrames[bone.joint].translation()).norm();
    EXPECT_NEAR(b.norm(), bound, 1e-12) << bone.name;
  }
}

TEST(SkeletonTransfer, SaysWhatDoesNotFit) {
  const Fit fit;
  const auto refused = [&](std::vector<BonePath> paths, const std::string& part) {
    try {
      transferSkeleton(fit.asf, fit.fitted, paths);
      ADD_FAILURE() << part;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  refused({{{"tail"}, {"hip", "top"}}}, "found 'tail'");
  refused({{{"low"}, {"hip", "chin"}}}, "found 'chin'");
  refused({{{"low", "leg"}, {"hip", "middle"}}}, "a bone that hangs on 'low' before it, found 'leg'");
  refused({{{"low"}, {"hip", "top"}}}, "a bone joins to 'hip', found 'top'");
  refused({{{"low"}, {"hip", "middle"}}, {{"leg"}, {"middle", "hip"}}}, "begin at one joint");
  refused({{{"low"}, {"hip", "middle"}}, {{"low"}, {"hip", "middle"}}},
          "in one path only, found 'low' again");
  refused({{{"high"}, {"middle", "top"}}}, "no path begins at a bone of the root");
}

TEST(BonePaths, AreReadAndBadLinesRefused) {
  const auto paths = parseBonePaths("# spine\nlow high : hip middle top # up\r\n\nleg: 0 3\n", "map.txt");
  ASSERT_EQ(paths.size(), 2u);
  EXPECT_EQ(paths[0].bones, (std::vector<std::string>{"low", "high"}));
  EXPECT_EQ(paths[1].joints, (std::vector<std::string>{"0", "3"}));
}

TEST(BonePaths, BadMappingsAreRefusedWithTheirLine) {
  const Fit fit;
  const std::string good = "low high : hip middle top\n";  // one line
  testing::expectRefused(
      {
          {"empty", "", 0, "at least one line 'bones : joints', found none"},
          {"only blanks", " \n\t\n\r\n", 0, "at least one line"},
          {"only comments", "# low : hip\n#\n", 0, "at least one line"},
          {"no colon", "low hip\n", 1, "bones : joints, found no colon"},
          {"colon in the comment", "low hip # : \n", 1, "no colon"},
          {"no bone", "\n: hip top\n", 2, "at least one bone before the colon"},
          {"nothing but a colon", good + ":\n", 2, "at least one bone"},
          {"one joint", "low : hip\n", 1, "at least two joints after the colon, found 1"},
          {"no joint", "low :\n", 1, "at least two joints after the colon, found 0"},
          {"joints commented out", "low : # hip middle\n", 1, "found 0"},
          {"cut off", good + "leg : hi", 2, "found 1"},
          {"unknown bone", "tail : hip foot\n", 1, "(root, low, high, hat, leg, nothing), found 'tail'"},
          {"unknown bone later", good + "\nleg toe : hip foot\n", 3, "found 'toe'"},
          {"unknown joint", "low : hip chin\n", 1, "(hip, middle, top, foot), found 'chin'"},
          {"joint in other case", "low : Hip middle\n", 1, "'Hip'"},
          {"index too large", "low : 0 4\n", 1, "'4'"},
          {"huge index", "low : 0 99999999999\n", 1, "'99999999999'"},
          {"negative index", "low : 0 -1\n", 1, "'-1'"},
          {"fraction as index", "low : 0 1.5\n", 1, "'1.5'"},
          {"NaN as joint", "low : 0 nan\n", 1, "'nan'"},
          {"the root as bone", "root low : hip middle\n", 1,
           "(the root is none: it goes where the paths of its bones begin), found 'root'"},
          {"bones that do not hang on each other", good.substr(0, 0) + "low leg : hip middle\n", 1,
           "hangs on 'low' before it, found 'leg'"},
          {"bones in reverse", "high low : hip middle\n", 1, "hangs on 'high' before it, found 'low'"},
          {"a bone after itself", "low low : hip middle\n", 1, "hangs on 'low' before it, found 'low'"},
          {"a joint left out", "low : hip top\n", 1, "joins to 'hip', found 'top'"},
          {"a joint twice", "low : hip hip\n", 1, "joins to 'hip', found 'hip'"},
          {"a cycle of joints", "low high : hip middle top hip\n", 1, "joins to 'top', found 'hip'"},
          {"root bones that begin apart", good + "leg : middle hip\n", 2,
           "begin at one joint, 'hip', found 'middle'"},
          {"a bone in two paths", good + "low : hip middle\n", 2, "in one path only, found 'low' again"},
          {"a bone twice in other case", good + "LOW : hip middle\n", 2, "found 'low' again"},
          {"two colons", "low : high : hip middle\n", 1, "found 'high'"},
          {"CRLF keeps line numbers", "low high : hip middle top\r\n\r\nleg\r\n", 3, "no colon"},
          {"binary",
           std::string("\x7f"
                       "ELF\0\1:\2 \3",
                       10),
           1, "a bone of the ASF skeleton"},
          {"an ASF instead", stick, 1, "at least one bone before the colon"},
      },
      [&](const std::string& text, const std::string& file) {
        transferSkeleton(fit.asf, fit.fitted, parseBonePaths(text, file));
      });
}

TEST(BonePathsByName, TakeJointsOfEqualNamesWhateverTheirCaseAndSide) {
  const Fit fit;
  const Skeleton fitted = parsePinocchioSkeleton(
      "Rig:Hips 1 5 0 -1\nRig:LOW 1 5 0.1 Rig:Hips\nextra 1 6 0 Rig:LOW\nRig:High 1 7 0 extra\nRig:Hat 2 7 0 "
      "Rig:High\nleg 1 4 0 Rig:Hips\n",
      "fit.skel");
  const auto paths = bonePathsByName(fit.asf, fitted);
  ASSERT_EQ(paths.size(), 2u);
  // The bone at the root begins at the hips although a joint has its name; the leg has no matched joint below
  // it.
  EXPECT_EQ(paths[0].bones, std::vector<std::string>{"low"});
  EXPECT_EQ(paths[0].joints, (std::vector<std::string>{"Rig:Hips", "Rig:LOW", "extra", "Rig:High"}));
  EXPECT_EQ(paths[1].bones, std::vector<std::string>{"high"});
  EXPECT_EQ(paths[1].joints, (std::vector<std::string>{"Rig:High", "Rig:Hat"}));
  const TransferredSkeleton result = transferSkeleton(fit.asf, fitted, paths);
  expectDirectionsInTheirOwnFramesUnchanged(fit.asf, result);
  EXPECT_EQ(result.unmatchedBones, (std::vector<std::string>{"hat", "leg", "nothing"}));
  EXPECT_EQ(result.unmatchedJoints, std::vector<std::string>{"leg"});
}

TEST(SkeletonTransfer, FittedHumanOnTheCmuSkeletonMatchesAllButHandsThumbsAndToes) {
  const std::string data = testing::dataFolder();
  if (!std::filesystem::exists(data + "/mocap/asf/02.asf")) GTEST_SKIP() << "no trial data at " << data;
  const AsfSkeleton asf = readAsf(data + "/mocap/asf/02.asf");
  const Skeleton fitted = namedAsHuman(readPinocchioSkeleton(data + "/pinocchio/mh_male.skeleton.out"));
  const TransferredSkeleton result = transferSkeleton(asf, fitted, cmuOnPinocchioHuman());
  expectDirectionsInTheirOwnFramesUnchanged(asf, result);
  EXPECT_TRUE(result.unmatchedJoints.empty());
  EXPECT_EQ(result.unmatchedBones.size(), 8u);  // hand, fingers, thumb, toes on both sides
  const Frames rest = restFrames(fitted);
  const auto end = [&](const char* bone) {
    return Vector3d(result.bindFrames[asf.bones[*asf.findBone(bone)].endJoint].translation());
  };
  EXPECT_LE((end("lwrist") - rest[fitted.jointIndex("hand_left")].translation()).norm(), 1e-12);
  EXPECT_LE((end("rtibia") - rest[fitted.jointIndex("ankle_right")].translation()).norm(), 1e-12);
  EXPECT_NEAR(result.heightRatio, 1.0, 0.1);  // both are grown men

  // By names alone the limbs lie where the table lays them.
  const TransferredSkeleton byName = transferSkeleton(asf, fitted, bonePathsByName(asf, fitted));
  for (const char* bone :
       {"lfemur", "ltibia", "lhumerus", "rfemur", "rtibia", "rhumerus", "lradius", "lhipjoint"})
    EXPECT_LE((result.bindFrames[asf.bones[*asf.findBone(bone)].endJoint].translation() -
               byName.bindFrames[asf.bones[*asf.findBone(bone)].endJoint].translation())
                  .norm(),
              std::string(bone) == "lradius" ? 0.2 : 1e-12)  // the table lays radius and wrist together
        << bone;
}

}  // namespace
}  // namespace gelenk
