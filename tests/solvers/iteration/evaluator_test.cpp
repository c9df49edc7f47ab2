#include "solvers/iteration/evaluator.h"

#include <gtest/gtest.h>

#include "kinematics/rotation.h"
#include "tests/kinematics/random_skeleton.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

TEST(Evaluator, JacobianMatchesCentralDifferencesForEveryGoalKind) {
  std::mt19937_64 random(1);
  constexpr double h = 1e-6;
  for (int i = 0; i < 60; ++i) {
    const Skeleton skeleton = testing::randomTree(random, 10, i);
    const VectorXd q = randomWithinLimits(skeleton, random);
    int elbow = -1;
    for (int k = 1; k < skeleton.jointCount(); ++k)
      if (!skeleton.children(k).empty()) elbow = k;
    const int tip = skeleton.jointCount() - 1;
    const Frames frames = forwardKinematics(skeleton, q);
    IkProblem problem{.skeleton = &skeleton, .start = q};
    const Vector3d somewhere = 3.0 * testing::randomUnit(random);
    problem.goals.push_back(
        {.kind = GoalKind::Position, .joint = tip, .pointInJoint = {0.1, 0, 0.2}, .target = somewhere});
    // The geometric Jacobian is exact where the orientation error vanishes.
    problem.goals.push_back({.kind = GoalKind::Pose,
                             .joint = tip,
                             .target = somewhere,
                             .orientation = Eigen::Quaterniond(frames[tip].linear()),
                             .weight = 0.3});
    // Likewise the aim: choose the axis that already points at the target.
    const Vector3d direction = (somewhere - frames[tip].translation()).normalized();
    problem.goals.push_back({.kind = GoalKind::Aim,
                             .joint = tip,
                             .target = somewhere,
                             .axisInJoint = frames[tip].linear().transpose() * direction});
    if (elbow >= 0)
      problem.goals.push_back({.kind = GoalKind::Pole, .joint = elbow, .target = somewhere, .weight = 2.0});
    CountedEvaluator at(problem);
    at.moveTo(q);
    const Eigen::MatrixXd J = at.jacobian();
    for (int k = 0; k < skeleton.nv(); ++k) {
      const VectorXd dq = h * VectorXd::Unit(skeleton.nv(), k);
      at.moveTo(integrate(skeleton, q, dq));
      const VectorXd plus = at.residual();
      at.moveTo(integrate(skeleton, q, -dq));
      const VectorXd slope = (plus - at.residual()) / (2 * h);
      EXPECT_LE((slope + J.col(k)).norm(), 1e-7 * std::max(1.0, J.norm())) << "column " << k;
    }
  }
}

TEST(Evaluator, HessianMatchesSecondDifferencesOfTheCostForEveryJointKind) {
  std::mt19937_64 random(21);
  constexpr double h = 1e-4;
  for (int i = 0; i < 30; ++i) {
    const Skeleton skeleton = testing::randomTree(random, 6, i);
    const VectorXd q = randomWithinLimits(skeleton, random);
    const int tip = skeleton.jointCount() - 1;
    IkProblem problem{.skeleton = &skeleton, .start = q};
    problem.goals = {
        {.kind = GoalKind::Pose,
         .joint = tip,
         .pointInJoint = {0.1, 0, 0.2},
         .target = testing::randomUnit(random),
         .orientation = expRotation(2.0 * testing::randomUnit(random)),
         .weight = 0.7},
        {.joint = tip / 2, .pointInJoint = {0.3, 0.1, 0}, .target = 2.0 * testing::randomUnit(random)},
        {.kind = GoalKind::Posture, .posture = randomWithinLimits(skeleton, random), .weight = 0.1}};
    CountedEvaluator at(problem);
    at.moveTo(q);
    const Eigen::MatrixXd H = at.hessian();
    const auto cost = [&](int a, double x, int b, double y) {
      VectorXd dq = VectorXd::Zero(skeleton.nv());
      dq[a] += x;
      dq[b] += y;
      at.moveTo(integrate(skeleton, q, dq));
      return at.cost();
    };
    for (int a = 0; a < skeleton.nv(); ++a)
      for (int b = 0; b <= a; ++b) {
        const double differences =
            (cost(a, h, b, h) - cost(a, h, b, -h) - cost(a, -h, b, h) + cost(a, -h, b, -h)) / (4.0 * h * h);
        EXPECT_NEAR(H(a, b), differences, 3e-6 * std::max(1.0, H.norm()))
            << a << ", " << b;  // h^2 and rounding / h^2
        EXPECT_NEAR(H(a, b), H(b, a), 1e-14 * H.norm());
      }
  }
}

TEST(Evaluator, JacobianDerivativeGivesTheGoalsMotionToSecondOrder) {
  std::mt19937_64 random(22);
  for (int i = 0; i < 30; ++i) {
    const Skeleton skeleton = testing::randomTree(random, 7, i);
    const VectorXd q = randomWithinLimits(skeleton, random);
    const int tip = skeleton.jointCount() - 1;
    const Frames before = forwardKinematics(skeleton, q);
    IkProblem problem{.skeleton = &skeleton, .start = q, .goals = {{.kind = GoalKind::Pose, .joint = tip}}};
    CountedEvaluator at(problem);
    VectorXd d(skeleton.nv());
    for (double& x : d) x = uniform01(random) - 0.5;
    double errors[2];
    for (int k = 0; k < 2; ++k) {
      const VectorXd step = (k == 0 ? 0.02 : 0.01) * d;
      at.moveTo(q);
      Eigen::MatrixXd dJ;
      at.jacobianDerivative(step, dJ);
      const VectorXd predicted = (at.jacobian() + 0.5 * dJ) * step;
      const Eigen::Isometry3d after = forwardKinematics(skeleton, integrate(skeleton, q, step))[tip];
      VectorXd actual(6);
      actual.head<3>() = after.translation() - before[tip].translation();
      actual.tail<3>() = logRotation(Eigen::Quaterniond(after.linear() * before[tip].linear().transpose()));
      errors[k] = (predicted - actual).norm();
    }
    // third order: half the step, an eighth of the error
    EXPECT_LE(errors[1], std::max(errors[0] / 6.0, 2e-11));
  }
}

}  // namespace
}  // namespace gelenk
