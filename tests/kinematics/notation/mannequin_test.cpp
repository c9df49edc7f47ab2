#include "kinematics/notation/mannequin.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/rotation.h"
#include "kinematics/symmetry.h"
#include "tests/places.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double degree = M_PI / 180.0;

Vector3d reflected(const Vector3d& p) { return {-p.x(), p.y(), p.z()}; }

double largestDistance(const Skeleton& skeleton, const VectorXd& q, const VectorXd& mirroredQ) {
  const Frames frames = forwardKinematics(skeleton, q), mirrored = forwardKinematics(skeleton, mirroredQ);
  const std::vector<int> partners = mirrorPartners(skeleton);
  double worst = 0.0;
  for (int i = 0; i < skeleton.jointCount(); ++i)
    worst =
        std::max(worst, (reflected(frames[i].translation()) - mirrored[partners[i]].translation()).norm());
  return worst;
}

TEST(Mannequin, HasSixtySixJointsWithLimitsOnAllButTheRoot) {
  const Skeleton figure = mannequin();
  EXPECT_EQ(figure.jointCount(), 66);
  int fixed = 0;
  for (int i = 0; i < figure.jointCount(); ++i) {
    const Joint& joint = figure.joint(i);
    fixed += figure.vCount(i) == 0;
    if (i == 0) continue;
    EXPECT_EQ(joint.ball, joint.ballLimit.has_value()) << joint.name;
    for (const AxisDof& dof : joint.axes) {
      EXPECT_GE(dof.upper - dof.lower, 40 * degree) << joint.name;
      EXPECT_LE(dof.upper - dof.lower, 170 * degree) << joint.name;
    }
  }
  EXPECT_EQ(fixed, 13);
  for (const std::string& name : mannequinHandles()) EXPECT_TRUE(figure.findJoint(name)) << name;
}

TEST(Mannequin, EveryBoneRunsAlongZAtRest) {
  const Skeleton figure = mannequin();
  const Frames rest = restFrames(figure);
  for (int i = 1; i < figure.jointCount(); ++i) {
    if (figure.children(i).size() != 1) continue;
    const Vector3d childInJoint = rest[i].inverse() * rest[figure.children(i)[0]].translation();
    EXPECT_NEAR(childInJoint.normalized().z(), 1.0, 1e-12) << figure.joint(i).name;
  }
}

TEST(Mannequin, RestLiesWithinEveryLimitWithThreeDegreesToSpare) {
  const Skeleton figure = mannequin();
  const VectorXd& q = figure.rest();
  EXPECT_LE(limitViolation(figure, q), 0.0);
  for (int i = 1; i < figure.jointCount(); ++i) {
    const Joint& joint = figure.joint(i);
    for (std::size_t k = 0; k < joint.axes.size(); ++k) {
      EXPECT_GE(q[figure.qIndex(i) + k], joint.axes[k].lower + 3 * degree) << joint.name;
      EXPECT_LE(q[figure.qIndex(i) + k], joint.axes[k].upper - 3 * degree) << joint.name;
    }
    if (!joint.ball) continue;
    const Vector3d c = swingTwistCoordinates(ballRotation(figure, q, i));
    EXPECT_LE((c.head<2>() - joint.ballLimit->swingCentre).cwiseQuotient(joint.ballLimit->swingRadii).norm(),
              0.9)
        << joint.name;
    EXPECT_GE(c.z(), joint.ballLimit->twistLower + 3 * degree) << joint.name;
    EXPECT_LE(c.z(), joint.ballLimit->twistUpper - 3 * degree) << joint.name;
  }
}

TEST(Mannequin, NoSwingWithinLimitsReaches150Degrees) {
  const Skeleton figure = mannequin();
  for (const Joint& joint : figure.joints()) {
    if (!joint.ballLimit) continue;
    const BallLimit& limit = *joint.ballLimit;
    double farthest = 0.0;
    for (int k = 0; k < 720; ++k) {
      const double angle = k * 0.5 * degree;
      farthest = std::max(farthest, (limit.swingCentre + limit.swingRadii.cwiseProduct(Eigen::Vector2d(
                                                             std::cos(angle), std::sin(angle))))
                                        .norm());
    }
    EXPECT_LE(farthest, 2.0 * std::sin(75 * degree)) << joint.name;
  }
}

/// How far outside its limits a ball is after its rest orientation in the world is turned by `turn`.
double violationOfTurn(const std::string& name, const Eigen::Quaterniond& turn) {
  const Skeleton figure = mannequin();
  const int i = figure.jointIndex(name);
  const Eigen::Quaterniond worldFromJoint(restFrames(figure)[i].linear());
  VectorXd q = figure.rest();
  const Eigen::Quaterniond local = worldFromJoint.conjugate() * turn * worldFromJoint;
  setBallRotation(figure, q, i, (ballRotation(figure, q, i) * local).normalized());
  return limitViolation(figure, q, i);
}

Eigen::Quaterniond about(const Vector3d& axis, double degrees) {
  return expRotation(degrees * degree * axis);
}

TEST(Mannequin, HipsAndSpineBendTheWayABodyDoes) {
  const Vector3d left = Vector3d::UnitX(), forward = Vector3d::UnitZ();
  EXPECT_LE(violationOfTurn("thigh_l", about(left, -90)), 0.0);  // sitting
  EXPECT_LE(violationOfTurn("thigh_r", about(left, -90)), 0.0);
  EXPECT_GT(violationOfTurn("thigh_l", about(left, 50)), 0.1);  // kicking backwards
  EXPECT_LE(violationOfTurn("thigh_l", about(forward, 30)), 0.0);
  EXPECT_GT(violationOfTurn("thigh_l", about(forward, -60)), 0.1);
  EXPECT_LE(violationOfTurn("thigh_r", about(forward, -30)), 0.0);
  EXPECT_LE(violationOfTurn("spine_01", about(left, 20)), 0.0);
  EXPECT_GT(violationOfTurn("spine_01", about(left, -20)), 0.05);  // it bends back by 10 degrees only
}

/// Violation where the bone of a ball points along the direction, without twist.
double violationOfDirection(const std::string& name, const Vector3d& direction) {
  const Skeleton figure = mannequin();
  const int i = figure.jointIndex(name);
  VectorXd q = figure.rest();
  const Frames rest = restFrames(figure);
  const Eigen::Quaterniond worldFromZero(
      Eigen::Matrix3d(rest[i].linear() * ballRotation(figure, q, i).conjugate().toRotationMatrix()));
  setBallRotation(figure, q, i, rotationBetween(Vector3d::UnitZ(), worldFromZero.conjugate() * direction));
  return limitViolation(figure, q, i);
}

TEST(Mannequin, TheArmReachesUpForwardSidewaysAndAcrossButNotBehind) {
  for (const Vector3d& d : {Vector3d(0.1, 1, 0.1), Vector3d(0, 0, 1), Vector3d(1, 0, 0), Vector3d(0, -1, 0),
                            Vector3d(-0.5, 0, 0.87)})
    EXPECT_LE(violationOfDirection("upperarm_l", d), 0.0) << d.transpose();
  EXPECT_GT(violationOfDirection("upperarm_l", {0, 0, -1}), 0.1);
  EXPECT_GT(violationOfDirection("upperarm_l", {-1, 0, -0.3}), 0.1);
  for (const Vector3d& d : {Vector3d(-0.1, 1, 0.1), Vector3d(-1, 0, 0)})
    EXPECT_LE(violationOfDirection("upperarm_r", d), 0.0);
}

/// Where a joint goes when one angle grows by 20 degrees.
Vector3d moved(const std::string& turned, int axis, const std::string& seen) {
  const Skeleton figure = mannequin();
  VectorXd q = figure.rest();
  q[figure.qIndex(figure.jointIndex(turned)) + axis] += 20 * degree;
  const int i = figure.jointIndex(seen);
  return forwardKinematics(figure, q)[i].translation() - restFrames(figure)[i].translation();
}

TEST(Mannequin, PositiveAnglesFlex) {
  for (const std::string side : {"_l", "_r"}) {
    EXPECT_LT(moved("calf" + side, 0, "foot" + side).z(), -0.1);      // the heel goes back
    EXPECT_GT(moved("lowerarm" + side, 0, "hand" + side).y(), 0.03);  // the hand rises
    EXPECT_LT(moved("foot" + side, 0, "toe_end" + side).y(), -0.03);  // the toes point down
    const Skeleton figure = mannequin();
    const Frames rest = restFrames(figure);
    const Vector3d dorsal = rest[figure.jointIndex("hand" + side)].linear().col(1);
    EXPECT_GT(dorsal.y(), 0.3);  // the back of the hand looks up and out
    EXPECT_GT(dorsal.x() * (side == "_l" ? 1 : -1), 0.3);
    for (const std::string finger : {"index", "middle", "ring", "pinky"})
      EXPECT_LT(moved(finger + "_01" + side, 0, finger + "_end" + side).dot(dorsal), -0.01) << finger;
    EXPECT_LT(moved("hand" + side, 0, "middle_end" + side).dot(dorsal), -0.03);
  }
}

TEST(Mannequin, MirroringTwiceGivesThePoseBackExactly) {
  const Skeleton figure = mannequin();
  std::mt19937_64 random(7);
  for (int run = 0; run < 50; ++run) {
    const VectorXd q = randomWithinLimits(figure, random);
    const VectorXd mirrored = mirrorPose(figure, q);
    EXPECT_EQ(mirrorPose(figure, mirrored), q);
    EXPECT_LE(largestDistance(figure, q, mirrored), 1e-13);  // three roundings a joint, 1 m
    EXPECT_LE(limitViolation(figure, mirrored), 1e-13);
    EXPECT_GT(largestDistance(figure, q, q), 1e-2);  // a random pose is not symmetric
  }
  EXPECT_EQ(mirrorPose(figure, figure.rest()), figure.rest());
}

TEST(Mirror, AsymmetricSkeletonsAreRefusedByName) {
  const Eigen::Isometry3d off(Eigen::Translation3d(0.1, 0.0, 0.0));
  const Skeleton lopsided({{.name = "root", .axes = {{AxisDof::Kind::Rotation, Vector3d::UnitZ()}}},
                           {.name = "arm", .parent = 0, .parentFromZero = off}});
  try {
    mirrorPose(lopsided, neutral(lopsided));
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("'arm'"), std::string::npos);
  }
  const Skeleton oneArmed({{.name = "root"}, {.name = "LeftArm", .parent = 0}});
  EXPECT_THROW(mirrorPartners(oneArmed), std::invalid_argument);
}

TEST(Mirror, WhetherAModelCanBeMirroredIsKnownBeforehand) {
  EXPECT_EQ(whyNotMirrored(mannequin()), "");
  EXPECT_NE(whyNotMirrored(Skeleton({{.name = "root"}, {.name = "hand_l", .parent = 0}})).find("hand_r"),
            std::string::npos);
}

TEST(Mirror, SidesAreFoundInTheUsualSpellings) {
  std::vector<Joint> joints{{.name = "hips"}};
  for (const std::string name : {"LeftArm", "RightArm", "leg.L", "leg.R", "hand_l", "hand_r"})
    joints.push_back({.name = name, .parent = 0});
  EXPECT_EQ(mirrorPartners(Skeleton(joints)), (std::vector<int>{0, 2, 1, 4, 3, 6, 5}));
}

TEST(Mannequin, RestPositionsAreThoseOfTheMeasuredTable) {
  std::ifstream table(testing::dataFolder() + "/mannequin/mannequin_joints.txt");
  if (!table) GTEST_SKIP() << "the table of measurements is not here";
  const Skeleton figure = mannequin();
  const Frames rest = restFrames(figure);
  int rows = 0;
  for (std::string line; std::getline(table, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::string name, parent;
    Vector3d p;
    words >> name >> parent >> p.x() >> p.y() >> p.z();
    const int i = figure.jointIndex(name);
    EXPECT_LE((rest[i].translation() - p).norm(), 1e-9) << name;
    EXPECT_EQ(i == 0 ? "-" : figure.joint(figure.parent(i)).name, parent);
    ++rows;
  }
  EXPECT_EQ(rows, 66);
}

}  // namespace
}  // namespace gelenk
