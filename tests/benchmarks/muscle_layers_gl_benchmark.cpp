// Muscle layers in the vertex shader against plain linear blend skinning: upload of the pose, every vertex
// once, and the wait for its end. The label says what "GPU" means: on llvmpipe it is the same processor.
// Nothing is drawn.
#include <benchmark/benchmark.h>

#ifdef GELENK_GRAPHICS
#include <memory>

#include "apps/commands/muscle_report.h"
#include "kinematics/configuration.h"
#include "kinematics/notation/mannequin.h"
#include "skinning/bodies/mannequin_body.h"
#include "skinning/gpu/offscreen_context.h"
#include "skinning/gpu/skinned_mesh_gl.h"
#include "skinning/io/skin_cache.h"
#include "skinning/muscles/muscle_control.h"
#include "tests/skinning/muscles/resting_arm.h"

namespace gelenk {
namespace {

struct LayeredBody {
  Frames frames;
  std::unique_ptr<MuscleRig> rig;
};

/// The figure with four limbs: a third of its vertices is on a layer.
LayeredBody figureBody() {
  const Skeleton skeleton = mannequin();
  const Frames rest = restFrames(skeleton);
  const Skin skin = cachedSkin(cacheFolder(), "figure", mannequinSkinKey(skeleton),
                               [&] { return makeMannequinSkin(skeleton); });
  LayeredBody body{
      .frames = rest,
      .rig = std::make_unique<MuscleRig>(bindMuscles(skin, standardLimbs(skeleton, rest), rest), rest)};
  Eigen::VectorXd q = skeleton.rest();
  for (const char* joint : {"lowerarm_l", "lowerarm_r", "calf_l", "calf_r"})
    q[skeleton.qIndex(skeleton.jointIndex(joint))] += 1.0;
  body.frames = forwardKinematics(skeleton, q);
  return body;
}

/// A tube, every vertex of which is on a layer.
LayeredBody armBody() {
  const Skeleton skeleton = testing::arm(0.8);
  const Frames rest = restFrames(skeleton);
  Skin skin = testing::tube(skeleton);
  Mesh& mesh = skin.mesh;
  for (int i = 0; i < 4; ++i) {  // the same 16 times: 23,040 vertices
    const int count = static_cast<int>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), mesh.positions.begin(), mesh.positions.begin() + count);
    mesh.normals.insert(mesh.normals.end(), mesh.normals.begin(), mesh.normals.begin() + count);
    skin.influences.insert(skin.influences.end(), skin.influences.begin(), skin.influences.begin() + count);
  }
  LayeredBody body{.frames = rest,
                   .rig = std::make_unique<MuscleRig>(
                       bindMuscles(skin, {makeLimb(skeleton, rest, "arm", {1, 2, 3})}, rest), rest)};
  Eigen::VectorXd q = skeleton.rest();
  q[skeleton.qIndex(2)] = 1.9;
  body.frames = forwardKinematics(skeleton, q);
  return body;
}

enum Way { LinearBlend, Layers, OneSculpted, AllSculpted };

void vertexStage(benchmark::State& state, LayeredBody (*make)(), Way way) {
  std::unique_ptr<OffscreenContext> context;
  try {
    context = std::make_unique<OffscreenContext>();
  } catch (const std::runtime_error& error) {
    return state.SkipWithError(error.what());
  }
  LayeredBody body = make();
  const std::vector<Eigen::Vector3d> sculpted(16, Eigen::Vector3d(1e-3, 0.0, 0.0));
  if (way == OneSculpted)
    body.rig->controls()[0].sculpted[0].plane2.displacement = sculpted;  // one muscle of one limb
  if (way == AllSculpted)
    for (MuscleControl& control : body.rig->controls())
      for (MuscleState& muscle : control.sculpted)
        muscle.plane2.displacement = muscle.plane4.displacement = sculpted;
  const MuscleSkin& skin = body.rig->body();
  SkinnedMeshGl mesh(skin);
  mesh.setSculpture(*body.rig);
  SkinPose pose;
  if (way == LinearBlend)
    poseSkin(skin.skin, body.frames, pose);
  else
    poseSkin(skin, body.frames, body.rig->pose(body.frames), pose);
  FeedbackSkinning skinning(mesh, pose);
  for (auto _ : state) {
    skinning.run(pose);
    glFinish();
  }
  int layered = 0;
  for (const LimbVertex& vertex : skin.vertices) layered += vertex.limb >= 0;
  state.counters["vertices"] = mesh.vertexCount();
  state.counters["on_layers"] = layered;
  state.SetLabel(glRenderer());
}

/// An edit: the control points of one muscle move, every vertex's share is computed and uploaded.
void edit(benchmark::State& state) {
  std::unique_ptr<OffscreenContext> context;
  try {
    context = std::make_unique<OffscreenContext>();
  } catch (const std::runtime_error& error) {
    return state.SkipWithError(error.what());
  }
  LayeredBody body = figureBody();
  SkinnedMeshGl mesh(body.rig->body());
  double shift = 0.0;
  for (auto _ : state) {
    body.rig->controls()[0].sculpted[0].plane2.displacement.assign(16,
                                                                   Eigen::Vector3d(shift += 1e-6, 0.0, 0.0));
    mesh.setSculpture(*body.rig);
    glFinish();
  }
}
BENCHMARK(edit)->Unit(benchmark::kMicrosecond)->UseRealTime();

BENCHMARK_CAPTURE(vertexStage, figure_lbs, figureBody, LinearBlend)
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(vertexStage, figure_layers, figureBody, Layers)
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(vertexStage, figure_one_sculpted, figureBody, OneSculpted)
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(vertexStage, figure_all_sculpted, figureBody, AllSculpted)
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(vertexStage, arm_lbs, armBody, LinearBlend)->Unit(benchmark::kMicrosecond)->UseRealTime();
BENCHMARK_CAPTURE(vertexStage, arm_layers, armBody, Layers)->Unit(benchmark::kMicrosecond)->UseRealTime();
BENCHMARK_CAPTURE(vertexStage, arm_one_sculpted, armBody, OneSculpted)
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(vertexStage, arm_all_sculpted, armBody, AllSculpted)
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

}  // namespace
}  // namespace gelenk
#endif
