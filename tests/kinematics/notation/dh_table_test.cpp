#include "kinematics/notation/dh_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "kinematics/configuration.h"
#include "kinematics/io/dh_text.h"
#include "kinematics/io/urdf.h"
#include "kinematics/notation/robots.h"
#include "tests/kinematics/io/bad_input.h"
#include "tests/kinematics/random_skeleton.h"
#include "tests/places.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::VectorXd;

DhTable randomTable(std::mt19937_64& random, DhConvention convention) {
  const auto between = [&](double lo, double hi) { return lo + (hi - lo) * uniform01(random); };
  DhTable table{.name = "random", .convention = convention};
  const int n = 1 + static_cast<int>(random() % 8);
  for (int i = 0; i < n; ++i)
    table.rows.push_back({.kind = static_cast<DhJoint>(random() % 3),
                          .a = between(-1, 1),
                          .alpha = between(-3, 3),
                          .d = between(-1, 1),
                          .phi = between(-3, 3)});
  table.base.linear() = expRotation(2.0 * testing::randomUnit(random)).toRotationMatrix();
  table.base.translation() = testing::randomUnit(random);
  table.tool.linear() = expRotation(testing::randomUnit(random)).toRotationMatrix();
  table.tool.translation() = 0.2 * testing::randomUnit(random);
  return table;
}

VectorXd randomVariables(const DhTable& table, std::mt19937_64& random) {
  VectorXd q(table.variableCount());
  for (double& value : q) value = 6.0 * uniform01(random) - 3.0;
  return q;
}

TEST(DhTable, OneRowIsTheMatrixOnTheSlide) {
  const DhRow row{.a = 0.3, .alpha = 0.4, .d = 0.5, .phi = 0.6};
  const double ca = std::cos(0.4), sa = std::sin(0.4), cp = std::cos(0.6), sp = std::sin(0.6);
  Matrix4d modified, standard;  // multiplied out by hand
  modified << cp, -sp, 0, 0.3, sp * ca, cp * ca, -sa, -0.5 * sa, sp * sa, cp * sa, ca, 0.5 * ca, 0, 0, 0, 1;
  standard << cp, -sp * ca, sp * sa, 0.3 * cp, sp, cp * ca, -cp * sa, 0.3 * sp, 0, sa, ca, 0.5, 0, 0, 0, 1;
  EXPECT_LE((dhTransform(row, DhConvention::Modified, 0.0).matrix() - modified).norm(), 1e-15);
  EXPECT_LE((dhTransform(row, DhConvention::Standard, 0.0).matrix() - standard).norm(), 1e-15);
}

TEST(DhTable, ChainOfMatricesAndSkeletonAreOneMotion) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 2000; ++i) {
    const DhConvention convention = i % 2 ? DhConvention::Modified : DhConvention::Standard;
    const DhTable table = randomTable(random, convention);
    const VectorXd q = randomVariables(table, random);
    const Frames chain = dhFrames(table, q);
    const Frames frames = forwardKinematics(toSkeleton(table), q);
    const double size = static_cast<double>(table.rows.size());  // 1e-14 a row: each product rounds once more
    EXPECT_LE((chain.back().matrix() - frames.back().matrix()).cwiseAbs().maxCoeff(), 1e-14 * size);
    if (convention == DhConvention::Modified) {
      for (std::size_t k = 0; k + 1 < chain.size(); ++k)
        EXPECT_LE((chain[k].matrix() - frames[k].matrix()).cwiseAbs().maxCoeff(), 1e-14 * size);
    }
  }
}

TEST(DhTable, RobotsAgreeWithTheirMatricesTo1em14) {
  std::mt19937_64 random(2);
  for (const Robot& robot : robots()) {
    const DhTable table = robot.table();
    const Skeleton skeleton = toSkeleton(table);
    for (int i = 0; i < 1000; ++i) {
      const VectorXd q = randomWithinLimits(skeleton, random);
      const Isometry3d difference =
          Isometry3d(dhFrames(table, q).back().matrix() - forwardKinematics(skeleton, q).back().matrix());
      EXPECT_LE(difference.matrix().cwiseAbs().maxCoeff(), 1e-14) << robot.name;
    }
    EXPECT_EQ(limitViolation(skeleton, skeleton.rest()), 0.0) << robot.name;
  }
}

TEST(DhTable, EachConventionTurnsIntoTheOtherAndBack) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 1000; ++i) {
    const DhConvention from = i % 2 ? DhConvention::Modified : DhConvention::Standard;
    const DhConvention to = i % 2 ? DhConvention::Standard : DhConvention::Modified;
    const DhTable table = randomTable(random, from);
    const DhTable other = toConvention(table, to);
    const VectorXd q = randomVariables(table, random);
    EXPECT_EQ(other.convention, to);
    EXPECT_LE((dhFrames(table, q).back().matrix() - dhFrames(other, q).back().matrix()).norm(), 1e-13);
    EXPECT_LE(
        (dhFrames(table, q).back().matrix() - dhFrames(toConvention(other, from), q).back().matrix()).norm(),
        1e-13);
  }
}

TEST(DhTable, HasFourParametersARowAndThreeForTheBasePoint) {
  EXPECT_EQ(parameterCount(robotTable("ur5")), 4 * 6 + 3);
}

TEST(CommonNormal, IsPerpendicularToBothAndShortest) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 1000; ++i) {
    const AxisLine first{2.0 * testing::randomUnit(random), 3.0 * testing::randomUnit(random)};
    const AxisLine second{2.0 * testing::randomUnit(random), testing::randomUnit(random)};
    const CommonNormal n = commonNormal(first, second);
    EXPECT_NEAR(n.x.norm(), 1.0, 1e-14);
    const Vector3d u = first.direction.normalized(), v = second.direction.normalized();
    const double slack = 1e-12 / u.cross(v).norm();  // nearly parallel axes have an ill-determined normal
    EXPECT_LE(std::abs(n.x.dot(u)), slack);
    EXPECT_LE(std::abs(n.x.dot(v)), slack);
    EXPECT_LE((n.footOnSecond - n.footOnFirst - n.a * n.x).norm(), slack);
    for (int k = 0; k < 10; ++k) {
      const Vector3d p = n.footOnFirst + (uniform01(random) - 0.5) * u,
                     q = n.footOnSecond + (uniform01(random) - 0.5) * v;
      EXPECT_GE((p - q).norm(), n.a - slack);
    }
    EXPECT_LE((Eigen::AngleAxisd(n.alpha, n.x) * u - v).norm(), slack);
  }
}

TEST(CommonNormal, KnowsSkewCrossingParallelAndCoincidentAxes) {
  const AxisLine z{{0, 0, 0}, {0, 0, 1}};
  const CommonNormal skew = commonNormal(z, {{2, 0, 5}, {0, 1, 0}});
  EXPECT_EQ(skew.kind, AxisPair::Skew);
  EXPECT_NEAR(skew.a, 2.0, 1e-15);
  EXPECT_NEAR(skew.alpha, -M_PI / 2, 1e-15);  // about +x, z turns into -y at +90 degrees
  EXPECT_LE((skew.footOnFirst - Vector3d(0, 0, 5)).norm(), 1e-14);
  const CommonNormal crossing = commonNormal(z, {{0, 3, 5}, {0, 1, 0}});
  EXPECT_EQ(crossing.kind, AxisPair::Crossing);
  EXPECT_EQ(crossing.a, 0.0);
  EXPECT_LE((crossing.footOnSecond - Vector3d(0, 0, 5)).norm(), 1e-14);
  const CommonNormal parallel = commonNormal(z, {{0, 2, 7}, {0, 0, 4}}, {9, 9, 1});
  EXPECT_EQ(parallel.kind, AxisPair::Parallel);
  EXPECT_LE((parallel.footOnFirst - Vector3d(0, 0, 1)).norm(), 1e-14);
  EXPECT_NEAR(parallel.a, 2.0, 1e-15);
  EXPECT_EQ(parallel.alpha, 0.0);
  const CommonNormal opposite = commonNormal(z, {{0, 2, 7}, {0, 0, -4}});
  EXPECT_EQ(opposite.kind, AxisPair::Parallel);
  EXPECT_NEAR(std::abs(opposite.alpha), M_PI, 1e-15);
  const CommonNormal coincident = commonNormal(z, {{0, 0, 7}, {0, 0, 1}}, {0, 0, 3}, {0, 1, 1});
  EXPECT_EQ(coincident.kind, AxisPair::Coincident);
  EXPECT_LE((coincident.x - Vector3d(0, 1, 0)).norm(), 1e-15);
  EXPECT_THROW(commonNormal(z, {{0, 0, 0}, {0, 0, 0}}), std::invalid_argument);
}

double distanceBetweenLines(const AxisLine& one, const AxisLine& other) {
  const Vector3d u = one.direction.normalized();
  return (u - other.direction.normalized()).norm() + (other.point - one.point).cross(u).norm();
}

TEST(DhFromAxes, GivesBackTheAxes) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 1000; ++i) {
    std::vector<AxisLine> axes;
    const int n = 1 + static_cast<int>(random() % 7);
    for (int k = 0; k < n; ++k) {
      AxisLine line{testing::randomUnit(random), testing::randomUnit(random)};
      const int relation = static_cast<int>(random() % 5);
      if (k > 0 && relation == 1) line.direction = axes.back().direction;                        // parallel
      if (k > 0 && relation == 2) line.point = axes.back().point + 0.7 * axes.back().direction;  // crossing
      if (k > 0 && relation == 3)
        line = {axes.back().point + axes.back().direction, axes.back().direction};  // coincident
      if (k > 0 && relation == 4) line.direction = -axes.back().direction;          // antiparallel
      axes.push_back(line);
    }
    const DhTable table = dhFromAxes(axes);
    EXPECT_EQ(table.convention, DhConvention::Modified);
    const auto again = jointAxes(table, VectorXd::Zero(n));
    ASSERT_EQ(again.size(), axes.size());
    for (int k = 0; k < n; ++k)
      EXPECT_LE(distanceBetweenLines(axes[k], again[k]), 1e-8) << "axis " << k << " of " << n;
    // Canonical parameters describe themselves: the axes of the table give the table's own axes and lengths
    // again.
    for (const DhRow& row : table.rows) EXPECT_GE(row.a, 0.0);
  }
}

TEST(DhFromAxes, EveryRobotIsRecoveredFromItsAxesAlone) {
  for (const Robot& robot : robots()) {
    const DhTable table = robot.table();
    const VectorXd zero = VectorXd::Zero(table.variableCount());
    std::vector<DhJoint> kinds;
    for (const DhRow& row : table.rows)
      if (row.kind != DhJoint::Fixed) kinds.push_back(row.kind);
    const DhTable recovered = dhFromAxes(jointAxes(table, zero), kinds);
    // The same axes must move the same way: compare where they are at another configuration.
    const VectorXd q = 0.3 * VectorXd::LinSpaced(table.variableCount(), 1.0, 2.0);
    const auto expected = jointAxes(table, q), found = jointAxes(recovered, q);
    ASSERT_EQ(expected.size(), found.size());
    for (std::size_t k = 0; k < expected.size(); ++k)
      EXPECT_LE(distanceBetweenLines(expected[k], found[k]), 1e-12) << robot.name << " axis " << k;
  }
}

void expectSameMotion(const Skeleton& skeleton, int end, const DhChain& chain) {
  std::mt19937_64 random(5);
  const DhTable again = parseDhTable(formatDhTable(chain.table), "again.dh");
  for (int trial = 0; trial < 100; ++trial) {
    const VectorXd q = randomWithinLimits(skeleton, random);
    VectorXd variables(chain.joints.size());
    for (std::size_t k = 0; k < chain.joints.size(); ++k) variables[k] = q[skeleton.qIndex(chain.joints[k])];
    const Matrix4d wanted = forwardKinematics(skeleton, q)[end].matrix();
    EXPECT_LE((dhFrames(again, variables).back().matrix() - wanted).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LE(
        (forwardKinematics(toSkeleton(again), variables).back().matrix() - wanted).cwiseAbs().maxCoeff(),
        1e-9);
  }
}

TEST(DhFromSkeleton, RobotsOfTablesComeBackWithTheirMotion) {
  for (const Robot& robot : robots()) {
    SCOPED_TRACE(robot.name);
    const Skeleton skeleton = toSkeleton(robot.table());
    const DhChain chain = dhFromSkeleton(skeleton);
    EXPECT_EQ(chain.table.variableCount(), skeleton.nv());
    expectSameMotion(skeleton, skeleton.jointCount() - 1, chain);
  }
}

TEST(DhFromSkeleton, RandomChainsOfTurningSlidingAndFixedJoints) {
  std::mt19937_64 random(8);
  for (int trial = 0; trial < 200; ++trial) {
    const DhTable table = randomTable(random, DhConvention::Modified);
    if (table.variableCount() == 0) continue;
    const Skeleton skeleton = toSkeleton(table);
    expectSameMotion(skeleton, skeleton.jointCount() - 1, dhFromSkeleton(skeleton));
  }
}

TEST(DhFromSkeleton, RobotsOfUrdfFiles) {
  const std::string folder = testing::dataFolder() + "/robots/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no trial data at " << folder;
  struct Case {
    const char *file, *end;
    int rows;
  };
  for (const Case& c :
       {Case{"ur5/urdf/ur5_robot.urdf", "wrist_3_joint", 6},
        Case{"kuka_iiwa/model.urdf", "lbr_iiwa_joint_7", 7}, Case{"panda/urdf/panda.urdf", "panda_joint7", 7},
        Case{"panda/urdf/panda.urdf", "panda_finger_joint1", 8}}) {
    SCOPED_TRACE(c.file);
    const Skeleton skeleton = readUrdf(folder + c.file).skeleton;
    const int end = skeleton.jointIndex(c.end);
    const DhChain chain = dhFromSkeleton(skeleton, end);
    EXPECT_EQ(chain.table.variableCount(), c.rows);
    expectSameMotion(skeleton, end, chain);
  }
}

TEST(DhFromSkeleton, SaysWhatIsNoChain) {
  const auto complaint = [](const Skeleton& skeleton) -> std::string {
    try {
      dhFromSkeleton(skeleton);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "no complaint";
  };
  using ::testing::HasSubstr;
  const Joint root{.name = "root"}, turning{.name = "a", .parent = 0, .axes = {AxisDof{}}},
      beside{.name = "b", .parent = 0, .axes = {AxisDof{}}}, ball{.name = "c", .parent = 0, .ball = true};
  EXPECT_THAT(complaint(Skeleton({root})), HasSubstr("needs a joint that moves"));
  EXPECT_THAT(complaint(Skeleton({root, turning, beside})), HasSubstr("joint 'a' is not on the way to 'b'"));
  EXPECT_THAT(complaint(Skeleton({root, ball})), HasSubstr("joint 'c' has 3"));
  Joint tilted{.name = "d", .parent = 1, .axes = {AxisDof{}}};
  tilted.parentFromZero.translation().x() = 1.0;
  tilted.parentFromZero.linear() = expRotation(Vector3d(0, 3e-9, 0)).toRotationMatrix();
  EXPECT_THAT(complaint(Skeleton({root, turning, tilted})),
              ::testing::AnyOf(HasSubstr("nearly parallel"), HasSubstr("no complaint")));
}

TEST(DhText, ReadsBackWhatItWrites) {
  for (const Robot& robot : robots()) {
    DhTable table = robot.table();
    table.base.translation() = Vector3d(0.1, 0.2, 0.3);
    const DhTable again = parseDhTable(formatDhTable(table), "robot.dh");
    EXPECT_EQ(formatDhTable(table), formatDhTable(again));
    EXPECT_LE(
        (dhFrames(table, *table.rest).back().matrix() - dhFrames(again, *again.rest).back().matrix()).norm(),
        1e-15);
  }
}

TEST(DhText, UnderstandsDegreesAndMultiplesOfPi) {
  const DhTable table = parseDhTable(
      "# a comment\ndh standard\nname arm\nangles degrees\nbase 0 0 1\n"
      "revolute 0.5 90 0 -pi/2 -45 45  # elbow\nprismatic 0 3pi/4 0.1 30 0 0.2\nfixed 0 0 0.1 0\ntool 0 0 "
      "0.1\nrest 10 0.15\n",
      "arm.dh");
  ASSERT_EQ(table.rows.size(), 3u);
  EXPECT_DOUBLE_EQ(table.rows[0].alpha, M_PI / 2);
  EXPECT_DOUBLE_EQ(table.rows[0].phi, -M_PI / 2);
  EXPECT_DOUBLE_EQ(table.rows[0].upper, M_PI / 4);
  EXPECT_DOUBLE_EQ(table.rows[1].alpha, 3 * M_PI / 4);
  EXPECT_DOUBLE_EQ(table.rows[1].upper, 0.2);  // metres are not degrees
  EXPECT_DOUBLE_EQ((*table.rest)[0], M_PI / 18);
  EXPECT_DOUBLE_EQ((*table.rest)[1], 0.15);
  EXPECT_DOUBLE_EQ(table.base.translation().z(), 1.0);
}

TEST(DhText, BadInputIsRefusedWithItsLine) {
  const std::string head = "dh modified\n";
  testing::expectRefused(
      {
          {"empty", "", 0, "'dh modified' or 'dh standard' as the first line"},
          {"only comments", "# nothing\n\n", 0, "as the first line, found no such line"},
          {"row before the convention", "revolute 0 0 0 0\n", 1,
           "'dh modified' or 'dh standard' first, found 'revolute'"},
          {"unknown convention", "dh craig\n", 1, "found 'dh craig'"},
          {"convention in other case", "dh Modified\n", 1, "found 'dh Modified'"},
          {"no convention", "dh\n", 1, "found 'dh'"},
          {"two conventions", head + "dh standard\n", 2, "one line 'dh' only, found a second one"},
          {"no row", head + "tool 0 0 1\n", 0, "at least one row"},
          {"three parameters", head + "revolute 0 0 0\n", 2,
           "the four parameters a alpha d phi, and both limits or none, found 3 values"},
          {"no parameter", head + "prismatic\n", 2, "found 0 values"},
          {"one limit", head + "revolute 0 0 0 0 1\n", 2, "both limits or none, found 5 values"},
          {"limits of a fixed row", head + "fixed 0 0 0 0 1 2\n", 2, "found 6 values"},
          {"reversed limits", head + "revolute 0 0 0 0 2 1\n", 2,
           "a lower limit not above the upper one, found '2' above '1'"},
          {"infinite limits", head + "revolute 0 0 0 0 -inf inf\n", 2, "for lower limit, found '-inf'"},
          {"a word", head + "revolute 0 x 0 0\n", 2, "a number (or a multiple of pi) for alpha, found 'x'"},
          {"NaN", head + "revolute 0 nan 0 0\n", 2, "'nan'"},
          {"overflow", head + "revolute 1e999 0 0 0\n", 2, "a number for a, found '1e999'"},
          {"decimal comma", head + "revolute 0 0 0,1 0\n", 2, "for d, found '0,1'"},
          {"pi over zero", head + "revolute 0 pi/0 0 0\n", 2, "'pi/0'"},
          {"pi over a word", head + "revolute 0 pi/two 0 0\n", 2, "'pi/two'"},
          {"pi as a length", head + "revolute pi 0 0 0\n", 2, "a number for a, found 'pi'"},
          {"unknown row", head + "\nscrew 0 0 0 0\n", 3,
           "'revolute', 'prismatic', 'fixed', 'name', 'angles', 'base', 'tool' or 'rest', found 'screw'"},
          {"row in other case", head + "Revolute 0 0 0 0\n", 2, "found 'Revolute'"},
          {"unit of angles", head + "angles grad\n", 2,
           "'angles radians' or 'angles degrees', found 'angles grad'"},
          {"unit after a row", head + "revolute 0 0 0 0\nangles degrees\n", 3, "before the first row"},
          {"name of two words", head + "name my arm\n", 2, "'name' and one word, found 'name my arm'"},
          {"base of two numbers", head + "base 0 0\n", 2, "'base x y z' (metres), or with a quaternion"},
          {"base with NaN", head + "base 0 nan 0\n", 2, "a number for y, found 'nan'"},
          {"quaternion of length 2", head + "tool 0 0 0 2 0 0 0\n", 2, "length 1, found length 2"},
          {"rest of another length", head + "revolute 0 0 0 0\nrest 1 2\n", 3,
           "1 values of the rest pose, one a moving row, found 2"},
          {"rest a word", head + "rest up\n", 2, "value 1 of the rest pose, found 'up'"},
          {"rest twice", head + "rest 0\nrest 0\n", 3, "one line 'rest' only"},
          {"cut in a row", head + "revolute 0 0 0 0\nprismatic 0 0", 3, "found 2 values"},
          {"CRLF keeps line numbers", "dh standard\r\n\r\nrevolute 0 0 y 0\r\n", 3, "'y'"},
          {"binary",
           std::string("\x7f"
                       "ELF\0\1",
                       6),
           1, "'dh modified' or 'dh standard' first"},
      },
      [](const std::string& text, const std::string& file) { parseDhTable(text, file); });
}

}  // namespace
}  // namespace gelenk
