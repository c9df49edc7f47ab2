#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace gelenk {

class Sandbox;
struct Document;

/// One room of the sandbox: an inspector tab, a menu, a tab of the bottom strip, things drawn into the view,
/// a share of every frame. Override what is needed. All calls come from the one thread, inside
/// Sandbox::frame, in the order of panels.cpp.
///
/// What the document holds (pose, goals, weights, muscles, motion, view) is read and changed through
/// sandbox.session(), so that undo and scene files know of it; a panel keeps only how it is being looked at.
/// The Sandbox that is passed in (sandbox.h) gives showFrames() to pose the figure for a frame, overlays and
/// labels, open() and say().
class Panel {
 public:
  virtual ~Panel() = default;

  /// The inspector tab's title, and the panel's name in replays, commands and the status file.
  virtual std::string name() const = 0;

  virtual bool hasInspector() const { return false; }
  /// Inside the inspector's tab: plain ImGui calls; the width is about 300 px times the scale.
  virtual void drawInspector(Sandbox&) {}

  virtual bool hasBottomStrip() const { return false; }
  /// What its tab there shows, in a word or two; no other tab is called that.
  virtual std::string stripTitle() const { return name(); }
  /// Inside the bottom strip's tab (plots, timeline).
  virtual void drawBottomStrip(Sandbox&) {}

  /// To the right of the strip's tabs, after ImGui::SameLine, while the panel's is in front: a switch that
  /// would take a line of the strip.
  virtual void drawBesideTabs(Sandbox&) {}

  /// What a room sees: half of the window or more, in large type, without controls. False: nothing to
  /// present.
  virtual bool drawPresentation(Sandbox&) { return false; }

  /// Inside the main menu bar, between Model and Help: `if (ImGui::BeginMenu("Lecture")) {...}`.
  virtual void drawMenu(Sandbox&) {}

  /// Before the frame's solve: playback, goals that move by themselves. dt: seconds.
  virtual void step(Sandbox&, double /*dt*/) {}

  /// Seconds until the panel changes something by itself: 0 while it moves, infinity at rest.
  virtual double rests(const Sandbox&) const { return std::numeric_limits<double>::infinity(); }

  /// After the solve, before rendering: lines and labels over the view (sandbox.overlay(), label()).
  virtual void overlay(Sandbox&) {}

  /// After another document was opened, before anything else: drop everything that belonged to the old one
  /// and take up what sandbox.session().document() says. fromFile: a scene; false: a model as it begins.
  virtual void opened(Sandbox&, bool /*fromFile*/) {}
  /// Puts into the document what the panel alone knows of it, before it is written.
  virtual void store(const Sandbox&, Document&) const {}

  /// A key (GLFW key code); true when taken. Without Ctrl it is asked before the sandbox while the panel's
  /// tab or its strip's is in front, otherwise for what the sandbox itself has no use for.
  virtual bool keyPressed(Sandbox&, int /*key*/, int /*modifiers*/) { return false; }

  /// Takes back, or does again, what the panel did to the model itself: where the document's own history has
  /// nothing more. False: neither has the panel.
  virtual bool takeBack(Sandbox&, bool /*redo*/) { return false; }
  virtual bool canTakeBack(bool /*redo*/) const { return false; }

  /// A command of a replay, `do PANEL WORDS...`: what the panel's buttons do. Throws std::invalid_argument
  /// that says what is known.
  virtual void act(Sandbox&, const std::vector<std::string>& /*words*/) {
    throw std::invalid_argument("the panel " + name() + " takes no commands");
  }

  /// A tool that works on the view with the left mouse button, such as a brush: while true the sandbox shows
  /// and drags nothing under the mouse, presses go to pressed(), and keys to keyPressed() first.
  virtual bool takesMouse(const Sandbox&) const { return false; }
  /// What the mouse does while takesMouse(), for the status line.
  virtual std::string mouseHint() const { return {}; }
  /// Window pixel. True: the moves up to the release are the tool's; false: they turn the camera.
  virtual bool pressed(Sandbox&, const Eigen::Vector2d& /*pixel*/) { return false; }
  virtual void moved(Sandbox&, const Eigen::Vector2d& /*pixel*/) {}
  virtual void released(Sandbox&) {}

  /// A dropped or opened file that is no model and no scene (.bvh, .amc, ...); true when taken. May throw
  /// ParseError.
  virtual bool openFile(Sandbox&, const std::string& /*path*/) { return false; }

  /// The panel's entry under "panels" in the status file as a JSON text, "" for none. The same replay must
  /// give the same bytes.
  virtual std::string status() const { return {}; }
};

/// Every panel there is, in the order of their tabs: an explicit table in panels.cpp.
std::vector<std::unique_ptr<Panel>> makePanels();

}  // namespace gelenk
