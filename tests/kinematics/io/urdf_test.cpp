#include "kinematics/io/urdf.h"

#include <filesystem>

#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "tests/kinematics/io/bad_input.h"
#include "tests/places.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

const std::string arm =
    "<?xml version=\"1.0\"?>\n"
    "<robot name=\"arm\">\n"
    "<link name=\"base\"><visual><origin xyz=\"0 0 0.1\"/><geometry><box size=\"1 2 "
    "3\"/></geometry></visual></link>\n"
    "<link name=\"upper\"/>\n"
    "<link name=\"slide\"/>\n"
    "<joint name=\"shoulder\" type=\"revolute\"><origin xyz=\"0 0 1\" rpy=\"0 0 "
    "1.5707963267948966\"/><parent link=\"base\"/><child link=\"upper\"/>"
    "<axis xyz=\"0 0 2\"/><limit lower=\"0.5\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint>\n"
    "<joint name=\"push\" type=\"prismatic\"><origin xyz=\"1 0 0\"/><parent link=\"upper\"/><child "
    "link=\"slide\"/>"
    "<limit upper=\"2\" effort=\"1\" velocity=\"1\"/></joint>\n"
    "</robot>\n";

TEST(Urdf, ArmByHand) {
  const UrdfRobot robot = parseUrdf(arm, "arm.urdf");
  ASSERT_EQ(robot.skeleton.jointCount(), 3);
  EXPECT_EQ(robot.skeleton.joint(1).name, "shoulder");
  EXPECT_EQ(robot.skeleton.rest()[0], 0.5);  // zero is outside the limits
  Eigen::VectorXd q(2);
  q << M_PI / 2, 0.25;
  // Turned by 90 + 90 degrees the upper arm points to -x; the slide moves along it (its axis is x where none
  // is given).
  EXPECT_LE((forwardKinematics(robot.skeleton, q)[2].translation() - Vector3d(-1.25, 0, 1)).norm(), 1e-15);
  ASSERT_EQ(robot.visuals.size(), 1u);
  EXPECT_EQ(robot.visuals[0].size, Vector3d(1, 2, 3));
}

/// A gripper: three fingers that slide as the first does, the third by way of the second.
const std::string gripper =
    "<robot name=\"g\">\n<link name=\"palm\"/><link name=\"a\"/><link name=\"b\"/><link name=\"c\"/>\n"
    "<joint name=\"third\" type=\"prismatic\"><parent link=\"palm\"/><child link=\"c\"/><limit lower=\"-9\" "
    "upper=\"9\"/><mimic joint=\"second\" multiplier=\"0.5\"/></joint>\n"
    "<joint name=\"first\" type=\"prismatic\"><parent link=\"palm\"/><child link=\"a\"/><limit "
    "lower=\"0.25\" upper=\"1\"/></joint>\n"
    "<joint name=\"second\" type=\"prismatic\"><parent link=\"palm\"/><child link=\"b\"/><limit lower=\"-9\" "
    "upper=\"9\"/><mimic joint=\"first\" multiplier=\"-2\" offset=\"0.1\"/></joint>\n"
    "</robot>\n";

TEST(Urdf, MimicsFollowTheLastJointOfTheirChain) {
  const UrdfRobot robot = parseUrdf(gripper, "g.urdf");
  ASSERT_EQ(robot.notes.size(), 1u);
  EXPECT_EQ(robot.notes[0].kind, "mimic");
  EXPECT_TRUE(robot.notes[0].fact);
  const Skeleton& skeleton = robot.skeleton;
  EXPECT_EQ(skeleton.nq(), 3);
  EXPECT_EQ(skeleton.nv(), 1);
  const auto value = [&](const Eigen::VectorXd& q, const char* name) {
    return q[skeleton.qIndex(skeleton.jointIndex(name))];
  };
  EXPECT_EQ(value(skeleton.rest(), "first"), 0.25);
  EXPECT_EQ(value(skeleton.rest(), "second"), -2 * 0.25 + 0.1);
  EXPECT_NEAR(value(skeleton.rest(), "third"), 0.5 * (-2 * 0.25 + 0.1), 1e-15);
  Eigen::VectorXd q = skeleton.rest();
  q[skeleton.qIndex(skeleton.jointIndex("first"))] = 1.0;
  EXPECT_NEAR(value(projectToLimits(skeleton, q), "third"), 0.5 * (-2 + 0.1), 1e-15);
}

/// second = -2 first + 0.1 within [-1, 9] leaves first [0.25, 0.55] of its [0.25, 1].
TEST(Urdf, LimitsOfAMimicHoldForWhatItFollows) {
  std::string text = gripper;
  const std::string second = "link=\"b\"/><limit lower=\"-9\"";
  text.replace(text.find(second), second.size(), "link=\"b\"/><limit lower=\"-1\"");
  const Skeleton skeleton = parseUrdf(text, "g.urdf").skeleton;
  const AxisDof& first = skeleton.joint(skeleton.jointIndex("first")).axes[0];
  EXPECT_NEAR(first.lower, 0.25, 1e-15);
  EXPECT_NEAR(first.upper, 0.55, 1e-15);
}

/// Limits copied from the finger that turns the other way: other programs close the hand all the same.
TEST(Urdf, LimitsOfAMimicThatLeaveNoWayArePassedOverAndTold) {
  std::string text = gripper;
  const std::string second = "link=\"b\"/><limit lower=\"-9\" upper=\"9\"";
  text.replace(text.find(second), second.size(), "link=\"b\"/><limit lower=\"0.25\" upper=\"1\"");
  const UrdfRobot robot = parseUrdf(text, "g.urdf");
  ASSERT_EQ(robot.notes.size(), 2u);
  EXPECT_EQ(robot.notes[0].kind, "mimic-limits");
  const AxisDof& first = robot.skeleton.joint(robot.skeleton.jointIndex("first")).axes[0];
  EXPECT_EQ(first.lower, 0.25);
  EXPECT_EQ(first.upper, 1.0);
}

TEST(Urdf, BadInputIsRefusedWithItsLine) {
  const auto with = [](std::string text, const std::string& old, const std::string& replacement) {
    const std::size_t at = text.find(old);
    EXPECT_NE(at, std::string::npos) << old;
    return text.replace(at, old.size(), replacement);
  };
  std::string deep = "<robot>";
  for (int k = 0; k < 100000; ++k) deep += "<a>";
  testing::expectRefused(
      {
          {"empty", "", 0, ""},
          {"not XML", "robot arm\n", 0, "document empty"},
          {"not closed", "<robot>\n<link name=\"a\">\n", 3, "end tag"},
          {"another root", "<mujoco/>\n", 1, "an element <robot>, found <mujoco>"},
          {"no link", "<robot/>\n", 1, "at least one <link>"},
          {"nested too deeply", deep, 1, "nested at most 200"},
          {"a zero byte", std::string("<robot>\n\0</robot>", 17), 2, "found byte 0"},
          {"a character cut off at the end", "<robot name=\"\xe3", 1, "text in UTF-8"},
          {"Latin-1", "<robot>\n<!-- H\xfcgel -->", 2, "text in UTF-8"},
          {"link without a name", with(arm, "<link name=\"upper\"/>", "<link/>"), 4, "an attribute name"},
          {"link twice", with(arm, "name=\"slide\"/>", "name=\"upper\"/>"), 5, "'upper' again"},
          {"joint without a type", with(arm, " type=\"prismatic\"", ""), 7, "an attribute type"},
          {"unknown type", with(arm, "prismatic", "screw"), 7, "'screw'"},
          {"joint twice", with(arm, "push", "shoulder"), 7, "'shoulder' again"},
          {"joint without a parent", with(arm, "<parent link=\"upper\"/>", ""), 7, "<parent>"},
          {"joint without a child", with(arm, "<child link=\"slide\"/>", ""), 7, "<child>"},
          {"unknown link", with(arm, "<child link=\"slide\"/>", "<child link=\"slid\"/>"), 7, "'slid'"},
          {"two parents", with(arm, "<child link=\"slide\"/>", "<child link=\"upper\"/>"), 7,
           "second one for 'upper'"},
          {"unknown link above", with(arm, "<parent link=\"upper\"/>", "<parent link=\"uper\"/>"), 7,
           "a second one, 'uper'"},
          {"two roots", with(arm, "<link name=\"slide\"/>", "<link name=\"slide\"/><link name=\"lost\"/>"), 5,
           "'lost'"},
          {"cycle at the root", with(arm, "<child link=\"slide\"/>", "<child link=\"base\"/>"), 6,
           "on a cycle of links"},
          {"only a cycle",
           "<robot><link name=\"a\"/><link name=\"b\"/><joint name=\"x\" type=\"fixed\"><parent "
           "link=\"a\"/><child link=\"b\"/></joint>"
           "<joint name=\"y\" type=\"fixed\"><parent link=\"b\"/><child link=\"a\"/></joint></robot>",
           1, "cycle"},
          {"a cycle aside",
           with(arm, "</robot>",
                "<link name=\"a\"/><link name=\"b\"/><joint name=\"x\" type=\"fixed\"><parent "
                "link=\"a\"/><child link=\"b\"/></joint>"
                "<joint name=\"y\" type=\"fixed\"><parent link=\"b\"/><child link=\"a\"/></joint></robot>"),
           8, "cycle"},
          {"axis of length zero", with(arm, "0 0 2", "0 0 0"), 6, "positive length"},
          {"axis of two numbers", with(arm, "0 0 2", "0 2"), 6, "'0 2'"},
          {"NaN", with(arm, "0 0 2", "0 nan 2"), 6, "'nan'"},
          {"origin with a word", with(arm, "xyz=\"0 0 1\"", "xyz=\"0 0 a\""), 6, "'a'"},
          {"overflow", with(arm, "xyz=\"0 0 1\"", "xyz=\"0 0 1e999\""), 6, "1e999"},
          {"limit a word", with(arm, "upper=\"2\"", "upper=\"high\""), 7, "'high'"},
          {"xacro", "<robot>\n<xacro:arm side=\"l\"/></robot>\n", 2, "expected URDF, found <xacro:arm>"},
          {"CRLF keeps line numbers", with(arm, "<robot name=\"arm\">\n", "<robot>\r\n<link/>\r\n"), 3,
           "an attribute name"},
      },
      [](const std::string& text, const std::string& file) { parseUrdf(text, file); });
}

/// The specification demands <limit> of both; urdfdom and Bullet refuse its absence, others open it.
TEST(Urdf, JointsThatLackTheirLimitMoveWithoutLimitsAndAreTold) {
  std::string text = arm;
  for (const std::string limit : {"<limit lower=\"0.5\" upper=\"1\" effort=\"1\" velocity=\"1\"/>",
                                  "<limit upper=\"2\" effort=\"1\" velocity=\"1\"/>"})
    text.erase(text.find(limit), limit.size());
  const UrdfRobot robot = parseUrdf(text, "arm.urdf");
  for (const int joint : {1, 2}) {
    ASSERT_EQ(robot.skeleton.joint(joint).axes.size(), 1u);
    EXPECT_EQ(robot.skeleton.joint(joint).axes[0].lower, -unlimited);
    EXPECT_EQ(robot.skeleton.joint(joint).axes[0].upper, unlimited);
  }
  EXPECT_EQ(robot.skeleton.rest(), Eigen::VectorXd::Zero(2));
  ASSERT_EQ(robot.notes.size(), 1u);
  EXPECT_EQ(robot.notes[0].kind, "limits-missing");
  EXPECT_EQ(robot.notes[0].count, 2);
  EXPECT_FALSE(robot.notes[0].fact);
  EXPECT_NE(robot.notes[0].text.find("'shoulder'"), std::string::npos);
}

TEST(Urdf, InertialsBecomeTheMassesOfTheJointsThatCarryTheirLinks) {
  std::string text = arm;
  const std::string link = "<link name=\"slide\"/>";
  text.replace(text.find(link), link.size(),
               "<link name=\"slide\"><inertial><origin xyz=\"0 0 0.5\" rpy=\"1 0 0\"/><mass value=\"2.5\"/>"
               "</inertial></link>");
  const UrdfRobot robot = parseUrdf(text, "arm.urdf");
  ASSERT_TRUE(robot.masses.has_value());
  robot.masses->check(robot.skeleton);
  const int push = robot.skeleton.jointIndex("push");
  EXPECT_EQ(robot.masses->mass[push], 2.5);
  EXPECT_EQ(robot.masses->total(), 2.5);
  EXPECT_EQ(robot.masses->centre[push], Eigen::Vector3d(0, 0, 0.5));
  EXPECT_FALSE(parseUrdf(arm, "arm.urdf").masses.has_value());
  std::string negative = text;
  negative.replace(negative.find("2.5"), 3, "-1.");
  EXPECT_THROW(parseUrdf(negative, "arm.urdf"), ParseError);
}

TEST(Urdf, EveryRobotOfTheTrialDataIsRead) {
  const std::string folder = testing::dataFolder() + "/robots/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no trial data at " << folder;
  EXPECT_EQ(readUrdf(folder + "panda/urdf/panda.urdf").skeleton.nv(), 8);
  EXPECT_EQ(readUrdf(folder + "ur5/urdf/ur5_robot.urdf").skeleton.nv(), 6);
  EXPECT_EQ(readUrdf(folder + "kuka_iiwa/model.urdf").skeleton.nv(), 7);
  EXPECT_GT(readUrdf(folder + "kuka_iiwa/model.urdf").masses.value().total(), 10.0);
  EXPECT_GT(readUrdf(folder + "simple_humanoid/urdf/simple_humanoid.urdf").skeleton.nv(), 20);
}

}  // namespace
}  // namespace gelenk
