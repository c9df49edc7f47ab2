#include "apps/sandbox/sandbox.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>

#include "apps/commands/image.h"
#include "apps/document/files_together.h"
#include "apps/document/model_files.h"
#include "apps/document/notes.h"
#include "apps/document/scene_file.h"
#include "apps/document/surface.h"
#include "apps/render/facts.h"
#include "apps/sandbox/sandbox_state.h"
#include "skinning/gpu/driver.h"
#include "skinning/gpu/render_target.h"
#include "solvers/lab/sweep.h"

namespace gelenk {
namespace {

constexpr double noticeSeconds = 3.5, errorSeconds = 9.0;
constexpr int framesToSettle = 4;
constexpr double slowFrame = 1.0 / 45.0, smallShare = 0.7;  // seconds; of a picture's width and height
constexpr double still = 1e-7;                              // radians or metres a frame
constexpr std::size_t errorHistory = 240, dragHistory = 3;

/// Moves in a fifth of a second, eased at both ends.
void glideCamera(Sandbox::State& s) {
  if (!s.cameraMove) return;
  const auto& [from, to, begin] = *s.cameraMove;
  const double t = std::clamp((s.time - begin) / 0.2, 0.0, 1.0), e = t * t * (3.0 - 2.0 * t);
  s.camera() = to;
  if (t >= 1.0) {
    s.cameraMove.reset();
    return;
  }
  s.camera().target = from.target + e * (to.target - from.target);
  s.camera().distance = from.distance * std::pow(to.distance / from.distance, e);
  s.camera().azimuth = from.azimuth + e * std::remainder(to.azimuth - from.azimuth, 2.0 * M_PI);
  s.camera().elevation = from.elevation + e * (to.elevation - from.elevation);
}

void recordPlots(Sandbox::State& s) {
  const FrameSolve& solve = s.session->lastSolve();
  if (!solve.ran) return;
  s.plots.errors.push_back(solve.error);
  if (s.plots.errors.size() > errorHistory) s.plots.errors.erase(s.plots.errors.begin());
  if (solve.residuals.size() > 1) s.plots.residuals = solve.residuals;
  if (s.session->dragged() && solve.residuals.size() >= s.plots.worst.size()) s.plots.worst = solve.residuals;
  if (!s.session->dragged() && s.plots.worst.size() > 1) {
    s.plots.earlier.push_back({s.plots.worst, s.session->solver()});
    if (s.plots.earlier.size() > dragHistory) s.plots.earlier.erase(s.plots.earlier.begin());
    s.plots.worst.clear();
  }
}

/// The picture's way follows what happened to the document and the pose.
void followDocument(const Sandbox& sandbox) {
  const Sandbox::State& s = const_cast<Sandbox&>(sandbox).state();
  const bool painting = s.gesture.kind == Gesture::Kind::Tool;
  s.session->setPainting(painting);
  s.view->follow(*s.session, sandbox.shownFrames(), !s.shownFrames || s.handlesOnShown, painting);
}

/// Everything that the picture follows from; empty where that is not to be told from outside: colours and
/// muscles live on the graphics card.
std::string madeFrom(const Sandbox::State& s, const RenderScene& scene, const Viewport& viewport) {
  Facts facts;
  const Camera& camera = s.session->document().view.camera;
  facts.add(camera.target), facts.add(camera.up);
  facts.add(camera.distance, camera.azimuth, camera.elevation, camera.verticalFieldOfView,
            camera.orthographic);
  facts.add(viewport.width, viewport.height, s.viewScale(), s.view.get(), s.session->weightsVersion());
  facts.addAll(toString(s.session->document().skin));
  facts.add(scene.theme, scene.xray, scene.shadows, scene.lightFromViewer, scene.size, scene.ground.visible,
            scene.ground.grid, scene.ground.height);
  facts.add(scene.bounds.min()), facts.add(scene.bounds.max());
  for (const Overlay* overlay : {&scene.overlay, &scene.overlayOnTop}) {
    facts.addAll(overlay->fills), facts.addAll(overlay->lines), facts.addAll(overlay->points);
  }
  for (const BodyInstance& body : scene.bodies) {
    if (body.surface == SurfaceColour::Vertex || !body.pose->layers.empty()) return {};
    facts.add(body.mesh, body.look, body.tint, body.wireframe, body.seeThrough);
    facts.addAll(body.pose->rows);
    facts.addAll(body.pose->method);
  }
  for (const std::string& part : s.session->document().view.hidden) facts.addAll(part);
  return facts.bytes();
}

/// Anew only where something changed. For a person who watches, what stands still is drawn once more, as
/// smooth as a picture in a file.
void renderView(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  s.extras.limitGlow = s.limitGlow;
  if (s.hover.kind == Hover::Kind::Goal) s.extras.hovered = s.hover.goal;
  s.extras.selected = s.goalSelected();
  s.extras.whole = false;
  s.extras.viewport = s.viewport();
  s.extras.pixelScale = s.viewScale();
  const RenderScene scene = s.view->compose(*s.session, s.extras);
  s.labels = scene.labels;
  const Viewport viewport = s.viewport();
  const bool watched = s.options.refines && !s.recorder.isRunning(), fine = watched && sandbox.rests() > 0.0;
  // Where the processor draws, what moves too slowly is drawn smaller until it stands still.
  s.drawnSmall = watched && !fine && isSoftwareRenderer() && (s.drawnSmall || s.secondsPerFrame > slowFrame);
  const double share = s.drawnSmall ? smallShare : 1.0;
  const Viewport drawn{static_cast<int>(share * viewport.width), static_cast<int>(share * viewport.height)};
  std::string from = madeFrom(s, scene, viewport);
  if (!from.empty() && from == s.drawn && (s.drawnFine || !fine)) return;
  s.drawn = std::move(from);
  s.drawnFine = fine;
  s.picture.resize(drawn.width, drawn.height, s.drawnSmall);
  s.renderer.setSupersampling(fine ? 2 : 1);
  s.renderer.setQuick(s.drawnSmall);
  s.renderer.draw(scene, s.camera(), drawn, s.picture.framebuffer(),
                  static_cast<float>(share) * s.viewScale());
}

}  // namespace

Sandbox::Sandbox(const SandboxOptions& options) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.options = options;
  s.scale = static_cast<float>(options.scale);
  s.preferences = s.written = readPreferences(options.preferences);
  s.preferences.opened(options.model);
  s.panels = makePanels();
  s.gui.setLook(options.theme, s.scale);
  s.windowWidth = options.width;
  s.windowHeight = options.height;
  s.layout = layOut(s, options.width, options.height);
  const bool isLecture =
      options.model.starts_with("lecture:");  // an example of the lecture opens its own model
  const bool isSurface =
      options.files == Companions{} && isSurfaceFile(options.model);  // is offered a skeleton
  if (isSurface) readSurface(options.model);  // what cannot be read is refused before a window opens
  const ModelReference reference{.nameOrFile = isLecture   ? "planar"
                                               : isSurface ? "figure"
                                                           : options.model,
                                 .files = options.files};
  auto [model, document] = gelenk::openDocument(reference);
  if (isScene(options.model)) {
    openDocument(std::move(model), std::move(document));
    s.scenePath = options.model;
  } else {
    adopt(std::make_unique<Session>(std::move(model), reference), false);
    s.theme() = options.theme;
    s.session->setSolver(withParameters({options.solver}, options.settings).front());
    if (!options.skin.empty()) s.session->chooseSkin(parseSkinChoice(options.skin));
  }
  if (isLecture || isSurface)
    for (const auto& panel : s.panels) panel->openFile(*this, options.model);
}

Sandbox::~Sandbox() = default;

void Sandbox::openModel(Model model, const ModelReference& reference) {
  adopt(std::make_unique<Session>(std::make_shared<const Model>(std::move(model)), reference), false);
}

void Sandbox::openDocument(std::shared_ptr<const Model> model, Document document) {
  adopt(std::make_unique<Session>(std::move(model), std::move(document)), true);
}

void Sandbox::adopt(std::unique_ptr<Session> session, bool fromFile) {
  State& s = *state_;
  const std::vector<Note>& notes = session->model().notes;
  demandNoNotes(session->document().model.nameOrFile, notes);
  auto view = std::make_unique<SceneView>(*session);
  if (s.session && !fromFile) session->theme() = s.theme();
  s.session = std::move(session);
  s.view = std::move(view);
  s.shownFrames.reset();
  s.extras = {};
  s.gesture = {};
  s.hover = {};
  s.selectedGoal.reset();
  s.plots = {};
  s.playing = false;
  s.scenePath.clear();
  s.cameraMove.reset();
  s.savedEdits = s.session->editCount();
  s.limitGlow.assign(s.session->skeleton().jointCount(), 0.0);
  const Eigen::AlignedBox3d whole = s.view->bounds();
  followDocument(*this);
  if (!fromFile || s.camera().distance == 0.0)
    s.camera() = s.view->wholeView(*s.session, s.viewport(), whole);
  for (const auto& panel : s.panels) panel->opened(*this, fromFile);
  if (!notesAreQuiet())
    for (const Note& note : notes) say(note.lineWithoutRemedy());
}

namespace {

/// A folder's files in its place, those of folders in it left out.
std::vector<std::string> withoutFolders(const std::vector<std::string>& paths) {
  std::vector<std::string> files;
  for (const std::string& path : paths) {
    if (!std::filesystem::is_directory(path)) {
      files.push_back(path);
      continue;
    }
    std::vector<std::string> inside;
    for (const auto& entry : std::filesystem::directory_iterator(path))
      if (entry.is_regular_file()) inside.push_back(entry.path().string());
    if (inside.empty()) throw std::invalid_argument("no file lies in the folder '" + path + "'");
    std::ranges::sort(inside);
    files.insert(files.end(), inside.begin(), inside.end());
  }
  return files;
}

}  // namespace

bool Sandbox::open(const ModelReference& reference) {
  try {
    bool taken = false;
    const Session* before = state_->session.get();
    if (reference.files == Companions{} && !isScene(reference.nameOrFile))
      for (const auto& panel : state_->panels) taken = taken || panel->openFile(*this, reference.nameOrFile);
    if (!taken && isScene(reference.nameOrFile)) {
      auto [model, document] = gelenk::openDocument(reference);
      openDocument(std::move(model), std::move(document));
      state_->scenePath = reference.nameOrFile;
    } else if (!taken) {
      openModel(readModel(reference), reference);
    }
    state_->preferences.opened(reference.nameOrFile);
    state_->savedEdits = session().editCount();
    if (taken && state_->session.get() == before) return true;  // a question comes first, or it was added
    say("Opened " + reference.nameOrFile);
    return true;
  } catch (const std::exception& error) {
    say(error.what(), true);
    return false;
  }
}

Document Sandbox::document() const {
  const State& s = *state_;
  Document document = s.session->saved();
  if (s.cameraMove) document.view.camera = s.cameraMove->to;
  for (const auto& panel : s.panels) panel->store(*this, document);
  return document;
}

bool Sandbox::saveSceneTo(const std::string& name) {
  const std::string path = scenePathOf(name);
  try {
    writeScene(path, document(), session().model());
    state_->scenePath = path;
    state_->preferences.opened(path);
    state_->savedEdits = session().editCount();
    say("Saved " + path);
    return true;
  } catch (const std::exception& error) {
    say(error.what(), true);
    return false;
  }
}

/// An example of the lecture can be opened again as the slide has it; it is asked about where it was saved as
/// a scene of one's own.
void Sandbox::whenSaved(std::function<void(Sandbox&)> what) {
  State& s = *state_;
  const bool ofTheLecture = s.scenePath.empty() && !document().lecture.topic.empty();
  if (!s.options.asks || ofTheLecture || s.session->editCount() == s.savedEdits) return what(*this);
  s.next = std::move(what);
  s.dialog = State::Dialog::Unsaved;
}

void Sandbox::requestClose() {
  whenSaved([](Sandbox& sandbox) { sandbox.state().closing = true; });
}

void Sandbox::requestOpen(const std::string& nameOrFile) {
  whenSaved([nameOrFile](Sandbox& sandbox) { sandbox.open(nameOrFile); });
}

void Sandbox::requestOpen(const std::vector<std::string>& paths) {
  try {
    const ModelReference reference = filesTogether(withoutFolders(paths));
    if (reference.files == Companions{}) return requestOpen(reference.nameOrFile);
    whenSaved([reference](Sandbox& sandbox) { sandbox.open(reference); });
  } catch (const std::exception& error) {
    say(error.what(), true);
  }
}

void Sandbox::frame(const Input& input, double dt) {
  State& s = *state_;
  const auto begin = std::chrono::steady_clock::now();
  GLint framebuffer = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer);
  ++s.frameNumber;
  s.time += dt;
  s.scale = static_cast<float>(input.scale);
  s.windowWidth = input.width;
  s.windowHeight = input.height;
  s.settling = input.events.empty() && s.frameNumber > 1 ? std::max(0, s.settling - 1) : framesToSettle;
  s.extras = {};
  s.shownFrames.reset();

  s.gui.setLook(s.theme(), s.scale);
  s.gui.beginFrame(input, dt);
  s.layout = layOut(s, input.width, input.height);
  glideCamera(s);
  handleViewInput(*this, input);
  for (const auto& panel : s.panels) panel->step(*this, dt);
  if (!s.shownFrames) s.session->step();
  recordPlots(s);
  followDocument(*this);

  drawShell(*this);
  for (const auto& panel : s.panels) panel->overlay(*this);
  glowLimits(*this);
  followDocument(*this);  // the inspector may have changed something
  renderView(*this);
  drawMarks(*this);

  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, input.width, input.height);
  s.gui.endFrame();
  if (!s.screenshotPath.empty()) {
    try {
      writePng(s.screenshotPath,
               {input.width, input.height, readPixels(framebuffer, input.width, input.height)});
      say("Screenshot " + s.screenshotPath);
    } catch (const std::exception& error) {
      say(error.what(), true);
    }
    s.screenshotPath.clear();
  }
  if (s.recorder.wants(s.time)) try {
      s.recorder.add({input.width, input.height, readPixels(framebuffer, input.width, input.height)}, s.time);
    } catch (const std::exception& error) {
      say(error.what(), true);
    }
  if (s.lastBegin) {
    const double seconds = std::chrono::duration<double>(begin - *s.lastBegin).count();
    s.secondsPerFrame += (s.secondsPerFrame > 0.0 ? 0.1 : 1.0) * (seconds - s.secondsPerFrame);
  }
  s.lastBegin.reset();  // a pause before the next frame is none of that frame's time
  if (rests() == 0.0) s.lastBegin = begin;
  if (s.afterFrame) std::exchange(s.afterFrame, nullptr)(*this);
  if (s.preferences != s.written && s.gesture.kind == Gesture::Kind::None && !ImGui::IsMouseDown(0)) {
    writePreferences(s.options.preferences, s.preferences);
    s.written = s.preferences;
  }
}

bool Sandbox::startRecording(const std::string& path) {
  State& s = *state_;
  try {
    s.recorder.start(path, s.windowWidth, s.windowHeight, s.time);
    return true;
  } catch (const std::exception& error) {
    say(error.what(), true);
    return false;
  }
}

bool Sandbox::stopRecording() {
  State& s = *state_;
  if (!s.recorder.isRunning()) return true;
  try {
    s.recorder.finish();
    say(fmt::format("Recorded {} ({:.1f} s)", s.recorder.path(), s.recorder.seconds()));
    return true;
  } catch (const std::exception& error) {
    say(error.what(), true);
    return false;
  }
}

bool Sandbox::wantsToClose() const { return state_->closing; }

double Sandbox::rests() const {
  const State& s = *state_;
  const FrameSolve& solve = s.session->lastSolve();
  if (s.settling > 0 || s.afterFrame || s.view->teaching().isWorking() || s.cameraMove ||
      s.gesture.kind != Gesture::Kind::None || !s.screenshotPath.empty() ||
      (!s.shownFrames && solve.ran && solve.jointMotion > still) ||
      std::ranges::any_of(s.limitGlow, [](double glow) { return glow > 0.0 && glow < 1.0; }))
    return 0.0;
  double seconds = keys() == Keys::Text ? 0.25 : std::numeric_limits<double>::infinity();  // the caret
  for (const Notice& notice : s.notices)
    seconds = std::min(seconds, std::max(0.0, notice.until - noticeFade - s.time));
  for (const auto& panel : s.panels) seconds = std::min(seconds, panel->rests(*this));
  return seconds;
}

void Sandbox::slept(double seconds) { state_->time += seconds; }
Session& Sandbox::session() { return *state_->session; }
const Session& Sandbox::session() const { return *state_->session; }
Camera& Sandbox::camera() { return state_->camera(); }
ViewOptions& Sandbox::options() { return state_->show(); }
Theme Sandbox::theme() const { return state_->theme(); }
float Sandbox::scale() const { return state_->scale; }
Keys Sandbox::keys() const { return state_->gui.keys(); }
int Sandbox::frameNumber() const { return state_->frameNumber; }
double Sandbox::time() const { return state_->time; }

void Sandbox::showFrames(Frames worldFromJoint, bool withHandles) {
  state_->shownFrames = std::move(worldFromJoint);
  state_->handlesOnShown = withHandles;
}
const Frames& Sandbox::shownFrames() const {
  return state_->shownFrames ? *state_->shownFrames : state_->session->frames();
}

const SkinnedVertices& Sandbox::surface() const {
  followDocument(*this);
  return state_->view->surface(*state_->session);
}
const MuscleRig* Sandbox::muscles() const { return state_->view->muscles(); }
const std::vector<LimbPose>& Sandbox::limbPoses() const {
  followDocument(*this);
  return state_->view->limbPoses(*state_->session);
}
void Sandbox::markLattice(int plane, int point) {
  state_->extras.latticePlane = plane;
  state_->extras.latticePoint = point;
}
Overlay& Sandbox::overlay() { return state_->extras.overlayOnTop; }
Overlay& Sandbox::overlayInScene() { return state_->extras.overlay; }
void Sandbox::showLecture(LectureDrawing& drawing) { state_->extras.lecture = &drawing; }
void Sandbox::label(const Eigen::Vector3d& at, const std::string& text, const Eigen::Vector4f& colour) {
  state_->extras.labels.push_back(
      {.at = at, .text = text, .colour = {colour.x(), colour.y(), colour.z(), colour.w()}, .isName = true});
}
void Sandbox::showVertexScalars(const std::vector<float>& values) {
  state_->extras.vertexColours = viridisColours(values);
}
void Sandbox::showVertexColours(std::vector<Eigen::Vector3f> colours) {
  state_->extras.vertexColours = std::move(colours);
}

std::optional<int> Sandbox::selectedJoint() const { return state_->selectedJoint(); }
void Sandbox::select(std::optional<int> joint) { state_->session->selectJoint(joint); }

void Sandbox::say(const std::string& sentence, bool isError) {
  State& s = *state_;
  std::erase_if(s.notices, [&](const Notice& notice) { return notice.words == sentence; });
  s.notices.push_back({sentence, isError, s.time + (isError ? errorSeconds : noticeSeconds)});
  if (s.notices.size() > 4) s.notices.erase(s.notices.begin());
}
bool Sandbox::playing() const { return state_->playing; }
void Sandbox::setPlaying(bool playing) { state_->playing = playing; }
void Sandbox::showInspector(const std::string& panelName) {
  state_->inspectorOpen = true;
  state_->inspectorTab = panelName;
}
void Sandbox::showBottomStrip(const std::string& panelName) {
  state_->stripOpen = true;
  state_->stripTab = panelName;
}
std::string Sandbox::renderer() const { return glRenderer(); }

}  // namespace gelenk
