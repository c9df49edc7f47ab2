// Making bodies and weights: the figure cold and from the cache, bodies around skeletons, bone heat.
#include <benchmark/benchmark.h>

#include <filesystem>

#include "kinematics/notation/mannequin.h"
#include "kinematics/notation/planar_chain.h"
#include "skinning/blend/linear_blend.h"
#include "skinning/bodies/body_around.h"
#include "skinning/bodies/mannequin_body.h"
#include "skinning/io/skin_cache.h"
#include "skinning/rigging/bone_heat.h"

namespace gelenk {
namespace {

void FigureSkinCold(benchmark::State& state) {
  const Skeleton figure = mannequin();
  for (auto _ : state) benchmark::DoNotOptimize(makeMannequinSkin(figure));
}
BENCHMARK(FigureSkinCold)->Unit(benchmark::kMillisecond)->UseRealTime();

/// Argument: threads.
void FigureMesh(benchmark::State& state) {
  const BodyShape shape = mannequinShape();
  PolygoniseOptions grid = mannequinGrid();
  grid.threads = static_cast<int>(state.range(0));
  for (auto _ : state)
    state.counters["vertices"] = static_cast<double>(polygonise(shape, grid).positions.size());
}
BENCHMARK(FigureMesh)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

void FigureSkinFromCache(benchmark::State& state) {
  const Skeleton figure = mannequin();
  const std::string path = (std::filesystem::temp_directory_path() / "gelenk-body-benchmark.skin").string();
  writeCachedSkin(path, mannequinSkinKey(figure), makeMannequinSkin(figure));
  for (auto _ : state) benchmark::DoNotOptimize(readCachedSkin(path, mannequinSkinKey(figure)));
  std::filesystem::remove(path);
}
BENCHMARK(FigureSkinFromCache)->Unit(benchmark::kMillisecond)->UseRealTime();

/// The figure's mesh on a coarser grid: about 27 thousand triangles, 64 bones of 53 joints.
void BoneHeat(benchmark::State& state) {
  PolygoniseOptions grid = mannequinGrid();
  grid.cell = 0.0255;
  const Mesh mesh = polygonise(mannequinShape(), grid);
  const Skeleton figure = mannequin();
  const std::vector<Bone> bones = bonesOf(figure, restFrames(figure));
  for (auto _ : state) benchmark::DoNotOptimize(boneHeatWeights(mesh, bones));
  state.counters["triangles"] = static_cast<double>(mesh.triangles.size());
}
BENCHMARK(BoneHeat)->Unit(benchmark::kMillisecond);

void PlanarArmSkin(benchmark::State& state) {
  const Skeleton arm = toSkeleton(lecturePlanarChain());
  for (auto _ : state) benchmark::DoNotOptimize(bodySkin(arm));
}
BENCHMARK(PlanarArmSkin)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace gelenk
