#include "kinematics/io/tutorial_skeleton.h"

#include <cstring>

#include "kinematics/forward_kinematics.h"
#include "kinematics/io/text_file.h"
#include "tests/kinematics/io/bad_input.h"
#include "tests/kinematics/random_skeleton.h"
#include "tests/places.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

const std::string assets = testing::assetFolder();

const std::string fork =
    "NumJoints: 4\n"
    "NonAnimatedJointPositions:\n"
    "0.000000, 0.000000, 0.000000,\n0.000000, 1.000000, 0.000000,\n0.500000, 2.000000, 0.000000,\n-0.500000, "
    "2.000000, 0.000000,\n"
    "NumBones: 3\n0, 1,\n1, 2,\n1, 3,\n"
    "NumJointHierarchies: 2\nNumJoints-trunk+left: 3\n0, 1, 2,\nNumJoints-right: 2\n1, 3,\n";

TEST(TutorialSkeleton, FigureHasTheTextsCountsItsSixPositionsAndItsFourteenGroups) {
  const TutorialSkeleton figure = readTutorialSkeleton(assets + "/tutorial_figure.figure");
  EXPECT_EQ(figure.positions.size(), 41u);
  EXPECT_EQ(figure.bones.size(), 40u);
  ASSERT_EQ(figure.groups.size(), 14u);
  const std::pair<int, Vector3d> given[] = {{0, {0.07, 0.72, 0.05}},     {1, {0.07, 0.72, -0.05}},
                                            {2, {0, 0.81, 0}},           {3, {-0.07, 0.68, 0}},
                                            {39, {-0.01, -0.38, -0.12}}, {40, {-0.01, -0.38, 0.12}}};
  for (const auto& [joint, position] : given) EXPECT_EQ(figure.positions[joint], position);
  EXPECT_EQ(figure.bones.front(), (std::array{8, 7}));
  EXPECT_EQ(figure.bones.back(), (std::array{40, 26}));
  EXPECT_EQ(figure.groups[0].name, "Wirbelsaeule+Hals+KopfTeil1");
  EXPECT_EQ(figure.groups[12].joints, (std::vector<int>{8, 25, 38, 40, 26, 27, 28}));
  const TutorialFigure model = toSkeleton(figure);
  EXPECT_EQ(model.skeleton.joint(0).name, "joint8");
  const Frames rest = restFrames(model.skeleton);
  for (int j = 0; j < 41; ++j)
    EXPECT_LE((rest[model.jointOfIndex[j]].translation() - figure.positions[j]).norm(), 1e-15) << j;
}

TEST(TutorialSkeleton, ReadWriteReadGivesTheSameBits) {
  const std::string text = readFile(assets + "/tutorial_figure.figure");
  EXPECT_EQ(formatTutorialSkeleton(parseTutorialSkeleton(text, "figure")), text);
  const std::string pose = readFile(assets + "/tutorial_stride.pose");
  EXPECT_EQ(formatTutorialPose(parseTutorialPose(pose, "pose")), pose);
  std::mt19937_64 random(9);
  TutorialPose any(41);
  for (auto& angles : any) angles = 6.0 * testing::randomUnit(random);
  any[3] = {-0.0, 1e-300, 1e300};
  const TutorialPose again = parseTutorialPose(formatTutorialPose(any), "pose");
  ASSERT_EQ(again.size(), any.size());
  EXPECT_EQ(std::memcmp(again.data(), any.data(), any.size() * sizeof any[0]), 0);
  const TutorialFigure figure = toSkeleton(parseTutorialSkeleton(text, "figure"));
  EXPECT_EQ(tutorialPose(figure, configuration(figure, any)), any);
}

TEST(TutorialSkeleton, AJointTurnsEverythingBelowItAboutXThenYThenZ) {
  const TutorialFigure figure = toSkeleton(parseTutorialSkeleton(fork, "fork"));
  TutorialPose pose(4, Vector3d::Zero());
  pose[1] = {M_PI / 2, 0, M_PI / 2};
  const Frames frames = forwardKinematics(figure.skeleton, configuration(figure, pose));
  // (0.5, 1, 0): a quarter about x makes it (0.5, 0, 1), a quarter about z (0, 0.5, 1).
  EXPECT_LE((frames[figure.jointOfIndex[2]].translation() - Vector3d(0, 1.5, 1)).norm(), 1e-15);
}

TEST(TutorialSkeleton, ListsMayEndWithoutACommaAndSectionsMayBeRepeated) {
  const std::size_t at = fork.find("NonAnimated");
  std::string text = fork + fork.substr(at);
  text.replace(text.find("3,\nNumJointHierarchies"), 2, "3");
  EXPECT_EQ(parseTutorialSkeleton(text, "fork").groups, parseTutorialSkeleton(fork, "fork").groups);
}

TEST(TutorialSkeleton, AnySkeletonCanBeWrittenAndReadBack) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 10; ++trial) {
    const Skeleton skeleton = testing::randomSkeleton(random, 15);
    const TutorialSkeleton tutorial =
        parseTutorialSkeleton(formatTutorialSkeleton(toTutorialSkeleton(skeleton)), "any");
    const Frames rest = restFrames(skeleton);
    for (int i = 0; i < 15; ++i) EXPECT_EQ(tutorial.positions[i], Vector3d(rest[i].translation()));
  }
}

TEST(TutorialSkeleton, BadInputIsRefusedWithItsLine) {
  const auto with = [](std::string text, const std::string& old, const std::string& replacement) {
    const std::size_t at = text.find(old);
    EXPECT_NE(at, std::string::npos) << old;
    return text.replace(at, old.size(), replacement);
  };
  testing::expectRefused(
      {
          {"empty", "", 0, "NumJoints:"},
          {"another format", "HIERARCHY\n", 1, "'HIERARCHY'"},
          {"no positions", "NumJoints: 4\n", 0, "NonAnimatedJointPositions:"},
          {"no bones", fork.substr(0, fork.find("NumBones")), 0, "NumBones:"},
          {"no groups", fork.substr(0, fork.find("NumJointH")), 0, "NumJointHierarchies:"},
          {"a million joints", with(fork, "NumJoints: 4", "NumJoints: 1000000"), 2,
           "1000000 positions, one a joint, found 4"},
          {"joints minus one", with(fork, "NumJoints: 4", "NumJoints: -1"), 1, "at least one"},
          {"joints a word", with(fork, "NumJoints: 4", "NumJoints: four"), 1, "'four'"},
          {"one position too few", with(fork, "-0.500000, 2.000000, 0.000000,\n", ""), 2, "found 3"},
          {"two coordinates", with(fork, "0.500000, 2.000000, 0.000000,\n-", "0.500000, 2.000000,\n-"), 7,
           "'NumBones:'"},
          {"NaN", with(fork, "1.000000", "nan"), 4, "'nan'"},
          {"infinite", with(fork, "1.000000", "inf"), 4, "'inf'"},
          {"overflow", with(fork, "1.000000", "1e400"), 4, "'1e400'"},
          {"bones a million", with(fork, "NumBones: 3", "NumBones: 1000000"), 7, "1000000 bones, found 3"},
          {"a bone too few", with(with(fork, "NumBones: 3", "NumBones: 2"), "1, 3,\nNum", "Num"), 7,
           "3 bones for 4 joints"},
          {"half a bone", with(fork, "1, 3,\nNum", "1,\nNum"), 11, "'NumJointHierarchies:'"},
          {"unknown joint in a bone", with(fork, "1, 3,\nNum", "1, 4,\nNum"), 10, "from 0 to 3"},
          {"negative joint", with(fork, "1, 3,\nNum", "1, -3,\nNum"), 10, "from 0 to 3, found -3"},
          {"fraction as joint", with(fork, "1, 3,\nNum", "1, 2.5,\nNum"), 10, "'2.5'"},
          {"two parents", with(fork, "1, 3,\nNum", "0, 2,\nNum"), 10, "a second one"},
          {"cycle", with(with(fork, "0, 1,\n1, 2", "2, 1,\n1, 2"), "1, 3,\nNum", "0, 3,\nNum"), 8, "cycle"},
          {"bone to itself", with(fork, "1, 3,\nNum", "3, 3,\nNum"), 10, "positive, finite length"},
          {"zero-length bone", with(fork, "0.500000, 2.000000", "0.000000, 1.000000"), 9,
           "positive, finite length"},
          {"groups too many", with(fork, "NumJointHierarchies: 2", "NumJointHierarchies: 3"), 11,
           "3 joint hierarchies, found 2"},
          {"group count wrong", with(fork, "trunk+left: 3", "trunk+left: 4"), 12,
           "4 joints in the group 'trunk+left', found 3"},
          {"group of one", with(fork, "right: 2\n1, 3,", "right: 1\n3,"), 14, "at least two joints"},
          {"group without a name", with(fork, "NumJoints-right: 2", "NumJoints-: 2"), 14, "a name"},
          {"group without a colon", with(fork, "NumJoints-right: 2", "NumJoints-right 2"), 14, "a colon"},
          {"group over a gap", with(fork, "0, 1, 2,\n", "0, 2, 1,\n"), 12, "a bone between"},
          {"group on nothing",
           with(with(fork, "trunk+left: 3\n0, 1, 2,", "left: 2\n1, 2,"), "right: 2\n1, 3", "right: 2\n0, 1"),
           12, "root at the top"},
          {"bone in no group", with(with(fork, "trunk+left: 3\n0, 1, 2,", "trunk: 2\n0, 1,"), "", ""), 11,
           "in a group, found 2"},
          {"bone in two groups", with(fork, "right: 2\n1, 3,", "right: 2\n1, 2,"), 14, "again"},
          {"unknown joint in a group", with(fork, "right: 2\n1, 3,", "right: 2\n1, 9,"), 14, "found 9"},
          {"contradicting repetition", fork + "NumBones: 1\n0, 2,\n", 16,
           "the same bones as in the section on line 7"},
          {"CRLF keeps line numbers", "NumJoints: 1\r\nNonAnimatedJointPositions:\r\nx, 0, 0,\r\n", 3, "'x'"},
          {"cut off", fork.substr(0, 90), 4, "the end of the file"},
      },
      [](const std::string& text, const std::string& file) { parseTutorialSkeleton(text, file); });
}

TEST(TutorialPose, BadInputIsRefusedWithItsLine) {
  const std::string two = "NumJoints: 2\nJointAngles:\n";  // two lines
  testing::expectRefused(
      {
          {"pose: empty", "", 0, "NumJoints:"},
          {"pose: no angles", "NumJoints: 2\n", 0, "JointAngles:"},
          {"pose: too few", "NumJoints: 2\nJointAngles:\n0, 0, 0,\n", 2,
           "2 triples of angles, one a joint, found 1"},
          {"pose: too many", "NumJoints: 1\nJointAngles:\n0, 0, 0,\n0, 0, 0,\n", 2, "found 2"},
          {"pose: two angles", "NumJoints: 1\nJointAngles:\n0, 0\n", 3, "the end of the file"},
          {"pose: NaN", "NumJoints: 1\nJointAngles:\n0, nan, 0\n", 3, "'nan'"},
          {"pose: a million", "NumJoints: 1000000\nJointAngles:\n0, 0, 0\n", 2, "1000000 triples"},
          {"pose: contradiction", "NumJoints: 1\nJointAngles:\n0, 0, 0\nJointAngles:\n0, 0, 1\n", 4,
           "the same angles"},
          {"pose: a skeleton instead", fork, 2, "'NonAnimatedJointPositions:'"},
          {"pose: only blanks", " \n\t\r\n", 0, "NumJoints:"},
          {"pose: another format", "HIERARCHY\n", 1, "'HIERARCHY'"},
          {"pose: no number of joints", "JointAngles:\n0, 0, 0,\n", 0, "a line NumJoints:"},
          {"pose: joints a word", "NumJoints: two\n", 1, "'two'"},
          {"pose: joints zero", "NumJoints: 0\nJointAngles:\n", 1, "at least one of the joints, found 0"},
          {"pose: joints minus one", "NumJoints: -1\n", 1, "found -1"},
          {"pose: joints a fraction", "NumJoints: 2.5\n", 1, "'2.5'"},
          {"pose: joints too large", "NumJoints: 99999999999\n", 1, "'99999999999'"},
          {"pose: joints missing", "NumJoints:\nJointAngles:\n", 2, "'JointAngles:'"},
          {"pose: joints contradicted", "NumJoints: 1\nNumJoints: 2\n", 2,
           "the same number of joints as in the section on line 1"},
          {"pose: no angle at all", two, 2, "2 triples of angles, one a joint, found 0"},
          {"pose: infinite", two + "0, inf, 0,\n", 3, "'inf'"},
          {"pose: overflow", two + "0, 0, 0,\n0, 1e400, 0,\n", 4, "'1e400'"},
          {"pose: a word", two + "0, x, 0,\n", 3, "'x'"},
          {"pose: degrees with their sign", two + "90\u00b0, 0, 0,\n", 3, "'90"},
          {"pose: a trailing letter", two + "0, 0.5f, 0,\n", 3, "'0.5f'"},
          {"pose: hexadecimal", two + "0, 0x10, 0,\n", 3, "'0x10'"},
          {"pose: a comma as decimal point", two + "0,5 0,5 0,5\n0,5\n", 4, "the end of the file"},
          {"pose: semicolons", two + "0; 0; 0;\n", 3, "'0;'"},
          {"pose: unknown section", two + "0, 0, 0,\n0, 0, 0,\nNumBones: 1\n", 5, "'NumBones:'"},
          {"pose: misspelt section", "NumJoints: 2\nJointAngels:\n", 2, "'JointAngels:'"},
          {"pose: a section without its colon", "NumJoints: 2\nJointAngles\n0, 0, 0,\n", 3, "':'"},
          {"pose: cut in a triple", two + "0, 0, 0,\n0.1, ", 4, "the end of the file"},
          {"pose: CRLF keeps line numbers", "NumJoints: 2\r\n\r\nJointAngles:\r\n0, y, 0,\r\n", 4, "'y'"},
          {"pose: binary",
           std::string("\x7f"
                       "ELF\0\1",
                       6),
           1, "NumJoints: or JointAngles:"},
      },
      [](const std::string& text, const std::string& file) { parseTutorialPose(text, file); });
}

}  // namespace
}  // namespace gelenk
