#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>

#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/commands/image.h"
#include "apps/document/notes.h"
#include "apps/sandbox/remote.h"
#include "apps/sandbox/replay.h"
#include "apps/sandbox/sandbox_state.h"
#include "apps/sandbox/window.h"
#include "kinematics/io/text_file.h"
#include "skinning/gpu/offscreen_context.h"
#include "skinning/gpu/render_target.h"

namespace gelenk {
namespace {

struct Arguments {
  SandboxOptions sandbox;
  std::string replay, record, screenshot, status, size = "1280x800", theme = "light";
  double scale = 0.0;
  bool offscreen = false, verbose = false, remote = false;
  int frames = 0;
};

using Clock = std::chrono::steady_clock;
double secondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

void parseSize(Arguments& arguments) {
  int width = 0, height = 0, used = 0;
  if (std::sscanf(arguments.size.c_str(), "%dx%d%n", &width, &height, &used) != 2 ||
      used != static_cast<int>(arguments.size.size()) || width < 320 || height < 240 || width > 16384 ||
      height > 16384)
    throw std::invalid_argument("--size: expected WIDTHxHEIGHT from 320x240 to 16384x16384, found '" +
                                arguments.size + "'");
  arguments.sandbox.width = width;
  arguments.sandbox.height = height;
}

/// Finds out before the work, not after it, that a result cannot be written.
void requireWritableFolder(const std::string& path) {
  if (path.empty()) return;
  const std::string probe = path + ".probe";
  writeFile(probe, "");
  std::filesystem::remove(probe);
}

void tellStart(const Arguments& arguments, Sandbox& sandbox, Clock::time_point begin) {
  sayNotes(arguments.sandbox.model, sandbox.session().model().notes);
  if (arguments.verbose)
    std::fprintf(stderr, "first frame after %.3f s, %s\n", secondsSince(begin), sandbox.renderer().c_str());
}

void startRecording(Sandbox& sandbox, const Arguments& arguments) {
  if (!arguments.record.empty() && !sandbox.startRecording(arguments.record))
    throw std::runtime_error("cannot record " + arguments.record +
                             ": is the program ffmpeg there, and the folder?");
}

/// Frames of 1/60 s into a framebuffer of its own.
void runOffscreen(const Arguments& arguments, std::optional<Replay> replay, Clock::time_point begin) {
  const OffscreenContext context;
  Sandbox sandbox(arguments.sandbox);
  const int width = arguments.sandbox.width, height = arguments.sandbox.height;
  ViewPicture target;
  target.resize(width, height);
  startRecording(sandbox, arguments);
  InputQueue queue;
  std::optional<Remote> remote;
  if (arguments.remote) remote.emplace([] {});
  const int frames = remote && arguments.frames == 0 ? std::numeric_limits<int>::max()
                     : arguments.frames > 0          ? arguments.frames
                     : replay                        ? replay->length() + 1
                                                     : 1;
  for (int i = 0; i < frames && !sandbox.wantsToClose() && !(remote && remote->isOver()); ++i) {
    if (remote) {
      if (i > 0 && arguments.frames == 0) remote->wait(sandbox.rests());
      remote->receive(sandbox);
    }
    if (replay) replay->play(i, sandbox, queue);
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
    sandbox.frame({.width = width,
                   .height = height,
                   .scale = arguments.sandbox.scale,
                   .events = queue.take(sandbox.keys())},
                  1.0 / 60.0);
    if (i == 0) tellStart(arguments, sandbox, begin);
    if (remote) remote->tell(sandbox);
    if (!arguments.status.empty()) writeFile(arguments.status, sandbox.status());
  }
  if (!sandbox.stopRecording()) throw std::runtime_error("the film " + arguments.record + " is not complete");
  if (!arguments.screenshot.empty())
    writePng(arguments.screenshot, {width, height, readPixels(target.framebuffer(), width, height)});
}

void runWindow(const Arguments& arguments, std::optional<Replay> replay, Clock::time_point begin) {
  Window window(arguments.sandbox.width, arguments.sandbox.height, "Gelenk");
  SandboxOptions options = arguments.sandbox;
  Input input = window.poll(arguments.scale);
  options.width = input.width;
  options.height = input.height;
  options.scale = input.scale;
  const bool watched = !replay && arguments.frames == 0;  // by a person
  options.asks = watched && !arguments.remote;
  options.refines = options.refines || watched;
  if (watched) options.preferences = preferencesFile();
  Sandbox sandbox(options);
  startRecording(sandbox, arguments);
  InputQueue queue;
  std::optional<Remote> remote;
  if (arguments.remote) remote.emplace(&Window::wake);
  auto last = Clock::now();
  for (int i = 0; !sandbox.wantsToClose() && !(remote && remote->isOver()) &&
                  (arguments.frames == 0 || i < arguments.frames);
       ++i) {
    // A window at rest is not drawn again. Replays and counted frames go through without a pause.
    if (!replay && arguments.frames == 0 && !window.hasEvents())
      if (const double rests = sandbox.rests(); rests > 0.0) window.wait(rests);
    input = window.poll(arguments.scale, sandbox.keys());
    if (window.takeCloseRequest()) sandbox.requestClose();
    if (remote) remote->receive(sandbox);
    if (replay) {
      replay->play(i, sandbox, queue);
      for (InputEvent& event : queue.take(sandbox.keys())) input.events.push_back(std::move(event));
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    const double since = secondsSince(std::exchange(last, Clock::now()));
    const double passed = std::clamp(since, 1.0 / 240.0, 0.1);
    if (since > passed) sandbox.slept(since - passed);
    sandbox.frame(input, replay ? 1.0 / 60.0 : passed);
    const bool lastFrame = arguments.frames > 0 && i + 1 == arguments.frames;
    if (lastFrame && !arguments.screenshot.empty())
      writePng(arguments.screenshot, {input.width, input.height, readPixels(0, input.width, input.height)});
    window.swap();
    if (remote) remote->tell(sandbox);
    if (i == 0) tellStart(arguments, sandbox, begin);
    if (!arguments.status.empty()) writeFile(arguments.status, sandbox.status());
  }
  if (!sandbox.stopRecording()) throw std::runtime_error("the film is not complete");
}

void run(Arguments arguments) {
  const auto begin = Clock::now();
  parseSize(arguments);
  arguments.sandbox.theme = arguments.theme == "dark" ? Theme::Dark : Theme::Light;
  if (arguments.scale > 0.0) arguments.sandbox.scale = arguments.scale;
  if (!arguments.sandbox.files.weights.empty() && arguments.sandbox.files.skeleton.empty())
    throw std::invalid_argument("--weights needs --skeleton: weights belong to the skeleton's bones");
  requireWritableFolder(arguments.screenshot);
  requireWritableFolder(arguments.status);
  if (!arguments.record.empty() && !arguments.record.ends_with(".mp4") && !arguments.record.ends_with(".gif"))
    throw std::invalid_argument("--record: expected a name ending in .mp4 or .gif, found '" +
                                arguments.record + "'");
  std::optional<Replay> replay;
  if (!arguments.replay.empty()) replay = Replay::read(arguments.replay);
  if (arguments.offscreen)
    runOffscreen(arguments, std::move(replay), begin);
  else
    runWindow(arguments, std::move(replay), begin);
}

}  // namespace

void addSandboxCommand(Command& app) {
  Command command = app.command("sandbox", "Open a model and drag it: the interactive window");
  auto arguments = std::make_shared<Arguments>();
  Arguments& a = *arguments;
  command
      .option("model", a.sandbox.model,
              "Built-in model, model file, OBJ body, scene (.json) or lecture:EXAMPLE")
      .showDefault();
  command.option("--skeleton", a.sandbox.files.skeleton, "Skeleton of an OBJ body");
  command.option("--weights", a.sandbox.files.weights,
                 "Weights of an OBJ body; heat weights where not given");
  command.option("--asf", a.sandbox.files.asf,
                 "ASF skeleton that an OBJ's fitted skeleton is laid on, or of an AMC");
  command.option("--amc", a.sandbox.files.amc, "Motion for the ASF skeleton");
  command.option("--clip", a.sandbox.files.clip,
                 "Which motion of a file that names several; default: the first");
  command
      .option(
          "--up", a.sandbox.files.up,
          "The axis that points up where the format does not say it; default: along which the body stands")
      .oneOf({"y", "z"});
  command.option("--mapping", a.sandbox.files.mapping,
                 "Which bones lie on which joints: lines 'bone ... : joint joint ...'");
  command.option("--replay", a.replay, "Play a file of input, frame by frame (docs/sandbox.md)");
  command.option("--record", a.record, "A film of the window, .mp4 or .gif (needs the program ffmpeg)");
  command.flag("--offscreen", a.offscreen, "Without a window; deterministic");
  command.option("--frames", a.frames, "Stop after so many frames; offscreen: the replay's length by default")
      .positive();
  command.option("--screenshot", a.screenshot, "Write the last frame as PNG");
  command.option("--status", a.status, "Write the state as JSON after every frame");
  command.option("--size", a.size, "Pixels, WIDTHxHEIGHT").showDefault();
  command.option("--scale", a.scale, "Of type and spacing; the monitor's by default").range(0.5, 4.0);
  command.option("--theme", a.theme, "light or dark").oneOf({"light", "dark"}).showDefault();
  command.option("--solver", a.sandbox.solver, "Solver while dragging").showDefault();
  command.option(
      "--skin", a.sandbox.skin,
      "Skinning method, such as lbs, dqs or cor+twist+smooth; otherwise the scene's or the model's");
  command.option("--set", a.sandbox.settings,
                 "A parameter of the solver, such as dls.lambda=0.1 (repeatable)");
  command.flag("--remote", a.remote,
               "Driven by a program over standard input and output, a JSON object a line (docs/sandbox.md)");
  command.flag("--refine", a.sandbox.refines,
               "Draw what stands still once more, smoother, also without a person who watches");
  command.flag("--verbose", a.verbose, "Tell the time to the first frame and the renderer");
  command.run([arguments] { run(*arguments); });
}

}  // namespace gelenk
