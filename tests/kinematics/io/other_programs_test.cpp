#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/io/asf_amc.h"
#include "kinematics/io/bvh.h"
#include "kinematics/io/dh_text.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/pinocchio_skeleton.h"
#include "kinematics/io/text_file.h"
#include "kinematics/io/tutorial_skeleton.h"
#include "kinematics/io/urdf.h"
#include "kinematics/motion/skeleton_transfer.h"
#include "tests/places.h"

// What other programs write and open: read as well, and told.

namespace gelenk {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

const std::string inputs = testing::inputFolder() + "/";

std::vector<std::string> kinds(const std::vector<Note>& notes) {
  std::vector<std::string> list;
  for (const Note& note : notes) list.push_back(note.kind);
  return list;
}

template <class Read>
std::string refusal(Read read) {
  try {
    read();
  } catch (const ParseError& error) {
    return error.what();
  }
  return "accepted";
}

/// A hierarchy of one joint and its end; frames: what follows MOTION.
std::string bvh(const std::string& motion, const std::string& end = "End Site") {
  return "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n" + end +
         "\n{\nOFFSET 0 1 0\n}\n}\nMOTION\n" + motion;
}

TEST(OtherProgramsBvh, TheRowsCountWhateverTheHeaderSays) {
  const BvhMotion file = readBvh(inputs + "frames_less.bvh");
  EXPECT_EQ(file.clip.frameCount(), 2);
  EXPECT_EQ(kinds(file.notes), std::vector<std::string>{"frame-count"});
  EXPECT_NEAR(file.clip.q(0, 1), 2.0, 1e-15);  // the second row, x
  for (const char* said : {"0", "1", "2", "4", "-3", "1000000000"}) {
    const BvhMotion read =
        parseBvh(bvh("Frames: " + std::string(said) + "\nFrame Time: 0.1\n1 2 3\n4 5 6\n7 8 9\n"), "a.bvh");
    EXPECT_EQ(read.clip.frameCount(), 3) << said;
    ASSERT_EQ(read.notes.size(), 1u) << said;
    EXPECT_THAT(read.notes[0].text, HasSubstr("there are 3 rows"));
  }
  const BvhMotion right = parseBvh(bvh("Frames: 3\nFrame Time: 0.1\n1 2 3 4 5\n6\n7 8 9\n"), "a.bvh");
  EXPECT_EQ(right.clip.frameCount(), 3);  // rows may run over lines where the count is right
  EXPECT_TRUE(right.notes.empty());
  const BvhMotion cut = parseBvh(bvh("Frames: 3\nFrame Time: 0.1\n1 2 3\n4 5 6\n7 8\n"), "a.bvh");
  EXPECT_EQ(cut.clip.frameCount(), 2);
  EXPECT_EQ(kinds(cut.notes), (std::vector<std::string>{"frame-cut-off", "frame-count"}));
}

TEST(OtherProgramsBvh, LabelsMayBeGluedOrApart) {
  const BvhMotion plain = parseBvh(bvh("Frames: 2\nFrame Time: 0.1\n1 2 3\n4 5 6\n"), "a.bvh");
  for (const char* header : {"Frames:2\nFrame Time:0.1\n", "Frames : 2\nFrame Time : 0.1\n",
                             "FRAMES:\t2\nFRAME TIME:\t0.1\n", "Frames: 2\r\nFrame Time: .1\r\n"}) {
    const BvhMotion read = parseBvh(bvh(std::string(header) + "1 2 3\n4 5 6\n"), "a.bvh");
    EXPECT_EQ(read.clip.q, plain.clip.q) << header;
    EXPECT_NEAR(read.clip.framesPerSecond, 10.0, 1e-12);
  }
}

TEST(OtherProgramsBvh, EndSitesMayHaveNames) {
  const std::string motion = "Frames: 1\nFrame Time: 0.1\n1 2 3\n";
  EXPECT_EQ(parseBvh(bvh(motion), "a.bvh").skeleton.joint(1).name, "a_end");
  EXPECT_EQ(parseBvh(bvh(motion, "End Site tip of it"), "a.bvh").skeleton.joint(1).name, "tip of it");
  EXPECT_EQ(parseBvh(bvh(motion, "End Site a"), "a.bvh").skeleton.joint(1).name, "a_");
}

TEST(OtherProgramsBvh, WhatIsWrittenHasSingleWordsAsNamesAndNoExponents) {
  const std::string text =
      "HIERARCHY\nROOT upper body\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nJOINT "
      "upper_body\n{\n"
      "OFFSET 0 1e-9 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 1 "
      "0\n}\n}\n}\nMOTION\n"
      "Frames: 1\nFrame Time: 0.1\n1e-12 2 3 4 5 6\n";
  const BvhMotion source = parseBvh(text, "a.bvh");
  const std::string written = formatBvh(source.skeleton, source.clip);
  EXPECT_THAT(written, HasSubstr("ROOT upper_body\n"));
  EXPECT_THAT(written, HasSubstr("JOINT upper_body_\n"));
  EXPECT_EQ(written.find("e-"), std::string::npos) << written;
  const BvhMotion again = parseBvh(written, "b.bvh");
  EXPECT_LE((again.clip.q.bottomRows(6) - source.clip.q.bottomRows(6)).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(OtherProgramsBvh, SeveralRootsHangOnOneJointAndMoveEachByItself) {
  const auto body = [](const std::string& name) {
    return "ROOT " + name +
           "\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
           "End Site\n{\nOFFSET 0 1 0\n}\n}\n";
  };
  const BvhMotion two = parseBvh("HIERARCHY\n" + body("a") + body("b") +
                                     "MOTION\nFrames: 1\nFrame Time: 0.1\n1 2 3 90 0 0 4 5 6 0 0 0\n",
                                 "two.bvh");
  ASSERT_EQ(two.skeleton.jointCount(), 5);
  ASSERT_EQ(two.notes.size(), 1u);
  EXPECT_EQ(two.notes[0].kind, "several-roots");
  EXPECT_EQ(two.notes[0].count, 2);
  const Frames frames = forwardKinematics(two.skeleton, two.clip.q.col(0));
  const auto place = [&](const char* name) {
    return Vector3d(frames[two.skeleton.jointIndex(name)].translation());
  };
  EXPECT_LT((place("a") - Vector3d(1, 2, 3)).norm(), 1e-12);
  EXPECT_LT((place("a_end") - Vector3d(0, 2, 3)).norm(), 1e-12);
  EXPECT_LT((place("b_end") - Vector3d(4, 6, 6)).norm(), 1e-12);
}

TEST(OtherProgramsBvh, JointsOfOneNameAreToldApart) {
  const std::string joint = "JOINT b\n{\nOFFSET 0 1 0\nCHANNELS 1 Xrotation\n}\n";
  const BvhMotion file = parseBvh("HIERARCHY\nROOT b\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n" + joint +
                                      joint + "}\nMOTION\nFrames: 1\nFrame Time: 0.1\n1 2 3\n",
                                  "b.bvh");
  std::vector<std::string> names;
  for (const Joint& one : file.skeleton.joints()) names.push_back(one.name);
  EXPECT_EQ(names, (std::vector<std::string>{"b", "b_2", "b_3"}));
  ASSERT_EQ(kinds(file.notes), std::vector<std::string>{"name-repeated"});
  EXPECT_EQ(file.notes[0].count, 2);
}

/// As systems other than CMU's write it: radians, centimetres, capitals, tabs, another order of rotations,
/// entries on one line, frames that begin elsewhere.
TEST(OtherProgramsAsf, KeywordsOfAnyCaseUnitsOrdersAndFrames) {
  const AsfSkeleton asf = parseAsf(
      ":VERSION 1.10\r\n:NAME Some Body\r\n:UNITS\r\n\tLENGTH 2.54\r\n\tANGLE RAD\r\n:ROOT\r\n\tAXIS "
      "zyx\r\n\tORDER tx ty tz "
      "rz ry rx\r\n\tPOSITION 0 0 0\r\n\tORIENTATION 0 0 0\r\n:BONEDATA\r\nBEGIN\r\n\tNAME "
      "Spine\r\n\tDIRECTION 0, 1, "
      "0\r\n\tLENGTH 50\r\n\tAXIS 0 0 0 zyx\r\n\tDOF rz ry rx\r\n\tLIMITS (-1 1)\r\n (-1,1)\r\n(-inf "
      "Inf)\r\nEND\r\nBEGIN NAME Head DIRECTION 0 1 0 LENGTH 20 AXIS 0 0 0 zyx "
      "END\r\n:HIERARCHY\r\nBEGIN\r\nroot "
      "spine\r\nSPINE head # its end\r\nEND\r\n:SKIN none\r\n",
      "other.asf");
  const MotionClip clip =
      parseAmc("#comment\r\n:FULLY-SPECIFIED\r\n101\r\nROOT 10 20 30 0.1 0.2 0.3\r\nspine\t0.5 0 1e-1\r\n",
               "other.amc", asf);
  const auto turn = [](double angle, int axis) {
    return Eigen::AngleAxisd(angle, Vector3d::Unit(axis)).toRotationMatrix();
  };
  const Vector3d expected = Vector3d(0.1, 0.2, 0.3) + turn(0.3, 0) * turn(0.2, 1) * turn(0.1, 2) *
                                                          turn(0.1, 0) * turn(0.5, 2) * Vector3d(0, 0.7, 0);
  const Frames frames = forwardKinematics(asf.skeleton, clip.q.col(0));
  EXPECT_LT((frames[asf.bones[2].endJoint].translation() - expected).norm(), 1e-12);
  EXPECT_TRUE(asf.notes.empty());
}

std::string urdf(const std::string& joints) {
  return "<robot name=\"m\"><link name=\"a\"/><link name=\"b\"/><link name=\"c\"/>" + joints + "</robot>";
}
const std::string hinge =
    "<joint name=\"j1\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/><axis xyz=\"0 0 1\"/>"
    "<limit lower=\"-1\" upper=\"1\"/>";

TEST(OtherProgramsUrdf, MimicsOnFixedJointsOrTowardsThemArePassedOver) {
  const UrdfRobot robot = readUrdf(inputs + "mimic_fixed.urdf");
  EXPECT_EQ(robot.skeleton.nq(), 1);
  EXPECT_LT((restFrames(robot.skeleton).back().translation() - Vector3d(0.4, 0, 0.1)).norm(), 1e-12);
  EXPECT_EQ(kinds(robot.notes), std::vector<std::string>{"mimic-ignored"});
  const UrdfRobot towards = parseUrdf(
      urdf(hinge + "<mimic joint=\"j2\"/></joint><joint name=\"j2\" type=\"fixed\"><parent link=\"b\"/>"
                   "<child link=\"c\"/></joint>"),
      "m.urdf");
  EXPECT_EQ(towards.skeleton.nv(), 1);
  EXPECT_EQ(kinds(towards.notes), std::vector<std::string>{"mimic-ignored"});
}

TEST(OtherProgramsUrdf, LimitsOfZeroToZeroAreTold) {
  const UrdfRobot robot = parseUrdf(
      urdf("<joint name=\"j1\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/><limit effort=\"1\"/>"
           "</joint><joint name=\"j2\" type=\"prismatic\"><parent link=\"b\"/><child link=\"c\"/>"
           "<limit lower=\"0\" upper=\"0\"/></joint>"),
      "m.urdf");
  ASSERT_EQ(robot.notes.size(), 1u);
  EXPECT_EQ(robot.notes[0].kind, "limits-zero");
  EXPECT_EQ(robot.notes[0].count, 2);
  EXPECT_THAT(robot.notes[0].line(), HasSubstr("(2 of this kind)"));
}

TEST(OtherProgramsUrdf, BodiesWithoutSizeOrOfAnotherKindArePassedOverAndTheRobotOpens) {
  const auto visual = [](const std::string& geometry) {
    return "<visual><geometry>" + geometry + "</geometry></visual>";
  };
  const UrdfRobot robot =
      parseUrdf("<robot><link name=\"a\">" + visual("<box size=\"0 0 0\"/>") +
                    visual("<cylinder radius=\"0.1\" length=\"0\"/>") + visual("<sphere radius=\"-1\"/>") +
                    visual("<capsule radius=\"1\" length=\"2\"/>") + visual("") +
                    visual("<sphere radius=\"1\"/>") + "</link></robot>",
                "m.urdf");
  EXPECT_EQ(robot.visuals.size(), 1u);
  EXPECT_EQ(kinds(robot.notes), (std::vector<std::string>{"geometry-empty", "geometry-unknown"}));
  EXPECT_EQ(robot.notes[0].count, 3);
  EXPECT_EQ(robot.notes[1].count, 2);
  EXPECT_THAT(robot.notes[1].text, HasSubstr("<capsule>"));
}

TEST(OtherProgramsUrdf, LimitsTheWrongWayRoundAreExchanged) {
  const UrdfRobot robot =
      parseUrdf(urdf("<joint name=\"j1\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/>"
                     "<limit lower=\"2\" upper=\"-1\"/></joint>"
                     "<joint name=\"j2\" type=\"fixed\"><parent link=\"b\"/><child link=\"c\"/></joint>"),
                "m.urdf");
  const AxisDof& dof = robot.skeleton.joint(robot.skeleton.jointIndex("j1")).axes[0];
  EXPECT_EQ(dof.lower, -1.0);
  EXPECT_EQ(dof.upper, 2.0);
  EXPECT_EQ(kinds(robot.notes), std::vector<std::string>{"limits-exchanged"});
}

TEST(OtherProgramsUrdf, WhatXacroLeftOverIsPassedOverAndTold) {
  const UrdfRobot robot = parseUrdf("<robot><link name=\"a\"/><xacro:pelvis/><xacro:usb/></robot>", "m.urdf");
  ASSERT_EQ(kinds(robot.notes), std::vector<std::string>{"xacro-left"});
  EXPECT_EQ(robot.notes[0].count, 2);
}

/// Hands are described for the arm that they are mounted on, and some programs know a link "world".
TEST(OtherProgramsUrdf, AParentLinkThatTheFileDoesNotHaveIsAddedAndTold) {
  const UrdfRobot robot = parseUrdf(
      "<robot><link name=\"a\"/><joint name=\"j\" type=\"fixed\"><origin xyz=\"0 0 2\"/><parent "
      "link=\"world\"/><child link=\"a\"/></joint></robot>",
      "m.urdf");
  EXPECT_EQ(robot.skeleton.joint(0).name, "world");
  EXPECT_EQ(restFrames(robot.skeleton)[1].translation(), Vector3d(0, 0, 2));
  EXPECT_EQ(kinds(robot.notes), std::vector<std::string>{"link-added"});
}

struct Text {
  const char* format;
  std::string text;
  std::function<void(const std::string&)> parse;
};

const std::vector<Text>& texts() {
  static const std::string asf =
      "# comment\n:version 1.10\n:name x\n:units\n mass 1.0\n length 0.45\n angle deg\n:root\n order TX TY "
      "TZ RX "
      "RY RZ\n axis XYZ\n position 0 0 0\n orientation 0 0 0\n:bonedata\n begin\n id 1\n name a\n direction "
      "0 1 "
      "0\n length 1\n axis 0 0 0 XYZ\n dof rx\n limits (-90 90)\n end\n:hierarchy\n begin\n root a\n end\n";
  static const std::vector<Text> list{
      {"BVH", bvh("Frames: 1\nFrame Time: 0.1\n1 2 3\n"), [](const std::string& t) { parseBvh(t, "f"); }},
      {"ASF", asf, [](const std::string& t) { parseAsf(t, "f"); }},
      {"AMC", ":FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 0 0 0 0 0\na 5\n",
       [](const std::string& t) { parseAmc(t, "f", parseAsf(asf, "f.asf")); }},
      {"URDF",
       "<?xml version=\"1.0\"?>\n" + urdf(hinge + "</joint><joint name=\"j2\" type=\"fixed\"><parent "
                                                  "link=\"b\"/><child link=\"c\"/></joint>"),
       [](const std::string& t) { parseUrdf(t, "f"); }},
      {"Pinocchio skeleton", "0 0 0 0 -1\n1 0 1 0 0\n",
       [](const std::string& t) { parsePinocchioSkeleton(t, "f"); }},
      {"DH table", "dh standard\nrevolute 1 0 0 0\n", [](const std::string& t) { parseDhTable(t, "f"); }},
      {"mapping", "a : b c\n", [](const std::string& t) { parseBonePaths(t, "f"); }}};
  return list;
}

TEST(OtherProgramsText, AByteOrderMarkIsNoPartOfAnyText) {
  for (const Text& text : texts()) {
    EXPECT_NO_THROW(text.parse(text.text)) << text.format;
    EXPECT_NO_THROW(text.parse("\xef\xbb\xbf" + text.text)) << text.format;
  }
}

TEST(OtherProgramsText, WideTextIsToldByItsEncodingWithAndWithoutItsMark) {
  const auto widened = [](const std::string& text, std::size_t bytes, bool bigEndian) {
    std::string wide;
    for (const char c : text) {
      const std::string zeros(bytes - 1, '\0');
      wide += bigEndian ? zeros + c : c + zeros;
    }
    return wide;
  };
  for (const Text& text : texts())
    for (const bool bigEndian : {false, true})
      for (const std::size_t bytes : {2u, 4u}) {
        const std::string mark = bigEndian ? "\xfe\xff" : "\xff\xfe", zeros(bytes - 2, '\0');
        const std::string marked = (bigEndian ? zeros + mark : mark + zeros);
        const std::string name = "UTF-" + std::to_string(8 * bytes) + (bigEndian ? "BE" : "LE");
        for (const std::string& begin : {std::string(), marked})
          EXPECT_THAT(refusal([&] { text.parse(begin + widened(text.text, bytes, bigEndian)); }),
                      HasSubstr(name + ": save it as UTF-8"))
              << text.format;
      }
}

TEST(OtherProgramsText, NumbersThatAreNoneAreRefusedWithTheReason) {
  const auto read = [](const std::string& word) {
    return refusal([&] { parseBvh(bvh("Frames: 1\nFrame Time: 0.1\n1 " + word + " 3\n"), "f.bvh"); });
  };
  for (const auto& [word, reason] : std::vector<std::pair<std::string, std::string>>{
           {"3.1+e2", "the sign of an exponent stands after the e"},
           {"3.1-e2", "the sign of an exponent stands after the e"},
           {"3.1e", "an exponent without digits"},
           {"3.1e+", "an exponent without digits"},
           {"3.1D+02", "an exponent begins with e"},
           {"3,1", "not a comma"},
           {"1.2.3", "two decimal points"},
           {"nan", "not a number"},
           {"-1.#IND", "not a number"},
           {"1.#INF", "infinity"},
           {"-inf", "infinity"},
           {"0x10", "numbers are decimal"},
           {"12abc", "other characters"}}) {
    EXPECT_THAT(read(word), HasSubstr("'" + word + "'")) << word;
    EXPECT_THAT(read(word), HasSubstr(reason)) << word;
    EXPECT_THAT(read(word), HasSubstr("f.bvh:14")) << word;
  }
  for (const char* word : {"3.1e+02", "3.1E2", "+3", "-.5", "1.", "1e-400", "7.6e-016"})
    EXPECT_EQ(read(word), "accepted") << word;
}

TEST(Notes, OneLineAKindWithItsCount) {
  std::vector<Note> notes;
  for (int k = 0; k < 3; ++k) tell(notes, "mesh-missing", "mesh " + std::to_string(k));
  tell(notes, "other", "once");
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_EQ(notes[0].line(), "mesh 0 (3 of this kind)");
  EXPECT_EQ(notes[1].line(), "once");
  EXPECT_EQ(listed({"a", "b", "c"}, 2), "a, b and 1 more");
}

}  // namespace
}  // namespace gelenk
