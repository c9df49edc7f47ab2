// Forward kinematics and twists of the built-in figure, 66 entries of which 53 move.
#include <benchmark/benchmark.h>

#include "kinematics/configuration.h"
#include "kinematics/jacobian.h"
#include "kinematics/notation/mannequin.h"

namespace gelenk {
namespace {

void ForwardKinematicsOfTheFigure(benchmark::State& state) {
  const Skeleton skeleton = mannequin();
  std::mt19937_64 random(1);
  const Eigen::VectorXd q = randomWithinLimits(skeleton, random);
  Frames frames;
  for (auto _ : state) {
    forwardKinematics(skeleton, q, frames);
    benchmark::DoNotOptimize(frames.data());
  }
  state.counters["ns_a_joint"] =
      benchmark::Counter(static_cast<double>(skeleton.jointCount()) * 1e-9,
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(ForwardKinematicsOfTheFigure);

void TwistsOfTheFigure(benchmark::State& state) {
  const Skeleton skeleton = mannequin();
  std::mt19937_64 random(1);
  const Eigen::VectorXd q = randomWithinLimits(skeleton, random);
  const Frames frames = forwardKinematics(skeleton, q);
  Twists twists;
  for (auto _ : state) {
    dofTwists(skeleton, q, frames, twists);
    benchmark::DoNotOptimize(twists.data());
  }
}
BENCHMARK(TwistsOfTheFigure);

}  // namespace
}  // namespace gelenk
