// Muscle layers on the CPU, one thread, double precision: nanoseconds a vertex with position and normal.
#include <benchmark/benchmark.h>

#include <algorithm>

#include "skinning/muscles/muscle_control.h"
#include "tests/skinning/muscles/resting_arm.h"

namespace gelenk {
namespace {

struct BentArm {
  Skeleton skeleton = testing::arm(0.8);
  Frames rest = restFrames(skeleton);
  MuscleRig rig{bindMuscles(testing::tube(skeleton), {makeLimb(skeleton, rest, "arm", {1, 2, 3})}, rest),
                rest};
  Frames frames = bent();
  std::vector<LimbPose> limbs = rig.pose(frames);

  /// Vertices that the volumes carry; the others follow the limb's ends.
  std::size_t onVolumes() const {
    return std::ranges::count_if(rig.body().vertices,
                                 [](const LimbVertex& vertex) { return vertex.volume >= 0; });
  }

  Frames bent() const {
    Eigen::VectorXd q = skeleton.rest();
    q[skeleton.qIndex(2)] = 1.9;
    return forwardKinematics(skeleton, q);
  }
};

void report(benchmark::State& state, std::size_t vertices) {
  state.counters["per_vertex"] =
      benchmark::Counter(static_cast<double>(state.iterations() * vertices),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void sixtyFourPoints(benchmark::State& state) {
  const BentArm arm;
  std::vector<FfdLattice> lattices;
  for (int v = 0; v < arm.limbs[0].volumeCount(); ++v) {
    const FfdPlane* planes = &arm.limbs[0].planes[3 * v];
    lattices.push_back(latticeOf({planes[0], planes[1], planes[2], planes[3]}));
  }
  for (auto _ : state)
    for (const LimbVertex& vertex : arm.rig.body().vertices) {
      if (vertex.volume < 0) continue;
      const FfdSample at = lattices[vertex.volume].evaluate(vertex.uvw);
      benchmark::DoNotOptimize(at.position);
      benchmark::DoNotOptimize(deformedNormal(at, vertex.normal));
    }
  report(state, arm.onVolumes());
}
BENCHMARK(sixtyFourPoints);

void affinePlanes(benchmark::State& state) {
  const BentArm arm;
  for (auto _ : state)
    for (const LimbVertex& vertex : arm.rig.body().vertices) {
      if (vertex.volume < 0) continue;
      const FfdSample at = arm.limbs[0].evaluate(vertex.volume, vertex.uvw);
      benchmark::DoNotOptimize(at.position);
      benchmark::DoNotOptimize(deformedNormal(at, vertex.normal));
    }
  report(state, arm.onVolumes());
}
BENCHMARK(affinePlanes);

void affinePlanesPositionOnly(benchmark::State& state) {
  const BentArm arm;
  for (auto _ : state)
    for (const LimbVertex& vertex : arm.rig.body().vertices)
      if (vertex.volume >= 0) benchmark::DoNotOptimize(arm.limbs[0].position(vertex.volume, vertex.uvw));
  report(state, arm.onVolumes());
}
BENCHMARK(affinePlanesPositionOnly);

void wholeSkinWithLayers(benchmark::State& state) {
  const BentArm arm;
  SkinnedVertices out;
  for (auto _ : state) {
    skinWithMuscles(arm.rig.body(), arm.frames, arm.limbs, out);
    benchmark::DoNotOptimize(out.positions.data());
  }
  report(state, arm.rig.body().vertices.size());
}
BENCHMARK(wholeSkinWithLayers);

void linearBlendingAlone(benchmark::State& state) {
  const BentArm arm;
  SkinnedVertices out;
  for (auto _ : state) {
    linearBlendSkin(arm.rig.body().skin, arm.frames, out);
    benchmark::DoNotOptimize(out.positions.data());
  }
  report(state, arm.rig.body().vertices.size());
}
BENCHMARK(linearBlendingAlone);

void poseWithVolumeRule(benchmark::State& state) {
  const BentArm arm;
  for (auto _ : state) benchmark::DoNotOptimize(arm.rig.pose(arm.frames));
}
BENCHMARK(poseWithVolumeRule);

}  // namespace
}  // namespace gelenk
