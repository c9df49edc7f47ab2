#pragma once

#include <Eigen/Core>
#include <optional>

#include "apps/render/label_places.h"
#include "apps/sandbox/sandbox_state.h"

namespace gelenk {

/// The goal that has the gizmo: the selected one, where it has a target or an orientation and nothing else is
/// shown; nullopt: none. Arrows need a target, rings an orientation that can be asked for.
struct GizmoPlace {
  GoalId goal = {};
  Eigen::Vector3d at = Eigen::Vector3d::Zero();  ///< world
  double size = 1.0;                             ///< length of an arrow, world
  bool arrows[3] = {true, true, true}, rings[3] = {true, true, true};
};
std::optional<GizmoPlace> gizmoOf(const Sandbox::State& state);

std::optional<GizmoPart> gizmoPartAt(const Sandbox::State& state, const GizmoPlace& place,
                                     const Eigen::Vector2d& pixel);

/// The angle of a window pixel about a world axis through a point, radians; nullopt where the axis is seen
/// from the side, so that no angle can be told.
std::optional<double> angleAbout(const Sandbox::State& state, const Eigen::Vector3d& at, int axis,
                                 const Eigen::Vector2d& pixel);

void drawGizmo(const Sandbox::State& state, ImDrawList& draw);
/// No words on its arrows and rings.
void keepGizmoFree(const Sandbox::State& state, LabelPlaces& places);

}  // namespace gelenk
