#include "solvers/evaluator.h"

#include <gtest/gtest.h>

#include "solvers/ik_solver.h"
#include "solvers/judge.h"
#include "tests/kinematics/random_skeleton.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

TEST(Evaluator, JacobianMatchesCentralDifferencesForEveryGoalKind) {
  std::mt19937_64 random(1);
  constexpr double h = 1e-6;
  for (int i = 0; i < 60; ++i) {
    const Skeleton skeleton = testing::randomSkeleton(random, 10);
    const VectorXd q = randomWithinLimits(skeleton, random);
    int elbow = -1;
    for (int k = 1; k < skeleton.jointCount(); ++k)
      if (!skeleton.children(k).empty()) elbow = k;
    const int tip = skeleton.jointCount() - 1;
    const Frames frames = forwardKinematics(skeleton, q);
    IkProblem problem{.skeleton = &skeleton, .start = q};
    const Vector3d somewhere = 3.0 * testing::randomUnit(random);
    problem.goals.push_back({.kind = GoalKind::Position, .joint = tip, .pointInJoint = {0.1, 0, 0.2}, .target = somewhere});
    // The geometric Jacobian is exact where the orientation error vanishes.
    problem.goals.push_back({.kind = GoalKind::Pose, .joint = tip, .target = somewhere,
                             .orientation = Eigen::Quaterniond(frames[tip].linear()), .weight = 0.3});
    // Likewise the aim: choose the axis that already points at the target.
    const Vector3d direction = (somewhere - frames[tip].translation()).normalized();
    problem.goals.push_back({.kind = GoalKind::Aim, .joint = tip, .target = somewhere,
                             .axisInJoint = frames[tip].linear().transpose() * direction});
    if (elbow >= 0) problem.goals.push_back({.kind = GoalKind::Pole, .joint = elbow, .target = somewhere, .weight = 2.0});
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

TEST(SolverContract, ErrorReportedEqualsErrorRecomputedByForwardKinematics) {
  std::mt19937_64 random(2);
  for (const SolverEntry& entry : solverCatalogue()) {
    const auto solver = entry.make();
    for (int i = 0; i < 20; ++i) {
      const Skeleton skeleton = testing::randomSkeleton(random, 8);
      const int tip = skeleton.jointCount() - 1;
      const Vector3d target = forwardKinematics(skeleton, randomWithinLimits(skeleton, random))[tip].translation();
      IkProblem problem{.skeleton = &skeleton, .start = randomWithinLimits(skeleton, random),
                        .goals = {{.joint = tip, .target = target}}};
      if (!solver->whyUnsupported(problem).empty()) continue;
      const IkReport report = solver->solve(problem, {}, TraceLevel::Off);
      const Judgement verdict = judge(problem, report.q);
      ASSERT_TRUE(verdict.finite) << entry.name;
      EXPECT_NEAR(verdict.goals[0].position, report.residual, 1e-12) << entry.name;
      EXPECT_LE(verdict.limitViolation, 1e-12) << entry.name;
      EXPECT_EQ(report.why == Stop::Converged, verdict.solved) << entry.name;
    }
  }
}

}  // namespace
}  // namespace gelenk
