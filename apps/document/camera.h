#pragma once

#include <Eigen/Geometry>

namespace gelenk {

/// Pixels of the picture; the origin of pixel coordinates is its top left corner, y down.
struct Viewport {
  int width = 1280, height = 800;
  double aspect() const { return height > 0 ? static_cast<double>(width) / height : 1.0; }
};

enum class StandardView { Front, Side, Top, ThreeQuarter };

/// A turntable camera: it looks at `target` from `distance`, turned by azimuth about `up` and raised by
/// elevation. Azimuth and elevation 0 is the front view: screen right is world x, the viewer stands at +z
/// where y is up and at -y where z is up. Metres (or whatever the scene's unit is), radians. A value without
/// any OpenGL in it.
struct Camera {
  Eigen::Vector3d target = Eigen::Vector3d::Zero();
  Eigen::Vector3d up = Eigen::Vector3d::UnitY();  ///< unit vector against gravity
  double distance = 4.0;                          ///< from target to eye, > 0
  double azimuth = 0.0;              ///< radians, positive: the viewer walks towards screen right
  double elevation = 0.0;            ///< radians in [-pi/2, pi/2]
  double verticalFieldOfView = 0.6;  ///< radians, perspective only
  bool orthographic = false;         ///< shows at the target what perspective would show there

  /// Columns: screen right, screen up, towards the viewer, in world coordinates.
  Eigen::Matrix3d axes() const;
  Eigen::Vector3d eye() const { return target + distance * axes().col(2); }
  /// Half the height of what is visible at the target.
  double halfHeight() const;
};

/// A ray in world coordinates, direction of unit length.
struct Ray {
  Eigen::Vector3d origin, direction;
  Eigen::Vector3d at(double t) const { return origin + t * direction; }
};

/// Depth range that holds a scene; positive, near < far.
struct DepthRange {
  double near = 0.05, far = 100.0;
};
/// The range that holds the box, with a margin, and stays usable when the eye is within it. extent: farthest
/// thing beyond the box that is drawn around its centre (the ground's rim).
DepthRange depthRange(const Camera& camera, const Eigen::AlignedBox3d& box, double extent);

Eigen::Matrix4d viewFromWorld(const Camera& camera);
/// OpenGL clip space (z in [-w, w]).
Eigen::Matrix4d clipFromView(const Camera& camera, const Viewport& viewport, const DepthRange& range);

/// Pixel of a world point, and its depth along the viewing direction (negative: behind the eye, pixel then
/// meaningless).
struct Projected {
  Eigen::Vector2d pixel;
  double depth;
};
Projected project(const Camera& camera, const Viewport& viewport, const Eigen::Vector3d& pointInWorld);
/// The ray through a pixel (its centre is at +0.5). Orthographic rays start in the eye's plane.
Ray rayThroughPixel(const Camera& camera, const Viewport& viewport, const Eigen::Vector2d& pixel);
/// World length of one pixel at a point.
double pixelSize(const Camera& camera, const Viewport& viewport, const Eigen::Vector3d& pointInWorld);

/// Turns by a mouse movement in pixels; a drag across the picture's height turns by half a turn. Elevation
/// stops at the poles.
Camera orbit(Camera camera, const Viewport& viewport, const Eigen::Vector2d& pixels);
/// Moves sideways so that what lies at the target's depth follows the mouse.
Camera pan(Camera camera, const Viewport& viewport, const Eigen::Vector2d& pixels);
/// Scales the distance by factor (< 1: nearer) so that what lies under the pixel, at the target's depth,
/// stays there.
Camera zoomTo(Camera camera, const Viewport& viewport, const Eigen::Vector2d& pixel, double factor);

/// Looks from a standard direction; target, distance and projection stay.
Camera lookFrom(Camera camera, StandardView view);
/// Moves target and distance so that the box fills the picture, with a margin (0.1: a tenth of the picture on
/// each side). The whole box lies before the eye, so an orthographic camera may show a very deep box smaller.
/// An empty box gives a camera at the origin.
Camera frameBox(Camera camera, const Viewport& viewport, const Eigen::AlignedBox3d& box,
                double margin = 0.05);

}  // namespace gelenk
