#include "solvers/iteration/limit_set.h"

#include <gtest/gtest.h>

#include "kinematics/rotation.h"
#include "solvers/methods/qp.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/problem/judge.h"
#include "tests/kinematics/random_skeleton.h"
#include "tests/solvers/random_problem.h"

namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

TEST(LimitSet, RowsAreTheDerivativesOfTheLimitsOfABall) {
  std::mt19937_64 random(3);
  std::vector<Joint> joints(1);
  joints[0].name = "ball";
  joints[0].ball = true;
  joints[0].ballLimit = BallLimit{{0.1, -0.2}, {0.9, 0.5}, -0.7, 1.1};
  const Skeleton skeleton(joints);
  LimitSet limits(skeleton);
  constexpr double h = 1e-6;
  for (int i = 0; i < 200; ++i) {
    const VectorXd q = randomWithinLimits(skeleton, random);
    limits.moveTo(q);
    for (const LimitSet::Row& row : limits.rows()) {
      const VectorXd along = h * row.normal;
      LimitSet moved(skeleton);
      moved.moveTo(integrate(skeleton, q, along));
      if (moved.rows().size() != limits.rows().size()) continue;
      const double after = moved.rows()[&row - limits.rows().data()].slack;
      if (row.slack < 1e-3 || row.slack > 0.3) continue;
      // slack / |gradient| falls by h up to the change of |gradient|, which is of the size of the slack
      EXPECT_NEAR((row.slack - after) / h, 1.0, 8.0 * row.slack);
    }
  }
}

TEST(LimitSet, LockedLimitsAreLeftAlone) {
  const Skeleton arm = testing::straightChain(3, 0.5);
  LimitSet limits(arm);
  limits.moveTo(Vector3d(0.5, 0.0, -0.5));
  limits.lockBlocked(Vector3d(1.0, 1.0, 1.0));
  VectorXd x = Vector3d(1.0, 2.0, 3.0);
  limits.project(x);
  EXPECT_EQ(x, VectorXd(Vector3d(0.0, 2.0, 3.0)));  // the third leaves its lower bound inwards
  VectorXd fixed = VectorXd::Zero(3);
  EXPECT_TRUE(limits.lockCrossed(Vector3d(0.0, 0.9, 0.2), fixed));
  EXPECT_DOUBLE_EQ(fixed[1], 0.5);
  EXPECT_FALSE(limits.lockCrossed(Vector3d(0.0, 0.0, 0.2), fixed));
}

TEST(LimitSet, FullTurnsWrapAndLegalAnglesPastPiStay) {
  const Skeleton arm = testing::straightChain(1, 2.0 * M_PI);
  LimitSet limits(arm);
  VectorXd out;
  limits.retract(VectorXd::Constant(1, 5.0), VectorXd::Constant(1, 1.0), out);
  EXPECT_DOUBLE_EQ(out[0], 6.0);
  limits.retract(VectorXd::Constant(1, 6.0), VectorXd::Constant(1, 1.0), out);
  EXPECT_DOUBLE_EQ(out[0], 7.0 - 2.0 * M_PI);
}

TEST(Qp, SolutionsSatisfyTheKarushKuhnTuckerConditions) {
  std::mt19937_64 random(4);
  ConvexQp qp;
  for (int i = 0; i < 500; ++i) {
    const int n = 1 + static_cast<int>(random() % 8), k = static_cast<int>(random() % 20);
    const auto number = [&] { return 2.0 * uniform01(random) - 1.0; };
    const MatrixXd A = MatrixXd::NullaryExpr(n, n, number), C = MatrixXd::NullaryExpr(k, n, number);
    const MatrixXd H = A.transpose() * A + 1e-3 * MatrixXd::Identity(n, n);
    const VectorXd g = VectorXd::NullaryExpr(n, number);
    const VectorXd b =
        VectorXd::NullaryExpr(k, [&] { return uniform01(random) < 0.3 ? 0.0 : uniform01(random); });
    VectorXd x;
    ASSERT_TRUE(qp.solve(H, g, C, b, x));
    EXPECT_TRUE(qp.optimal());
    EXPECT_TRUE(((C * x - b).array() <= 1e-10).all());
    EXPECT_TRUE((qp.multipliers().array() >= -1e-10).all());
    EXPECT_LE((H * x - g + C.transpose() * qp.multipliers()).norm(), 1e-8);  // condition 1e3 to 1e4
    for (int row = 0; row < k; ++row)
      EXPECT_LE(std::abs(qp.multipliers()[row] * (C.row(row) * x - b[row])), 1e-9);
  }
}

/// Where a limit blocks the straight way a mere clamp stops short; the active set slides along the limit.
TEST(Limits, AnArmAtItsLimitReachesWithItsOtherJoints) {
  const Skeleton arm = testing::straightChain(3, 1.0);
  const VectorXd there = Vector3d(1.0, 0.4, -0.9);  // the first joint at its bound
  IkProblem problem{.skeleton = &arm, .start = Vector3d(0.9, -0.6, 0.5)};
  problem.goals = {{.joint = 3, .target = forwardKinematics(arm, there)[3].translation()}};
  for (const char* name :
       {"pseudo-inverse", "dls", "lm-gain-ratio", "exact-hessian", "qp", "bfgs", "l-bfgs"}) {
    const IkReport report =
        makeSolver(name)->solve(problem, {.maxIterations = 400, .maxSeconds = 1e9}, TraceLevel::Off);
    EXPECT_TRUE(judge(problem, report.q).solved)
        << name << ": " << toString(report.why) << ", " << report.residual;
  }
}

TEST(TaskPriority, TheSecondGoalNeverSpoilsTheFirst) {
  const Skeleton arm = testing::straightChain(5);
  std::mt19937_64 random(6);
  for (int i = 0; i < 20; ++i) {
    IkProblem problem{.skeleton = &arm, .start = randomWithinLimits(arm, random)};
    const Vector3d target = forwardKinematics(arm, randomWithinLimits(arm, random))[5].translation();
    problem.goals = {{.joint = 5, .target = target + Vector3d(0.5, 0.0, 0.0), .priority = 1},
                     {.joint = 5, .target = target, .priority = 0}};
    const IkReport report = makeSolver("task-priority")
                                ->solve(problem, {.maxIterations = 500, .maxSeconds = 1e9}, TraceLevel::Off);
    const Judgement verdict = judge(problem, report.q);
    EXPECT_LE(verdict.goals[1].position, 1e-5) << toString(report.why);  // the damped pull of the second
    EXPECT_NEAR(verdict.goals[0].position, 0.5, 1e-5);
  }
}

}  // namespace
}  // namespace gelenk
