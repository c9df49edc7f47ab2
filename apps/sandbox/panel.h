#pragma once

#include <Eigen/Core>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace gelenk {

class Sandbox;
struct Model;

/// One room of the sandbox: an inspector tab, a menu, a tab of the bottom strip, things drawn into the view,
/// a share of every frame. Override what is needed. All calls come from the one thread, inside
/// Sandbox::frame, in the order of panels.cpp.
///
/// The rest of the program is reached through the Sandbox that is passed in (sandbox.h): its session (pose,
/// goals, solver), openModel(), showFrames() to pose the figure for a frame, ghosts to draw further bodies,
/// deformer to replace the skinning, select(), requestStatus().
class Panel {
 public:
  virtual ~Panel() = default;

  /// The tab's title and the panel's key in scene files.
  virtual std::string name() const = 0;

  virtual bool hasInspector() const { return false; }
  /// Inside the inspector's tab: plain ImGui calls; the width is about 300 px times the scale.
  virtual void drawInspector(Sandbox&) {}

  virtual bool hasBottomStrip() const { return false; }
  /// Inside the bottom strip's tab (plots, timeline).
  virtual void drawBottomStrip(Sandbox&) {}

  /// Inside the main menu bar, between Model and Help: `if (ImGui::BeginMenu("Lecture")) {...}`.
  virtual void drawMenu(Sandbox&) {}

  /// Before the frame's solve: playback, goals that move by themselves. dt: seconds.
  virtual void step(Sandbox&, double /*dt*/) {}

  /// After the solve, before rendering: ghosts, and lines and labels over the view (sandbox.overlay(),
  /// label()).
  virtual void overlay(Sandbox&) {}

  /// After another model was opened: drop everything that belonged to the old one.
  virtual void modelChanged(Sandbox&) {}

  /// A key that the sandbox itself has no use for (GLFW key code); true when taken.
  virtual bool keyPressed(Sandbox&, int /*key*/, int /*modifiers*/) { return false; }

  /// A command of a replay, `do PANEL WORDS...`: what the panel's buttons do. Throws std::invalid_argument
  /// that says what is known.
  virtual void act(Sandbox&, const std::vector<std::string>& /*words*/) {
    throw std::invalid_argument("the panel " + name() + " takes no commands");
  }

  /// A tool that works on the view with the left mouse button, such as a brush: while true the sandbox shows
  /// and drags nothing under the mouse, presses go to pressed(), and keys to keyPressed() first.
  virtual bool takesMouse(const Sandbox&) const { return false; }
  /// Window pixel. True: the moves up to the release are the tool's; false: they turn the camera.
  virtual bool pressed(Sandbox&, const Eigen::Vector2d& /*pixel*/) { return false; }
  virtual void moved(Sandbox&, const Eigen::Vector2d& /*pixel*/) {}
  virtual void released(Sandbox&) {}

  /// After Sandbox::setWeights: the skin is bound anew, its mesh and skeleton are as they were.
  virtual void weightsChanged(Sandbox&) {}

  /// A dropped or opened file that is no model and no scene (.bvh, .amc, ...); true when taken. May throw
  /// ParseError.
  virtual bool openFile(Sandbox&, const std::string& /*path*/) { return false; }

  /// The panel's entry under "panels" in the status file as a JSON text, "" for none. The same replay must
  /// give the same bytes.
  virtual std::string status() const { return {}; }

  /// State for the scene file as a JSON text, "" for none; load gets what save returned. load may throw
  /// std::exception.
  virtual std::string save() const { return {}; }
  virtual void load(Sandbox&, const std::string& /*json*/) {}
  /// Throws what load would throw for this model and changes nothing: asked before a scene replaces what is
  /// open.
  virtual void verify(const Model&, const std::string& /*json*/) const {}
  /// A scene of the model that is open has no part of this panel: back to how the model begins.
  virtual void reset(Sandbox&) {}
};

/// Every panel there is, in the order of their tabs: an explicit table in panels.cpp.
std::vector<std::unique_ptr<Panel>> makePanels();

}  // namespace gelenk
