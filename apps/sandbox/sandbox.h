#pragma once

#include <array>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/document/session.h"
#include "apps/render/scene_view.h"
#include "apps/sandbox/input.h"
#include "apps/sandbox/panel.h"
#include "skinning/muscles/muscle_control.h"

namespace gelenk {

/// What the sandbox is started with.
struct SandboxOptions {
  std::string model = "figure";
  Companions files = {};
  int width = 1280, height = 800;  ///< pixels
  double scale = 1.0;              ///< of type and spacing
  Theme theme = Theme::Light;
  std::string solver = "drag";
  std::string skin = {};                   ///< method (skin_choice.h); empty: the scene's or the model's
  std::vector<std::string> settings = {};  ///< values of its parameters, "dls.lambda=0.1"
  std::string preferences = {};  ///< file of what the window remembers (preferences.h); empty: nothing
  bool bare = false;             ///< the view alone, without menus and panels: for films
  bool asks = false;             ///< before unsaved changes are lost: a person sits before it
  bool refines = false;          ///< draws what stands still once more, smoother and with darker folds
  std::function<void()> chooseFiles = {};  ///< asks for files to open; empty: the sandbox's own dialog
  std::function<void()> shareScene = {};   ///< makes a link to the scene; empty: that is not offered
};

/// The sandbox: session, panels, view and picture. One frame(input, dt) serves window, offscreen and replay.
/// Needs a current OpenGL 3.3 context for its whole life.
class Sandbox {
 public:
  explicit Sandbox(const SandboxOptions& options);
  ~Sandbox();
  Sandbox(const Sandbox&) = delete;
  Sandbox& operator=(const Sandbox&) = delete;

  /// Takes input, steps, solves, draws into the framebuffer that is bound. dt: seconds. Deterministic but for
  /// what is measured (times, fps), which is shown and never fed back.
  void frame(const Input& input, double dt);
  bool wantsToClose() const;
  void requestClose();  ///< closes, where there is nothing to ask
  /// Seconds for which the next frame would look like the last one if nothing happens: 0 while anything moves
  /// (the solver, a clip, a glow, a camera that glides), infinity at rest.
  double rests() const;
  /// So many seconds passed beside those that frames are told.
  void slept(double seconds);

  // --- model and scene
  Session& session();
  const Session& session() const;
  /// A built-in name, a model file, a scene (.json), or a file that a panel takes. Failures are shown on
  /// screen and return false; what is open stays open.
  bool open(const std::string& nameOrFile) { return open(ModelReference{.nameOrFile = nameOrFile}); }
  bool open(const ModelReference& reference);  ///< a model with all its files
  /// The same as a person asks for it: unsaved changes are asked about first, a mesh without a skeleton is
  /// offered one. A file whose kind needs no question opens at once.
  void requestOpen(const std::string& nameOrFile);
  /// Files, or a folder of them, that came at once: what they are together (files_together.h).
  void requestOpen(const std::vector<std::string>& paths);
  /// Does it, or asks first where changes that are not saved would be lost.
  void whenSaved(std::function<void(Sandbox&)> what);
  /// A model that the program made itself. Nothing of the document before goes into the new one, but for the
  /// user's preferences (theme).
  void openModel(Model model, const ModelReference& reference);
  /// A document of that model.
  void openDocument(std::shared_ptr<const Model> model, Document document);
  bool saveSceneTo(const std::string& path);
  /// What saveSceneTo writes: all that is needed to see this picture again.
  Document document() const;

  // --- what panels use
  Camera& camera();
  ViewOptions& options();
  Theme theme() const;
  float scale() const;  ///< HiDPI factor: multiply pixel sizes by it
  int frameNumber() const;
  Keys keys() const;    ///< whom those of the next frame belong to
  double time() const;  ///< sum of dt, seconds

  /// Shows these frames instead of the session's pose, in this frame only; the solver rests. For poses that
  /// no q describes; where one does, prefer session().setPose(q). withHandles: the session stands in the same
  /// pose, so that its handles can be shown and taken.
  void showFrames(Frames worldFromJoint, bool withHandles = false);
  /// What is drawn: the frames shown, else the session's.
  const Frames& shownFrames() const;
  /// The model's surface as it was drawn last (world, metres); empty without a skin.
  const SkinnedVertices& surface() const;

  /// The muscle layers that the document asks for, bound; nullptr: none.
  const MuscleRig* muscles() const;
  /// The limbs of this frame; empty without muscle layers.
  const std::vector<LimbPose>& limbPoses() const;
  void markLattice(int plane, int point);  ///< drawn stronger, this frame
  Overlay& overlay();  ///< lines, dots, bones, fills over the view, this frame (apps/render/renderer.h)
  Overlay& overlayInScene();  ///< the same, hidden by bodies in front
  /// What the open example of the lecture shows, this frame; it must live until the frame ends.
  void showLecture(LectureDrawing& drawing);
  /// Text at a world point, this frame; colour sRGB 0..1.
  void label(const Eigen::Vector3d& at, const std::string& text, const Eigen::Vector4f& colour);
  /// One value in [0, 1] a vertex, shown as viridis instead of the clay, this frame: weights, distances,
  /// strain.
  void showVertexScalars(const std::vector<float>& values);
  /// Any colours instead, linear light 0..1, one a vertex.
  void showVertexColours(std::vector<Eigen::Vector3f> colours);

  std::optional<int> selectedJoint() const;
  void select(std::optional<int> joint);
  void say(const std::string& sentence, bool isError = false);  ///< a notice at the lower edge that fades
  bool playing() const;  ///< Space toggles it; panels that play motion obey it
  void setPlaying(bool playing);
  void showInspector(const std::string& panelName);  ///< brings a tab to the front
  void showBottomStrip(const std::string& panelName);

  /// Everything the status file holds, as a JSON text (docs/sandbox.md).
  std::string status() const;
  std::string renderer() const;  ///< GL_RENDERER

  /// A film of what is shown from the next frame on, .mp4 or .gif; says so where it cannot be written.
  bool startRecording(const std::string& path);
  bool stopRecording();  ///< false: it could not be finished, which was said

  struct State;
  State& state() { return *state_; }  ///< for the sandbox's own files

 private:
  void adopt(std::unique_ptr<Session> session, bool fromFile);

  std::unique_ptr<State> state_;
};

}  // namespace gelenk
