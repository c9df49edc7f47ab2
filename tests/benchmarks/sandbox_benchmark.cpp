// What the sandbox does on the CPU in a frame, apart from drawing: picking the skin under the mouse, and the
// session's step.
#include <benchmark/benchmark.h>

#include "apps/document/model.h"
#include "apps/document/pick.h"
#include "apps/document/session.h"
#include "skinning/blend/linear_blend.h"

namespace gelenk {
namespace {

/// The ray to the chest: 70,000 triangles, front faces only.
void pickTheSkin(benchmark::State& state) {
  const Model model = openModel("figure");
  const SkinnedVertices surface = linearBlendSkin(*model.skin, restFrames(model.skeleton));
  const Camera camera{.target = {0.0, 0.9, 0.0}, .distance = 4.0};
  double x = 440.0;
  for (auto _ : state) {
    x = x < 520.0 ? x + 0.37 : 440.0;
    benchmark::DoNotOptimize(pickSurface(model.skin->mesh.triangles, surface.positions,
                                         rayThroughPixel(camera, {960, 556}, {x, 220.0})));
  }
  state.counters["triangles"] = static_cast<double>(model.skin->mesh.triangles.size());
}
BENCHMARK(pickTheSkin)->Unit(benchmark::kMillisecond);

/// Feet pinned, one hand led on a circle of 10 cm at 1 cm a frame.
void sessionStepWhileDragging(benchmark::State& state) {
  Session session(openModel("figure"));
  const GoalId hand = *session.findGoal("hand_r");
  session.beginDrag(hand);
  const Eigen::Vector3d centre = session.goal(hand).goal.target;
  double angle = 0.0;
  for (auto _ : state) {
    angle += 0.1;
    session.moveDrag(centre + 0.1 * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0));
    session.step();
  }
}
BENCHMARK(sessionStepWhileDragging)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace gelenk
