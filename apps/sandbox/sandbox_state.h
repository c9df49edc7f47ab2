#pragma once

#include <chrono>

#include "apps/document/pick.h"
#include "apps/render/renderer.h"
#include "apps/render/scene_marks.h"
#include "apps/render/scene_view.h"
#include "apps/sandbox/file_browser.h"
#include "apps/sandbox/gui.h"
#include "apps/sandbox/palette.h"
#include "apps/sandbox/preferences.h"
#include "apps/sandbox/recorder.h"
#include "apps/sandbox/sandbox.h"
#include "apps/sandbox/view_picture.h"

namespace gelenk {

/// Rectangles of the frame, pixels of the window.
struct Layout {
  struct Rect {
    float x = 0, y = 0, width = 0, height = 0;
    bool contains(double px, double py) const {
      return px >= x && py >= y && px < x + width && py < y + height;
    }
  };
  Rect view, inspector, rail, strip, statusLine;
};

/// What lies under the mouse, and what a press would take.
struct Hover {
  enum class Kind { Nothing, Goal, Joint, Skin };
  Kind kind = Kind::Nothing;
  GoalId goal = {};
  int joint = -1;  ///< Skin: the joint that carries most of the point
  SurfacePoint surface = {};
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Grip grip() const {
    return kind == Kind::Goal ? Grip(goal) : kind == Kind::Joint ? Grip(JointGrip{joint}) : Grip(surface);
  }
};

/// What of the gizmo lies under a pixel: an arrow along a world axis, a ring about one.
struct GizmoPart {
  enum class Kind { Arrow, Ring };
  Kind kind = Kind::Arrow;
  int axis = 0;  ///< 0, 1, 2: x, y, z
  bool operator==(const GizmoPart&) const = default;
};

/// The mouse between press and release.
struct Gesture {
  enum class Kind { None, PressedSkin, Drag, Orbit, Pan, Tool };
  Kind kind = Kind::None;
  int button = -1;
  Eigen::Vector2d press = Eigen::Vector2d::Zero();  ///< window pixels
  Eigen::Vector2d last = Eigen::Vector2d::Zero();
  Eigen::Vector2d grip = Eigen::Vector2d::Zero();   ///< from the mouse to the dragged point's pixel
  Eigen::Vector3d start = Eigen::Vector3d::Zero();  ///< target when the present constraint began
  DragConstraint constraint = DragConstraint::ViewPlane;
  DragConstraint lock = DragConstraint::ViewPlane;  ///< chosen by X, Y, Z
  bool rotated = false;                             ///< Alt turned the goal since the last move
  std::optional<GizmoPart> part = {};               ///< of the gizmo, that is being dragged
  double angle = 0.0;                               ///< radians that the ring was turned
  std::optional<double> lastAngle = {};             ///< of the mouse about the ring's axis
  Hover pressed;
  Panel* tool = nullptr;  ///< Tool: the panel that took the press
};

constexpr double noticeFade = 0.5;  ///< seconds in which a notice goes
struct Notice {
  std::string words;
  bool isError = false;
  double until = 0.0;  ///< sandbox time
};

/// Histories for the plots; newest last.
struct PlotHistory {
  struct Drag {
    std::vector<double> residuals;
    std::string solver;
  };
  std::vector<Drag> earlier;      ///< worst frame of the last drags
  std::vector<double> residuals;  ///< of the last frame that iterated
  std::vector<double> worst;      ///< of the present drag's frame with most iterations
  std::vector<double> errors;     ///< largest goal error a frame, metres
};

struct Sandbox::State {
  SandboxOptions options;
  Gui gui;
  Renderer renderer;
  ViewPicture picture;

  // model
  std::unique_ptr<Session> session;
  std::unique_ptr<SceneView> view;  ///< the way to the picture
  std::string scenePath;

  // pose and surface of this frame
  std::optional<Frames> shownFrames;
  bool handlesOnShown = false;  ///< the session stands as shown

  // view
  struct CameraMove {
    Camera from, to;
    double begin = 0.0;
  };
  std::optional<CameraMove> cameraMove;
  float scale = 1.0f;
  Layout layout;
  PictureExtras extras;                ///< what panels add to this frame's picture
  std::vector<SceneLabel> labels;      ///< of this frame's picture
  std::vector<double> limitGlow;       ///< a joint, 1 at its limit, fading
  std::optional<GoalId> selectedGoal;  ///< may have gone meanwhile: goalSelected()

  // input
  Eigen::Vector2d mouse{-1.0, -1.0};
  bool buttons[3] = {false, false, false};
  bool ctrl = false, shift = false, alt = false;
  bool turnKey = false;  ///< T, which turns as Alt does: many window managers keep Alt + drag for themselves
  Hover hover;
  Gesture gesture;

  // panels
  std::vector<std::unique_ptr<Panel>> panels;
  std::string inspectorTab, stripTab;  ///< in front; empty: the first
  bool inspectorOpen = true, stripOpen = true, presenting = false, helpOpen = false, playing = false,
       closing = false;
  enum class Dialog { None, OpenFile, SaveScene, Unsaved } dialog = Dialog::None;
  FileBrowser browser;
  CommandPalette palette;
  Preferences preferences, written;          ///< as they are, and as the file has them
  std::function<void(Sandbox&)> next;        ///< what Unsaved stands in the way of
  std::function<void(Sandbox&)> afterFrame;  ///< run when the frame is drawn: it may open another document
  std::string toOpen;                        ///< chosen in a menu or dialog
  int savedEdits = 0;                        ///< Session::editCount() when the document was opened or saved
  std::string drawn;                         ///< what the picture of the view was made from; empty: not known
  bool drawnFine = false;                    ///< smooth, as a still picture is
  bool drawnSmall = false;                   ///< in fewer pixels than it is shown in
  std::vector<Notice> notices;
  PlotHistory plots;
  std::string screenshotPath;  ///< written at the end of the frame
  Recorder recorder;

  int windowWidth = 0, windowHeight = 0;  ///< pixels
  int frameNumber = 0;
  int settling = 1;  ///< frames to draw yet: the first, and panels take some to come to rest after input
  double time = 0.0;
  std::optional<std::chrono::steady_clock::time_point> lastBegin;
  double secondsPerFrame = 0.0;  ///< measured from frame to frame while something moves, running mean

  // the document's
  Camera& camera() const { return session->view().camera; }
  ViewOptions& show() const { return session->view().show; }
  Theme& theme() const { return session->theme(); }
  std::optional<int> selectedJoint() const { return session->selectedJoint(); }

  /// Type of a presentation, pixels: to be read from the last row.
  float presentationType() const { return static_cast<float>(windowHeight) / 30.0f; }
  /// Of what is written and drawn over the view: larger where a room looks at it.
  float viewScale() const { return presenting ? std::max(scale, presentationType() / 20.0f) : scale; }
  bool turning() const { return alt || turnKey; }
  double size() const { return view->size(); }  ///< diagonal of the rest pose, metres

  std::optional<GoalId> goalSelected() const {
    return selectedGoal && session->hasGoal(*selectedGoal) ? selectedGoal : std::nullopt;
  }
  Viewport viewport() const {
    return {std::max(1, static_cast<int>(layout.view.width)),
            std::max(1, static_cast<int>(layout.view.height))};
  }
  Eigen::Vector2d toView(const Eigen::Vector2d& windowPixel) const {
    return windowPixel - Eigen::Vector2d(layout.view.x, layout.view.y);
  }
  /// Pixel in the window; a negative depth lies behind the viewer.
  Projected toWindow(const Eigen::Vector3d& point) const {
    Projected p = project(camera(), viewport(), point);
    p.pixel += Eigen::Vector2d(layout.view.x, layout.view.y);
    return p;
  }
  const Palette& colours() const { return gelenk::palette(theme()); }
};

// viewport.cpp: mouse and keys over the view
void handleViewInput(Sandbox& sandbox, const Input& input);
void frameEverything(Sandbox& sandbox, bool glide);
void frameSelection(Sandbox& sandbox);         ///< everything where nothing is selected
void frameReachable(Sandbox& sandbox);         ///< steps back until the reachable set is in view
void undoOrRedo(Sandbox& sandbox, bool redo);  ///< says so where there is nothing
void mirrorPose(Sandbox& sandbox);             ///< the selection goes along with its goal
/// The handle that a press at the window's pixel takes.
std::optional<GoalId> handleAt(const Sandbox::State& state, const Eigen::Vector2d& pixel);
/// The panel whose tool has the mouse; nullptr: dragging is on.
Panel* toolOf(Sandbox& sandbox);
/// Another method; where only pins stand in its way they are freed, and that is said.
void chooseSolver(Sandbox& sandbox, const std::string& name);

// marks.cpp: what lights up, and what is written over the picture
void glowLimits(Sandbox& sandbox);
void drawMarks(Sandbox& sandbox);

void toggleRecording(Sandbox& sandbox);  // shell.cpp
/// "gelenk-0001.png" and so on: the first one that is not there.
std::string nextFileName(const std::string& ending);

// shell.cpp: menu bar, inspector, strip, status line, dialogs
void askForFiles(Sandbox::State& state);
Layout layOut(const Sandbox::State& state, int width, int height);
void drawShell(Sandbox& sandbox);
/// What the mouse does now, as the status line says it.
std::string mouseHint(Sandbox& sandbox);
/// At its right: the solver and its last frame, the renderer.
std::string statusFacts(Sandbox& sandbox);

/// Around the present window, which floats over others: a soft shadow, and the corners that go with it
/// (pushFloating before its Begin, popFloating after its End).
void pushFloating(const Sandbox::State& state);
void dropShadow(const Sandbox::State& state);
void popFloating();
/// A small dim line of words over a group of an inspector.
void heading(const Sandbox::State& state, const char* words);
/// A colour map, viridis where none is named, from 0 to 1 over the whole width, with what its ends mean below
/// it; without words where other lines say it.
using ColourMap = Colour (*)(float t);
void colourBar(const Sandbox::State& state, ColourMap map);
void colourBar(const Sandbox::State& state, ColourMap map, const char* least, const char* most);
void colourBar(const Sandbox::State& state, const char* least, const char* most);
/// A tooltip over the item before it: what a quantity is, its unit and formula.
void tooltip(const char* words);
/// The same, at the mouse, whatever lies there.
void showTooltip(const char* words);
/// The largest errors of the goals: 0.42 mm, and the angle where it can be seen.
std::string describeErrors(const FrameSolve& solve);
/// A text in lines of at most so many pixels of the present font, broken at blanks, a path that is longer
/// than a line after its slashes: numbers stay whole.
std::string brokenAtBlanks(const std::string& text, float width);
/// A text in as many such lines as the room in its window asks for.
void wrappedText(const std::string& words);
void wrappedText(const ImVec4& colour, const std::string& words);
/// "out of reach by 41.3 mm: this is the closest pose" and the like.
std::string describeSolve(const Session& session);
/// 0.42 mm, 41.3 mm, 1.27 m.
std::string formatLength(double metres);

}  // namespace gelenk
