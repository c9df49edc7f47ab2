#include "kinematics/io/pinocchio_skeleton.h"

#include <filesystem>

#include "kinematics/forward_kinematics.h"
#include "kinematics/io/text_file.h"
#include "tests/kinematics/io/bad_input.h"
#include "tests/places.h"

namespace gelenk {
namespace {

// The skeleton on the exercise sheet.
const std::string sheet =
    "0 0.501255 0.605129 0.0191935 -1\n"
    "1 0.56259 0.538386 0.0423232 0\n"
    "2 0.658742 0.274211 0.0423232 1\n"
    "3 0.751012 0.0206998 0.0423232 2\n"
    "4 0.758307 0.000658038 0.121764 3\n"
    "5 0.441625 0.538386 0.0423231 0\n"
    "6 0.345554 0.274432 0.0423231 5\n";

TEST(PinocchioSkeleton, ExerciseSheetBecomesATreeOfBallsWithFixedEnds) {
  const Skeleton skeleton = parsePinocchioSkeleton(sheet, "sheet.skel");
  ASSERT_EQ(skeleton.jointCount(), 7);
  EXPECT_EQ(skeleton.parent(5), 0);
  EXPECT_EQ(skeleton.nv(), 6 + 4 * 3);  // free root; 1, 2, 3, 5 turn; the ends 4 and 6 do not
  const Frames frames = restFrames(skeleton);
  EXPECT_LE((frames[4].translation() - Eigen::Vector3d(0.758307, 0.000658038, 0.121764)).norm(), 1e-15);
  EXPECT_LE((frames[6].translation() - Eigen::Vector3d(0.345554, 0.274432, 0.0423231)).norm(), 1e-15);
}

TEST(PinocchioSkeleton, WordsAreIdsAndBlankLinesAndCrLfAreNothing) {
  const Skeleton skeleton =
      parsePinocchioSkeleton("hip 0 1 0 -1\r\n\r\n\tknee 0 .5 0 hip\r\nankle 1e-2 0 0 knee", "words.skel");
  ASSERT_EQ(skeleton.jointCount(), 3);
  EXPECT_EQ(skeleton.joint(2).name, "ankle");
  EXPECT_EQ(skeleton.parent(2), 1);
}

TEST(PinocchioSkeleton, WrittenAndReadAgainEveryPositionIsTheSameToRounding) {
  const Skeleton first = parsePinocchioSkeleton(sheet, "sheet.skel");
  const Skeleton second = parsePinocchioSkeleton(formatPinocchioSkeleton(first), "again.skel");
  for (int i = 0; i < first.jointCount(); ++i) {
    EXPECT_EQ(first.joint(i).name, second.joint(i).name);
    EXPECT_EQ(first.parent(i), second.parent(i));
    // positions are sums of offsets: one rounding a joint on the path
    EXPECT_LE((restFrames(first)[i].translation() - restFrames(second)[i].translation()).norm(), 1e-15);
  }
}

TEST(PinocchioSkeleton, BadInputIsRefusedWithItsLine) {
  using testing::BadInput;
  testing::expectRefused(
      {
          {"empty", "", 0, "at least one joint"},
          {"only blanks", "\n  \n\t\n", 0, "at least one joint"},
          {"four words", "0 0 0 0\n", 1, "five words"},
          {"six words", "0 0 0 0 -1 7\n", 1, "five words"},
          {"NaN", "0 nan 0 0 -1\n", 1, "finite number"},
          {"infinite", "0 inf 0 0 -1\n", 1, "finite number"},
          {"overflow", "0 1e999 0 0 -1\n", 1, "finite number"},
          {"word for a number", "0 a 0 0 -1\n", 1, "'a'"},
          {"comma as decimal point", "0 0,5 0 0 -1\n", 1, "'0,5'"},
          {"trailing letter", "0 0.5f 0 0 -1\n", 1, "'0.5f'"},
          {"no root", "0 0 0 0 0\n", 1, "cycle"},
          {"two roots", "0 0 0 0 -1\n1 1 0 0 -1\n", 2, "second root"},
          {"forward reference", "0 0 0 0 -1\n1 1 0 0 2\n2 2 0 0 0\n", 2, "comes only on line 3"},
          {"root later", "1 1 0 0 0\n0 0 0 0 -1\n", 1, "comes only on line 2"},
          {"cycle of two", "0 0 0 0 -1\n1 1 0 0 2\n2 2 0 0 1\n", 2, "cycle"},
          {"cycle of three", "0 0 0 0 -1\n1 1 0 0 3\n2 2 0 0 1\n3 3 0 0 2\n", 2, "cycle"},
          {"own parent", "0 0 0 0 -1\n1 1 0 0 1\n", 2, "cycle"},
          {"unknown parent", "0 0 0 0 -1\n1 1 0 0 9\n", 2, "'9'"},
          {"parent in other case", "Hip 0 0 0 -1\nknee 1 0 0 hip\n", 2, "'hip'"},
          {"id twice", "0 0 0 0 -1\n0 1 0 0 0\n", 2, "first on line 1"},
          {"id -1", "-1 0 0 0 -1\n", 1, "other than -1"},
          {"zero-length bone", "0 1 2 3 -1\n1 1 2 3 0\n", 2, "positive length"},
          {"zero-length bone, minus zero", "0 0 0 0 -1\n1 -0 0 0 0\n", 2, "positive length"},
          {"overflowing bone", "0 -1.7e308 0 0 -1\n1 1.7e308 0 0 0\n", 2, "finite"},
          {"truncated last line", "0 0 0 0 -1\n1 1 0", 2, "found 3"},
          {"bare CR as line end", "0 0 0 0 -1\r1 1 0 0 0\r", 1, "five words"},
          {"a comment", "# skeleton\n0 0 0 0 -1\n", 1, "five words"},
          {"binary",
           std::string("\x7f"
                       "ELF\0\0\1",
                       7),
           1, "five words"},
          {"a header with a count", "18\n0 0 0 0 -1\n", 1, "five words"},
          {"hexadecimal", "0 0x10 0 0 -1\n", 1, "finite number"},
          {"CRLF keeps line numbers", "0 0 0 0 -1\r\n\r\n1 x 0 0 0\r\n", 3, "'x'"},
      },
      [](const std::string& text, const std::string& file) { parsePinocchioSkeleton(text, file); });
}

TEST(PinocchioSkeleton, FittedHumanHasItsSidesNamedByTheBody) {
  const std::string path = testing::dataFolder() + "/pinocchio/mh_male.skeleton.out";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no trial data at " << path;
  const Skeleton skeleton = namedAsHuman(readPinocchioSkeleton(path));
  const Frames frames = restFrames(skeleton);
  // The body faces +z with y up: its left hand is at +x.
  EXPECT_GT(frames[skeleton.jointIndex("hand_left")].translation().x(), 0.4);
  EXPECT_LT(frames[skeleton.jointIndex("hand_right")].translation().x(), -0.4);
  EXPECT_GT(frames[skeleton.jointIndex("head")].translation().y(), 1.6);
  EXPECT_LT(frames[skeleton.jointIndex("toe_left")].translation().y(), 0.1);
  EXPECT_EQ(skeleton.parent(skeleton.jointIndex("toe_left")), skeleton.jointIndex("ankle_left"));
}

}  // namespace
}  // namespace gelenk
