#include "kinematics/io/bvh.h"

#include <filesystem>

#include "kinematics/forward_kinematics.h"
#include "tests/kinematics/io/bad_input.h"
#include "tests/places.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

const std::string arm =
    "HIERARCHY\n"
    "ROOT hip\n{\n"
    "\tOFFSET 0 0 0\n\tCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
    "\tJOINT upper arm\n\t{\n"
    "\t\tOFFSET 1 0 0\n\t\tCHANNELS 3 Yrotation Zrotation Xrotation\n"
    "\t\tEnd Site\n\t\t{\n\t\t\tOFFSET 0.5 0 0\n\t\t}\n"
    "\t}\n}\n"
    "MOTION\nFrames: 2\nFrame Time: 0.025\n"
    "0 1 0 0 0 0 0 0 0\n"
    "0 1 0 90 0 0 90 90 0\n";

TEST(Bvh, TwoJointsByHandInTheOrderOfTheirChannels) {
  const BvhMotion bvh = parseBvh(arm, "arm.bvh");
  ASSERT_EQ(bvh.skeleton.jointCount(), 3);
  EXPECT_EQ(bvh.skeleton.joint(1).name, "upper arm");
  EXPECT_NEAR(bvh.clip.framesPerSecond, 40.0, 1e-12);
  const Frames frames = forwardKinematics(bvh.skeleton, bvh.clip.q.col(1));
  // The hip's Rz(90) carries the arm's start to +y. The arm: Ry(90) Rz(90) x = Ry(90) y = y, which the hip
  // turns to -x.
  EXPECT_LE((frames[1].translation() - Vector3d(0, 2, 0)).norm(), 1e-14);
  EXPECT_LE((frames[2].translation() - Vector3d(-0.5, 2, 0)).norm(), 1e-14);
}

TEST(Bvh, WrittenAndReadAgainIsTheSameToTheLastBitWhereAnglesAreKept) {
  const BvhMotion bvh = parseBvh(arm, "arm.bvh");
  const BvhMotion again = parseBvh(formatBvh(bvh.skeleton, bvh.clip), "again.bvh");
  EXPECT_LE((again.clip.q - bvh.clip.q).cwiseAbs().maxCoeff(), 4e-16);  // degrees and back
  EXPECT_EQ(again.skeleton.jointCount(), bvh.skeleton.jointCount());
}

/// What Blender's and three.js' readers want: three rotations a joint, positions of inner joints only where
/// they change.
TEST(Bvh, JointsAreWrittenWithThreeRotationsAndWithoutPositionsThatStandStill) {
  const auto joint = [](const char* name, int parent, std::vector<AxisDof> axes) {
    Joint made{.name = name, .parent = parent, .axes = std::move(axes)};
    made.parentFromZero.translation().y() = 1.0;
    return made;
  };
  const AxisDof slide{AxisDof::Kind::Translation, Vector3d::UnitX()},
      x{AxisDof::Kind::Rotation, Vector3d::UnitX()}, z{AxisDof::Kind::Rotation, Vector3d::UnitZ()};
  const Skeleton skeleton({joint("root", -1, {x}), joint("still", 0, {slide, z}),
                           joint("moving", 1, {slide, z, x}), joint("end", 2, {})});
  MotionClip clip{.framesPerSecond = 10.0, .q = Eigen::MatrixXd(6, 2)};
  clip.q.col(0) << 0.1, 0.25, 0.2, 0.5, 0.3, 0.4;
  clip.q.col(1) << 0.2, 0.25, 0.3, 0.6, 0.4, 0.5;
  const std::string text = formatBvh(skeleton, clip);
  EXPECT_NE(text.find("CHANNELS 6 Xposition Yposition Zposition Xrotation Yrotation Zrotation"),
            std::string::npos);
  EXPECT_NE(text.find("OFFSET 0.25 1 0\n\t\tCHANNELS 3 Zrotation Xrotation Yrotation"), std::string::npos)
      << text;
  EXPECT_NE(text.find("CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation"),
            std::string::npos);
  // Blender puts positions in the place of OFFSET, three.js adds them to it.
  for (const BvhPositions positions : {BvhPositions::Automatic, BvhPositions::Replace, BvhPositions::Add}) {
    const BvhMotion again = parseBvh(text, "again.bvh", {.positions = positions});
    for (int f = 0; f < 2; ++f) {
      const Frames before = forwardKinematics(skeleton, clip.q.col(f)),
                   after = forwardKinematics(again.skeleton, again.clip.q.col(f));
      for (int i = 0; i < skeleton.jointCount(); ++i)
        EXPECT_LE((before[i].translation() - after[i].translation()).norm(), 1e-12);
    }
  }
}

TEST(Bvh, UnitIsWhatTheCallerSays) {
  const BvhMotion bvh = parseBvh(arm, "arm.bvh", {.metresPerUnit = 0.01});
  EXPECT_NEAR(restFrames(bvh.skeleton)[2].translation().x(), 0.015, 1e-15);
  EXPECT_NEAR(bvh.clip.q(1, 0), 0.01, 1e-15);
}

TEST(Bvh, PositionsOfInnerJointsAreDifferencesOrPlacesWhicheverKeepsTheBones) {
  const auto text = [](const std::string& position) {
    return "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 3 Xrotation Yrotation Zrotation\nJOINT b\n{\nOFFSET "
           "0 2 0\nCHANNELS 3 Xposition Yposition "
           "Zposition\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\n}\nMOTION\nFrames: 1\nFrame Time: 1\n0 0 0 " +
           position + "\n";
  };
  const BvhMotion differences = parseBvh(text("0 0.01 0"), "a.bvh"),
                  places = parseBvh(text("0 2.01 0"), "b.bvh");
  EXPECT_NEAR(forwardKinematics(differences.skeleton, differences.clip.q.col(0))[1].translation().y(), 2.01,
              1e-15);
  EXPECT_NEAR(forwardKinematics(places.skeleton, places.clip.q.col(0))[1].translation().y(), 2.01, 1e-15);
  EXPECT_NEAR(restFrames(differences.skeleton)[1].translation().y(), 2.0, 1e-15);
  EXPECT_NEAR(restFrames(places.skeleton)[1].translation().y(), 2.0, 1e-15);
  ASSERT_EQ(places.notes.size(), 1u);
  const BvhMotion added = parseBvh(text("0 2.01 0"), "c.bvh", {.positions = BvhPositions::Add});
  EXPECT_NEAR(forwardKinematics(added.skeleton, added.clip.q.col(0))[1].translation().y(), 4.01, 1e-15);
}

TEST(Bvh, AnotherRootPositionConventionIsAnOption) {
  std::string text = arm;
  text.replace(text.find("OFFSET 0 0 0"), 12, "OFFSET 0 9 0");
  const BvhMotion replaced = parseBvh(text, "arm.bvh"),
                  added = parseBvh(text, "arm.bvh", {.positions = BvhPositions::Add});
  EXPECT_NEAR(forwardKinematics(replaced.skeleton, replaced.clip.q.col(0))[0].translation().y(), 1.0, 1e-15);
  EXPECT_NEAR(forwardKinematics(added.skeleton, added.clip.q.col(0))[0].translation().y(), 10.0, 1e-15);
}

TEST(Bvh, AMillionNestedJointsNeedNoDeepStack) {
  const int depth = 20000;
  std::string text = "HIERARCHY\nROOT j\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n";
  for (int k = 0; k < depth; ++k) text += "JOINT j" + std::to_string(k) + "\n{\nOFFSET 0 1 0\nCHANNELS 0\n";
  for (int k = 0; k <= depth; ++k) text += "}\n";
  text += "MOTION\nFrames: 1\nFrame Time: 1\n0\n";
  const BvhMotion bvh = parseBvh(text, "deep.bvh");
  EXPECT_EQ(bvh.skeleton.jointCount(), depth + 1);
  const BvhMotion again = parseBvh(formatBvh(bvh.skeleton, bvh.clip), "deep.bvh");
  EXPECT_EQ(again.skeleton.jointCount(), depth + 1);
}

TEST(Bvh, BadInputIsRefusedWithItsLine) {
  const auto with = [](std::string text, const std::string& old, const std::string& replacement) {
    const std::size_t at = text.find(old);
    EXPECT_NE(at, std::string::npos) << old;
    return text.replace(at, old.size(), replacement);
  };
  const std::string motion = "MOTION\nFrames: 2\nFrame Time: 0.025\n";
  testing::expectRefused(
      {
          {"empty", "", 1, "'HIERARCHY', found the end of the file"},
          {"another format", "# ASF\n:version 1\n", 1, "'HIERARCHY'"},
          {"no root", "HIERARCHY\nMOTION\n", 2, "'ROOT'"},
          {"no brace", with(arm, "ROOT hip\n{\n", "ROOT hip\n"), 3, "'{'"},
          {"no offset", with(arm, "\tOFFSET 0 0 0\n", ""), 4, "'OFFSET'"},
          {"two coordinates", with(arm, "OFFSET 0 0 0", "OFFSET 0 0"), 5, "a finite number"},
          {"NaN", with(arm, "OFFSET 0 0 0", "OFFSET 0 nan 0"), 4, "'nan'"},
          {"overflow", with(arm, "OFFSET 0 0 0", "OFFSET 0 1e309 0"), 4, "'1e309'"},
          {"unknown channel", with(arm, "Xposition", "Wposition"), 5, "'Wposition'"},
          {"channel cut short", with(arm, "Xposition", "X"), 5, "'X'"},
          {"channel twice", with(arm, "Yposition", "Xposition"), 5, "second Xposition"},
          {"fewer channels than named", with(arm, "CHANNELS 6", "CHANNELS 5"), 5, "'Yrotation'"},
          {"more channels than named", with(arm, "CHANNELS 3", "CHANNELS 4"), 10, "'End'"},
          {"seven channels", with(arm, "CHANNELS 6", "CHANNELS 7"), 5, "0 to 6"},
          {"a million channels", with(arm, "CHANNELS 6", "CHANNELS 1000000"), 5, "0 to 6"},
          {"minus one channel", with(arm, "CHANNELS 6", "CHANNELS -1"), 5, "0 to 6"},
          {"half a channel", with(arm, "CHANNELS 6", "CHANNELS 2.5"), 5, "'2.5'"},
          {"two lines CHANNELS", with(arm, "\tJOINT upper", "\tCHANNELS 1 Xrotation\n\tJOINT upper"), 6,
           "second one"},
          {"unknown keyword", with(arm, "JOINT", "BONE"), 6, "'BONE'"},
          {"end without site", with(arm, "End Site", "End"), 11, "'Site'"},
          {"brace too few", with(arm, "\t}\n}\n", "\t}\n"), 15, "'MOTION'"},
          {"brace too many", with(arm, "}\nMOTION", "}\n}\nMOTION"), 16, "'}'"},
          {"a second root without an offset", with(arm, "MOTION", "ROOT two\n{\n}\nMOTION"), 18, "'OFFSET'"},
          {"no motion", arm.substr(0, arm.find("MOTION")), 15, "'MOTION'"},
          {"no frame", arm.substr(0, arm.find("0 1 0 0 0")), 18, "at least one frame"},
          {"a frame too short for one", arm.substr(0, arm.find("0 1 0 0 0")) + "1 2 3\n", 19,
           "3 values in this row"},
          {"frames overflow", with(arm, "Frames: 2", "Frames: 99999999999"), 17, "'99999999999'"},
          {"frame time zero", with(arm, "Time: 0.025", "Time: 0"), 18, "positive frame time"},
          {"frame time negative", with(arm, "Time: 0.025", "Time: -1"), 18, "positive frame time"},
          {"too few values in the first row", with(arm, "0 1 0 0 0 0", "0 1 0 0 0"), 19,
           "8 values in this row, 17 in all"},
          {"too many values in the last row", with(arm, "90 90 0\n", "90 90 0 1\n"), 20,
           "10 values in this row"},
          {"a word among values", with(arm, "90 90 0\n", "90 x 0\n"), 20, "'x'"},
          {"NaN among values", with(arm, "90 90 0\n", "90 nan 0\n"), 20, "'nan'"},
          {"no channel at all", "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\n}\n" + motion, 2,
           "at least one channel"},
          {"CRLF keeps line numbers", "HIERARCHY\r\nROOT a\r\n{\r\nOFFSET 0 x 0\r\n", 4, "'x'"},
          {"cut in the hierarchy", arm.substr(0, 120), 6, ""},
      },
      [](const std::string& text, const std::string& file) { parseBvh(text, file); });
}

TEST(Bvh, EveryFileOfTheTrialDataIsReadAndSurvivesWriting) {
  const std::string folder = testing::dataFolder() + "/mocap/bvh/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no trial data at " << folder;
  for (const char* name : {"mh_walk1.bvh", "mh_dance1.bvh", "mh_tpose.bvh"}) {
    const BvhMotion bvh = readBvh(folder + name);
    const BvhMotion again = parseBvh(formatBvh(bvh.skeleton, bvh.clip), name);
    ASSERT_EQ(again.clip.frameCount(), bvh.clip.frameCount());
    for (int f = 0; f < bvh.clip.frameCount(); ++f) {
      const Frames a = forwardKinematics(bvh.skeleton, bvh.clip.q.col(f)),
                   b = forwardKinematics(again.skeleton, again.clip.q.col(f));
      for (int i = 0; i < bvh.skeleton.jointCount(); ++i)
        ASSERT_LE(
            (a[i].translation() - b[again.skeleton.jointIndex(bvh.skeleton.joint(i).name)].translation())
                .norm(),
            1e-9)
            << name << ' ' << i;
    }
  }
}

}  // namespace
}  // namespace gelenk
