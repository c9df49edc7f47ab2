#include "solvers/own_solver.h"

#include <gtest/gtest.h>

#include "kinematics/configuration.h"
#include "kinematics/notation/robots.h"
#include "solvers/methods/step_rules.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/problem/judge.h"

namespace gelenk {
namespace {

OwnSolver damped(const std::string& name, double lambda = 0.05) {
  return {.name = name,
          .title = "Damped, from outside",
          .reference = "test",
          .parameters = {{.name = "lambda", .value = lambda, .lower = 0.0, .upper = 1.0}},
          .make = [lambda](const ParameterValues& values) {
            const auto found = values.find("lambda");
            return makeDampedLeastSquares({.lambda = found == values.end() ? lambda : found->second});
          }};
}

TEST(OwnSolver, JoinsTheCatalogueAndAnswersAsItsMethodDoes) {
  const std::size_t before = solverCatalogue().size();
  const SolverEntry* first = solverCatalogue().data();
  addSolver(damped("test-dls"));
  ASSERT_EQ(solverCatalogue().size(), before + 1);
  EXPECT_EQ(solverCatalogue().data(), first) << "entries stay where they are";
  EXPECT_EQ(toText(solverSpec("test-dls[lambda=0.2]")), "test-dls[lambda=0.2]");
  EXPECT_THROW(makeSolver("test-dls[lambda=2]"), std::invalid_argument);

  const Skeleton ur5 = toSkeleton(robotTable("ur5"));
  std::mt19937_64 random(3);
  const int tip = ur5.jointCount() - 1;
  const Eigen::Vector3d target = forwardKinematics(ur5, randomWithinLimits(ur5, random))[tip].translation();
  const IkProblem problem{.skeleton = &ur5, .start = ur5.rest(), .goals = {{.joint = tip, .target = target}}};
  const Budget budget{.maxIterations = 100, .maxSeconds = 1e9, .restarts = 5};
  EXPECT_EQ(makeSolver("test-dls[lambda=0.2]")->solve(problem, budget, TraceLevel::Off).q,
            makeSolver("dls[lambda=0.2]")->solve(problem, budget, TraceLevel::Off).q);
}

TEST(OwnSolver, ANewMethodTakesTheNameAndTheOldOneGoesOn) {
  addSolver(damped("test-again", 0.05));
  const auto old = makeSolver("test-again");
  const std::size_t count = solverCatalogue().size();
  const int changes = solverChanges();
  addSolver(damped("test-again", 0.5));
  EXPECT_EQ(solverCatalogue().size(), count);
  EXPECT_EQ(solverChanges(), changes + 1);
  EXPECT_EQ(solverEntry("test-again").parameters[0].value, 0.5);
  const Skeleton ur5 = toSkeleton(robotTable("ur5"));
  const IkProblem problem{.skeleton = &ur5,
                          .start = ur5.rest(),
                          .goals = {{.joint = ur5.jointCount() - 1, .target = {0.4, 0.1, 0.5}}}};
  const Budget few{.maxIterations = 3, .maxSeconds = 1e9};
  EXPECT_NE(old->solve(problem, few, TraceLevel::Off).q,
            makeSolver("test-again")->solve(problem, few, TraceLevel::Off).q);
}

TEST(OwnSolver, NamesAndParametersMustMakeSense) {
  EXPECT_THROW(addSolver(damped("dls")), std::invalid_argument);
  EXPECT_THROW(addSolver(damped("hybrid")), std::invalid_argument) << "the drag solver's old name";
  EXPECT_THROW(addSolver(damped("default")), std::invalid_argument);
  for (const char* name : {"", "With Blanks", "a[b]", "a.b", "a,b"})
    EXPECT_THROW(addSolver(damped(name)), std::invalid_argument) << name;
  EXPECT_THROW(addSolver(damped("test-range", 2.0)), std::invalid_argument);
  OwnSolver twice = damped("test-twice");
  twice.parameters.push_back(twice.parameters[0]);
  EXPECT_THROW(addSolver(twice), std::invalid_argument);
  OwnSolver none = damped("test-none");
  none.make = {};
  EXPECT_THROW(addSolver(none), std::invalid_argument);
}

}  // namespace
}  // namespace gelenk
