#include "solvers/methods/newton.h"

#include <gtest/gtest.h>

#include "kinematics/forward_kinematics.h"
#include "kinematics/notation/planar_chain.h"
#include "solvers/problem/judge.h"
#include "tests/kinematics/random_skeleton.h"

namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

TEST(Newton, OneDimensionConvergesQuadraticallyAtASimpleZero) {
  const auto steps = newton1d([](double phi) { return std::sin(phi); }, 0.2, 0.5, 1e-7);
  std::vector<double> errors;
  for (const auto& step : steps) errors.push_back(step.phi - M_PI / 6);
  EXPECT_LE(std::abs(errors.back()), 1e-13);
  EXPECT_NEAR(convergenceOrder(errors, 1e-12), 2.0, 0.2);
}

TEST(Newton, ACoarseDifferenceQuotientConvergesOnlyLinearly) {
  const auto steps = newton1d([](double phi) { return std::sin(phi); }, 0.2, 0.5, 0.1);
  std::vector<double> errors;
  for (const auto& step : steps) errors.push_back(step.phi - M_PI / 6);
  EXPECT_NEAR(convergenceOrder(errors, 1e-13), 1.0, 0.1);
}

TEST(Newton, PseudoInverseGivesTheShortestOfAllSteps) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 200; ++i) {
    const PlanarChain chain{
        .base = {0, 0},
        .lengths = {uniform01(random), uniform01(random), uniform01(random), uniform01(random)}};
    VectorXd phi(4);
    for (double& angle : phi) angle = 6.0 * uniform01(random) - 3.0;
    const MatrixXd D = jacobian(chain, phi), Dplus = pseudoInverse(D);
    if (D.jacobiSvd().singularValues()[1] < 0.05) continue;
    EXPECT_LE((D * Dplus - Eigen::Matrix2d::Identity()).norm(), 1e-11);
    const Vector2d g(uniform01(random), uniform01(random));
    const VectorXd step = -Dplus * g;
    const MatrixXd N = MatrixXd::Identity(4, 4) - Dplus * D;  // all solutions: step + N z
    EXPECT_LE((N * step).norm(), 1e-10);                      // no part of the step lies in the null space
    for (int k = 0; k < 20; ++k) {
      const VectorXd other = step + N * (2.0 * VectorXd::Random(4));
      EXPECT_LE((D * other + g).norm(), 1e-10);
      EXPECT_GE(other.norm(), step.norm() - 1e-12);
    }
  }
}

TEST(Newton, LinearisedStepEndsAtTheTarget) {
  const PlanarChain chain = lecturePlanarChain();
  const VectorXd start = Eigen::Vector3d(0.3, 0.4, 0.5);
  const Vector2d X = endEffector(chain, start) + Vector2d(5, -3);
  const NewtonRun run =
      newton([&](const VectorXd& phi) -> VectorXd { return endEffector(chain, phi); },
             [&](const VectorXd& phi) -> MatrixXd { return jacobian(chain, phi); }, start, X, 1e-10);
  EXPECT_EQ(run.why, NewtonStop::Converged);
  for (std::size_t i = 0; i + 1 < run.steps.size(); ++i)
    EXPECT_LE((run.steps[i].linearised - X).norm(), 1e-9);
}

TEST(Newton, TheStraightArmHasNoInverse) {
  const PlanarChain chain{.base = {0, 0}, .lengths = {1, 1}};
  const NewtonRun run = newton([&](const VectorXd& phi) -> VectorXd { return endEffector(chain, phi); },
                               [&](const VectorXd& phi) -> MatrixXd { return jacobian(chain, phi); },
                               Vector2d(0.5, 0.0), Vector2d(1, 1));
  EXPECT_EQ(run.why, NewtonStop::Singular);
  EXPECT_EQ(run.iterations(), 0);
}

TEST(Newton, DifferenceQuotientsApproachTheJacobian) {
  const PlanarChain chain = lecturePlanarChain();
  const VectorXd phi = Eigen::Vector3d(0.6, 1.0, -0.7);
  const MatrixXd D =
      differenceQuotient([&](const VectorXd& x) -> VectorXd { return endEffector(chain, x); }, phi, 1e-6);
  EXPECT_LE((D - jacobian(chain, phi)).norm(), 1e-3);  // first order: delta l / 2 a column
}

TEST(NewtonSolvers, SolveNearbyTargetsOfTheLecturesChain) {
  const Skeleton skeleton = toSkeleton(lecturePlanarChain());
  std::mt19937_64 random(2);
  for (const char* name : {"newton", "newton-quotient"})
    for (int i = 0; i < 100; ++i) {
      VectorXd there(3);
      there << 6.0 * uniform01(random), 0.4 + uniform01(random), 0.4 + uniform01(random);
      IkProblem problem{.skeleton = &skeleton, .start = there, .goals = {{.joint = 3}}};
      problem.goals[0].target = forwardKinematics(skeleton, there)[3].translation();
      for (double& angle : problem.start) angle += 0.05;
      const auto solver = makeSolver(name);
      ASSERT_EQ(solver->whyUnsupported(problem), "");
      const IkReport report = solver->solve(problem, {}, TraceLevel::Residuals);
      EXPECT_EQ(report.why, Stop::Converged);
      EXPECT_TRUE(judge(problem, report.q).solved);
      EXPECT_LE(report.counters.iterations, 8);
    }
}

TEST(NewtonSolvers, OneDimensionFindsReachableAndNearestPoses) {
  const Skeleton skeleton = toSkeleton(PlanarChain{.base = {0, 0}, .lengths = {2.0}});
  const auto solver = makeNewton1d();
  IkProblem problem{.skeleton = &skeleton,
                    .start = VectorXd::Constant(1, 0.1),
                    .goals = {{.joint = 1, .target = {std::sqrt(3.0), 1.0, 0}}}};
  EXPECT_NEAR(solver->solve(problem, {}, TraceLevel::Off).q[0], M_PI / 6, 1e-6);
  problem.goals[0].target = {3.0, 3.0, 0.0};
  const IkReport nearest = solver->solve(problem, {}, TraceLevel::Off);
  EXPECT_NEAR(nearest.q[0], M_PI / 4, 1e-9);
  EXPECT_EQ(nearest.why, Stop::Stationary);
  const Skeleton two = toSkeleton(PlanarChain{.base = {0, 0}, .lengths = {1, 1}});
  problem.skeleton = &two;
  problem.start = VectorXd::Zero(2);
  EXPECT_NE(solver->whyUnsupported(problem), "");
  EXPECT_EQ(solver->solve(problem, {}, TraceLevel::Off).why, Stop::Unsupported);
}

}  // namespace
}  // namespace gelenk
