#include "kinematics/masses.h"

#include <gtest/gtest.h>

#include "kinematics/notation/mannequin.h"
#include "kinematics/notation/mannequin_masses.h"
#include "tests/kinematics/random_skeleton.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

TEST(Masses, CentreOfTwoBallsIsWhereTheirLeverBalances) {
  std::vector<Joint> joints{{.name = "a"}, {.name = "b", .parent = 0}};
  joints[1].parentFromZero.translation() = Vector3d(3, 0, 0);
  const Skeleton skeleton(joints);
  const Masses masses{{1.0, 2.0}, {Vector3d(0, 0, 0), Vector3d(0, 0, 0)}};
  EXPECT_EQ(centreOfMass(masses, restFrames(skeleton)), Vector3d(2, 0, 0));  // 1 kg at 0, 2 kg at 3 m
}

TEST(Masses, JacobianIsTheWeightedSumOfPointJacobians) {
  std::mt19937_64 random(51);
  for (int i = 0; i < 30; ++i) {
    const Skeleton skeleton = testing::randomSkeleton(random, 9);
    Masses masses;
    for (int k = 0; k < 9; ++k) {
      masses.mass.push_back(k == 4 ? 0.0 : uniform01(random));
      masses.centre.push_back(testing::randomUnit(random));
    }
    const VectorXd q = randomWithinLimits(skeleton, random);
    const Frames frames = forwardKinematics(skeleton, q);
    Eigen::Matrix3Xd expected = Eigen::Matrix3Xd::Zero(3, skeleton.nv()), J(3, skeleton.nv());
    for (int k = 0; k < 9; ++k)
      expected += masses.mass[k] / masses.total() * pointJacobian(skeleton, q, frames, k, masses.centre[k]);
    centreOfMassJacobian(skeleton, masses, frames, dofTwists(skeleton, q, frames), J);
    EXPECT_LE((J - expected).norm(), 1e-13 * std::max(1.0, expected.norm()));
  }
}

TEST(Masses, TheFigureWeighs73KilogramsAndItsCentreLiesWhereAMansDoes) {
  const Skeleton figure = mannequin();
  const Masses masses = mannequinMasses(figure);
  masses.check(figure);
  EXPECT_NEAR(masses.total(), 73.0, 1e-9);  // the table's shares sum to 1
  VectorXd upright = figure.rest();
  const Vector3d centre = centreOfMass(masses, forwardKinematics(figure, upright));
  EXPECT_NEAR(centre.x(), 0.0, 1e-12);  // the figure is symmetric
  // 55 to 57 % of the stature is the textbook's height of a standing man's centre; arms held up raise it
  EXPECT_GT(centre.y() / 1.73, 0.54);
  EXPECT_LT(centre.y() / 1.73, 0.60);
  double front = -1.0, back = 1.0;
  for (const FootPoint& point : mannequinSoles(figure)) {
    const Vector3d p = restFrames(figure)[point.joint] * point.inJoint;
    EXPECT_NEAR(p.y(), 0.0, 1e-12);
    front = std::max(front, p.z());
    back = std::min(back, p.z());
  }
  EXPECT_GT(centre.z(), back + 0.03);  // it stands
  EXPECT_LT(centre.z(), front - 0.03);
  // Left and right alike.
  for (const char* name : {"thigh", "calf", "foot", "upperarm", "lowerarm", "hand"})
    EXPECT_EQ(masses.mass[figure.jointIndex(std::string(name) + "_l")],
              masses.mass[figure.jointIndex(std::string(name) + "_r")]);
}

TEST(Masses, RodsHaveTheirCentresHalfWay) {
  std::vector<Joint> joints{{.name = "a"}, {.name = "b", .parent = 0}, {.name = "c", .parent = 1}};
  joints[1].parentFromZero.translation() = Vector3d(2, 0, 0);
  joints[2].parentFromZero.translation() = Vector3d(0, 1, 0);
  const Skeleton skeleton(joints);
  const Masses masses = rodMasses(skeleton, 3.0);
  EXPECT_EQ(masses.mass, (std::vector<double>{6.0, 3.0, 0.0}));
  EXPECT_EQ(masses.centre[0], Vector3d(1, 0, 0));
  EXPECT_EQ(masses.centre[1], Vector3d(0, 0.5, 0));
  EXPECT_THROW(rodMasses(skeleton, 0.0), std::invalid_argument);
  EXPECT_THROW(rodMasses(Skeleton({{.name = "a"}})), std::invalid_argument);
}

TEST(Masses, BadOnesAreRefused) {
  const Skeleton skeleton({{.name = "a"}});
  EXPECT_THROW((Masses{{}, {}}.check(skeleton)), std::invalid_argument);
  EXPECT_THROW((Masses{{-1.0}, {Vector3d::Zero()}}.check(skeleton)), std::invalid_argument);
  EXPECT_THROW((Masses{{0.0}, {Vector3d::Zero()}}.check(skeleton)), std::invalid_argument);
  EXPECT_THROW((Masses{{1.0}, {Vector3d(0, std::nan(""), 0)}}.check(skeleton)), std::invalid_argument);
}

}  // namespace
}  // namespace gelenk
