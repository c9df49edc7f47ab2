#include "apps/sandbox/film.h"

#include <fmt/format.h>
#include <unistd.h>

#include <stdexcept>

#include "apps/sandbox/replay.h"
#include "apps/sandbox/sandbox_state.h"
#include "apps/sandbox/view_picture.h"
#include "skinning/gpu/offscreen_context.h"

namespace gelenk {

void filmReplay(const FilmOrder& order) {
  Replay replay = Replay::read(order.replay);
  const OffscreenContext context;
  Sandbox sandbox({.model = order.input,
                   .files = order.files,
                   .width = order.width,
                   .height = order.height,
                   .scale = order.scale,
                   .theme = order.theme,
                   .bare = true});
  if (order.themeIsWanted) sandbox.state().theme() = order.theme;
  ViewPicture target;
  target.resize(order.width, order.height);
  sandbox.state().recorder.start(order.output, order.width, order.height, 0.0);
  InputQueue queue;
  const int frames = replay.length() + 1;
  const bool shown = isatty(STDERR_FILENO);
  for (int i = 0; i < frames && !sandbox.wantsToClose(); ++i) {
    replay.play(i, sandbox, queue);
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
    sandbox.frame({.width = order.width,
                   .height = order.height,
                   .scale = order.scale,
                   .events = queue.take(sandbox.keys())},
                  1.0 / 60.0);
    if (shown) fmt::print(stderr, "\r{}/{}{}", i + 1, frames, i + 1 == frames ? "\n" : "");
  }
  if (!sandbox.state().recorder.isRunning())
    throw std::runtime_error("the film " + order.output + " is not complete");
  sandbox.state().recorder.finish();
}

}  // namespace gelenk
