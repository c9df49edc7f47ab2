// Linear blend skinning on the CPU (double precision, with normals) and in the vertex shader. What "GPU"
// means is in the label: on llvmpipe it is the same processor.
#include <benchmark/benchmark.h>

#include <memory>
#include <optional>

#include "kinematics/configuration.h"
#include "skinning/blend/linear_blend.h"
#ifdef GELENK_GRAPHICS
#include "skinning/gpu/offscreen_context.h"
#include "skinning/gpu/skinned_mesh_gl.h"
#endif
#include "tests/gpu/test_bodies.h"

namespace gelenk {
namespace {

/// A chain of 60 joints and 34,000 vertices, as large as the figure, bent a little. Half of its vertices have
/// two influences.
struct Body {
  testing::Arm arm = testing::arm(60, 0.03, 0.05, 17, 33);
  Frames frames;
  Body() {
    std::mt19937_64 random(1);
    frames = forwardKinematics(arm.skeleton, testing::bent(arm.skeleton, random, 0.3));
  }
};
const Body& body() {
  static const Body made;
  return made;
}

void reportPerVertex(benchmark::State& state, std::size_t vertices) {
  state.counters["vertices"] = static_cast<double>(vertices);
  state.counters["per_vertex"] =
      benchmark::Counter(static_cast<double>(vertices),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void CpuSkinning(benchmark::State& state) {
  SkinnedVertices out;
  for (auto _ : state) {
    linearBlendSkin(body().arm.skin, body().frames, out);
    benchmark::DoNotOptimize(out.positions.data());
    benchmark::ClobberMemory();
  }
  reportPerVertex(state, out.positions.size());
}
BENCHMARK(CpuSkinning)->Unit(benchmark::kMicrosecond);

#ifdef GELENK_GRAPHICS
/// Upload of the pose, skinning of every vertex in the shader, and the wait for its end; the vertices stay in
/// GPU memory.
void GpuSkinning(benchmark::State& state) {
  std::unique_ptr<OffscreenContext> context;
  try {
    context = std::make_unique<OffscreenContext>();
  } catch (const std::runtime_error& error) {
    return state.SkipWithError(error.what());
  }
  const SkinnedMeshGl mesh(body().arm.skin);
  SkinPose pose = poseSkin(body().arm.skin, body().frames);
  FeedbackSkinning skinning(mesh, pose);
  for (auto _ : state) {
    poseSkin(body().arm.skin, body().frames, pose);
    skinning.run(pose);
    glFinish();
  }
  reportPerVertex(state, mesh.vertexCount());
  state.SetLabel(glRenderer());
}
BENCHMARK(GpuSkinning)->Unit(benchmark::kMicrosecond)->UseRealTime();
#endif

}  // namespace
}  // namespace gelenk
