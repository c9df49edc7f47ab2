// Every solver that joins the catalogue inherits these tests.
#include <gtest/gtest.h>

#include <cstdlib>

#include "solvers/iteration/evaluator.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/problem/judge.h"
#include "tests/solvers/random_problem.h"

namespace gelenk {

void PrintTo(const SolverEntry& entry, std::ostream* out) { *out << entry.name; }

namespace {

using Eigen::VectorXd;
using testing::randomProblem;

/// GELENK_CONTRACT_PROBLEMS=100000 for the long run.
int problemCount() {
  if (const char* wanted = std::getenv("GELENK_CONTRACT_PROBLEMS")) return std::atoi(wanted);
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
  return 40;
#endif
#endif
  return 200;
}

const Budget shortBudget{.maxIterations = 60, .maxSeconds = 1e9, .restarts = 1, .seed = 7};

/// A model and how problems on it are drawn.
struct ContractModel {
  std::shared_ptr<const Skeleton> skeleton;  ///< none: a new one for every problem
  testing::OwnedProblem (*draw)(std::shared_ptr<const Skeleton>, std::mt19937_64&,
                                int) = testing::chainProblem;
};

/// New trees; trees that are asked again; chains of hinges and sliders, of balls, in the plane; robots. Few
/// models with many problems each, so that tables are built once a model.
std::vector<ContractModel> contractModels() {
  std::mt19937_64 random(21);
  std::vector<ContractModel> models{{nullptr, [](std::shared_ptr<const Skeleton>, std::mt19937_64& r, int i) {
                                       return randomProblem(r, i);
                                     }}};
  const auto add = [&](Skeleton skeleton, auto draw) {
    models.push_back({std::make_shared<Skeleton>(std::move(skeleton)), draw});
  };
  for (int i = 0; i < 2; ++i) add(testing::randomSkeleton(random, 2 + 6 * i), testing::problemOn);
  for (const Robot& robot : robots()) add(toSkeleton(robot.table()), testing::chainProblem);
  for (int dofs = 1; dofs <= 8; ++dofs) add(testing::randomDhChain(random, dofs), testing::chainProblem);
  for (int i = 0; i < 4; ++i) add(testing::randomWristArm(random), testing::chainProblem);
  for (int i = 0; i < 6; ++i) add(testing::randomBallChain(random), testing::chainProblem);
  for (int n = 1; n <= 4; ++n) add(testing::straightChain(n, n % 2 ? unlimited : 1.5), testing::chainProblem);
  return models;
}

class SolverContract : public ::testing::TestWithParam<SolverEntry> {
 protected:
  std::unique_ptr<IkSolver> solver = GetParam().make();
  using Owned = testing::OwnedProblem;

  /// Problem `number` of a model, the same in every run whatever was drawn before it.
  static Owned problemOf(const ContractModel& model, std::uint64_t seed, int number) {
    std::seed_seq parts{seed, static_cast<std::uint64_t>(number)};
    std::mt19937_64 random(parts);
    return model.draw(model.skeleton, random, number);
  }

  /// Calls check(owned, report) for at least `count` problems that the solver supports, shared evenly among
  /// the models on which it supports anything; what it does not support must be refused honestly.
  template <typename Check>
  void forEachProblem(int count, std::uint64_t seed, Check check) {
    const std::vector<ContractModel> all = contractModels();
    constexpr int probes = 40;
    std::vector<const ContractModel*> able;
    for (const ContractModel& model : all) {
      bool some = false;
      for (int i = 0; i < probes && !some; ++i)
        some = solver->whyUnsupported(problemOf(model, seed, i).problem).empty();
      if (some)
        able.push_back(&model);
      else if (model.skeleton)
        refuses(problemOf(model, seed, 0).problem);
    }
    ASSERT_FALSE(able.empty());
    const int share = (count + static_cast<int>(able.size()) - 1) / static_cast<int>(able.size());
    int supported = 0;
    for (const ContractModel* model : able) {
      if (model->skeleton) solver->prepare(*model->skeleton);
      int here = 0;
      for (int i = 0; here < share && i < 400 * share; ++i) {
        const Owned owned = problemOf(*model, seed, i);
        SCOPED_TRACE("model " + std::to_string(model - all.data()) + ", problem " + std::to_string(i) +
                     " of seed " + std::to_string(seed) + ": " + owned.story);
        if (!solver->whyUnsupported(owned.problem).empty()) {
          refuses(owned.problem);
        } else {
          if (!model->skeleton && here % 8 == 0)
            solver->prepare(*owned.skeleton);  // the others must do without, or notice that it was another
          ++here;
          const IkReport report = solver->solve(owned.problem, shortBudget, TraceLevel::Off);
          ASSERT_NE(report.why, Stop::Unsupported);
          check(owned, report);
        }
        if (HasFatalFailure()) return;
      }
      supported += here;
    }
    ASSERT_GE(supported, count);
    RecordProperty("problems", supported);
  }

 private:
  void refuses(const IkProblem& problem) {
    const IkReport report = solver->solve(problem, shortBudget, TraceLevel::Off);
    ASSERT_EQ(report.why, Stop::Unsupported);
    ASSERT_EQ(report.q, problem.start);
  }
};

TEST_P(SolverContract, AnswersAreFiniteWithinLimitsAndTheirErrorIsTheOneReported) {
  forEachProblem(problemCount(), 11, [&](const Owned& owned, const IkReport& report) {
    const Judgement verdict = judge(owned.problem, report.q);
    ASSERT_TRUE(verdict.finite);
    EXPECT_LE(verdict.limitViolation, 1e-9);
    CountedEvaluator at(owned.problem);
    at.moveTo(report.q);
    // rounding of one forward kinematics over metres
    EXPECT_NEAR(at.residual().norm(), report.residual, 1e-12 * (1.0 + report.residual));
    EXPECT_EQ(report.why == Stop::Converged, verdict.solved) << toString(report.why);
    // searches for the closest pose, from the start and from the best pose met, may follow the last attempt
    EXPECT_LE(report.counters.iterations, shortBudget.maxIterations * (3 + shortBudget.restarts));
  });
}

TEST_P(SolverContract, TheSameProblemAndSeedGiveTheSameBits) {
  const auto another = GetParam().make();
  std::shared_ptr<const Skeleton> prepared;
  forEachProblem(problemCount() / 4, 12, [&](const Owned& owned, const IkReport& report) {
    if (owned.skeleton != prepared) another->prepare(*owned.skeleton);  // tables take long
    prepared = owned.skeleton;
    const IkReport again = another->solve(owned.problem, shortBudget, TraceLevel::Off);
    EXPECT_EQ(again.q, report.q);
    EXPECT_EQ(again.why, report.why);
    EXPECT_EQ(again.residual, report.residual);
    EXPECT_EQ(again.counters.iterations, report.counters.iterations);
    EXPECT_EQ(again.counters.forwardKinematics, report.counters.forwardKinematics);
  });
}

TEST_P(SolverContract, TracingChangesNothingAndTellsTheResiduals) {
  forEachProblem(problemCount() / 8, 13, [&](const Owned& owned, const IkReport& report) {
    const IkReport traced = solver->solve(owned.problem, shortBudget, TraceLevel::Full);
    EXPECT_EQ(traced.q, report.q);
    for (const IterationRecord& record : traced.trace) {
      EXPECT_TRUE(std::isfinite(record.residual));
      EXPECT_EQ(record.q.size(), owned.skeleton->nq());
    }
  });
}

TEST_P(SolverContract, NoGoalsAreMetAtOnce) {
  forEachProblem(40, 14, [&](const Owned& owned, const IkReport& report) {
    if (!owned.problem.goals.empty()) return;
    EXPECT_EQ(report.why, Stop::Converged);
    EXPECT_EQ(report.residual, 0.0);
  });
}

INSTANTIATE_TEST_SUITE_P(Catalogue, SolverContract,
                         ::testing::ValuesIn(solverCatalogue().begin(), solverCatalogue().end()),
                         [](const auto& info) {
                           std::string name(info.param.name);
                           for (char& c : name)
                             if (c == '-') c = '_';
                           return name;
                         });

/// What the method is for: from a random start a local method with restarts reaches a reachable position.
TEST(Catalogue, EveryIterativeSolverReachesMostReachablePositionsOfAFreeArm) {
  for (const SolverEntry& entry : solverCatalogue()) {
    if (entry.name == "two-link") continue;  // a closed form that moves the last two joints only
    const auto solver = entry.make();
    std::mt19937_64 random(5);
    int supported = 0, solved = 0;
    for (int i = 0; i < 20; ++i) {
      const Skeleton arm = testing::straightChain(4);
      const VectorXd there = randomWithinLimits(arm, random);
      IkProblem problem{.skeleton = &arm, .start = randomWithinLimits(arm, random)};
      problem.goals = {{.joint = 4, .target = forwardKinematics(arm, there)[4].translation()}};
      problem.positionTolerance = 1e-4;
      if (!solver->whyUnsupported(problem).empty()) continue;
      ++supported;
      solver->prepare(arm);
      const IkReport report =
          solver->solve(problem, {.maxIterations = 500, .maxSeconds = 1e9, .restarts = 5}, TraceLevel::Off);
      solved += judge(problem, report.q).solved;
    }
    EXPECT_GE(solved, supported - 1) << entry.name << " of " << supported;
  }
}

TEST(Catalogue, APositionAndAnOrientationOfOneEffectorAreAPose) {
  const Skeleton puma = toSkeleton(robotTable("puma560"));
  const int tip = puma.jointCount() - 1;
  std::mt19937_64 random(8);
  const Eigen::Isometry3d there = forwardKinematics(puma, randomWithinLimits(puma, random))[tip];
  const Goal pose{.kind = GoalKind::Pose,
                  .joint = tip,
                  .target = there.translation(),
                  .orientation = Eigen::Quaterniond(there.linear())};
  Goal position = pose, orientation = pose;
  position.kind = GoalKind::Position;
  orientation.kind = GoalKind::Orientation;
  const Budget budget{.maxIterations = 100, .maxSeconds = 1e9, .restarts = 50};
  IkProblem one{.skeleton = &puma, .start = randomWithinLimits(puma, random), .goals = {pose}}, two = one;
  for (const std::vector<Goal>& goals : {std::vector<Goal>{position, orientation}, {orientation, position}}) {
    two.goals = goals;
    for (const char* name : {"serial-pose", "serial-pose-table", "closed-form"}) {
      const auto solver = makeSolver(name);
      EXPECT_EQ(solver->whyUnsupported(two), "") << name;
      const IkReport report = solver->solve(two, budget, TraceLevel::Off);
      EXPECT_EQ(report.why, Stop::Converged) << name;
      EXPECT_TRUE(judge(two, report.q).solved) << name;
      EXPECT_EQ(report.q, solver->solve(one, budget, TraceLevel::Off).q) << name;
    }
  }
  two.goals[0].weight = 2.0;  // another residual than the pose's
  EXPECT_NE(makeSolver("serial-pose")->whyUnsupported(two), "");
}

TEST(Catalogue, NamesAreUniqueAndUnknownOnesListThem) {
  for (const SolverEntry& a : solverCatalogue()) {
    int same = 0;
    for (const SolverEntry& b : solverCatalogue()) same += a.name == b.name;
    EXPECT_EQ(same, 1) << a.name;
  }
  try {
    makeSolver("newtonn");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("lm-gain-ratio"), std::string::npos);
  }
}

}  // namespace
}  // namespace gelenk
