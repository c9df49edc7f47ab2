// Chains of unit bones with ball joints: time and success of FABRIK, the ball-chain LM and CCD.
//   characters_benchmark [google-benchmark flags]
// 200 targets uniform in the ball of the chain's length, tolerance 0.01 bone; every start is the same
// slightly bent chain (bends of 0.1 rad about alternating axes). The table's times are wall time of single
// solves; "points" are the direct functions with rotations recovered where the method has them, "interface"
// the solver interface, judged by forward kinematics.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <random>

#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "solvers/methods/ball_chain.h"
#include "solvers/methods/fabrik.h"
#include "solvers/problem/judge.h"

namespace {

using namespace gelenk;
using Clock = std::chrono::steady_clock;
using Eigen::Quaterniond;
using Eigen::Vector3d;

struct Setting {
  int bones;
  std::vector<Vector3d> start, targets;
  Skeleton skeleton;
  Eigen::VectorXd q;
};

Setting makeSetting(int bones) {
  Setting s{.bones = bones, .start = {}, .targets = {}, .skeleton = {}, .q = {}};
  std::vector<Joint> joints;
  for (int i = 0; i <= bones; ++i) {
    Joint joint{.name = "joint" + std::to_string(i), .parent = i - 1, .ball = i < bones};
    if (i > 0) joint.parentFromZero.translation().z() = 1.0;
    joints.push_back(joint);
  }
  s.skeleton = Skeleton(joints);
  s.q = neutral(s.skeleton);
  for (int i = 0; i < bones; ++i)
    setBallRotation(s.skeleton, s.q, i,
                    Quaterniond(Eigen::AngleAxisd(0.1, i % 2 ? Vector3d::UnitX() : Vector3d::UnitY())));
  for (const Eigen::Isometry3d& frame : forwardKinematics(s.skeleton, s.q))
    s.start.push_back(frame.translation());
  std::mt19937_64 random(200);
  while (s.targets.size() < 200) {
    const Vector3d p(2.0 * uniform01(random) - 1.0, 2.0 * uniform01(random) - 1.0,
                     2.0 * uniform01(random) - 1.0);
    if (p.norm() < 1.0) s.targets.push_back(p * bones);
  }
  return s;
}

template <typename Solve>
void row(const char* name, const Setting& setting, Solve&& solve) {
  std::vector<double> best(setting.targets.size(), 1e300);
  int solved = 0;
  for (int round = 0; round < 5; ++round) {
    solved = 0;
    for (size_t i = 0; i < setting.targets.size(); ++i) {
      const auto begin = Clock::now();
      const bool reached = solve(setting.targets[i]);
      best[i] = std::min(best[i], std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
      solved += reached;
    }
  }
  std::sort(best.begin(), best.end());
  fmt::print("{:<28}{:>6}{:>6}/200{:>12.2f}{:>12.2f}{:>12.2f}\n", name, setting.bones, solved, best[100],
             best[190], best[199]);
}

void table() {
  fmt::print(
      "200 targets, 0.01 bone; microseconds, the least of 5 rounds a "
      "target\n{:<28}{:>6}{:>10}{:>12}{:>12}{:>12}\n",
      "method", "bones", "solved", "median", "p95", "max");
  for (const int bones : {10, 40}) {
    const Setting s = makeSetting(bones);
    std::vector<Vector3d> points;
    std::vector<Quaterniond> rotations(bones);
    row("FABRIK, points", s, [&](const Vector3d& t) {
      points = s.start;
      return fabrikPoints(points, t, 0.01, 1000).distance <= 0.01;
    });
    row("ball-chain LM, points", s, [&](const Vector3d& t) {
      points = s.start;
      std::fill(rotations.begin(), rotations.end(), Quaterniond::Identity());
      return solveBallChain(points, rotations, t, 0.01, 1000).distance <= 0.01;
    });
    for (const char* name : {"fabrik", "ball-chain", "ccd", "dls"}) {
      const auto solver = makeSolver(name);
      IkProblem problem{.skeleton = &s.skeleton, .start = s.q};
      problem.goals = {{.joint = bones}};
      problem.positionTolerance = 0.01;
      row((std::string(name) + ", interface").c_str(), s, [&](const Vector3d& t) {
        problem.goals[0].target = t;
        return judge(problem, solver->solve(problem, {.maxIterations = 1000}, TraceLevel::Off).q).solved;
      });
    }
  }
}

void BM_Fabrik(benchmark::State& state) {
  const Setting s = makeSetting(static_cast<int>(state.range(0)));
  std::vector<Vector3d> points;
  size_t i = 0;
  for (auto _ : state) {
    points = s.start;
    benchmark::DoNotOptimize(fabrikPoints(points, s.targets[i++ % 200], 0.01, 1000));
  }
}
BENCHMARK(BM_Fabrik)->Arg(10)->Arg(40);

void BM_BallChain(benchmark::State& state) {
  const Setting s = makeSetting(static_cast<int>(state.range(0)));
  std::vector<Vector3d> points;
  size_t i = 0;
  for (auto _ : state) {
    points = s.start;
    benchmark::DoNotOptimize(solveBallChain(points, {}, s.targets[i++ % 200], 0.01, 1000));
  }
}
BENCHMARK(BM_BallChain)->Arg(10)->Arg(40);

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  table();
  benchmark::RunSpecifiedBenchmarks();
}
