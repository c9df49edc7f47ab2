// The whole picture of the figure at 1280 x 800, as the sandbox draws it: pose upload, shadow, ground, body,
// copy. Time on the wall until the renderer has finished. The label says which renderer that was.
#include <benchmark/benchmark.h>

#ifdef GELENK_GRAPHICS
#include <memory>

#include "apps/render/scene_view.h"
#include "skinning/gpu/offscreen_context.h"
#include "skinning/gpu/render_target.h"

namespace gelenk {
namespace {

void FigurePicture(benchmark::State& state) {
  std::unique_ptr<OffscreenContext> context;
  try {
    context = std::make_unique<OffscreenContext>();
  } catch (const std::runtime_error& error) {
    return state.SkipWithError(error.what());
  }
  Session session(openModel("figure"));
  SceneView view(session);
  view.follow(session, session.frames(), true);
  Renderer renderer;
  const Viewport viewport{1280, 800};
  const RenderTarget target(viewport.width, viewport.height);
  ViewOptions& show = session.view().show;
  show.ground = show.shadow = state.range(0) == 1;
  show.handles = false;
  Camera camera = view.wholeView(session, viewport, view.bounds());
  for (auto _ : state) {
    camera.azimuth += 0.01;
    renderer.draw(view.compose(session), camera, viewport, target.framebuffer());
    glFinish();
  }
  state.SetLabel(glRenderer() + ", " + std::to_string(renderer.samples()) + " samples");
}
BENCHMARK(FigurePicture)
    ->ArgName("ground_and_shadow")
    ->Arg(1)
    ->Arg(0)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace gelenk
#endif
