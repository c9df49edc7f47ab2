// The sandbox of a page: page.js hands it files, input and the time, and shows what it draws. The functions
// below are all that the page calls; texts are UTF-8, and a text that is returned holds until the next call.
#include "apps/web/page.h"

#include <emscripten.h>
#include <emscripten/html5.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "apps/document/scene_file.h"
#include "apps/lecture/example.h"
#include "apps/sandbox/requests.h"
#include "apps/sandbox/sandbox_state.h"
#include "apps/web/packed_body.h"
#include "kinematics/io/text_file.h"
#include "kinematics/notation/mannequin.h"
#include "skinning/bodies/mannequin_body.h"
#include "skinning/io/prepared_cache.h"
#include "skinning/io/skin_cache.h"

EM_JS(void, tellChooseFiles, (), { Module["chooseFiles"](); });
EM_JS(void, tellShareScene, (), { Module["shareScene"](); });
EM_JS(void, tellCopied, (const char* text), { Module["copy"](UTF8ToString(text)); });

namespace gelenk {
namespace {

struct Page {
  bool hasContext = false;
  std::unique_ptr<Sandbox> sandbox;
  InputQueue queue;
  std::string text;  ///< what was returned last
  std::string told;  ///< the last event
};

Page& page() {
  static Page only;
  return only;
}

const char* returned(std::string text) {
  page().text = std::move(text);
  return page().text.c_str();
}

/// In which a narrow page begins: the view alone.
constexpr double narrow = 760.0;

/// The figure's body and what is prepared for it, as they were made when the page was built, into the place
/// where both are kept.
void unpackFigure() {
  const Skeleton figure = mannequin();
  const std::string file = readFile("/figure.body");
  std::string_view packed = file;
  const Skin body = unpackBody(packed, figure);
  const auto [choice, prepared] = unpackPrepared(packed, body, figure);
  std::filesystem::create_directories(cacheFolder());
  writeCachedSkin(cacheFolder() + "/figure.skin", mannequinSkinKey(figure), body);
  keepPreparedSkin(cacheFolder(), "figure", body, choice, prepared);
  std::filesystem::remove("/figure.body");
}

void prepareOnce() {
  if (page().hasContext) return;
  EmscriptenWebGLContextAttributes attributes;
  emscripten_webgl_init_context_attributes(&attributes);
  attributes.majorVersion = 2;
  attributes.alpha = attributes.depth = attributes.stencil = attributes.antialias = false;
  attributes.powerPreference = EM_WEBGL_POWER_PREFERENCE_HIGH_PERFORMANCE;
  const auto context = emscripten_webgl_create_context("#canvas", &attributes);
  if (context <= 0) throw std::runtime_error("this browser shows no WebGL 2");
  emscripten_webgl_make_context_current(context);
  page().hasContext = true;
  unpackFigure();
}

/// An example by its name or the beginning of it, so that an address may say "newton".
std::string exampleNamed(const std::string& name) {
  const auto& topics = lectureTopics();
  const auto begins = [&](const LectureTopic& topic) { return topic.id.starts_with(name); };
  const auto is = [&](const LectureTopic& topic) { return topic.id == name; };
  auto found = std::find_if(topics.begin(), topics.end(), is);
  if (found == topics.end()) found = std::find_if(topics.begin(), topics.end(), begins);
  return "lecture:" + (found == topics.end() ? name : found->id);
}

}  // namespace

Sandbox& pageSandbox() { return *page().sandbox; }

}  // namespace gelenk

using namespace gelenk;

extern "C" {

/// options: {"model", "lecture", "theme", "solver", "bare", "scene" (a text), "width", "height", "scale"}.
/// Returns "" or why it cannot begin.
EMSCRIPTEN_KEEPALIVE const char* page_start(const char* text) {
  try {
    const Json wanted = Json::parse(text);
    prepareOnce();
    SandboxOptions options{.model = wanted.value("model", "figure"),
                           .width = wanted.at("width"),
                           .height = wanted.at("height"),
                           .scale = wanted.at("scale"),
                           .theme = wanted.value("theme", "light") == "dark" ? Theme::Dark : Theme::Light,
                           .solver = wanted.value("solver", "drag"),
                           .preferences = preferencesFile(),
                           .bare = wanted.value("bare", false),
                           .asks = true,
                           .refines = true,
                           .chooseFiles = [] { tellChooseFiles(); },
                           .shareScene = [] { tellShareScene(); }};
    if (wanted.contains("lecture")) options.model = exampleNamed(wanted["lecture"]);
    if (wanted.contains("scene")) {
      const char* path = "/tmp/link.json";
      writeFile(path, wanted["scene"].get<std::string>());
      options.model = path;
    }
    page().sandbox = std::make_unique<Sandbox>(options);
    ImGui::GetIO().SetClipboardTextFn = [](void*, const char* copied) { tellCopied(copied); };
    Sandbox::State& s = page().sandbox->state();
    if (wanted.contains("scene")) s.scenePath.clear();
    if (options.width / options.scale < narrow) s.inspectorOpen = s.stripOpen = false;
    return "";
  } catch (const std::exception& error) {
    return returned(error.what());
  }
}

EMSCRIPTEN_KEEPALIVE void page_move(double x, double y) {
  page().queue.add({.kind = InputEvent::Kind::MouseMove, .x = x, .y = y});
}
EMSCRIPTEN_KEEPALIVE void page_button(int button, int down) {
  page().queue.add({.kind = InputEvent::Kind::MouseButton, .code = button, .down = down != 0});
}
EMSCRIPTEN_KEEPALIVE void page_wheel(double x, double y) {
  page().queue.add({.kind = InputEvent::Kind::Wheel, .x = x, .y = y});
}
EMSCRIPTEN_KEEPALIVE void page_key(int key, int down) {
  page().queue.add({.kind = InputEvent::Kind::Key, .code = key, .down = down != 0});
}
EMSCRIPTEN_KEEPALIVE void page_character(int code) {
  page().queue.add({.kind = InputEvent::Kind::Character, .code = code});
}

/// Whether this place is one of the view, not of a panel or the menu.
EMSCRIPTEN_KEEPALIVE int page_in_view(double x, double y) {
  return page().sandbox->state().layout.view.contains(x, y);
}

/// Files of the page's file system that came at once: a JSON list of their paths.
EMSCRIPTEN_KEEPALIVE void page_open(const char* paths) {
  Sandbox& sandbox = *page().sandbox;
  try {
    sandbox.requestOpen(Json::parse(paths).get<std::vector<std::string>>());
  } catch (const std::exception& error) {
    sandbox.say(error.what(), true);
  }
}

EMSCRIPTEN_KEEPALIVE void page_say(const char* sentence, int isError) {
  page().sandbox->say(sentence, isError != 0);
}

/// Draws a frame. passed: seconds since the last one. Returns for how many the next would look the same, 0 if
/// it would not, -1 for ever, -2 where it could not be drawn.
EMSCRIPTEN_KEEPALIVE double page_frame(int width, int height, double scale, double passed) {
  try {
    Sandbox& sandbox = *page().sandbox;
    const double dt = std::clamp(passed, 1.0 / 240.0, 0.1);
    if (passed > dt) sandbox.slept(passed - dt);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    sandbox.frame(
        {.width = width, .height = height, .scale = scale, .events = page().queue.take(sandbox.keys())}, dt);
    if (sandbox.wantsToClose()) {
      sandbox.state().closing = false;
      sandbox.say("Close the page's tab to quit");
    }
    const double rests = page().queue.empty() ? sandbox.rests() : 0.0;
    return std::isfinite(rests) ? rests : -1.0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return -2.0;
  }
}

/// A request as a program's (docs/sandbox.md); the reply. Built-in models and examples alone are opened.
EMSCRIPTEN_KEEPALIVE const char* page_ask(const char* text) {
  Json reply, id;
  Sandbox& sandbox = *page().sandbox;
  try {
    const Json request = Json::parse(text);
    const std::string what = checkedRequest(request);
    id = request.value("id", Json());
    if (what == "load") {  // a scene as a text
      const std::string path = "/tmp/message.json";
      writeFile(path, request.at("text").get<std::string>());
      if (!sandbox.open(path)) throw std::runtime_error(sandbox.state().notices.back().words);
      sandbox.state().scenePath.clear();
      reply = Json::object();
    } else if (auto answered = answerRequest(sandbox, what, request)) {
      reply = std::move(*answered);
    } else {
      throw std::invalid_argument("no message is called '" + what + "'; there are: " + requestNames +
                                  ", load, events");
    }
    reply["ok"] = true;
  } catch (const std::exception& error) {
    reply = {{"ok", false}, {"error", error.what()}};
  }
  Json out{{"gelenk", messageVersion}, {"id", id}};
  out.update(reply);
  return returned(out.dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// The pose where it changed since the last call, else "".
EMSCRIPTEN_KEEPALIVE const char* page_event() {
  Json event{{"gelenk", messageVersion}, {"event", "pose"}};
  event.update(poseMessage(*page().sandbox));
  std::string text = event.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text == page().told) return "";
  page().told = std::move(text);
  return page().told.c_str();
}

/// The scene as a link holds it, "" where it stands on a file that a link cannot hold.
EMSCRIPTEN_KEEPALIVE const char* page_scene() {
  const Sandbox& sandbox = *page().sandbox;
  const Document document = sandbox.document();
  if (document.model.files != Companions{} || !standsInNoFile(document.model.nameOrFile)) return "";
  return returned(formatScene(document, sandbox.session().model()));
}

/// The notices that are shown: a JSON list of {"words", "error"}.
EMSCRIPTEN_KEEPALIVE const char* page_notices() {
  Json list = Json::array();
  for (const Notice& notice : page().sandbox->state().notices)
    list.push_back({{"words", notice.words}, {"error", notice.isError}});
  return returned(list.dump());
}

EMSCRIPTEN_KEEPALIVE const char* page_status() { return returned(page().sandbox->status()); }

}  // extern "C"

int main() {}
