// Complete sets, the nearest solution of a family, and paths. The column CPU counts, on a shared machine.

#include <benchmark/benchmark.h>

#include <Eigen/Eigenvalues>

#include "kinematics/notation/robots.h"
#include "solvers/solutions/path_planner.h"
#include "tests/solvers/solutions/example_arms.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::VectorXd;
using testing::chainOf;
using testing::randomAngles;

/// Targets of random joints; 1,000 of them, seed 4711.
template <class Draw>
std::vector<Isometry3d> targets(const SerialChain& chain, const Draw& draw) {
  std::mt19937_64 random(4711);
  std::vector<Isometry3d> list;
  for (int k = 0; k < 1000; ++k) list.push_back(tipFrame(chain, draw(random)));
  return list;
}

void completeSet(benchmark::State& state, const DhTable& table) {
  const SixJointArm arm(chainOf(table));
  const auto list =
      targets(arm.chain(), [](std::mt19937_64& random) { return VectorXd(randomAngles(random)); });
  ArmSolutions found;
  size_t k = 0, count = 0;
  for (auto _ : state) {
    arm.solve(list[k++ % list.size()], Vector6d::Zero(), found);
    count += found.count;
  }
  state.counters["solutions"] = static_cast<double>(count) / static_cast<double>(state.iterations());
}
BENCHMARK_CAPTURE(completeSet, ur5, robotTable("ur5"));
BENCHMARK_CAPTURE(completeSet, puma560, robotTable("puma560"));
BENCHMARK_CAPTURE(completeSet, jaco2, testing::generalArm("jaco2"));
BENCHMARK_CAPTURE(completeSet, xarm6, testing::generalArm("xarm6"));
BENCHMARK_CAPTURE(completeSet, crx10ia, testing::generalArm("crx10ia"));

/// One elimination of a general arm, in one cut: what the complete set of such an arm asks one to three
/// times.
void elimination(benchmark::State& state) {
  std::mt19937_64 random(4711);
  std::vector<Loop> loops(200);
  for (Loop& loop : loops) {
    const SerialChain chain = chainOf(testing::randomArm(random));
    Isometry3d way = Isometry3d::Identity();
    for (int i = 0; i < 5; ++i) {
      const ChainConstants& C = chain.constants;
      Isometry3d& X = loop.link[i];
      X.setIdentity();
      X.linear() << 1, 0, 0, 0, C.cosAlpha[i + 1], -C.sinAlpha[i + 1], 0, C.sinAlpha[i + 1],
          C.cosAlpha[i + 1];
      X.translation() = X.linear() * Eigen::Vector3d(C.a[i + 1], 0, C.d[i + 1]) * 3.0 / chain.length;
      way = way * Eigen::AngleAxisd(M_PI * (2.0 * uniform01(random) - 1.0), Eigen::Vector3d::UnitZ()) * X;
    }
    loop.link[5] =
        (way * Eigen::AngleAxisd(uniform01(random), Eigen::Vector3d::UnitZ())).inverse(Eigen::Isometry);
  }
  size_t k = 0;
  for (auto _ : state) benchmark::DoNotOptimize(solveGeneralLoop(loops[k++ % loops.size()]));
}
BENCHMARK(elimination);

/// The eigenvalue problem of Manocha and Canny (1994) alone, at its size: eigenvalues and vectors of a
/// general 24 x 24 matrix.
void eigenvalues(benchmark::State& state) {
  std::srand(4711);
  const Eigen::Matrix<double, 24, 24> A = Eigen::Matrix<double, 24, 24>::Random();
  Eigen::EigenSolver<Eigen::Matrix<double, 24, 24>> solver;
  for (auto _ : state) benchmark::DoNotOptimize(solver.compute(A).eigenvalues()[0]);
}
BENCHMARK(eigenvalues);

/// The solution nearest to random joints, within limits.
void nearest(benchmark::State& state, const char* robot) {
  const Skeleton skeleton = toSkeleton(robotTable(robot));
  const SevenJointArm arm(chainOf(robotTable(robot)));
  const auto draw = [&](std::mt19937_64& random) { return randomWithinLimits(skeleton, random); };
  const auto list = targets(arm.chain(), draw);
  std::mt19937_64 random(1);
  std::vector<Vector7d> near;
  for (size_t k = 0; k < list.size(); ++k) near.push_back(draw(random));
  Vector7d best;
  size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(arm.nearest(list[k], near[k], best));
    k = (k + 1) % list.size();
  }
}
BENCHMARK_CAPTURE(nearest, panda, "panda");
BENCHMARK_CAPTURE(nearest, iiwa14, "iiwa14");

/// Every component of the self-motion as a chain of poses.
void selfMotion(benchmark::State& state) {
  const Skeleton skeleton = toSkeleton(robotTable("panda"));
  const SevenJointArm arm(chainOf(robotTable("panda")));
  const auto list =
      targets(arm.chain(), [&](std::mt19937_64& random) { return randomWithinLimits(skeleton, random); });
  size_t k = 0;
  for (auto _ : state) benchmark::DoNotOptimize(arm.selfMotion(list[k++ % list.size()]));
}
BENCHMARK(selfMotion)->Unit(benchmark::kMillisecond);

/// 300 poses that the joints can go.
void path(benchmark::State& state, const char* robot) {
  const Skeleton skeleton = toSkeleton(robotTable(robot));
  const PathPlanner planner(skeleton, skeleton.jointCount() - 1);
  std::mt19937_64 random(51);
  std::vector<std::vector<Isometry3d>> paths(8);
  for (auto& poses : paths) {
    const VectorXd a = 0.5 * (randomWithinLimits(skeleton, random) + skeleton.rest()),
                   b = 0.5 * (randomWithinLimits(skeleton, random) + skeleton.rest());
    for (int k = 0; k < 300; ++k) poses.push_back(tipFrame(planner.chain(), a + (b - a) * (k / 299.0)));
  }
  size_t k = 0, jumps = 0;
  for (auto _ : state) jumps += planner.plan(paths[k++ % paths.size()]).jumps.size();
  state.counters["jumps"] = static_cast<double>(jumps);
}
BENCHMARK_CAPTURE(path, panda, "panda")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(path, ur5, "ur5")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gelenk
