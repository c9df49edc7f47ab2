#include "kinematics/motion/joint_matching.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gelenk {
namespace {

/// Each joint hangs on the one before; every joint has one axis.
Skeleton chain(const std::vector<std::string>& names) {
  std::vector<Joint> joints;
  for (std::size_t i = 0; i < names.size(); ++i)
    joints.push_back({.name = names[i], .parent = static_cast<int>(i) - 1, .axes = {AxisDof{}}});
  return Skeleton(joints);
}

using Pairs = std::vector<std::pair<std::string, std::string>>;
Pairs pairs(const Skeleton& source, const Skeleton& target) {
  Pairs list;
  for (const JointMatch& match : matchJoints(source, target).matches)
    list.emplace_back(source.joint(match.source).name, target.joint(match.target).name);
  return list;
}

TEST(PlainNames, PutCaseSeparatorsSidesAndPrefixesAside) {
  const PlainName thigh{"thigh", Side::Left};
  for (const char* name : {"thigh_l", "Thigh.L", "LeftUpLeg", "left_thigh", "mixamorig:LeftUpLeg", "L-Femur",
                           "UpLeg_L", "upperleg.l", "hip_left", "scene|rig|thigh l"})
    EXPECT_EQ(plainNames(chain({"root", name}))[1], thigh) << name;
  EXPECT_EQ(plainNames(chain({"root", "lfemur", "rfemur"}))[1], thigh);
  EXPECT_EQ(
      plainNames(chain({"root", "lfemur"}))[1],
      (PlainName{"lfemur", Side::Middle}));  // without its counterpart the letter may be part of the name
  EXPECT_EQ(plainNames(chain({"root", "lowerback"}))[1], (PlainName{"lowerback", Side::Middle}));
  EXPECT_EQ(plainNames(chain({"root", "thumb_01_l"}))[1], (PlainName{"thumb1", Side::Left}));
  EXPECT_EQ(plainNames(chain({"root", "Thumb1_L"}))[1], (PlainName{"thumb1", Side::Left}));
  const auto shared = plainNames(chain({"Bip01", "Bip01 Pelvis", "Bip01 L Thigh", "Bip01 R Thigh"}));
  EXPECT_EQ(plainNames(chain({"root", "arm_l", "arm_r"}))[1],
            (PlainName{"upperarm", Side::Left}));  // what is left must be more than a side
  EXPECT_EQ(shared[1], (PlainName{"pelvis", Side::Middle})) << shared[1].part;
}

TEST(PlainNames, AShoulderIsTheCollarBoneWhereTheArmHasItsOwnName) {
  EXPECT_EQ(plainNames(chain({"root", "LeftShoulder", "LeftArm"}))[1].part, "clavicle");
  EXPECT_EQ(plainNames(chain({"root", "shoulder_left", "elbow_left"}))[1].part, "upperarm");
}

TEST(PlainNames, ARootIsThePelvisWhereThereIsNone) {
  const auto part = [](const std::vector<Joint>& joints) { return plainNames(Skeleton(joints))[0].part; };
  EXPECT_EQ(part({{.name = "root"}, {.name = "lfemur", .parent = 0}}), "pelvis");
  EXPECT_EQ(part({{.name = "root"}, {.name = "Hips", .parent = 0}}), "root");
}

TEST(JointMatching, PairsRigsOfDifferentMakersAndListsTheRest) {
  const Skeleton source =
      chain({"Hips", "Spine", "LeftShoulder", "LeftArm", "LeftForeArm", "LeftHand", "Tail"});
  const Skeleton target = chain({"pelvis", "clavicle_l", "upperarm_l", "lowerarm_l", "hand_l", "sword"});
  EXPECT_EQ(pairs(source, target), (Pairs{{"Hips", "pelvis"},
                                          {"LeftShoulder", "clavicle_l"},
                                          {"LeftArm", "upperarm_l"},
                                          {"LeftForeArm", "lowerarm_l"},
                                          {"LeftHand", "hand_l"}}));
  const JointMatching matching = matchJoints(source, target);
  EXPECT_THAT(matching.unmatchedSource, ::testing::ElementsAre("Spine", "Tail"));
  EXPECT_THAT(matching.unmatchedTarget, ::testing::ElementsAre("sword"));
}

TEST(JointMatching, EqualNamesComeFirstThenTheShortestOfSeveral) {
  EXPECT_EQ(pairs(chain({"root", "__UpLeg_L", "UpLeg_L"}), chain({"root", "thigh_l"})),
            (Pairs{{"root", "root"}, {"UpLeg_L", "thigh_l"}}));
  EXPECT_EQ(pairs(chain({"root", "__UpLeg_L", "UpLeg_L"}), chain({"root", "__UpLeg_L"})),
            (Pairs{{"root", "root"}, {"__UpLeg_L", "__UpLeg_L"}}));
  EXPECT_EQ(pairs(chain({"root", "foot_l", "FOOT_L"}), chain({"root", "FootL"})),
            (Pairs{{"root", "root"}}));  // which of the two cannot be told
}

TEST(JointMatching, NeverTurnsTheHierarchyRound) {
  EXPECT_EQ(pairs(chain({"root", "knee", "ankle"}), chain({"root", "ankle", "knee"})),
            (Pairs{{"root", "root"}, {"ankle", "ankle"}}));
}

TEST(JointMatching, LeftIsNeverRight) {
  EXPECT_EQ(pairs(chain({"root", "hand_l"}), chain({"root", "hand_r"})), (Pairs{{"root", "root"}}));
}

}  // namespace
}  // namespace gelenk
