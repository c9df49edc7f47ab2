#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "kinematics/configuration.h"
#include "kinematics/io/text_file.h"
#include "kinematics/notation/robots.h"
#include "solvers/iteration/evaluator.h"
#include "solvers/lab/comparison.h"
#include "solvers/lab/report.h"
#include "solvers/lab/statistics.h"
#include "solvers/lab/sweep.h"
#include "solvers/lab/truth.h"
#include "solvers/methods/step_rules.h"
#include "solvers/problem/goal_text.h"
#include "solvers/problem/judge.h"
#include "solvers/solutions/complete_set.h"
#include "tests/kinematics/random_skeleton.h"
#include "tests/solvers/solutions/example_arms.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
namespace fs = std::filesystem;

// ---- statistics

TEST(Statistics, WilsonIntervalIsTheTextbooks) {
  // 50 of 100: (0.5 + z^2/200 -+ z sqrt(0.0025 + z^2/40000)) / (1 + z^2/100) with z = 1.96, by hand
  EXPECT_NEAR(wilsonInterval(50, 100).lower, 0.40383, 1e-5);
  EXPECT_NEAR(wilsonInterval(50, 100).upper, 0.59617, 1e-5);
  EXPECT_NEAR(wilsonInterval(10000, 10000).lower, 1.0 / (1.0 + 3.841458821 / 10000), 1e-9);  // n/(n + z^2)
  EXPECT_EQ(wilsonInterval(10000, 10000).upper, 1.0);
  EXPECT_EQ(wilsonInterval(0, 5).lower, 0.0);
}

TEST(Statistics, McNemarIsTheExactBinomialTest) {
  EXPECT_DOUBLE_EQ(mcNemar(0, 0), 1.0);
  EXPECT_NEAR(mcNemar(0, 5), 2.0 / 32.0, 1e-12);
  EXPECT_NEAR(mcNemar(1, 9), 2.0 * (1.0 + 10.0) / 1024.0, 1e-12);
  EXPECT_NEAR(mcNemar(7, 7), 1.0, 1e-12);
  EXPECT_EQ(mcNemar(3, 20), mcNemar(20, 3));
}

TEST(Statistics, QuantilesInterpolateAndLeaveNothingOut) {
  EXPECT_DOUBLE_EQ(quantile({4.0, 1.0, 3.0, 2.0}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(quantile({1.0, 2.0}, 0.99), 1.99);
  EXPECT_DOUBLE_EQ(quantile({NAN, 7.0}, 0.3), 7.0);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
  EXPECT_TRUE(std::isinf(quantile({1.0, INFINITY}, 1.0)));
}

TEST(Statistics, StandardDeviationByHand) {
  EXPECT_DOUBLE_EQ(standardDeviation({2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0}), std::sqrt(32.0 / 7.0));
  EXPECT_DOUBLE_EQ(standardDeviation({1.0, NAN, 3.0}), std::sqrt(2.0));
  EXPECT_TRUE(std::isnan(standardDeviation({1.0})));
}

TEST(Statistics, BootstrapIntervalHoldsTheRatioAndShrinksWithTheSample) {
  std::mt19937_64 random(1);
  const auto width = [&](int n) {
    std::vector<double> a, b;
    for (int i = 0; i < n; ++i) {
      b.push_back(1.0 + uniform01(random));
      a.push_back(3.0 * b.back() * (0.5 + uniform01(random)));
    }
    const RatioEstimate estimate = pairedRatio(a, b, 7);
    EXPECT_LT(estimate.interval.lower, estimate.ratio);
    EXPECT_GT(estimate.interval.upper, estimate.ratio);
    EXPECT_NEAR(estimate.ratio, 3.0, 6.0 / std::sqrt(n));
    return estimate.interval.upper - estimate.interval.lower;
  };
  const double wide = width(50), narrow = width(5000);
  EXPECT_LT(narrow, 0.2 * wide);  // 1 / sqrt(100) is expected
}

TEST(Statistics, PerformanceProfileOfTwoMethodsByHand) {
  const auto profile = performanceProfile({{1.0, 4.0, INFINITY}, {2.0, 2.0, INFINITY}}, {1.0, 2.0, 10.0});
  EXPECT_EQ(profile[0], (std::vector<double>{1.0 / 3, 2.0 / 3, 2.0 / 3}));
  EXPECT_EQ(profile[1], (std::vector<double>{1.0 / 3, 2.0 / 3, 2.0 / 3}));
}

// ---- problem sets

Skeleton arm() {
  std::vector<Joint> joints;
  const Vector3d axes[] = {{0, 0, 1}, {0, 1, 0}, {0, 0, 1}, {0, 1, 0}, {0, 0, 1}, {0, 1, 0}, {0, 0, 1}};
  for (int i = 0; i < 8; ++i) {
    Joint joint{.name = "j" + std::to_string(i), .parent = i - 1};
    if (i > 0) joint.parentFromZero.translation().z() = i % 2 ? 0.1 : 0.3;
    if (i < 7) joint.axes = {{AxisDof::Kind::Rotation, axes[i], -2.8, 2.8}};
    joints.push_back(joint);
  }
  return Skeleton(joints);
}

/// What a set can be asked of: numbers of solutions are those of six joints.
LabModel modelFor(const ProblemSetEntry& set) {
  return set.family == ProblemFamily::Solutions ? labModel("puma560", toSkeleton(robotTable("puma560")))
                                                : labModel("arm", arm());
}

TEST(ProblemSets, AreFrozenBySeedAndDoNotDependOnTheirNumber) {
  for (const ProblemSetEntry& set : problemSetCatalogue()) {
    const LabModel model = modelFor(set);
    const auto some = makeProblems(set, model, 60, 3, 1e-6), more = makeProblems(set, model, 120, 3, 1e-6);
    EXPECT_EQ(checksum(some), checksum(makeProblems(set, model, 60, 3, 1e-6))) << set.name;
    EXPECT_NE(checksum(some), checksum(makeProblems(set, model, 60, 4, 1e-6))) << set.name;
    for (int i = 0; i < 50; ++i) {
      EXPECT_EQ(some[i].problem.start, more[i].problem.start) << set.name;
      EXPECT_EQ(some[i].problem.goals[0].target, more[i].problem.goals[0].target) << set.name;
    }
  }
}

TEST(ProblemSets, MeetableGoalsAreMetByTheirReferenceWithinTheLimits) {
  for (const ProblemSetEntry& set : problemSetCatalogue()) {
    if (!set.meetable) continue;
    const LabModel model = modelFor(set);
    for (const LabProblem& one : makeProblems(set, model, 60, 5, 1e-9)) {
      if (set.family == ProblemFamily::Solutions && one.level == 0.0) continue;
      EXPECT_TRUE(judge(one.problem, one.reference).solved) << set.name << " " << one.index;
      EXPECT_LE(limitViolation(*one.skeleton, one.problem.start), 1e-12);
    }
  }
}

/// A goal of every kind on the arm, as a person would type it for a comparison.
std::vector<Goal> everyKind(const Skeleton& skeleton) {
  const auto masses = std::make_shared<const Masses>(rodMasses(skeleton));
  const std::string end = skeleton.joint(skeleton.jointCount() - 1).name, half = skeleton.joint(3).name;
  std::vector<Goal> goals;
  for (const GoalType* type : goalTypes()) {
    if (!type->judged) continue;
    std::string text(type->name);
    for (const GoalField& field : type->fields) {
      if (field.meaning != GoalField::Meaning::Joint) continue;
      const bool other = field.name != "joint";
      text += " " + std::string(field.name) + "=" + (type->kind == GoalKind::Pole || other ? half : end);
    }
    if (type->kind == GoalKind::KeepOut) text += " target=0.1,0.1,0.1 radius=0.3";  // poses are drawn for it
    goals.push_back(goalTemplateFromText(text, skeleton, masses));
  }
  return goals;
}

TEST(ProblemSets, GoalsOfEveryKindAreMetByTheReferenceAndFrozen) {
  for (const Goal& goal : everyKind(arm())) {
    LabModel model = labModel("arm", arm());
    model.goals = {goal};
    const std::string kind(goalType(goal.kind).name);
    bool checksumSeesIt = false;
    for (const char* set : {"D1", "D2", "D3", "D6"}) {
      const auto problems = makeProblems(problemSet(set), model, 12, 5, 1e-9);
      for (const LabProblem& one : problems) {
        ASSERT_EQ(one.problem.goals.size(), 2u) << kind;
        EXPECT_TRUE(judge(one.problem, one.reference).solved) << kind << " " << set << " " << one.index;
      }
      EXPECT_EQ(checksum(problems), checksum(makeProblems(problemSet(set), model, 12, 5, 1e-9))) << kind;
      checksumSeesIt |=
          checksum(problems) != checksum(makeProblems(problemSet(set), labModel("arm", arm()), 12, 5, 1e-9));
    }
    EXPECT_TRUE(checksumSeesIt) << kind;
    model.effectors.clear();
    EXPECT_EQ(makeProblems(problemSet("D1"), model, 3, 5, 1e-6)[2].problem.goals.size(), 1u) << kind;
    EXPECT_THROW(makeProblems(problemSet("D4"), model, 3, 5, 1e-6), std::invalid_argument);
  }
  LabModel model = labModel("arm", arm());
  model.goals = {
      goalTemplateFromText("keep-out joint=" + arm().joint(6).name + " target=0,0,0 radius=9", arm())};
  EXPECT_THROW(makeProblems(problemSet("D1"), model, 1, 1, 1e-6), std::invalid_argument);
  EXPECT_THROW(makeProblems(problemSet("D5"), model, 9, 1, 1e-6), std::invalid_argument);
  EXPECT_THROW(goalTemplateFromText("distance other=nobody", arm()), std::invalid_argument);
}

TEST(ProblemSets, LevelsAreWhatTheySay) {
  const LabModel model = labModel("arm", arm());
  for (LabProblem& one : makeProblems(problemSet("D2"), model, 30, 6, 1e-6)) {
    annotate(problemSet("D2"), one);
    EXPECT_NEAR(one.sigmaMin, one.level, 2e-3 * one.level + 1e-8);
  }
  for (LabProblem& one : makeProblems(problemSet("D4"), model, 12, 6, 1e-6)) {
    annotate(problemSet("D4"), one);
    const double distance = one.problem.goals[0].target.norm();  // the base is the origin
    EXPECT_GE(one.bestResidual, (1.0 - 1.0 / one.level) * distance - 1e-6);
    EXPECT_LE(distance / one.level, 1.3 + 1e-9);  // the links in line
  }
  for (const LabProblem& one : makeProblems(problemSet("D3"), model, 24, 6, 1e-6)) {
    EXPECT_LE(one.problem.goals[0].target.norm(), 1.3 * one.level + 1e-9);
    EXPECT_GE(one.problem.goals[0].target.norm(),
              1.1 * one.level - 1e-9);  // 0.1 m of the base turn about the vertical only
  }
  const auto drags = makeProblems(problemSet("D5"), model, 150, 6, 1e-6);
  for (std::size_t i = 1; i < drags.size(); ++i) {
    if (drags[i].frame == 0) continue;
    EXPECT_LE((drags[i].reference - drags[i - 1].reference).lpNorm<Eigen::Infinity>(),
              drags[i].level * (1 + 1e-12));
  }
}

TEST(ProblemSets, UnknownNamesAndEmptySetsAreRefused) {
  EXPECT_THROW(problemSet("D9"), std::invalid_argument);
  EXPECT_THROW(makeProblems(problemSet("D8"), labModel("arm", arm()), 1, 1, 1e-6), std::invalid_argument);
  EXPECT_THROW(makeProblems(problemSet("D1"), labModel("arm", arm()), 0, 1, 1e-6), std::invalid_argument);
  EXPECT_THROW(labModel("arm", arm(), {"hand"}), std::invalid_argument);
}

/// Counted by another route: Newton from many starts.
TEST(ProblemSets, D8HasAsManySolutionsAsItsLevelSays) {
  const LabModel model = modelFor(problemSet("D8"));
  const auto solver = makeLmGainRatio();
  std::vector<Joint> joints = model.skeleton->joints();
  for (Joint& joint : joints)
    for (AxisDof& dof : joint.axes) dof.lower = -M_PI, dof.upper = M_PI;
  const Skeleton free(joints);
  std::set<double> levels;
  for (const LabProblem& one : makeProblems(problemSet("D8"), model, 20, 7, 1e-6)) {
    levels.insert(one.level);
    if (one.level == 1.0) continue;  // merging: a double root is not counted by starts
    IkProblem problem = one.problem;
    problem.skeleton = &free;
    std::vector<VectorXd> found;
    std::mt19937_64 random(9);
    for (int start = 0; start < 200; ++start) {
      problem.start = randomWithinLimits(free, random);
      const IkReport report =
          solver->solve(problem, {.maxIterations = 200, .maxSeconds = 1e9}, TraceLevel::Off);
      if (!judge(problem, report.q).solved) continue;
      const bool known = std::ranges::any_of(found, [&](const VectorXd& q) {
        double most = 0.0;
        for (int i = 0; i < 6; ++i)
          most = std::max(most, std::abs(std::remainder(q[i] - report.q[i], 2 * M_PI)));
        return most < 1e-2;
      });
      if (!known) found.push_back(report.q);
    }
    EXPECT_EQ(static_cast<double>(found.size()), one.level) << one.index;
  }
  EXPECT_GE(levels.size(), 3u);  // 0, 1 and the PUMA's own
}

TEST(ProblemSets, D8OfAGeneralArmGoesUpToSixteenSolutions) {
  const Skeleton crx = toSkeleton(testing::generalArm("crx10ia"));
  const LabModel model = labModel("crx10ia", crx);
  const CompleteSet set(crx, crx.jointCount() - 1);
  std::set<double> levels;
  for (const LabProblem& one : makeProblems(problemSet("D8"), model, 30, 7, 1e-6)) {
    levels.insert(one.level);
    if (one.level < 2.0) continue;
    const Goal& goal = one.problem.goals[0];
    ArmSolutions found;
    set.solve(Eigen::Translation3d(goal.target) * goal.orientation, Vector6d::Zero(), found);
    int reached = 0;
    IkProblem problem = one.problem;
    std::vector<Joint> joints = crx.joints();
    for (Joint& joint : joints)
      for (AxisDof& dof : joint.axes) dof.lower = -10.0, dof.upper = 10.0;
    const Skeleton free(joints);
    problem.skeleton = &free;
    for (const ArmSolution& s : found.all()) reached += judge(problem, VectorXd(s.q)).solved;
    EXPECT_EQ(reached, one.level);
  }
  EXPECT_TRUE(levels.contains(16.0));
  EXPECT_GE(levels.size(), 6u);  // 0, 1, 16 and what lies between
}

TEST(Truth, KnowsTheNearestSolutionAndWhatHasNone) {
  TruthFinder truths;
  for (const char* robot : {"puma560", "panda"}) {
    SCOPED_TRACE(robot);
    const LabModel model = labModel(robot, toSkeleton(robotTable(robot)));
    for (const LabProblem& one : makeProblems(problemSet("D1"), model, 20, 3, 1e-6)) {
      const Truth truth = truths.of(one.problem);
      EXPECT_EQ(truth.solutions == "family", model.skeleton->nq() == 7);
      EXPECT_NE(truth.solutions, "0");
      EXPECT_LE(truth.nearest, (one.problem.start - one.reference).norm() + 1e-9);
      IkProblem at = one.problem;  // from a solution nothing is nearer than itself
      at.start = one.reference;
      EXPECT_LT(truths.of(at).nearest, 1e-6);
      at.goals[0].target.x() += 10.0;
      EXPECT_EQ(truths.of(at).solutions, "0");
      EXPECT_TRUE(std::isnan(truths.of(at).nearest));
      at.goals.push_back(at.goals[0]);
      EXPECT_EQ(truths.of(at).solutions, "");
    }
  }
}

// ---- comparisons

class Comparison : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = fs::path(::testing::TempDir()) /
             ("gelenk-lab-" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  void TearDown() override { fs::remove_all(folder); }

  ComparisonPlan plan() const {
    ComparisonPlan plan{.sets = {"D1", "D5", "D7"},
                        .solvers = {"dls", "lm-gain-ratio", "evolution", "two-link"},
                        .problems = 12,
                        .seed = 9};
    plan.budget = {.maxIterations = 60, .maxSeconds = 1e9, .restarts = 1, .seed = 9};
    plan.traces = 4;
    plan.seeds = 3;
    return plan;
  }
  void run(const ComparisonPlan& plan, const std::string& name, int stopAfter = 1 << 30) const {
    struct Stopped {};
    try {
      runComparison(plan, model, path(name), [&](int done, int, const std::string&) {
        if (done >= stopAfter) throw Stopped();
      });
    } catch (const Stopped&) {
    }
  }
  std::string path(const std::string& name) const { return (folder / name).string(); }

  /// The file with the given columns (times) emptied.
  static std::string withoutTimes(const std::string& file, int timeColumns) {
    std::string out;
    const std::string text = readFile(file);
    for (std::string_view line : splitLines(text)) {
      for (int k = 0; k < timeColumns; ++k) line = line.substr(0, line.rfind(','));
      out += std::string(line) + '\n';
    }
    return out;
  }
  void expectSameAnswers(const std::string& a, const std::string& b) const {
    EXPECT_EQ(readFile(path(a) + "/solutions.csv"), readFile(path(b) + "/solutions.csv"));
    EXPECT_EQ(readFile(path(a) + "/goals.csv"), readFile(path(b) + "/goals.csv"));
    EXPECT_EQ(withoutTimes(path(a) + "/results.csv", 2), withoutTimes(path(b) + "/results.csv", 2));
    EXPECT_EQ(withoutTimes(path(a) + "/seeds.csv", 1), withoutTimes(path(b) + "/seeds.csv", 1));
    EXPECT_EQ(withoutTimes(path(a) + "/traces.csv", 1), withoutTimes(path(b) + "/traces.csv", 1));
  }

  fs::path folder;
  LabModel model = labModel("arm", arm());
};

TEST_F(Comparison, TheSameSeedGivesTheSameBits) {
  run(plan(), "a");
  run(plan(), "b");
  expectSameAnswers("a", "b");
}

TEST_F(Comparison, AnInterruptedRunContinuesToTheSameAnswers) {
  run(plan(), "whole");
  run(plan(), "cut", 17);
  {  // a killed process leaves part of a line
    std::ofstream(path("cut") + "/results.csv", std::ios::app) << "D1,dls,3,3,0,0,conv";
    std::ofstream(path("cut") + "/traces.csv", std::ios::app) << "D1,dls,3,";
  }
  const std::size_t before = readResults(path("cut")).rows.size();
  EXPECT_GT(before, 0u);
  EXPECT_LT(before, readResults(path("whole")).rows.size());
  run(plan(), "cut");
  expectSameAnswers("whole", "cut");
}

TEST_F(Comparison, ShardsJoinToTheUnshardedRun) {
  run(plan(), "whole");
  std::vector<std::string> shards;
  for (int k = 1; k <= 3; ++k) {
    ComparisonPlan part = plan();
    part.shard = k;
    part.shards = 3;
    shards.push_back(path("part" + std::to_string(k)));
    run(part, "part" + std::to_string(k));
  }
  EXPECT_THROW(mergeComparisons({shards[0], shards[2]}, path("joined")), std::runtime_error);
  EXPECT_THROW(mergeComparisons({shards[0], shards[0], shards[2]}, path("joined")), std::runtime_error);
  EXPECT_FALSE(fs::exists(path("joined")));
  mergeComparisons(shards, path("joined"));
  expectSameAnswers("whole", "joined");
  EXPECT_EQ(readRecord(path("whole")), readRecord(path("joined")));
}

TEST_F(Comparison, SolversThatDrawRandomNumbersAreRunWithSeveralSeeds) {
  ComparisonPlan p{.sets = {"D1"}, .solvers = {"dls", "evolution"}, .problems = 6, .seed = 3};
  p.budget = {.maxIterations = 20, .maxSeconds = 1e9, .seed = 3};
  EXPECT_EQ(seedCount(p, "dls", 0), 1);  // nothing in it is random without restarts
  EXPECT_EQ(seedCount(p, "evolution", 0), 20);
  p.budget.restarts = 1;
  EXPECT_EQ(seedCount(p, "dls", 1), 1);  // unless asked for
  p.seeds = 4;
  EXPECT_EQ(seedCount(p, "dls", 1), 4);
  run(p, "a");
  const Results results = readResults(path("a"));
  ASSERT_EQ(results.seeds.size(), 2u * 6u * 4u);
  int differ = 0;
  for (const SeedRow& row : results.seeds) {
    const ResultRow& first =
        results.rows[static_cast<std::size_t>((row.solver == "dls" ? 0 : 6) + row.problem)];
    ASSERT_EQ(first.solver, row.solver);
    if (row.seed == 3) {
      EXPECT_EQ(row.displacement, first.displacement);
    }
    differ += row.displacement != first.displacement;
  }
  EXPECT_GT(differ, 6);  // other seeds, other answers: the arm has a spare degree of freedom
  writeReport(path("a"), results,
              {.version = "test", .commandLine = "", .colour = [](const std::string&) { return "#336699"; }});
  EXPECT_NE(readFile(path("a") + "/summary.json").find("problems_solved_by_every_seed"), std::string::npos);
}

TEST_F(Comparison, PreparationIsTimedAndItsMemoryMeasured) {
  run({.sets = {"D1"}, .solvers = {"dls", "serial-pose-table"}, .problems = 1, .traces = 0}, "a");
  const Results results = readResults(path("a"));
  ASSERT_EQ(results.preparations.size(), 2u);
  EXPECT_EQ(results.preparations[1].solver, "serial-pose-table");
  EXPECT_GT(results.preparations[1].seconds, results.preparations[0].seconds);
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
  return;  // its allocator does not tell
#endif
#endif
#ifndef __GLIBC__
  GTEST_SKIP() << "this library's allocator does not tell";
#endif
  EXPECT_LT(results.preparations[0].bytes, 1e4);
  EXPECT_GT(results.preparations[1].bytes, 1e6);  // 8^4 cells of eight configurations
}

TEST_F(Comparison, ErrorsWrittenAreThoseOfTheSolutionsWritten) {
  run(plan(), "a");
  const auto problems = makeProblems(problemSet("D1"), model, 12, 9, 1e-6);
  const std::string text = readFile(path("a") + "/solutions.csv");
  const auto lines = splitLines(text);
  const Results results = readResults(path("a"));
  for (std::size_t i = 1; i <= 12; ++i) {  // D1, dls
    std::string line(lines[i]);
    for (char& c : line)
      if (c == ',') c = ' ';
    const auto words = splitWords(line);
    VectorXd q(7);
    for (int k = 0; k < 7; ++k) q[k] = *parseNumber(words[words.size() - 7 + k]);
    const Judgement verdict = judge(problems[i - 1].problem, q);
    EXPECT_EQ(verdict.goals[0].position, results.rows[i - 1].position);
    EXPECT_EQ(verdict.goals[0].orientation, results.rows[i - 1].orientation);
    EXPECT_EQ(verdict.solved, results.rows[i - 1].solved);
  }
}

TEST_F(Comparison, ForeignFoldersAndOtherPlansAreLeftUntouched) {
  fs::create_directories(path("letters"));
  std::ofstream(path("letters") + "/results.csv") << "dear\n";
  EXPECT_THROW(run(plan(), "letters"), std::invalid_argument);
  EXPECT_EQ(readFile(path("letters") + "/results.csv"), "dear\n");
  run(plan(), "a");
  const std::string before = readFile(path("a") + "/results.csv");
  ComparisonPlan other = plan();
  other.seed = 10;
  EXPECT_THROW(run(other, "a"), std::invalid_argument);
  EXPECT_EQ(readFile(path("a") + "/results.csv"), before);
  EXPECT_THROW(mergeComparisons({path("letters")}, path("joined")), std::runtime_error);
}

TEST_F(Comparison, PlansWithoutSenseAreRefusedWithAReason) {
  const auto refused = [&](auto change) {
    ComparisonPlan bad = plan();
    change(bad);
    EXPECT_THROW(validate(bad), std::invalid_argument);
  };
  validate(plan());
  refused([](ComparisonPlan& p) { p.problems = 0; });
  refused([](ComparisonPlan& p) { p.tolerance = -1e-6; });
  refused([](ComparisonPlan& p) { p.tolerance = NAN; });
  refused([](ComparisonPlan& p) { p.solvers = {"newtonn"}; });
  refused([](ComparisonPlan& p) { p.sets = {"D0"}; });
  refused([](ComparisonPlan& p) { p.sets = {"D1", "D1"}; });
  refused([](ComparisonPlan& p) { p.shard = 3, p.shards = 2; });
  refused([](ComparisonPlan& p) { p.budget.restarts = -1; });
}

// ---- parameters

TEST(Sweep, IsEvenlySpacedAndRefusesWhatMakesNoSense) {
  const ParameterSweep log = parameterSweep("dls.lambda=0.01:1:log9");
  EXPECT_EQ(log.values,
            (std::vector<double>{0.01, 0.01778, 0.03162, 0.05623, 0.1, 0.1778, 0.3162, 0.5623, 1.0}));
  EXPECT_EQ(parameterSweep("dls.lambda=0:1:lin5").values, (std::vector<double>{0.0, 0.25, 0.5, 0.75, 1.0}));
  EXPECT_EQ(parameterSweep("l-bfgs.memory=1:4:log9").values, (std::vector<double>{1, 2, 3, 4}));
  for (const char* bad :
       {"dls.lambda=0.01:1", "dls.lambda=0.01:1:9", "dls.lambda=1:0.01:log9", "dls.lambda=0:1:log9",
        "dls.lambda=0.01:1:log1", "dls.lambda=0.01:20:log9", "dls.mu=0.01:1:log9", "dls=0.01:1:log9",
        "dls.lambda=0.01:1:log", "dls.lambda=:1:log9", ""})
    EXPECT_THROW(parameterSweep(bad), std::invalid_argument) << bad;
}

TEST(Sweep, SettingsAndGridsReachTheSolversTheyName) {
  using Texts = std::vector<std::string>;
  EXPECT_EQ(withParameters({"dls", "ccd"}, {"dls.lambda=0.1"}), (Texts{"dls[lambda=0.1]", "ccd"}));
  EXPECT_EQ(withParameters({"ccd"}, {}, {"dls.lambda=0.1:0.3:lin3"}),
            (Texts{"ccd", "dls[lambda=0.1]", "dls[lambda=0.2]", "dls[lambda=0.3]"}));
  EXPECT_EQ(withParameters({}, {"dls.largest-step=1"}, {"dls.lambda=0.05:0.1:lin2"}),
            (Texts{"dls[largest-step=1]", "dls[lambda=0.1,largest-step=1]"}));
  EXPECT_EQ(withParameters({}, {}, {"dls.lambda=0.1:0.2:lin2", "dls.largest-step=1:2:lin2"}).size(), 4u);
  EXPECT_THROW(withParameters({"ccd"}, {"dls.lambda=0.1"}), std::invalid_argument);
}

TEST_F(Comparison, ParametersStandInTheRecordOfEveryResult) {
  ComparisonPlan p{
      .sets = {"D1"},
      .solvers = withParameters({"ccd"}, {}, {"dls.lambda=0.05:1:log3", "dls.largest-step=0.5:1:lin2"}),
      .problems = 8,
      .seed = 3};
  p.budget.maxIterations = 40;
  ASSERT_EQ(p.solvers.size(), 7u);
  run(p, "a");
  const Results results = readResults(path("a"));
  EXPECT_EQ(results.rows.size(), 7u * 8u);
  EXPECT_EQ(results.rows.back().solver, "dls[lambda=1,largest-step=1]");
  EXPECT_EQ(valuesOf(results.record, "parameters").back(),
            "dls[lambda=1,largest-step=1]: lambda=1 largest-step=1");
  EXPECT_NE(readFile(path("a") + "/solvers.csv").find("\"dls[lambda=1,largest-step=1]\",lambda,1,0.05,m,"),
            std::string::npos);
  // another value is another comparison, also where only a default was left out before
  ComparisonPlan other = p;
  other.solvers.back() = "dls[lambda=2,largest-step=1]";
  EXPECT_THROW(run(other, "a"), std::invalid_argument);
  // answers differ between values, and stay what one value gives alone
  ComparisonPlan alone = p;
  alone.solvers = {"dls[lambda=1,largest-step=1]"};
  run(alone, "alone");
  const Results one = readResults(path("alone"));
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(one.rows[i].residual, results.rows[48 + i].residual);
    EXPECT_EQ(one.rows[i].counters.iterations, results.rows[48 + i].counters.iterations);
  }
  // interrupted and sharded runs lead to the same
  run(p, "cut", 20);
  run(p, "cut");
  expectSameAnswers("a", "cut");
  std::vector<std::string> shards;
  for (int k = 1; k <= 2; ++k) {
    ComparisonPlan part = p;
    part.shard = k;
    part.shards = 2;
    run(part, "part" + std::to_string(k));
    shards.push_back(path("part" + std::to_string(k)));
  }
  mergeComparisons(shards, path("joined"));
  expectSameAnswers("a", "joined");
  writeReport(path("a"), results,
              {.version = "test", .commandLine = "", .colour = [](const std::string&) { return "#336699"; }});
  const std::string html = readFile(path("a") + "/report.html");
  if (html.find("gnuplot was not found") == std::string::npos) {
    EXPECT_NE(html.find("dls.lambda: Damping"), std::string::npos);      // a curve over three values
    EXPECT_EQ(html.find("dls.largest-step: Steps"), std::string::npos);  // two make none
  }
  EXPECT_NE(readFile(path("a") + "/summary.json").find("\"largest-step\": 1.0"), std::string::npos);
}

TEST_F(Comparison, ASetMayBeAskedOnceMoreWithRestarts) {
  ComparisonPlan p{.sets = {"D1", "D1[restarts=5]"}, .solvers = {"lm-chan"}, .problems = 20, .seed = 3};
  run(p, "a");
  const Results results = readResults(path("a"));
  EXPECT_EQ(results.sets[0].checksum, results.sets[1].checksum);
  int single = 0, restarted = 0;
  for (const ResultRow& row : results.rows) (row.set == "D1" ? single : restarted) += row.solved;
  EXPECT_GT(restarted, single);
  for (const char* bad : {"D1[", "D1[restarts]", "D1[restarts=-1]", "D1[restarts=x]", "D9[restarts=5]"})
    EXPECT_THROW(setChoice(bad), std::invalid_argument) << bad;
}

TEST_F(Comparison, TheReportIsSelfContainedAndSaysWhatWasUnsupported) {
  run(plan(), "a");
  writeReport(path("a"), readResults(path("a")),
              {.version = "test", .commandLine = "gelenk compare <x>", .colour = [](const std::string&) {
                 return "#336699";
               }});
  const std::string html = readFile(path("a") + "/report.html"),
                    summary = readFile(path("a") + "/summary.json");
  EXPECT_NE(html.find("unsupported"), std::string::npos);
  EXPECT_NE(html.find("gelenk compare &lt;x&gt;"), std::string::npos);
  EXPECT_NE(html.find("solvers compared on "), std::string::npos);  // which model
  EXPECT_EQ(html.find("src="), std::string::npos);                  // nothing is fetched from elsewhere
  EXPECT_EQ(html.find("href=\"http"), std::string::npos);
  // The maps of where problems are hard: a name over each, whole labels at the axes.
  const std::string maps = readFile(path("a") + "/plots/D1-hardness.svg");
  for (const char* solver : {"dls", "lm-gain-ratio", "evolution"})
    EXPECT_NE(maps.find(">" + std::string(solver) + "<"), std::string::npos) << solver;
  EXPECT_EQ(maps.find(">two-link<"), std::string::npos);  // it does none of these problems
  int axes = 0;
  for (std::size_t at = maps.find(">limit margin<"); at != std::string::npos;
       at = maps.find(">limit margin<", at + 1), ++axes) {
    const std::string mark = "translate(";
    EXPECT_GT(std::stod(maps.substr(maps.rfind(mark, at) + mark.size())), 12.0);  // its height of type
  }
  EXPECT_EQ(axes, 3);
  for (const char* word :
       {"mcnemar_p", "wilson_95", "bootstrap_95", "expected_running_time", "p99", "jitter", "checksums"})
    EXPECT_NE(summary.find(word), std::string::npos) << word;
}

}  // namespace
}  // namespace gelenk
