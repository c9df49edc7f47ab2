// Pose inverse kinematics: ours against Orocos KDL, in one run, every answer judged outside the solvers.
//   pose_benchmark [--problems=N] [--rounds=R] [--robot=NAME] [--no-peers] [--fresh=N] [google-benchmark
//   flags]
// --fresh=N: N fresh targets a robot, counting failures (1000000 in the mark). Means: processor time
// of this thread over all problems, failures included, the least and the median of the rounds; p50 and p99:
// wall time of single solves in one more round, which other programs on the machine may stretch.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <ctime>
#include <fstream>
#include <functional>
#include <random>

#include "kinematics/configuration.h"
#include "kinematics/notation/robots.h"
#include "solvers/problem/judge.h"
#include "solvers/serial/serial_pose.h"

namespace {

using namespace gelenk;
using Clock = std::chrono::steady_clock;

struct Settings {
  int problems = 10'000, rounds = 5, peerProblems = 1'000;
  long fresh = 0;
  std::string robot;
  bool peers = true;
} settings;

/// Processor time of this thread, microseconds.
double processorTime() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e6 + static_cast<double>(t.tv_nsec) * 1e-3;
}

double microseconds(Clock::time_point begin) {
  return std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
}

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

struct ProblemSet {
  Skeleton skeleton;
  std::vector<IkProblem> problems = {};
  std::vector<Eigen::Isometry3d> targets = {};
  std::vector<TipGoal> goals = {};
  std::vector<ChainVector> starts = {};
  std::vector<double> flatStarts = {};
};

/// Reachable: forward kinematics of a random configuration. drag: starts within +-drag rad of it, else
/// anywhere within limits.
void fill(ProblemSet& set, int count, std::uint64_t seed, double drag = 0.0) {
  const Skeleton& skeleton = set.skeleton;
  const int tip = skeleton.jointCount() - 1;
  std::mt19937_64 random(seed);
  for (int i = 0; i < count; ++i) {
    const Eigen::VectorXd solution = randomWithinLimits(skeleton, random);
    const Eigen::Isometry3d target = forwardKinematics(skeleton, solution)[tip];
    IkProblem problem{.skeleton = &skeleton};
    problem.start = randomWithinLimits(skeleton, random);
    if (drag > 0.0) {
      problem.start = solution;
      for (double& q : problem.start) q += drag * (2.0 * uniform01(random) - 1.0);
      problem.start = projectToLimits(skeleton, problem.start);
    }
    problem.goals = {{.kind = GoalKind::Pose,
                      .joint = tip,
                      .target = target.translation(),
                      .orientation = Eigen::Quaterniond(target.linear())}};
    set.targets.push_back(target);
    set.goals.push_back({.target = target.translation(), .orientation = target.linear()});
    set.starts.push_back(problem.start);
    set.flatStarts.insert(set.flatStarts.end(), problem.start.begin(), problem.start.end());
    set.problems.push_back(std::move(problem));
  }
}

struct Row {
  std::string name;
  int count = 0, solved = 0;
  std::vector<double> means = {};   // us a solve, one a round
  std::vector<double> single = {};  // us, one a problem
};

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<size_t>(share * static_cast<double>(values.size())))];
}

void print(const Row& row) {
  fmt::print("{:<34}{:>8}{:>10.3f}{:>12.3f}{:>10.3f}", row.name, row.count, 100.0 * row.solved / row.count,
             quantile(row.means, 0.0), quantile(row.means, 0.5));
  if (row.single.empty())
    fmt::print("{:>10}{:>10}\n", "-", "-");
  else
    fmt::print("{:>10.2f}{:>10.2f}\n", quantile(row.single, 0.5), quantile(row.single, 0.99));
}

/// solveOne(i) returns the configuration for problem i.
Row measure(std::string name, const ProblemSet& set, int count, int rounds,
            const std::function<Eigen::VectorXd(int)>& solveOne) {
  Row row{.name = std::move(name), .count = count};
  for (int i = 0; i < count; ++i) {
    const auto begin = Clock::now();
    const Eigen::VectorXd q = solveOne(i);
    row.single.push_back(microseconds(begin));
    row.solved += judge(set.problems[i], q).solved;
  }
  for (int round = 0; round < rounds; ++round) {
    const double begin = processorTime();
    for (int i = 0; i < count; ++i) benchmark::DoNotOptimize(solveOne(i));
    row.means.push_back((processorTime() - begin) / count);
  }
  return row;
}

/// Without the copy of q that `measure` needs.
Row measureDirect(std::string name, const ProblemSet& set, const SerialPoseSolver& solver, int rounds) {
  const int count = static_cast<int>(set.problems.size());
  Row row{.name = std::move(name), .count = count};
  for (int i = 0; i < count; ++i) {
    const auto begin = Clock::now();
    const SerialPoseAnswer answer = solver.solve(set.goals[i], set.starts[i]);
    row.single.push_back(microseconds(begin));
    row.solved += judge(set.problems[i], answer.q).solved;
  }
  for (int round = 0; round < rounds; ++round) {
    const double begin = processorTime();
    for (int i = 0; i < count; ++i) benchmark::DoNotOptimize(solver.solve(set.goals[i], set.starts[i]));
    row.means.push_back((processorTime() - begin) / count);
  }
  return row;
}

Row measureBatch(std::string name, const ProblemSet& set, const SerialPoseSolver& solver, int rounds) {
  const int count = static_cast<int>(set.problems.size()), n = solver.chain().n;
  Row row{.name = std::move(name), .count = count};
  std::vector<KernelAnswer> answers(count);
  for (int round = 0; round < rounds; ++round) {
    const double begin = processorTime();
    solver.solveBatch(set.targets, set.flatStarts, answers);
    row.means.push_back((processorTime() - begin) / count);
  }
  for (int i = 0; i < count; ++i)
    row.solved += judge(set.problems[i], Eigen::Map<const Eigen::VectorXd>(answers[i].q, n)).solved;
  return row;
}

void printHeader() {
  fmt::print("{:<34}{:>8}{:>10}{:>12}{:>10}{:>10}{:>10}\n", "solver", "solves", "solved %", "mean us min",
             "median", "p50", "p99");
}

void compareOn(const Robot& robot) {
  ProblemSet set{.skeleton = toSkeleton(robot.table())};
  fill(set, settings.problems, 20'240'601);
  const SerialChain chain = extractSerialChain(set.skeleton, set.skeleton.jointCount() - 1).chain;
  fmt::print("\n{}: {} dofs, {} reachable poses, random starts, 1e-6 m and 1e-6 rad, limits, seed 20240601\n",
             robot.name, chain.n, settings.problems);
  printHeader();
  double ours = 0.0;
  for (const InstructionSet isa : {InstructionSet::Baseline, InstructionSet::Avx2, InstructionSet::Avx512}) {
    if (!isAvailable(isa)) continue;
    SerialPoseSolver solver(chain, isa);
    const Row plain =
        measureDirect(fmt::format("serial-pose, {}", toString(isa)), set, solver, settings.rounds);
    print(plain);
    ours = quantile(plain.means, 0.0);
    print(measureBatch(fmt::format("  batch, {}", toString(isa)), set, solver, settings.rounds));
    if (!solver.buildSeedTable()) continue;
    print(measureDirect(fmt::format("  table, {}", toString(isa)), set, solver, settings.rounds));
    print(measureBatch(fmt::format("  table and batch, {}", toString(isa)), set, solver, settings.rounds));
    if (isa == bestInstructionSet())
      fmt::print("  (table: {:.3f} s to build, {:.2f} MB, {:.0f} % of the cells filled)\n",
                 solver.seedTable()->seconds(), static_cast<double>(solver.seedTable()->bytes()) * 1e-6,
                 100.0 * solver.seedTable()->filledCells());
  }
  const Budget budget{.maxIterations = 200, .maxSeconds = 5e-3, .restarts = 4000};
  const auto throughInterface = [&](const std::string& name, int count, int rounds) {
    const auto solver = makeSolver(name);
    solver->prepare(set.skeleton);
    return measure(name + ", solver interface", set, count, rounds,
                   [&](int i) { return solver->solve(set.problems[i], budget, TraceLevel::Off).q; });
  };
  print(throughInterface("serial-pose", settings.problems, settings.rounds));
#ifdef GELENK_HAS_KDL
  if (settings.peers) {
    double best = 1e300;
    for (const char* name : {"kdl-nr", "kdl-nr-jl", "kdl-lma"}) {
      const Row row = throughInterface(name, std::min(settings.problems, settings.peerProblems), 1);
      print(row);
      if (row.name.find("kdl-nr,") == std::string::npos) best = std::min(best, quantile(row.means, 0.0));
    }
    fmt::print("KDL's best of NR_JL and LMA takes {:.0f} times as long as serial-pose without table.\n",
               best / ours);
  }
#endif
}

void drag() {
  ProblemSet set{.skeleton = toSkeleton(robotTable("panda"))};
  fill(set, settings.problems, 7, 0.15);
  const SerialChain chain = extractSerialChain(set.skeleton, set.skeleton.jointCount() - 1).chain;
  fmt::print("\npanda, drag regime: start = solution +- 0.15 rad, {} poses, seed 7\n", settings.problems);
  printHeader();
  const SerialPoseSolver solver(chain);
  print(measureDirect(fmt::format("serial-pose, {}", toString(bestInstructionSet())), set, solver,
                      settings.rounds));
  int jumps = 0;
  for (size_t i = 0; i < set.goals.size(); ++i)
    jumps += (solver.solve(set.goals[i], set.starts[i]).q - set.starts[i]).cwiseAbs().maxCoeff() > 0.5;
  fmt::print("answers that jump more than 0.5 rad: {} of {}\n", jumps, set.goals.size());
}

void freshTargets(const Robot& robot) {
  const Skeleton skeleton = toSkeleton(robot.table());
  const SerialPoseSolver solver(extractSerialChain(skeleton, skeleton.jointCount() - 1).chain);
  long failures = 0, done = 0;
  for (std::uint64_t seed = 1000; done < settings.fresh; ++seed) {
    ProblemSet set{.skeleton = skeleton};
    fill(set, static_cast<int>(std::min(10'000L, settings.fresh - done)), seed);
    for (size_t i = 0; i < set.goals.size(); ++i)
      failures += !judge(set.problems[i], solver.solve(set.goals[i], set.starts[i]).q).solved;
    done += static_cast<long>(set.goals.size());
  }
  fmt::print("\n{}, {} fresh targets (seeds from 1000, 10,000 each): {} failures\n", robot.name, done,
             failures);
}

void BM_PandaFrameAndJacobian(benchmark::State& state) {
  const Skeleton skeleton = toSkeleton(robotTable("panda"));
  const SerialPoseSolver solver(extractSerialChain(skeleton, skeleton.jointCount() - 1).chain);
  ChainVector q = ChainVector::Constant(7, 0.3);
  ChainJacobian J(6, 7);
  for (auto _ : state) {
    q[0] += 1e-3;
    benchmark::DoNotOptimize(solver.frameAndJacobian(q, J));
    benchmark::DoNotOptimize(J);
  }
}
BENCHMARK(BM_PandaFrameAndJacobian)->Repetitions(5)->ReportAggregatesOnly();

}  // namespace

int main(int argc, char** argv) {
  std::vector<char*> rest{argv[0]};
  for (int i = 1; i < argc; ++i) {
    const std::string a = argv[i];
    const auto value = [&] { return a.substr(a.find('=') + 1); };
    if (a.starts_with("--problems="))
      settings.problems = std::stoi(value());
    else if (a.starts_with("--rounds="))
      settings.rounds = std::stoi(value());
    else if (a.starts_with("--robot="))
      settings.robot = value();
    else if (a.starts_with("--peer-problems="))
      settings.peerProblems = std::stoi(value());
    else if (a.starts_with("--fresh="))
      settings.fresh = std::stol(value());
    else if (a == "--no-peers")
      settings.peers = false;
    else
      rest.push_back(argv[i]);
  }
  int restCount = static_cast<int>(rest.size());
  benchmark::Initialize(&restCount, rest.data());
  if (benchmark::ReportUnrecognizedArguments(restCount, rest.data())) return 1;
  fmt::print("{}; kernels chosen here: {}\n", processor(), toString(bestInstructionSet()));
  for (const Robot& robot : robots()) {
    if (robot.name == "scara" || (!settings.robot.empty() && settings.robot != robot.name)) continue;
    settings.fresh > 0 ? freshTargets(robot) : compareOn(robot);
  }
  if (settings.fresh > 0) return 0;
  drag();
  fmt::print("\n");
  benchmark::RunSpecifiedBenchmarks();
}
