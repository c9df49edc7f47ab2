#pragma once

#include <optional>
#include <vector>

#include "apps/document/camera.h"
#include "apps/document/document.h"
#include "skinning/muscles/muscle_layer.h"
#include "skinning/skin.h"

namespace gelenk {

/// Where a ray meets a surface first.
struct SurfaceHit {
  SurfacePoint point;
  Eigen::Vector3d position;  ///< metres, world
  double depth = 0.0;        ///< metres along the ray
};

/// The nearest triangle that the ray meets from outside (front faces only). positions: of the posed mesh, one
/// a vertex. Moeller and Trumbore 1997, every triangle: 0.36 ms of processor time for 70,000 triangles.
/// nullopt where it meets none.
std::optional<SurfaceHit> pickSurface(const std::vector<std::array<int, 3>>& triangles,
                                      const std::vector<Eigen::Vector3d>& positions, const Ray& ray);

/// The joint that carries most of a point of the skin.
int dominantJoint(const Skin& skin, const SurfacePoint& point);

/// A point of the skin by the linear blend, metres, world.
Eigen::Vector3d linearBlendPoint(const Skin& skin, const Frames& worldFromJoint, const SurfacePoint& point);

/// A control point of a limb's lattice: plane 6 link + (0 ... 6), point 4 j + i.
struct LatticePoint {
  int plane = -1, point = -1;
};
/// The plane whose grid of lines passes the pixel nearest, within so many pixels, and its control point
/// nearest to the pixel; of planes equally near the one nearer to the eye. What lies behind the eye is not
/// picked.
std::optional<LatticePoint> pickLattice(const LimbPose& limb, const Camera& camera, const Viewport& viewport,
                                        const Eigen::Vector2d& pixel, double reach = 8.0);

/// What the mouse may do to a dragged point: stay in the plane through `start` that faces the viewer, on the
/// horizontal plane through it, or on the line through it along one world axis.
enum class DragConstraint { ViewPlane, GroundPlane, AxisX, AxisY, AxisZ };

/// The point of the constraint's plane or line that lies under the pixel; for a line the one nearest to the
/// pixel's ray. nullopt where the ray runs nearly along the plane (within 3 degrees) or the line, or meets it
/// behind the eye.
std::optional<Eigen::Vector3d> dragTarget(const Camera& camera, const Viewport& viewport,
                                          const Eigen::Vector2d& pixel, const Eigen::Vector3d& start,
                                          DragConstraint constraint);

}  // namespace gelenk
