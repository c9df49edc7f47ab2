#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <imgui_internal.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "apps/sandbox/branches.h"
#include "apps/sandbox/gizmo.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/rotation.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double handleReach = 13.0, jointReach = 8.0;  // pixels at scale 1
constexpr double dragThreshold = 3.0;
constexpr double radiansPerPixel = 0.01;  // Alt turning

Hover hoverAt(Sandbox& sandbox, const Vector2d& pixel) {
  Sandbox::State& s = sandbox.state();
  const Session& session = *s.session;
  Hover best;
  if (const auto goal = handleAt(s, pixel))
    return {.kind = Hover::Kind::Goal, .goal = *goal, .position = session.reached(*goal)};
  if (s.show().skeleton || !session.skin()) {
    double nearest = jointReach * s.viewScale();
    for (int i = 0; i < session.skeleton().jointCount(); ++i) {
      const Projected p = s.toWindow(sandbox.shownFrames()[i].translation());
      if (const double d = (p.pixel - pixel).norm(); p.depth > 0.0 && d < nearest) {
        nearest = d;
        best = {.kind = Hover::Kind::Joint, .joint = i, .position = sandbox.shownFrames()[i].translation()};
      }
    }
    if (best.kind != Hover::Kind::Nothing) return best;
  }
  if (session.skin() && (s.show().skin || s.show().wireframe)) {
    const Ray ray = rayThroughPixel(s.camera(), s.viewport(), s.toView(pixel));
    if (const auto hit = pickSurface(s.view->triangles(session), sandbox.surface().positions, ray))
      return {.kind = Hover::Kind::Skin,
              .joint = dominantJoint(*session.skin(), hit->point),
              .surface = hit->point,
              .position = hit->position};
  }
  return best;
}

void restartConstraint(Sandbox::State& s) {
  s.gesture.start = s.session->goal(*s.session->dragged()).goal.target;
  s.gesture.grip = s.toWindow(s.gesture.start).pixel - s.mouse;
}

void beginDrag(Sandbox::State& s, const Hover& hover) {
  s.selectedGoal = s.session->beginDrag(hover.grip());
  s.session->selectJoint(s.session->goal(*s.selectedGoal).goal.joint);
  s.gesture.kind = Gesture::Kind::Drag;
  s.gesture.constraint = s.gesture.lock = DragConstraint::ViewPlane;
  restartConstraint(s);
  s.plots.worst.clear();
}

/// Turns the goal with the mouse about the ring's axis; where the ring is seen from the side, along it.
void turnRing(Sandbox::State& s) {
  const int axis = s.gesture.part->axis;
  const auto angle = angleAbout(s, s.session->reached(*s.session->dragged()), axis, s.mouse);
  double turn = 0.0;
  if (angle && s.gesture.lastAngle) {
    turn = std::remainder(*angle - *s.gesture.lastAngle, 2.0 * M_PI);
  } else if (!angle) {
    const Eigen::Matrix3d view = s.camera().axes();
    const Vector3d along = Vector3d::Unit(axis).cross(view.col(2));  // how the near side moves
    const Vector2d moved = s.mouse - s.gesture.last;
    turn = radiansPerPixel * (moved.x() * along.dot(view.col(0)) - moved.y() * along.dot(view.col(1)));
  }
  s.gesture.lastAngle = angle;
  if (turn == 0.0) return;
  s.gesture.angle += turn;
  s.session->rotateDrag(expRotation(Vector3d(turn * Vector3d::Unit(axis))));
}

void continueDrag(Sandbox::State& s) {
  const Vector2d moved = s.mouse - s.gesture.last;
  if (s.gesture.part && s.gesture.part->kind == GizmoPart::Kind::Ring) return turnRing(s);
  if (s.turning()) {
    if (moved.norm() > 0.0) {
      const Eigen::Matrix3d axes = s.camera().axes();
      const Vector3d turn = radiansPerPixel * (moved.x() * axes.col(1) + moved.y() * axes.col(0));
      s.session->rotateDrag(expRotation(turn));
    }
    s.gesture.rotated = true;
    return;
  }
  const DragConstraint wanted = s.gesture.lock != DragConstraint::ViewPlane ? s.gesture.lock
                                : s.shift                                   ? DragConstraint::GroundPlane
                                                                            : DragConstraint::ViewPlane;
  if (wanted != s.gesture.constraint || s.gesture.rotated) {
    s.gesture.constraint = wanted;
    s.gesture.rotated = false;
    restartConstraint(s);
  }
  const Vector2d pixel = s.toView(s.mouse + s.gesture.grip);
  if (const auto target = dragTarget(s.camera(), s.viewport(), pixel, s.gesture.start, wanted))
    s.session->moveDrag(s.gesture.start +
                        (*target - s.gesture.start).cwiseMax(-10.0 * s.size()).cwiseMin(10.0 * s.size()));
}

void press(Sandbox& sandbox, int button) {
  Sandbox::State& s = sandbox.state();
  if (s.gesture.kind != Gesture::Kind::None) return;
  s.gesture = {};
  s.gesture.button = button;
  s.gesture.press = s.gesture.last = s.mouse;
  s.cameraMove.reset();
  if (button == GLFW_MOUSE_BUTTON_RIGHT || (button == GLFW_MOUSE_BUTTON_MIDDLE && s.shift)) {
    s.gesture.kind = Gesture::Kind::Pan;
  } else if (button == GLFW_MOUSE_BUTTON_MIDDLE) {
    s.gesture.kind = Gesture::Kind::Orbit;
  } else if (Panel* tool = toolOf(sandbox)) {
    s.gesture.kind = tool->pressed(sandbox, s.mouse) ? Gesture::Kind::Tool : Gesture::Kind::Orbit;
    s.gesture.tool = tool;
  } else {
    if (const auto gizmo = gizmoOf(s))
      if (const auto part = gizmoPartAt(s, *gizmo, s.mouse)) {
        beginDrag(s, {.kind = Hover::Kind::Goal, .goal = gizmo->goal});
        s.gesture.part = part;
        if (part->kind == GizmoPart::Kind::Arrow)
          s.gesture.lock = static_cast<DragConstraint>(static_cast<int>(DragConstraint::AxisX) + part->axis);
        else
          s.gesture.lastAngle = angleAbout(s, gizmo->at, part->axis, s.mouse);
        return;
      }
    s.gesture.pressed = hoverAt(sandbox, s.mouse);
    switch (s.gesture.pressed.kind) {
      case Hover::Kind::Nothing: s.gesture.kind = Gesture::Kind::Orbit; break;
      case Hover::Kind::Goal: beginDrag(s, s.gesture.pressed); break;
      default: s.gesture.kind = Gesture::Kind::PressedSkin; break;
    }
  }
}

void release(Sandbox& sandbox, int button) {
  Sandbox::State& s = sandbox.state();
  if (s.gesture.kind == Gesture::Kind::None || button != s.gesture.button) return;
  if (s.gesture.kind == Gesture::Kind::Drag) {
    s.session->endDrag();
  } else if (s.gesture.kind == Gesture::Kind::PressedSkin) {
    s.session->selectJoint(s.gesture.pressed.joint);  // a click
  } else if (s.gesture.kind == Gesture::Kind::Tool) {
    s.gesture.tool->released(sandbox);
  } else if (s.gesture.kind == Gesture::Kind::Orbit && !s.gesture.tool &&
             (s.mouse - s.gesture.press).norm() < dragThreshold * s.scale &&
             !takeBranchAt(sandbox, s.mouse)) {
    s.session->selectJoint(std::nullopt);
    s.selectedGoal.reset();
  }
  s.gesture = {};
}

void moveMouse(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (s.gesture.kind == Gesture::Kind::Drag && !s.session->dragged())
    s.gesture = {};  // something else ended the drag, such as a pose that was mirrored or a goal let go
  const Vector2d moved = s.mouse - s.gesture.last;
  switch (s.gesture.kind) {
    case Gesture::Kind::PressedSkin:
      if ((s.mouse - s.gesture.press).norm() >= dragThreshold * s.scale) {
        const Vector2d now = s.mouse;
        s.mouse = s.gesture.press;  // what was pressed is what follows
        beginDrag(s, s.gesture.pressed);
        s.mouse = now;
      }
      break;
    case Gesture::Kind::Orbit:
      if (!s.session->model().planar || s.gesture.button == GLFW_MOUSE_BUTTON_MIDDLE)
        s.camera() = orbit(s.camera(), s.viewport(), moved);
      else
        s.camera() = pan(s.camera(), s.viewport(), moved);
      break;
    case Gesture::Kind::Pan: s.camera() = pan(s.camera(), s.viewport(), moved); break;
    case Gesture::Kind::Tool: s.gesture.tool->moved(sandbox, s.mouse); break;
    default: break;
  }
  if (s.gesture.kind == Gesture::Kind::Drag) continueDrag(s);
  s.gesture.last = s.mouse;
}

void glideTo(Sandbox::State& s, const Camera& to) { s.cameraMove = {s.camera(), to, s.time}; }

void pinUnderMouse(Sandbox::State& s) {
  if (s.session->dragged())
    s.session->togglePin(*s.session->dragged());
  else if (s.hover.kind != Hover::Kind::Nothing)
    s.session->togglePin(s.hover.grip());
  else if (const auto goal = s.goalSelected())
    s.session->togglePin(*goal);
  s.hover = {};
}

void deleteGoal(Sandbox::State& s) {
  const std::optional<GoalId> goal =
      s.hover.kind == Hover::Kind::Goal ? std::optional(s.hover.goal) : s.goalSelected();
  if (!goal || s.session->dragged()) return;
  s.session->remember();
  s.session->removeGoal(*goal);
  s.hover = {};
}

bool controlKey(Sandbox& sandbox, int key) {
  Sandbox::State& s = sandbox.state();
  switch (key) {
    case GLFW_KEY_Z: undoOrRedo(sandbox, s.shift); return true;
    case GLFW_KEY_Y: undoOrRedo(sandbox, true); return true;
    case GLFW_KEY_S:
      if (s.scenePath.empty() || s.shift)
        s.dialog = Sandbox::State::Dialog::SaveScene;
      else
        sandbox.saveSceneTo(s.scenePath);
      return true;
    case GLFW_KEY_O: askForFiles(s); return true;
    case GLFW_KEY_Q: sandbox.requestClose(); return true;
    case GLFW_KEY_K: s.palette.open(); return true;
    case GLFW_KEY_R: toggleRecording(sandbox); return true;
    default: return false;
  }
}

bool plainKey(Sandbox& sandbox, int key) {
  Sandbox::State& s = sandbox.state();
  if (s.gesture.kind == Gesture::Kind::Drag && key >= GLFW_KEY_X && key <= GLFW_KEY_Z) {
    const auto axis = static_cast<DragConstraint>(static_cast<int>(DragConstraint::AxisX) + key - GLFW_KEY_X);
    s.gesture.lock = s.gesture.lock == axis ? DragConstraint::ViewPlane : axis;
    return true;
  }
  switch (key) {
    case GLFW_KEY_P: pinUnderMouse(s); return true;
    case GLFW_KEY_R:
      s.gesture = {};
      s.hover = {};
      s.session->resetPose();
      return true;
    case GLFW_KEY_M: mirrorPose(sandbox); return true;
    case GLFW_KEY_TAB: s.session->nextSolver(s.shift ? -1 : 1); return true;
    case GLFW_KEY_SPACE: s.playing = !s.playing; return true;
    case GLFW_KEY_DELETE: deleteGoal(s); return true;
    case GLFW_KEY_F: frameSelection(sandbox); return true;
    case GLFW_KEY_HOME: frameEverything(sandbox, true); return true;
    case GLFW_KEY_1:
    case GLFW_KEY_KP_1: glideTo(s, lookFrom(s.camera(), StandardView::Front)); return true;
    case GLFW_KEY_3:
    case GLFW_KEY_KP_3: glideTo(s, lookFrom(s.camera(), StandardView::Side)); return true;
    case GLFW_KEY_7:
    case GLFW_KEY_KP_7: glideTo(s, lookFrom(s.camera(), StandardView::Top)); return true;
    case GLFW_KEY_5:
    case GLFW_KEY_KP_5: s.camera().orthographic = !s.camera().orthographic; return true;
    case GLFW_KEY_H:
    case GLFW_KEY_SLASH: s.helpOpen = !s.helpOpen; return true;
    case GLFW_KEY_F5: s.presenting = !s.presenting; return true;
    case GLFW_KEY_F12: s.screenshotPath = nextFileName(".png"); return true;
    case GLFW_KEY_ESCAPE:
      if (ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup)) {  // a list or a menu
        ImGui::ClosePopupToLevel(0, true);
        return true;
      }
      if (s.gesture.kind == Gesture::Kind::Drag) {
        s.session->cancelDrag();
        s.gesture = {};
      }
      s.helpOpen = s.presenting = false;
      return true;
    default: return false;
  }
}

/// Its inspector or its strip is seen.
bool isInFront(const Sandbox::State& s, const Panel& panel) {
  if (s.presenting) return false;
  return (s.layout.inspector.width > 0 && panel.name() == s.inspectorTab) ||
         (s.layout.strip.height > 0 && panel.name() == s.stripTab);
}

void pressKey(Sandbox& sandbox, int key) {
  Sandbox::State& s = sandbox.state();
  const int modifiers =
      (s.ctrl ? GLFW_MOD_CONTROL : 0) | (s.shift ? GLFW_MOD_SHIFT : 0) | (s.alt ? GLFW_MOD_ALT : 0);
  if (Panel* tool = toolOf(sandbox); tool && tool->keyPressed(sandbox, key, modifiers)) return;
  for (const auto& panel : s.panels)
    if (!s.ctrl && isInFront(s, *panel) && panel->keyPressed(sandbox, key, modifiers)) return;
  if (s.ctrl ? controlKey(sandbox, key) : plainKey(sandbox, key)) return;
  for (const auto& panel : s.panels)
    if (panel->keyPressed(sandbox, key, modifiers)) return;
}

void trackModifiers(Sandbox::State& s, const InputEvent& event) {
  switch (event.code) {
    case GLFW_KEY_LEFT_CONTROL:
    case GLFW_KEY_RIGHT_CONTROL: s.ctrl = event.down; break;
    case GLFW_KEY_LEFT_SHIFT:
    case GLFW_KEY_RIGHT_SHIFT: s.shift = event.down; break;
    case GLFW_KEY_LEFT_ALT:
    case GLFW_KEY_RIGHT_ALT: s.alt = event.down; break;
    case GLFW_KEY_T: s.turnKey = event.down; break;
    default: break;
  }
}

}  // namespace

Panel* toolOf(Sandbox& sandbox) {
  for (const auto& panel : sandbox.state().panels)
    if (panel->takesMouse(sandbox)) return panel.get();
  return nullptr;
}

std::string nextFileName(const std::string& ending) {
  for (int n = 1;; ++n)
    if (std::string name = fmt::format("gelenk-{:04}{}", n, ending); !std::filesystem::exists(name))
      return name;
}

std::optional<GoalId> handleAt(const Sandbox::State& s, const Vector2d& pixel) {
  if (!s.show().handles || (s.shownFrames && !s.handlesOnShown)) return std::nullopt;
  std::optional<GoalId> best;
  double nearest = handleReach * s.viewScale();
  for (const SceneGoal& goal : s.session->goals()) {
    if (!s.view->shows(*s.session, goal)) continue;
    const Projected p = s.toWindow(s.session->reached(goal.id));
    if (const double d = (p.pixel - pixel).norm(); p.depth > 0.0 && d < nearest) {
      nearest = d;
      best = goal.id;
    }
  }
  return best;
}

void chooseSolver(Sandbox& sandbox, const std::string& name) {
  Session& session = sandbox.session();
  if (!session.whyUnsupported(name).empty() && session.whyUnsupported(name, Session::Pins::Freed).empty()) {
    session.freePins();
    sandbox.say("Pins freed, since this solver moves one chain; undo brings them back");
  }
  session.setSolver(name);
}

void undoOrRedo(Sandbox& sandbox, bool redo) {
  Sandbox::State& s = sandbox.state();
  s.gesture = {};
  s.hover = {};
  if (redo ? s.session->redo() : s.session->undo()) return;
  for (const auto& panel : s.panels)
    if (panel->takeBack(sandbox, redo)) return;
  sandbox.say(redo ? "Nothing to redo" : "Nothing to undo");
}

void mirrorPose(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  const auto selected = s.goalSelected();
  try {
    s.session->mirrorPose();
  } catch (const std::exception& error) {
    return sandbox.say(error.what(), true);
  }
  if (!selected) return;
  s.selectedGoal = s.session->mirrored(*selected);
  s.session->selectJoint(s.session->goal(*s.selectedGoal).goal.joint);
}

void frameSelection(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  if (!s.selectedJoint()) return frameEverything(sandbox, true);
  Eigen::AlignedBox3d box;
  const Vector3d at = sandbox.shownFrames()[*s.selectedJoint()].translation();
  box.extend(at - Vector3d::Constant(0.08 * s.size()));
  box.extend(at + Vector3d::Constant(0.08 * s.size()));
  for (const int child : s.session->skeleton().children(*s.selectedJoint()))
    box.extend(sandbox.shownFrames()[child].translation());
  glideTo(s, frameBox(s.camera(), s.viewport(), box));
}

void frameEverything(Sandbox& sandbox, bool glide) {
  Sandbox::State& s = sandbox.state();
  const Camera camera = s.view->wholeView(*s.session, s.viewport(), s.view->bounds());
  if (glide)
    glideTo(s, camera);
  else
    s.camera() = camera;
}

void frameReachable(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  Eigen::AlignedBox3d box = s.view->bounds();
  box.extend(s.view->teaching().reachableBox(*s.session, s.goalSelected()));
  const Camera camera = frameBox(s.camera(), s.viewport(), box);
  if (camera.distance > s.camera().distance) glideTo(s, camera);
}

void handleViewInput(Sandbox& sandbox, const Input& input) {
  Sandbox::State& s = sandbox.state();
  const ImGuiIO& io = ImGui::GetIO();
  const bool typing =
      sandbox.keys() == Keys::Text || s.dialog != Sandbox::State::Dialog::None || s.palette.isOpen();
  for (const InputEvent& event : input.events) {
    switch (event.kind) {
      case InputEvent::Kind::MouseMove:
        s.mouse = {event.x, event.y};
        moveMouse(sandbox);
        break;
      case InputEvent::Kind::MouseButton:
        if (event.down && s.layout.view.contains(s.mouse.x(), s.mouse.y()) && !io.WantCaptureMouse && !typing)
          press(sandbox, event.code);
        if (!event.down) release(sandbox, event.code);
        break;
      case InputEvent::Kind::Wheel:
        if (s.layout.view.contains(s.mouse.x(), s.mouse.y()) && !io.WantCaptureMouse) {
          s.cameraMove.reset();
          s.camera() = zoomTo(s.camera(), s.viewport(), s.toView(s.mouse), std::pow(0.9, event.y));
        }
        break;
      case InputEvent::Kind::Key:
        trackModifiers(s, event);
        if (event.down && !typing) pressKey(sandbox, event.code);
        break;
      case InputEvent::Kind::Drop: sandbox.requestOpen(event.paths); break;
      case InputEvent::Kind::Character: break;
    }
  }
  if (s.gesture.kind == Gesture::Kind::Drag && s.session->dragged())
    continueDrag(s);  // modifiers may have changed
  const bool free = s.gesture.kind == Gesture::Kind::None && !toolOf(sandbox) &&
                    s.layout.view.contains(s.mouse.x(), s.mouse.y()) && !io.WantCaptureMouse;
  const auto gizmo = free ? gizmoOf(s) : std::nullopt;
  s.hover = free && !(gizmo && gizmoPartAt(s, *gizmo, s.mouse)) ? hoverAt(sandbox, s.mouse) : Hover{};
}

}  // namespace gelenk
