#include "kinematics/io/asf_amc.h"

#include <filesystem>

#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/io/bvh.h"
#include "kinematics/io/text_file.h"
#include "tests/kinematics/io/bad_input.h"
#include "tests/kinematics/io/c3d.h"
#include "tests/kinematics/random_skeleton.h"
#include "tests/places.h"

namespace gelenk {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const std::string data = testing::dataFolder() + "/mocap/asf/";

#define REQUIRE_DATA(path) \
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no trial data at " << (path)

const std::string units = ":units\n length 0.0254\n angle deg\n";  // one unit is one metre
const std::string root = ":root\n order TX TY TZ RX RY RZ\n axis XYZ\n position 0 0 0\n orientation 0 0 0\n";
const std::string thigh =
    ":bonedata\nbegin\n id 1\n name thigh\n direction 0 -1 0\n length 0.5\n axis 0 0 0 XYZ\n dof rx rz\n "
    "limits (-90 20)\n (-inf inf)\nend\n";
const std::string shin =
    "begin\n name shin\n direction 0 -1 0\n length 0.4\n axis 0 90 0 XYZ\n dof rz\n limits (0 150)\nend\n";
const std::string tree = ":hierarchy\nbegin\n root thigh\n thigh shin\nend\n";
const std::string leg = units + root + thigh + shin + tree;

TEST(Asf, TwoBonesByHand) {
  const AsfSkeleton asf = parseAsf(leg, "leg.asf");
  ASSERT_EQ(asf.skeleton.jointCount(), 4);  // root, thigh, shin, shin_end
  EXPECT_EQ(asf.skeleton.nq(), 6 + 2 + 1);
  EXPECT_EQ(asf.skeleton.joint(1).axes[0].upper, unlimited);  // z is outermost, x comes after it
  EXPECT_NEAR(asf.skeleton.joint(1).axes[1].lower, -M_PI / 2, 1e-15);
  const MotionClip clip =
      parseAmc(":FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 1 0 0 0 0\nthigh 0 90\nshin 90\n", "leg.amc", asf);
  const Frames frames = forwardKinematics(asf.skeleton, clip.q.col(0));
  // The thigh turns about z from -y to +x. The shin's axis is turned by 90 degrees about y: its own z is the
  // thigh's x, which the thigh's turn carried to +y. Turning +x by 90 degrees about +y gives -z.
  EXPECT_LE((frames[2].translation() - Vector3d(0.5, 1.0, 0.0)).norm(), 1e-14);
  EXPECT_LE((frames[3].translation() - Vector3d(0.5, 1.0, -0.4)).norm(), 1e-14);
}

TEST(Asf, SaysWhichBonesEndWhere) {
  const AsfSkeleton asf = parseAsf(leg, "leg.asf");
  EXPECT_EQ(asf.bones[*asf.findBone("THIGH")].endJoint, 2);
  EXPECT_EQ(asf.skeleton.joint(asf.bones[*asf.findBone("shin")].endJoint).name, "shin_end");
}

TEST(Asf, MixedCaseCrLfRadiansAndDocumentationAreRead) {
  std::string text = "# head\n" + leg;
  text.replace(text.find("angle deg"), 9, "ANGLE Rad");
  text.replace(text.find("axis 0 90 0"), 11, "axis 0 1.5707963267948966 0");
  text.replace(text.find(":root"), 5, ":Documentation\n any words, begin end\n\n:ROOT");
  std::string crlf;
  for (const char c : text) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  const AsfSkeleton asf = parseAsf(crlf, "leg.asf");
  EXPECT_NEAR(asf.skeleton.joint(2).axes[0].upper, 150.0, 1e-12);
  const MotionClip clip = parseAmc("1\r\nRoot 0 0 0 0 0 0\r\nTHIGH 0 1\r\nShin 7.6e-016\r\n", "leg.amc", asf);
  EXPECT_NEAR(clip.q(6, 0), 1.0, 1e-15);  // rz is the thigh's first axis
}

TEST(Amc, ChangingLengthsArePassedOverAndTold) {
  std::string text = leg;
  const std::string dofs = "dof rx rz\n";
  text.replace(text.find(dofs), dofs.size(), "dof rx l rz\n");
  const std::string limits = "(-inf inf)";
  text.replace(text.find(limits), limits.size(), "(0 9) (-inf inf)");
  const AsfSkeleton asf = parseAsf(text, "leg.asf");
  ASSERT_EQ(asf.notes.size(), 1u);
  EXPECT_EQ(asf.notes[0].kind, "length-dof");
  const AsfSkeleton without = parseAsf(leg, "leg.asf");
  EXPECT_EQ(asf.skeleton.nq(), without.skeleton.nq());
  EXPECT_EQ(parseAmc("1\nroot 0 0 0 0 0 0\nthigh 3 9 4\nshin 5\n", "leg.amc", asf).q,
            parseAmc("1\nroot 0 0 0 0 0 0\nthigh 3 4\nshin 5\n", "leg.amc", without).q);
}

TEST(Amc, BonesMayComeInAnyOrderAndAnotherOneInEveryFrame) {
  const AsfSkeleton asf = parseAsf(leg, "leg.asf");
  const MotionClip clip = parseAmc(
      "5\nroot 1 2 3 4 5 6\nthigh 7 8\nshin 9\n6\nshin 9\nroot 1 2 3 4 5 6\nthigh 7 8\n7\nthigh 7 8\nshin "
      "9\nroot 1 2 3 4 5 6\n",
      "leg.amc", asf);
  ASSERT_EQ(clip.frameCount(), 3);
  EXPECT_EQ(clip.q.col(0), clip.q.col(1));
  EXPECT_EQ(clip.q.col(0), clip.q.col(2));
  EXPECT_EQ(clip.framesPerSecond, 120.0);
}

TEST(Asf, BadInputIsRefusedWithItsLine) {
  const auto with = [](std::string text, const std::string& old, const std::string& replacement) {
    const std::size_t at = text.find(old);
    EXPECT_NE(at, std::string::npos) << old;
    return text.replace(at, old.size(), replacement);
  };
  testing::expectRefused(
      {
          {"empty", "", 0, "a section :root, found none"},
          {"no section", "begin\n", 1, "a section such as"},
          {"unknown section", with(leg, ":units", ":unit"), 1, "':unit'"},
          {"no root", units + thigh + shin + tree, 0, "a section :root"},
          {"no bones", units + root, 0, ":bonedata"},
          {"empty bonedata", units + root + ":bonedata\n:hierarchy\nbegin\nend\n", 0, "with bones"},
          {"no hierarchy", units + root + thigh, 0, "a section :hierarchy"},
          {"hierarchy before bones", units + root + tree + thigh, 9, ":bonedata before"},
          {"length unit 0", with(leg, "length 0.0254", "length 0"), 2, "above 0"},
          {"angle unit", with(leg, "angle deg", "angle grad"), 3, "deg or rad"},
          {"NaN direction", with(leg, "direction 0 -1 0", "direction 0 nan 0"), 13, "'nan'"},
          {"infinite length", with(leg, "length 0.5", "length inf"), 14, "'inf'"},
          {"negative length", with(leg, "length 0.5", "length -0.5"), 14, "at least 0"},
          {"huge length", with(leg, "length 0.5", "length 1e400"), 14, "'1e400'"},
          {"overflow in metres",
           with(with(leg, "length 0.5", "length 1e308"), "length 0.0254", "length 1e-300"), 21, "overflow"},
          {"direction too short", with(leg, "direction 0 -1 0", "direction 0 -0.5 0"), 13, "unit length"},
          {"direction zero", with(leg, "direction 0 -1 0", "direction 0 0 0"), 19, "positive length"},
          {"no direction", with(leg, " direction 0 -1 0\n", ""), 18, "a direction in the block of 'thigh'"},
          {"no name", with(leg, " name thigh\n", ""), 18, "a name"},
          {"axis order", with(leg, "0 0 0 XYZ", "0 0 0 XYY"), 15, "'XYY'"},
          {"axis order cut", with(leg, "0 0 0 XYZ", "0 0 0"), 16, "order of the axes"},
          {"unknown dof", with(leg, "dof rx rz", "dof rx rw"), 16, "'rw'"},
          {"dof twice", with(leg, "dof rx rz", "dof rx rx"), 16, "second rx"},
          {"two lengths", with(leg, "dof rx rz", "dof l l"), 16, "a second l"},
          {"dof without any", with(leg, "dof rx rz", "dof"), 17, "after dof"},
          {"half a limit", with(leg, " (-inf inf)\n", " (-inf)\n"), 19, "a limit"},
          {"reversed limits", with(leg, "(-90 20)", "(20 -90)"), 17, "lower <= upper"},
          {"bone twice", with(leg, "name shin", "name thigh"), 21, "'thigh' again"},
          {"bone twice in other case", with(leg, "name shin", "name Thigh"), 21, "'Thigh' again"},
          {"bone called root", with(leg, "name shin", "name root"), 21, "'root' again"},
          {"unknown parent", with(leg, "root thigh\n", "rood thigh\n"), 30, "'rood'"},
          {"unknown child", with(leg, "thigh shin\n", "thigh shim\n"), 31, "'shim'"},
          {"two parents", with(leg, "root thigh\n", "root thigh shin\n"), 31, "second one for 'shin'"},
          {"no parent", with(leg, " thigh shin\n", ""), 21, "none for 'shin'"},
          {"cycle", with(leg, "root thigh\n", "shin thigh\n"), 12, "cycle"},
          {"root as child", with(leg, "thigh shin\n", "thigh shin root\n"), 31, "the root"},
          {"cut in a bone", leg.substr(0, leg.find("limits (0")), 26, "end of the file"},
          {"cut in the hierarchy", leg.substr(0, leg.size() - 4), 31, "end of the file"},
          {"CRLF keeps line numbers",
           with(":units\r\nlength 0.0254\r\nangle deg\r\n" + root + thigh, "length 0.5", "length x"), 14,
           "'x'"},
      },
      [](const std::string& text, const std::string& file) { parseAsf(text, file); });
}

TEST(Amc, BadInputIsRefusedWithItsLine) {
  const AsfSkeleton asf = parseAsf(leg, "leg.asf");
  const std::string one = "1\nroot 0 0 0 0 0 0\nthigh 0 0\nshin 0\n";  // four lines
  testing::expectRefused(
      {
          {"empty", "", 0, "at least one frame"},
          {"header alone", ":FULLY-SPECIFIED\n:DEGREES\n", 0, "at least one frame"},
          {"bone before frame", "root 0 0 0 0 0 0\n", 1, "frame number before"},
          {"unknown bone", one + "2\nfoot 1\n", 6, "'foot'"},
          {"no root", "1\nthigh 0 0\nshin 0\n", 3, "no 'root' in frame 1"},
          {"empty second frame", "1\nroot 0 0 0 0 0 0\nthigh 0 0\n2\n", 4, "no 'root' in frame 2"},
          {"missing bone in the last frame", one + "2\nroot 0 0 0 0 0 0\nthigh 0 0\n", 7,
           "no 'shin' in frame 2"},
          {"a bone that comes later", "1\nroot 0 0 0 0 0 0\nthigh 0 0\n2\nroot 0 0 0 0 0 0\nshin 0\n", 6,
           "bones that the first frame has, found 'shin'"},
          {"another skeleton's bones", "1\nroot 0 0 0 0 0 0\nfemur 0 0\nshin 0\n", 3, "'femur'"},
          {"an unknown bone without values", one + "foot\n", 5, "'foot'"},
          {"an unknown bone's words", one + "foot x\n", 5, "'x'"},
          {"bone twice", "1\nroot 0 0 0 0 0 0\nthigh 0 0\nthigh 0 0\n", 4, "'thigh' again"},
          {"too few values", "1\nroot 0 0 0 0 0 0\nthigh 0\n", 3, "2 values for bone 'thigh', found 1"},
          {"too many values", "1\nroot 0 0 0 0 0 0\nthigh 0 0 0\n", 3,
           "2 values for bone 'thigh', found more"},
          {"root cut", "1\nroot 0 0 0\n", 2, "6 values"},
          {"no value", "1\nroot\n", 2, "6 values for bone 'root', found 0"},
          {"NaN", "1\nroot 0 0 nan 0 0 0\n", 2, "'nan'"},
          {"Windows NaN", "1\nroot 0 0 -1.#IND 0 0 0\n", 2, "'-1.#IND'"},
          {"infinite", "1\nroot 0 inf 0 0 0 0\n", 2, "'inf'"},
          {"overflow", "1\nroot 0 1e309 0 0 0 0\n", 2, "'1e309'"},
          {"a word", "1\nroot 0 a 0 0 0 0\n", 2, "'a'"},
          {"decimal comma", "1\nroot 0 0,5 0 0 0 0\n", 2, "'0,5'"},
          {"frame skipped", one + "3\n", 5, "frame 2, found 3"},
          {"frame repeated", one + "1\n", 5, "frame 2, found 1"},
          {"frame too large", one + "99999999999\n", 5, "'99999999999'"},
          {"unknown header", ":PARTLY-SPECIFIED\n" + one, 1, "':PARTLY-SPECIFIED'"},
          {"header among frames", one + ":DEGREES\n", 5, "before the first frame"},
          {"rate of zero", ":SAMPLES-PER-SECOND 0\n" + one, 1, "positive rate"},
          {"rate missing", ":SAMPLES-PER-SECOND\n" + one, 1, "positive rate"},
          {"CRLF keeps line numbers", "1\r\nroot 0 0 0 0 0 0\r\nthigh 0 x\r\n", 3, "'x'"},
          {"an ASF instead", leg, 1, "':units'"},
          {"binary", std::string("\0\1\2", 3), 1, "frame number before"},
          {"a number and a word", "1 2\n", 1, "frame number before"},
          {"cut in a number's line", "1\nroot 0 0 0 0 0 0\nthigh 0 0\nshi", 4, "'shi'"},
          {"empty first frame", "1\n2\n", 2, "no 'root' in frame 1"},
      },
      [&](const std::string& text, const std::string& file) { parseAmc(text, file, asf); });
}

/// Motions of fewer bones (no fingers were captured) and of more (props) than the skeleton has.
TEST(Amc, BonesThatOnlyOneOfTheTwoHasAreTold) {
  const AsfSkeleton asf = parseAsf(leg, "leg.asf");
  std::vector<Note> notes;
  const std::string fewer = "1\nroot 0 1 0 0 0 0\nshin 5\n2\nshin 6\nroot 0 2 0 0 0 0\n";
  const MotionClip clip = parseAmc(fewer, "fewer.amc", asf, 120.0, &notes);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0].kind, "bones-missing");
  EXPECT_NE(notes[0].text.find("thigh"), std::string::npos);
  EXPECT_FALSE(notes[0].fact);
  const int thighAt = asf.skeleton.qIndex(1), shinAt = asf.skeleton.qIndex(2);
  EXPECT_EQ(clip.q.col(1).segment(thighAt, 2), Eigen::Vector2d::Zero());
  EXPECT_NEAR(clip.q(shinAt, 1), 6 * M_PI / 180, 1e-15);

  notes.clear();
  const std::string one = "root 0 1 0 0 0 0\nthigh 3 4\nsword 1 2 3\nshin 5\n";
  const MotionClip more = parseAmc("1\n" + one + "2\n" + one, "more.amc", asf, 120.0, &notes);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0].kind, "bones-unknown");
  EXPECT_NE(notes[0].text.find("sword"), std::string::npos);
  EXPECT_EQ(more.q.col(1), parseAmc("1\nroot 0 1 0 0 0 0\nthigh 3 4\nshin 5\n", "f", asf).q.col(0));
}

/// Acclaim's definition of the format, and Vicon's notes on it: `order` and `dof` say in which sequence the
/// rotations are made about fixed axes, `axis` only in which one its own three angles are.
TEST(Asf, RotationsFollowTheOrderOfTheDofs) {
  const std::string text =
      ":root\norder TX TY TZ RZ RX RY\naxis XYZ\nposition 0 0 0\norientation 0 0 0\n:bonedata\nbegin\nname "
      "a\ndirection 0 1 0\nlength 1\naxis 30 0 20 ZYX\ndof ry rz rx\nend\n:hierarchy\nbegin\nroot a\nend\n";
  const AsfSkeleton asf = parseAsf(text, "a.asf", 1.0);
  const MotionClip clip = parseAmc(":DEGREES\n1\nroot 1 2 3 10 20 30\na 40 50 60\n", "a.amc", asf);
  const auto turn = [](double degrees, int axis) {
    return Eigen::AngleAxisd(degrees * M_PI / 180.0, Vector3d::Unit(axis)).toRotationMatrix();
  };
  const Matrix3d root = turn(30, 1) * turn(20, 0) * turn(10, 2), C = turn(30, 0) * turn(20, 2),
                 M = turn(60, 0) * turn(50, 2) * turn(40, 1);
  const Vector3d expected = Vector3d(1, 2, 3) + root * C * M * C.transpose() * Vector3d::UnitY();
  const Frames frames = forwardKinematics(asf.skeleton, clip.q.col(0));
  EXPECT_LT((frames[asf.bones[1].endJoint].translation() - expected).norm(), 1e-12);
  ASSERT_EQ(asf.notes.size(), 1u);
  EXPECT_EQ(asf.notes[0].kind, "rotation-order");
  EXPECT_TRUE(asf.notes[0].fact);
  EXPECT_NE(asf.notes[0].text.find("root, a"), std::string::npos);
  EXPECT_TRUE(parseAsf(leg, "leg.asf").notes.empty());
}

TEST(Asf, LimitsThatDoNotFitTheDofsArePassedOverAndTold) {
  for (const std::string limits : {"limits (0 1)", "limits (0 1) (0 1) (0 1)"}) {
    const AsfSkeleton asf =
        parseAsf(":root\norder TX\n:bonedata\nbegin\nname a\ndirection 0 1 0\nlength 1\naxis 0 0 0 XYZ\n" +
                     limits + "\ndof rx rz\nend\n:hierarchy\nbegin\nroot a\nend\n",
                 "a.asf");
    ASSERT_EQ(asf.notes.size(), 1u) << limits;
    EXPECT_EQ(asf.notes[0].kind, "limits-count");
    EXPECT_FALSE(asf.notes[0].fact);
    EXPECT_EQ(asf.skeleton.joint(1).axes[0].upper, unlimited);
  }
}

struct Walk {
  AsfSkeleton asf = readAsf(data + "02.asf");
  MotionClip clip = readAmc(data + "02_01.amc", asf);
};

TEST(Asf, CmuWalkAgreesWithTheGoldenToATenthOfAMillimetre) {
  const std::string golden = testing::dataFolder() + "/pinocchio/asf_fk_golden_02_01.txt";
  REQUIRE_DATA(golden);
  const Walk walk;
  EXPECT_EQ(walk.clip.q.rows(), 62);
  EXPECT_EQ(walk.clip.frameCount(), 343);
  double worst = 0.0;
  int checked = 0;
  Frames frames;
  const std::string text = readFile(golden);
  for (const auto line : splitLines(text)) {
    const auto words = splitWords(line);
    if (words.empty() || words[0] == "#") continue;
    if (words[0] == "frame") {
      const auto number = parseInteger(words[1]);
      frames = forwardKinematics(walk.asf.skeleton, number ? Eigen::VectorXd(walk.clip.q.col(*number - 1))
                                                           : walk.asf.skeleton.rest());
      continue;
    }
    const Vector3d expected(*parseNumber(words[1]), *parseNumber(words[2]), *parseNumber(words[3]));
    const int bone = *walk.asf.findBone(words[0]);
    worst = std::max(worst, (frames[walk.asf.bones[bone].endJoint].translation() - expected).norm());
    ++checked;
  }
  EXPECT_GE(checked, 31 * 5);
  EXPECT_LE(worst, 1e-5);  // the golden has six decimals; the issue asks for 1e-4
  RecordProperty("worst_micrometres", std::to_string(worst * 1e6));
}

TEST(Asf, AnkleMarkersKeepTheirDistanceFromTheJointOverTheWholeWalk) {
  REQUIRE_DATA(data + "02_01.c3d");
  const Walk walk;
  const testing::C3d c3d = testing::parseC3d(readFile(data + "02_01.c3d"));
  ASSERT_EQ(c3d.frames, walk.clip.frameCount());
  const std::pair<const char*, const char*> pairs[] = {{"LANK", "ltibia"}, {"RANK", "rtibia"}};
  for (const auto& [marker, bone] : pairs) {
    const auto& track = c3d.markers.at(marker);
    const int joint = walk.asf.bones[*walk.asf.findBone(bone)].endJoint;
    double sum = 0.0, squares = 0.0;
    for (int f = 0; f < c3d.frames; ++f) {
      const Vector3d inAsf = 1e-3 * Vector3d(track[f].y(), track[f].z(), track[f].x());
      ASSERT_TRUE(inAsf.allFinite());
      const double distance =
          (inAsf - forwardKinematics(walk.asf.skeleton, walk.clip.q.col(f))[joint].translation()).norm();
      sum += distance, squares += distance * distance;
    }
    const double mean = sum / c3d.frames,
                 deviation = std::sqrt(std::max(0.0, squares / c3d.frames - mean * mean));
    EXPECT_NEAR(mean, 0.0475, 0.002) << marker;
    EXPECT_LE(deviation, 0.5e-3) << marker;
    RecordProperty(std::string(marker) + "_deviation_micrometres", std::to_string(deviation * 1e6));
  }
}

TEST(Amc, ThreeToEightPercentOfSamplesViolateTheFilesOwnLimitsAndAreKept) {
  REQUIRE_DATA(data + "02_01.amc");
  const Walk walk;
  int outside = 0, limited = 0;
  for (int f = 0; f < walk.clip.frameCount(); ++f)
    for (const AsfSkeleton::Bone& bone : walk.asf.bones)
      for (std::size_t k = 0; k < walk.asf.skeleton.joint(bone.joint).axes.size(); ++k) {
        const AxisDof& dof = walk.asf.skeleton.joint(bone.joint).axes[k];
        if (dof.upper == unlimited) continue;
        const double value = walk.clip.q(walk.asf.skeleton.qIndex(bone.joint) + k, f);
        outside += value < dof.lower - 1e-9 || value > dof.upper + 1e-9;
        ++limited;
      }
  EXPECT_EQ(limited, 343 * 56);
  EXPECT_GE(outside, 0.03 * limited);
  EXPECT_LE(outside, 0.08 * limited);
}

/// Largest distance, over all frames, of joints that both skeletons have under one name.
double worstDistance(const Skeleton& a, const MotionClip& x, const Skeleton& b, const MotionClip& y,
                     int atLeast) {
  EXPECT_EQ(x.frameCount(), y.frameCount());
  double worst = 0.0;
  int shared = 0;
  for (int f = 0; f < x.frameCount(); ++f) {
    const Frames one = forwardKinematics(a, x.q.col(f)), other = forwardKinematics(b, y.q.col(f));
    shared = 0;
    for (int i = 0; i < a.jointCount(); ++i)
      if (const auto j = b.findJoint(a.joint(i).name)) {
        worst = std::max(worst, (one[i].translation() - other[*j].translation()).norm());
        ++shared;
      }
  }
  EXPECT_GE(shared, atLeast);
  return worst;
}

TEST(AsfAmc, ToBvhAndBackKeepsEveryJointOverTheWholeWalk) {
  REQUIRE_DATA(data + "02_01.amc");
  const Walk walk;
  const BvhMotion bvh = parseBvh(formatBvh(walk.asf.skeleton, walk.clip), "walk.bvh");
  EXPECT_LE(worstDistance(walk.asf.skeleton, walk.clip, bvh.skeleton, bvh.clip, 31), 1e-9);
  const AsfSkeleton asf = parseAsf(formatAsf(bvh.skeleton), "walk.asf");
  const MotionClip clip = parseAmc(formatAmc(bvh.skeleton, bvh.clip), "walk.amc", asf);
  EXPECT_NEAR(clip.framesPerSecond, 120.0, 1e-9);
  EXPECT_LE(worstDistance(walk.asf.skeleton, walk.clip, asf.skeleton, clip, 31),
            1e-9);  // the issue asks for 1e-6 m
}

TEST(AsfAmc, WrittenAndReadAgainKeepsDofsLimitsAndValues) {
  REQUIRE_DATA(data + "02_01.amc");
  const Walk walk;
  const AsfSkeleton again = parseAsf(formatAsf(walk.asf.skeleton), "again.asf");
  ASSERT_EQ(again.skeleton.nq(), walk.asf.skeleton.nq());
  for (const AsfSkeleton::Bone& bone : walk.asf.bones) {
    const Joint& before = walk.asf.skeleton.joint(bone.joint);
    const Joint& after = again.skeleton.joint(again.skeleton.jointIndex(bone.name));
    ASSERT_EQ(after.axes.size(), before.axes.size()) << bone.name;
    for (std::size_t k = 0; k < after.axes.size(); ++k)
      if (before.axes[k].lower != -unlimited) {
        EXPECT_NEAR(after.axes[k].lower, before.axes[k].lower, 1e-12) << bone.name;
      }
  }
  const MotionClip clip = parseAmc(formatAmc(walk.asf.skeleton, walk.clip), "again.amc", again);
  EXPECT_LE(worstDistance(walk.asf.skeleton, walk.clip, again.skeleton, clip, 31), 1e-9);
}

TEST(AsfAmc, AnySkeletonOfAxesAndBallsSurvivesTheWayThroughAsfAndThroughBvh) {
  const unsigned seed = 21;
  std::mt19937_64 random(seed);
  for (int trial = 0; trial < 20; ++trial) {
    Skeleton skeleton = testing::randomSkeleton(random, 10);
    std::vector<Joint> joints = skeleton.joints();
    for (Joint& joint : joints)
      if (joint.parent >= 0)
        std::erase_if(joint.axes, [](const AxisDof& dof) { return dof.kind == AxisDof::Kind::Translation; });
    skeleton = Skeleton(joints);
    MotionClip clip{.framesPerSecond = 50.0, .q = Eigen::MatrixXd(skeleton.nq(), 5)};
    for (int f = 0; f < 5; ++f) clip.q.col(f) = randomWithinLimits(skeleton, random);

    const AsfSkeleton asf = parseAsf(formatAsf(skeleton), "random.asf");
    const MotionClip amc = parseAmc(formatAmc(skeleton, clip), "random.amc", asf);
    const BvhMotion bvh = parseBvh(formatBvh(skeleton, clip), "random.bvh");
    for (int f = 0; f < 5; ++f) {
      const Frames frames = forwardKinematics(skeleton, clip.q.col(f));
      const Frames inAsf = forwardKinematics(asf.skeleton, amc.q.col(f)),
                   inBvh = forwardKinematics(bvh.skeleton, bvh.clip.q.col(f));
      for (int i = 0; i < skeleton.jointCount(); ++i) {
        const std::string name = i == 0 ? "root" : skeleton.joint(i).name;
        const std::string where =
            "seed " + std::to_string(seed) + " trial " + std::to_string(trial) + ' ' + name;
        const bool fixedEnd = i > 0 && skeleton.vCount(i) == 0 && skeleton.children(i).empty();
        if (const auto bone = asf.findBone(
                name)) {  // a fixed end is where its bone ends, any other joint where its bone begins
          const int j = fixedEnd ? asf.bones[*bone].endJoint : asf.bones[*bone].joint;
          EXPECT_LE((frames[i].translation() - inAsf[j].translation()).norm(), 1e-9) << where;
        } else {
          EXPECT_TRUE(fixedEnd) << where;
        }
        if (const auto j = bvh.skeleton.findJoint(skeleton.joint(i).name)) {
          EXPECT_LE((frames[i].translation() - inBvh[*j].translation()).norm(), 1e-9) << where;
        } else {
          EXPECT_TRUE(fixedEnd) << where;
        }
      }
    }
  }
}

}  // namespace
}  // namespace gelenk
