// Solves timed alike by the native program and in WebAssembly (tests/web/speed_test.py): a line each, its
// name and microseconds a solve. Every portion of the solves is taken several times and its least time
// counts, which other programs on the machine stretch least.
#include <chrono>
#include <cstdio>
#include <functional>

#include "kinematics/notation/robots.h"
#include "solvers/serial/serial_pose.h"
#include "tests/solvers/tree/drag_marks.h"

using namespace gelenk;

namespace {

constexpr int portion = 20, rounds = 9;

void measure(const char* name, int count, const std::function<void()>& begin,
             const std::function<void(int)>& solve) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> least(count / portion, 1e300);
  for (int round = 0; round < rounds; ++round) {
    begin();
    for (std::size_t p = 0; p < least.size(); ++p) {
      const auto start = Clock::now();
      for (int i = 0; i < portion; ++i) solve(static_cast<int>(p) * portion + i);
      least[p] = std::min(least[p], std::chrono::duration<double, std::micro>(Clock::now() - start).count());
    }
  }
  double sum = 0.0;
  for (const double each : least) sum += each;
  std::printf("%s %.3f\n", name, sum / static_cast<double>(least.size()) / portion);
}

void drag(const char* name, bool reachable, double step) {
  const marks::Figure figure;
  std::mt19937_64 random(1);
  constexpr int frames = 1000;
  const marks::Path path = reachable ? marks::reachablePath(figure, random, frames, step)
                                     : marks::wildPath(figure, random, frames, step);
  DragSolver solver(figure.skeleton);
  std::vector<Goal> goals = figure.goals();
  measure(
      name, frames, [&] { solver.reset(figure.start); },
      [&](int i) {
        figure.setTargets(goals, path[i]);
        solver.frame(goals);
      });
}

void pose(const char* name, InstructionSet set) {
  const Skeleton skeleton = toSkeleton(robotTable("panda"));
  const int tip = skeleton.jointCount() - 1;
  const SerialPoseSolver solver(extractSerialChain(skeleton, tip).chain, set);
  std::mt19937_64 random(20'240'601);
  std::vector<TipGoal> goals;
  std::vector<ChainVector> starts;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Isometry3d target = forwardKinematics(skeleton, randomWithinLimits(skeleton, random))[tip];
    goals.push_back({.target = target.translation(), .orientation = target.linear()});
    starts.push_back(randomWithinLimits(skeleton, random));
  }
  int solved = 0;
  measure(
      name, static_cast<int>(goals.size()), [&] { solved = 0; },
      [&](int i) { solved += solver.solve(goals[i], starts[i]).why == Stop::Converged; });
  std::printf("%s-solved %d\n", name, solved);
}

}  // namespace

int main() {
  drag("drag-reachable-1cm", true, 0.01);
  drag("drag-reachable-5cm", true, 0.05);
  drag("drag-unreachable-1cm", false, 0.01);
  drag("drag-unreachable-5cm", false, 0.05);
  pose("panda-pose", bestInstructionSet());
  pose("panda-pose-of-128-bits", InstructionSet::Baseline);
}
