// The whole picture of the figure at 1280 x 800, as the sandbox draws it: pose upload, shadow, ground, body,
// copy. Time on the wall until the renderer has finished. The label says which renderer that was.
#include <benchmark/benchmark.h>

#ifdef GELENK_GRAPHICS
#include <memory>

#include "apps/render/model_view.h"
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
  const Model model = openModel("figure");
  ModelView view(model);
  Renderer renderer;
  const Viewport viewport{1280, 800};
  const RenderTarget target(viewport.width, viewport.height);
  ViewOptions options;
  options.ground = options.shadow = state.range(0) == 1;
  Camera camera = view.usualCamera(viewport);
  for (auto _ : state) {
    camera.azimuth += 0.01;
    renderer.draw(view.compose(model.skeleton.rest(), options, Theme::Light), camera, viewport,
                  target.framebuffer());
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
