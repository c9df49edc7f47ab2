#include "apps/render/render_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/commands/muscle_report.h"
#include "apps/document/file_format.h"
#include "apps/document/model_files.h"
#include "apps/document/notes.h"
#include "apps/document/scene_file.h"
#include "apps/document/session.h"
#include "apps/render/label_writer.h"
#include "apps/render/muscle_sheet.h"
#include "apps/render/scene_view.h"
#include "apps/render/video.h"
#include "kinematics/configuration.h"
#include "kinematics/io/text_file.h"
#include "skinning/gpu/offscreen_context.h"
#include "skinning/gpu/render_target.h"

namespace gelenk {
namespace {

constexpr double degrees = std::numbers::pi / 180.0;

/// The command's arguments as they were given; empty or nullopt: not given.
struct Request {
  std::string input, output;
  Companions files;
  int frame = 0;
  bool bindPose = false;
  std::string size = "1280x800", theme, view, focus, weightsOf;
  double scale = 1.0, zoom = 1.0, seconds = 6.0;
  std::optional<double> azimuth, elevation;
  std::vector<double> q;
  int smoothing = 0, frames = 0, framesPerSecond = 30;
  bool orthographic = false, wireframe = false, bones = false, jointFrames = false, handles = false;
  bool noGround = false, noShadow = false;
  std::string skin;    ///< method; empty: as the scene or the model says
  std::string layers;  ///< empty: as the scene says
  bool lattice = false;
  std::string muscleSheet;  ///< name of a limb or its joints
  std::vector<std::string> turns, show, hide;
  std::string solver, replay;
};

bool endsWith(const std::string& text, std::string_view end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

Viewport parseSize(const Request& request) {
  Viewport viewport;
  char rest = 0;
  if (std::sscanf(request.size.c_str(), "%dx%d%c", &viewport.width, &viewport.height, &rest) != 2 ||
      viewport.width < 1 || viewport.height < 1)
    throw std::invalid_argument("--size: expected WIDTHxHEIGHT such as 1280x800, found '" + request.size +
                                "'");
  viewport.width = static_cast<int>(std::lround(viewport.width * request.scale));
  viewport.height = static_cast<int>(std::lround(viewport.height * request.scale));
  return viewport;
}

/// --q: values in the configuration's order, angles in radians as `gelenk fk --q` takes them.
Eigen::VectorXd configurationOf(const Request& request, const Skeleton& skeleton,
                                const Eigen::VectorXd& otherwise) {
  if (request.q.empty()) return otherwise;
  const std::optional<Eigen::VectorXd> given = configurationFrom(skeleton, request.q);
  if (!given)
    throw std::invalid_argument(fmt::format("--q: the model has {} configuration values, {} are given",
                                            skeleton.nq(), request.q.size()));
  Eigen::VectorXd q = *given;
  for (int j = 0; j < skeleton.jointCount(); ++j) {
    if (!skeleton.joint(j).ball) continue;
    const Eigen::Quaterniond rotation = ballRotation(skeleton, q, j);
    if (!(rotation.norm() > 1e-9))
      throw std::invalid_argument("--q: the quaternion of joint " + skeleton.joint(j).name + " is zero");
    setBallRotation(skeleton, q, j, rotation.normalized());
  }
  return q;
}

/// --turn elbow=60: sets the first axis of a joint, degrees; --turn shoulder.y=30: turns a ball about an axis
/// of its frame.
Eigen::VectorXd turned(const Skeleton& skeleton, Eigen::VectorXd q, const std::string& turn) {
  const std::size_t equals = std::min(turn.find('='), turn.size());
  const auto angle = equals < turn.size() ? parseNumber(turn.substr(equals + 1)) : std::nullopt;
  if (!angle)
    throw std::invalid_argument("--turn: expected JOINT=DEGREES such as lowerarm_l=60, found '" + turn + "'");
  std::string name = turn.substr(0, equals);
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  if (!skeleton.findJoint(name) && name.size() > 2 && name[name.size() - 2] == '.' && name.back() >= 'x' &&
      name.back() <= 'z') {
    axis = Eigen::Vector3d::Unit(name.back() - 'x');
    name.resize(name.size() - 2);
  }
  const int joint = skeleton.jointIndex(name);
  if (skeleton.joint(joint).ball)
    setBallRotation(
        skeleton, q, joint,
        ballRotation(skeleton, q, joint) * Eigen::Quaterniond(Eigen::AngleAxisd(*angle * degrees, axis)));
  else if (!skeleton.joint(joint).axes.empty())
    setJointValue(skeleton, q, joint, *angle * degrees);
  else
    throw std::invalid_argument("--turn: joint " + name + " does not move");
  return q;
}

std::optional<StandardView> standardView(const std::string& name) {
  if (name == "front") return StandardView::Front;
  if (name == "side") return StandardView::Side;
  if (name == "top") return StandardView::Top;
  if (name == "three-quarter") return StandardView::ThreeQuarter;
  return std::nullopt;
}

/// Frames the joint and what is near it.
Eigen::AlignedBox3d around(const Frames& frames, int joint, double size) {
  const Eigen::Vector3d at = frames[joint].translation(), half = Eigen::Vector3d::Constant(0.09 * size);
  return {Eigen::Vector3d(at - half), Eigen::Vector3d(at + half)};
}

/// The pose as the arguments ask for it.
Eigen::VectorXd poseOf(const Request& request, const Model& model, const Eigen::VectorXd& otherwise) {
  Eigen::VectorXd q = otherwise;
  if (request.frame > 0) q = motionFrame(model, request.frame);
  q = configurationOf(request, model.skeleton, q);
  for (const std::string& turn : request.turns) q = turned(model.skeleton, q, turn);
  return q;
}

/// Muscle layers as the scene has them, or as --layers and --lattice ask.
std::shared_ptr<const MuscleSettings> musclesOf(const Request& request, const Model& model,
                                                std::shared_ptr<const MuscleSettings> otherwise) {
  const bool wanted = request.layers.empty() ? otherwise && otherwise->enabled : request.layers != "none";
  if (request.lattice && !wanted)
    throw std::invalid_argument("--lattice: no muscle layers are on; add --layers ffd or --layers muscle");
  if (request.layers.empty() && !request.lattice) return otherwise;
  if (wanted && !otherwise)
    throw std::invalid_argument("--layers: model '" + model.name +
                                "' has no limb of a known name (upperarm_l, lowerarm_l, hand_l, ...)");
  if (!otherwise) return nullptr;
  MuscleSettings settings = *otherwise;
  settings.enabled = wanted;
  settings.lattice = request.lattice;
  if (request.lattice) settings.shownLimb.clear();
  const std::vector<Limb> limbs = limbsOf(model);
  if (request.layers == "ffd")
    for (std::size_t l = 0; l < limbs.size(); ++l)
      settings.limbs[l].second.control = noMuscleControl(limbs[l]);
  return std::make_shared<const MuscleSettings>(std::move(settings));
}

/// The document that the picture shows: the scene's, or the model's as it begins, with what the arguments
/// change of it.
Session openRequested(const Request& request) {
  auto [model, document] = openDocument({.nameOrFile = request.input, .files = request.files});
  document.edits.q = poseOf(request, *model, document.edits.q);
  if (!request.skin.empty()) chooseSkin(document, *model, parseSkinChoice(request.skin));
  document.edits.muscles = musclesOf(request, *model, document.edits.muscles);
  if (!request.theme.empty()) document.theme = request.theme == "dark" ? Theme::Dark : Theme::Light;
  ViewOptions& show = document.view.show;
  show.wireframe = show.wireframe || request.wireframe;
  show.skeleton = show.skeleton || request.bones;
  show.jointFrames = show.jointFrames || request.jointFrames;
  document.playback.showing = document.playback.showing && isScene(request.input);  // the marks of a motion
  show.handles = request.handles || (show.handles && isScene(request.input));
  show.ground = show.ground && !request.noGround;
  show.shadow = show.shadow && !request.noShadow;
  for (const std::string& name : request.show) show.*viewOption(name) = true;
  document.view.hidden.insert(request.hide.begin(), request.hide.end());
  if (!request.solver.empty()) document.solver.name = solverSpec(request.solver).entry->name;
  if (!request.weightsOf.empty()) {
    show.weights = true;
    document.view.selectedJoint = model->skeleton.joint(model->skeleton.jointIndex(request.weightsOf)).name;
  }
  return Session(std::move(model), std::move(document));
}

Camera cameraOf(const Request& request, const Session& session, SceneView& view, const Viewport& viewport) {
  const bool asked = !request.view.empty() || !request.focus.empty() || request.azimuth ||
                     request.elevation || request.orthographic;
  Camera camera = session.document().view.camera;
  if ((!isScene(request.input) || camera.distance == 0.0) && !asked) {
    camera = view.wholeView(session, viewport, view.bounds());
  } else if (asked) {
    if (const auto standard = standardView(request.view)) camera = lookFrom(camera, *standard);
    if (request.azimuth) camera.azimuth = *request.azimuth * degrees;
    if (request.elevation) camera.elevation = *request.elevation * degrees;
    camera.orthographic = camera.orthographic || request.orthographic;
    const Eigen::AlignedBox3d box =
        request.focus.empty()
            ? view.bounds()
            : around(view.frames(), session.skeleton().jointIndex(request.focus), view.size());
    camera = frameBox(camera, viewport, box);
  }
  camera.distance /= request.zoom;
  return camera;
}

/// Everything between the request and the pixels.
class Studio {
 public:
  explicit Studio(const Request& request)
      : request_(request), viewport_(parseSize(request)), session_(openRequested(request)) {
    sayNotes(request.input, session_.model().notes);
    context_.emplace();
    view_.emplace(session_, isScene(request.input) || request.frame > 0 ? SceneView::Ground::UnderMotion
                                                                        : SceneView::Ground::UnderRest);
    view_->follow(session_, request.bindPose ? bindFrames(session_.model()) : session_.frames(),
                  !request.bindPose);
    if (!view_->muscleFault().empty()) throw std::invalid_argument(view_->muscleFault());
    session_.view().camera = cameraOf(request, session_, *view_, viewport_);
    renderer_.emplace();
    renderer_->setSupersampling(smoothing());
    target_.emplace(viewport_.width, viewport_.height);
  }

  const Viewport& viewport() const { return viewport_; }
  const Model& model() const { return session_.model(); }

  /// The picture with the camera turned by so many radians about up.
  Image picture(double turn = 0.0) {
    Camera camera = session_.document().view.camera;
    camera.azimuth += turn;
    const auto scale = static_cast<float>(request_.scale);
    const RenderScene scene = view_->compose(session_, {.viewport = viewport_, .pixelScale = scale});
    renderer_->draw(scene, camera, viewport_, target_->framebuffer(), scale);
    if (!scene.labels.empty()) {
      if (!labels_) labels_.emplace(scene.theme, scale);
      labels_->write(scene.labels, camera, viewport_, session_.model().planar, target_->framebuffer());
    }
    return {viewport_.width, viewport_.height, target_->readPixels()};
  }

 private:
  /// Pixels drawn for one of the picture: as many as the renderer can hold, 3 x 3 at most for a still, 2 x 2
  /// for a video.
  int smoothing() const {
    if (request_.smoothing > 0) return request_.smoothing;
    GLint most = 0;
    glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &most);
    const int wanted =
        endsWith(request_.output, ".mp4") || endsWith(request_.output, ".gif") || !isSoftwareRenderer() ? 2
                                                                                                        : 3;
    return std::clamp(most / std::max(viewport_.width, viewport_.height), 1, wanted);
  }

  const Request& request_;
  Viewport viewport_;
  Session session_;
  std::optional<OffscreenContext> context_;  // before all that lives in it
  std::optional<SceneView> view_;
  std::optional<Renderer> renderer_;
  std::optional<RenderTarget> target_;
  std::optional<LabelWriter> labels_;
};

void showProgress(int done, int all) {
  if (!isatty(STDERR_FILENO)) return;
  constexpr int width = 40;
  const int filled = width * done / all;
  fmt::print(stderr, "\r[{:#<{}}{:.<{}}] {}/{}{}", "", filled, "", width - filled, done, all,
             done == all ? "\n" : "");
  std::fflush(stderr);
}

void writeTurntable(Studio& studio, const Request& request) {
  const int count = request.frames > 0
                        ? request.frames
                        : static_cast<int>(std::lround(request.seconds * request.framesPerSecond));
  if (count < 1) throw std::invalid_argument("a video needs at least one frame");
  VideoWriter video(request.output, studio.viewport().width, studio.viewport().height,
                    request.framesPerSecond);
  for (int i = 0; i < count; ++i) {
    video.add(studio.picture(2.0 * std::numbers::pi * i / count));
    showProgress(i + 1, count);
  }
  video.finish();
}

/// The limb of a known name ("left arm"), else the one of the joints "shoulder,elbow,wrist".
Limb limbOf(const Skeleton& skeleton, const std::string& name) {
  const Frames rest = restFrames(skeleton);
  for (const Limb& limb : standardLimbs(skeleton, rest))
    if (limb.name == name) return limb;
  return limbByNames(skeleton, rest, name);
}

void renderMuscleSheet(const Request& request) {
  const Model model = *openDocument({.nameOrFile = request.input, .files = request.files}).model;
  sayNotes(request.input, model.notes);
  const Limb limb = limbOf(model.skeleton, request.muscleSheet);
  const OffscreenContext context;
  writePng(request.output, drawMuscleSheet(model, limb,
                                           {.scale = request.scale,
                                            .smoothing = request.smoothing > 0 ? request.smoothing : 3,
                                            .theme = request.theme == "dark" ? Theme::Dark : Theme::Light}));
  fmt::print("{}: {}, {}, {}\n", request.output, model.name, limb.name, glRenderer());
}

/// By the name's ending: PNG, or the pixels as they are for programs that read them (PPM, P6).
void writePicture(const std::string& path, const Image& image) {
  if (!endsWith(path, ".ppm")) return writePng(path, image);
  std::string text = fmt::format("P6\n{} {}\n255\n", image.width, image.height);
  for (std::size_t i = 0; i < image.pixels.size(); i += 4)
    text.append(reinterpret_cast<const char*>(&image.pixels[i]), 3);
  writeFile(path, text);
}

void renderReplay(const Request& request, const std::function<void(const FilmOrder&)>& film) {
  if (!film) throw std::invalid_argument("--replay: this program has no sandbox to play it");
  const Viewport viewport = parseSize(request);
  film({.input = request.input,
        .files = request.files,
        .replay = request.replay,
        .output = request.output,
        .width = viewport.width,
        .height = viewport.height,
        .scale = request.scale,
        .theme = request.theme == "dark" ? Theme::Dark : Theme::Light,
        .themeIsWanted = !request.theme.empty()});
  fmt::print("{}: {} x {}, {}, {}\n", request.output, viewport.width, viewport.height, request.input,
             request.replay);
}

void render(const Request& request, const std::function<void(const FilmOrder&)>& film) {
  const bool video = endsWith(request.output, ".mp4") || endsWith(request.output, ".gif");
  if (!request.muscleSheet.empty()) return renderMuscleSheet(request);
  const bool still = endsWith(request.output, ".png") || endsWith(request.output, ".ppm");
  if (!video && (!still || !request.replay.empty()))
    throw std::invalid_argument(
        fmt::format("--output: expected a name ending in {}, found '{}'",
                    request.replay.empty() ? ".png, .ppm, .mp4 or .gif" : ".mp4 or .gif", request.output));
  if (!request.replay.empty()) return renderReplay(request, film);
  Studio studio(request);
  if (video)
    writeTurntable(studio, request);
  else
    writePicture(request.output, studio.picture());
  fmt::print("{}: {} x {}, {}, {}\n", request.output, studio.viewport().width, studio.viewport().height,
             studio.model().name, glRenderer());
}

}  // namespace

void addRenderCommand(Command& app, std::function<void(const FilmOrder&)> film) {
  const auto request = std::make_shared<Request>();
  Command command = app.command(
      "render", "Draw a model or a scene into a picture (.png, .ppm) or a turntable video (.mp4)");
  command.option("input", request->input, "Built-in model, model file or scene (.json)").required();
  command.option("-o,--output", request->output, "Picture or video to write").required();
  command.option("--skeleton", request->files.skeleton, "Skeleton file that goes with an OBJ");
  command.option("--weights", request->files.weights, "Weights file that goes with an OBJ and a skeleton");
  command.option("--asf", request->files.asf,
                 "ASF skeleton that an OBJ's fitted skeleton is laid on, or of an AMC");
  command.option("--amc", request->files.amc, "Motion for the ASF skeleton");
  command.option("--mapping", request->files.mapping,
                 "Which bones lie on which joints: lines 'bone ... : joint joint ...'");
  command.option("--clip", request->files.clip,
                 "Which motion of a file that names several; default: the first");
  command
      .option(
          "--up", request->files.up,
          "The axis that points up where the format does not say it; default: along which the body stands")
      .oneOf({"y", "z"});
  command.option("--frame", request->frame, "Pose of this frame of the motion, from 1").positive();
  command.flag("--bind-pose", request->bindPose,
               "The pose in which the skin is bound, where that is not the skeleton's rest pose");
  command.option("--size", request->size, "Pixels at scale 1").showDefault();
  command.option("--scale", request->scale, "Enlarges the picture, and lines and marks with it")
      .range(0.1, 8.0)
      .showDefault();
  command.option("--theme", request->theme, "light or dark; otherwise the scene's").oneOf({"light", "dark"});
  command.option("--view", request->view, "Standard direction")
      .oneOf({"front", "side", "top", "three-quarter"});
  command.option("--azimuth", request->azimuth, "Degrees about the vertical, 0 from the front");
  command.option("--elevation", request->elevation, "Degrees above the horizon").range(-90.0, 90.0);
  command.option("--focus", request->focus, "Close-up of this joint");
  command.option("--zoom", request->zoom, "Factor").range(0.001, 1000.0);
  command.flag("--orthographic", request->orthographic, "Without perspective");
  command.option("--q", request->q,
                 "The whole configuration (radians, metres, quaternions w x y z); otherwise the rest pose");
  command.flag("--wireframe", request->wireframe, "Edges of the triangles");
  command.flag("--bones", request->bones, "Skeleton through a translucent skin");
  command.option("--weights-of", request->weightsOf, "Skinning weights of this joint as colours");
  command.option("--show", request->show,
                 "Something more: velocity_ellipsoid, force_ellipsoid, reachable, solutions, null_space, "
                 "convergence or what else a scene shows; may be repeated");
  command.option("--hide", request->hide, "A part of the body that is not drawn; may be repeated");
  command.option("--solver", request->solver, "Solver of the convergence map");
  command.flag("--joint-frames", request->jointFrames, "Axes of every joint");
  command.option(
      "--skin", request->skin,
      "Skinning method, such as lbs, dqs or cor+twist+smooth; otherwise the scene's or the model's");
  command
      .option("--layers", request->layers,
              "Muscle layers on known limbs: none, ffd (volumes without muscles) or muscle; otherwise "
              "the scene's")
      .oneOf({"none", "ffd", "muscle"});
  command.flag("--lattice", request->lattice, "Control planes of the muscle layers");
  command.option("--muscle-sheet", request->muscleSheet,
                 "Instead of one picture a sheet of this limb ('left arm', or joints "
                 "shoulder,elbow,wrist): straight, 60, 120 degrees; LBS, FFD, FFD with muscle");
  command.option("--turn", request->turns,
                 "JOINT=DEGREES sets the first axis of a joint, JOINT.y=DEGREES turns a ball about an "
                 "axis of its frame, from the pose; may be repeated");
  command.flag("--no-ground", request->noGround, "Without the ground");
  command.flag("--no-shadow", request->noShadow, "Without the shadow");
  command
      .option("--smoothing", request->smoothing,
              "Draw n x n pixels for one; otherwise what suits the renderer")
      .range(1, 4);
  command.option("--seconds", request->seconds, "Video: length of one turn")
      .range(0.01, 3600.0)
      .showDefault();
  command.option("--frames", request->frames, "Video: number of frames instead of --seconds").positive();
  command.option("--fps", request->framesPerSecond, "Video: frames a second").range(1, 240).showDefault();
  command.option(
      "--replay", request->replay,
      "Film this replay (docs/sandbox.md): the view alone, 30 pictures a second; needs .mp4 or .gif");
  command.run([request, film] { render(*request, film); });
}

}  // namespace gelenk
