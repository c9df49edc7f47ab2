// Automatic rigging, everything, by size of the mesh: the figure's body with each triangle cut into four
// until there are enough. Counters: seconds of each stage in the last round; the process's peak memory so
// far.
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <map>

#include "skinning/rigging/auto_rig.h"
#include "skinning/rigging/fit/template_body.h"

namespace gelenk {
namespace {

Mesh cutInFour(const Mesh& mesh) {
  Mesh out{.positions = mesh.positions, .triangles = {}};
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [found, fresh] = middles.emplace(std::minmax(a, b), static_cast<int>(out.positions.size()));
    if (fresh) out.positions.push_back(0.5 * (out.positions[a] + out.positions[b]));
    return found->second;
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    out.triangles.insert(out.triangles.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  return out;
}

const Mesh& bodyOf(std::int64_t triangles) {
  static std::map<std::int64_t, Mesh> made;
  Mesh& mesh = made[triangles];
  if (mesh.triangles.empty()) mesh = humanTemplate().surface;
  while (static_cast<std::int64_t>(mesh.triangles.size()) < triangles) mesh = cutInFour(mesh);
  return mesh;
}

void tellSize(benchmark::State& state, const Mesh& mesh) {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  state.counters["triangles"] = static_cast<double>(mesh.triangles.size());
  state.counters["peakMB"] = static_cast<double>(usage.ru_maxrss) / 1024.0;
}

void Rig(benchmark::State& state) {
  const Mesh& mesh = bodyOf(state.range(0));
  RiggedBody body;
  for (auto _ : state) body = rigBody(mesh);
  for (const RigStage& stage : body.report.stages) state.counters[stage.name] = stage.seconds;
  tellSize(state, mesh);
}
BENCHMARK(Rig)->ArgName("triangles")->Arg(20'000)->Arg(80'000)->Arg(320'000)->Unit(benchmark::kMillisecond);

void WeighAnew(benchmark::State& state) {
  const Mesh& mesh = bodyOf(state.range(0));
  RiggedBody body = rigBody(mesh);
  for (auto _ : state) weigh(mesh, body);
  tellSize(state, mesh);
}
BENCHMARK(WeighAnew)->ArgName("triangles")->Arg(20'000)->Arg(80'000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gelenk
