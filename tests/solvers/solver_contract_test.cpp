// Every solver that joins the catalogue inherits these tests.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdlib>
#include <set>

#include "kinematics/configuration.h"
#include "solvers/iteration/evaluator.h"
#include "solvers/iteration/limit_set.h"
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
  for (const bool balls : {false, true}) add(testing::fork(balls), testing::forkProblem);
  for (int i = 0; i < 2; ++i)
    add(testing::withCouplings(testing::randomSkeleton(random, 6 + 4 * i), random), testing::problemOn);
  for (const bool inPlane : {false, true}) add(testing::tendonFinger(inPlane), testing::chainProblem);
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

/// Joints that no goal looks at from below keep every bit, restarts or not.
TEST_P(SolverContract, JointsOffTheGoalsPathsStay) {
  int held = 0;
  forEachProblem(problemCount(), 15, [&](const Owned& owned, const IkReport& report) {
    const Skeleton& skeleton = *owned.skeleton;
    if (owned.problem.goals.empty()) return;
    for (int i = 0; i < skeleton.jointCount(); ++i) {
      const auto sourceOf = [&](int j) {
        const auto& coupling = skeleton.joint(j).coupling;
        return coupling ? coupling->source : j;
      };
      bool below = false;
      for (const Goal& goal : owned.problem.goals) {
        below = below || goal.kind == GoalKind::Posture;
        for (int j = goal.joint; j >= 0; j = skeleton.parent(j)) below = below || sourceOf(j) == sourceOf(i);
      }
      const VectorXd& start = owned.problem.start;
      const Joint& joint = skeleton.joint(i);
      const int n = static_cast<int>(joint.axes.size()) + (joint.ball ? 4 : 0);
      if (n == 0 || below || limitViolation(skeleton, start, sourceOf(i)) > 0.0) continue;
      VectorXd coupled = start;
      skeleton.couple(coupled);
      if (coupled[skeleton.qIndex(i)] != start[skeleton.qIndex(i)]) continue;  // it cannot stay so
      if (joint.ball && std::abs(ballRotation(skeleton, start, i).norm() - 1.0) > 1e-12) continue;
      EXPECT_EQ(report.q.segment(skeleton.qIndex(i), n), start.segment(skeleton.qIndex(i), n)) << joint.name;
      ++held;
    }
  });
  RecordProperty("held", held);
}

/// The lowest second derivative of the cost over the directions that limits leave, by differences of the
/// slope, and the largest entry.
std::pair<double, double> lowestCurvature(const IkProblem& problem, const VectorXd& q) {
  const Skeleton& skeleton = *problem.skeleton;
  CountedEvaluator at(problem);
  const int nv = skeleton.nv();
  const double h = 1e-5;
  Eigen::MatrixXd H(nv, nv);
  const auto slopeAt = [&](const VectorXd& x) -> VectorXd {
    at.moveTo(x);
    return at.jacobian().transpose() * at.residual();
  };
  for (int k = 0; k < nv; ++k)
    H.col(k) = (slopeAt(integrate(skeleton, q, -h * VectorXd::Unit(nv, k))) -
                slopeAt(integrate(skeleton, q, h * VectorXd::Unit(nv, k)))) /
               (2.0 * h);
  H = (0.5 * (H + H.transpose())).eval();
  const double size = H.cwiseAbs().maxCoeff();
  LimitSet limits(skeleton);
  limits.moveTo(q);
  limits.lockBlocked(slopeAt(q));
  limits.lockTouched();
  limits.projectBothSides(H);
  return {Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(H).eigenvalues()[0], size};
}

TEST_P(SolverContract, OnlyAMinimumIsCalledStationary) {
  forEachProblem(problemCount(), 16, [&](const Owned& owned, const IkReport& report) {
    std::set<int> priorities;
    for (const Goal& goal : owned.problem.goals) priorities.insert(goal.servedAs());
    if (report.why != Stop::Stationary || priorities.size() > 1) return;  // an order of goals has no one cost
    const auto [lowest, size] = lowestCurvature(owned.problem, report.q);
    // A cost without curvature (target at the base): differences of a slope of order 1 round at 1e-16 / h.
    EXPECT_GE(lowest, -1e-5 * size - 1e-11);
  });
}

/// The straight arm with its target on its own line: no slope, but reachable.
TEST_P(SolverContract, AStraightArmReachesATargetOnItsLine) {
  const std::string name(GetParam().name);
  if (name.starts_with("newton") || name.starts_with("kdl"))
    GTEST_SKIP() << "full steps need an inverse, which does not exist there; peers are as they are";
  std::vector<Skeleton> arms{testing::straightChain(2), testing::straightChain(2, 3.0),
                             testing::straightChain(4, 2.0)};
  {
    std::vector<Joint> joints;
    for (int i = 0; i <= 2; ++i) {
      Joint joint{.name = "b" + std::to_string(i), .parent = i - 1, .ball = i < 2};
      if (i > 0) joint.parentFromZero.translation().x() = 1.0;
      joints.push_back(joint);
    }
    arms.emplace_back(joints);
  }
  for (const Skeleton& arm : arms) {
    const int tip = arm.jointCount() - 1;
    for (const double share : {0.6, 0.95, 0.2}) {
      IkProblem problem{.skeleton = &arm, .start = neutral(arm)};
      problem.goals = {{.joint = tip, .target = {share * tip, 0.0, 0.0}}};
      problem.positionTolerance = 1e-4;
      if (!solver->whyUnsupported(problem).empty()) continue;
      if (tip > 2 && (name == "two-link" || name == "fabrik"))
        continue;  // moves two joints alone; nothing guarantees its progress with limits
      solver->prepare(arm);
      const IkReport report =
          solver->solve(problem, {.maxIterations = 2000, .maxSeconds = 1e9}, TraceLevel::Off);
      EXPECT_TRUE(judge(problem, report.q).solved)
          << tip << " bones, " << share << " of the reach: " << toString(report.why) << ", "
          << report.residual;
    }
  }
}

TEST_P(SolverContract, NoGoalsAreMetAtOnce) {
  forEachProblem(40, 14, [&](const Owned& owned, const IkReport& report) {
    if (!owned.problem.goals.empty()) return;
    EXPECT_EQ(report.why, Stop::Converged);
    EXPECT_EQ(report.residual, 0.0);
  });
}

std::vector<SolverEntry> everyEntry() {
  std::vector<SolverEntry> all(solverCatalogue().begin(), solverCatalogue().end());
  all.push_back(solverEntry("default"));
  return all;
}

INSTANTIATE_TEST_SUITE_P(Catalogue, SolverContract, ::testing::ValuesIn(everyEntry()), [](const auto& info) {
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

TEST(Catalogue, EveryParameterIsNamedWithinItsRangeAndExplained) {
  for (const SolverEntry& entry : solverCatalogue())
    for (const Parameter& p : entry.parameters) {
      SCOPED_TRACE(std::string(entry.name) + "." + std::string(p.name));
      EXPECT_LT(p.lower, p.upper);
      EXPECT_GE(p.value, p.lower);
      EXPECT_LE(p.value, p.upper);
      EXPECT_FALSE(p.unit.empty());
      EXPECT_FALSE(p.source.empty());
      EXPECT_TRUE(p.meaning.ends_with('.'));
      EXPECT_EQ(p.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz-"), std::string_view::npos);
      int same = 0;
      for (const Parameter& other : entry.parameters) same += other.name == p.name;
      EXPECT_EQ(same, 1);
      EXPECT_NO_THROW(entry.make({{std::string(p.name), p.value}}));
      EXPECT_THROW(entry.make({{std::string(p.name), std::nextafter(p.upper, INFINITY)}}),
                   std::invalid_argument);
      EXPECT_THROW(entry.make({{std::string(p.name), p.lower - 1.0}}), std::invalid_argument);
      EXPECT_THROW(entry.make({{std::string(p.name), NAN}}), std::invalid_argument);
      if (p.whole) {
        EXPECT_THROW(entry.make({{std::string(p.name), p.value + 0.5}}), std::invalid_argument);
      }
    }
}

/// A parameter that no problem's answer or work depends on is none.
TEST(Catalogue, EveryParameterChangesWhatItsSolverDoes) {
  const std::vector<ContractModel> models = contractModels();
  for (const SolverEntry& entry : solverCatalogue())
    for (const Parameter& p : entry.parameters) {
      const double low = p.lower > 0.0 ? std::sqrt(p.lower * p.value) : p.lower;
      const auto usual = entry.make();
      bool changed = false;
      for (double value : {p.whole ? std::floor(low) : low, p.lower, p.upper}) {
        if (value == p.value || changed) continue;
        std::unique_ptr<IkSolver> other;
        try {
          other = entry.make({{std::string(p.name), value}});
        } catch (const std::invalid_argument&) {
          continue;  // evolution's numbers bound each other
        }
        for (const ContractModel& model : models)
          for (int i = 0; i < 60 && !changed; ++i) {
            std::seed_seq parts{3u, static_cast<unsigned>(i)};
            std::mt19937_64 random(parts);
            const testing::OwnedProblem owned = model.draw(model.skeleton, random, i);
            if (!usual->whyUnsupported(owned.problem).empty()) continue;
            const Budget budget{.maxIterations = 30, .maxSeconds = 1e9, .restarts = i % 2 * 20};
            const IkReport a = usual->solve(owned.problem, budget, TraceLevel::Off),
                           b = other->solve(owned.problem, budget, TraceLevel::Off);
            changed = a.q != b.q || a.counters.iterations != b.counters.iterations ||
                      a.counters.forwardKinematics != b.counters.forwardKinematics;
          }
      }
      EXPECT_TRUE(changed) << entry.name << "." << p.name;
    }
}

TEST(Catalogue, ChoicesAreTextsAndBack) {
  EXPECT_EQ(toText(solverSpec("dls")), "dls");
  EXPECT_EQ(toText(solverSpec("dls[largest-step=1,lambda=0.1]")), "dls[lambda=0.1,largest-step=1]");
  EXPECT_EQ(toText(solverSpec("dls[lambda=0.05]")), "dls");  // the default
  EXPECT_EQ(toText(withParameter(solverSpec("dls[lambda=0.1]"), "lambda", 0.05)), "dls");
  const ParameterSetting setting = parameterSetting("lm-chan.lambda=2");
  EXPECT_EQ(setting.entry->name, "lm-chan");
  EXPECT_EQ(setting.parameter, "lambda");
  EXPECT_EQ(setting.value, 2.0);
  const auto reason = [](auto run) -> std::string {
    try {
      run();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(
      reason([] { makeSolver("dls[lamda=0.1]"); }).find("there are: lambda (0.05 m; 0 to 10), largest-step"),
      std::string::npos);
  EXPECT_NE(reason([] { makeSolver("dls[lambda=11]"); }).find("dls.lambda must lie in 0 to 10 m, not 11"),
            std::string::npos);
  EXPECT_NE(reason([] { makeSolver("l-bfgs[memory=2.5]"); }).find("whole number"), std::string::npos);
  EXPECT_NE(reason([] { makeSolver("two-link[lambda=1]"); }).find("no parameters"), std::string::npos);
  EXPECT_NE(reason([] { makeSolver("evolution[parents=20]"); }).find("must not exceed"), std::string::npos);
  for (const char* broken :
       {"dls[", "dls[]", "dls[lambda]", "dls[lambda=]", "dls[lambda=0.1", "dls[lambda=x]"})
    EXPECT_NE(reason([&] { makeSolver(broken); }), "accepted") << broken;
  for (const char* broken : {"dls", "dls.lambda", "lambda=0.1", "dls.lambda=", "dls.mu=1", "dsl.lambda=1"})
    EXPECT_NE(reason([&] { parameterSetting(broken); }), "accepted") << broken;
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
