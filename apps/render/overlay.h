#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "apps/render/colour.h"

namespace gelenk {

/// Coloured geometry within the scene or on top of it: bones, frames, cones, trails, handles, shaded areas. A
/// plain list without OpenGL. Widths are pixels of a picture at scale 1. Fills are drawn first, then lines,
/// then points, each in the order given.
class Overlay {
 public:
  enum class Shape {
    Disc,
    Ring,
    Square,  ///< these with an outline in a darker shade, but for the ring
    Plain,
    PlainSquare,
    Diamond  ///< these without
  };

  static constexpr float opaqueFrom = 0.995f;  ///< colours with less are translucent

  void line(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Colour& colour, float width = 1.5f);
  /// Translucent ones meet in flat ends where they bend little, so that no dots of twice the colour show.
  void polyline(const std::vector<Eigen::Vector3d>& points, const Colour& colour, float width = 1.5f,
                bool closed = false);
  /// Dashes and gaps of equal length in the world; a dash begins at a.
  void dashedLine(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double dash, const Colour& colour,
                  float width = 1.5f);
  void point(const Eigen::Vector3d& at, const Colour& colour, float diameter = 10.0f,
             Shape shape = Shape::Disc);
  /// Unlit, seen from both sides.
  void triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                const Colour& colour);
  /// Triangles from the apex to each edge of the rim: limit cones, polygons that are convex about the apex.
  void fan(const Eigen::Vector3d& apex, const std::vector<Eigen::Vector3d>& rim, const Colour& colour,
           bool closed = true);

  // Larger signs, made of the above.

  /// A slim octahedral bone, each face shaded by its direction so that its form shows. thickness: its widest
  /// half width.
  void bone(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double thickness, const Colour& colour);
  /// The axes of a frame: x red, y green, z blue.
  void axes(const Eigen::Isometry3d& worldFromFrame, double length, float width = 2.0f);
  /// A filled ring, or a sector of it, in the plane of u and v (unit, perpendicular; angles in radians from u
  /// towards v).
  void annulus(const Eigen::Vector3d& centre, const Eigen::Vector3d& u, const Eigen::Vector3d& v,
               double inner, double outer, const Colour& colour, double fromAngle = 0.0,
               double toAngle = 6.283185307179586);
  /// The outline of a circle or of an arc, likewise.
  void arc(const Eigen::Vector3d& centre, const Eigen::Vector3d& u, const Eigen::Vector3d& v, double radius,
           const Colour& colour, float width = 1.5f, double fromAngle = 0.0,
           double toAngle = 6.283185307179586);

  void clear();
  bool empty() const { return fills.empty() && lines.empty() && points.empty(); }

  // The lists, as the graphics card reads them.
  struct Vertex {
    float position[3];
    Colour colour;
  };
  struct Line {
    Vertex a, b;
    float width;
    float flatEnds = 0.0f;  ///< 1: at a, 2: at b, 3: both; else round ones
  };
  struct Point {
    Vertex at;
    float diameter;
    float shape;  ///< Shape as a number
  };
  std::vector<Vertex> fills;  ///< three a triangle
  std::vector<Line> lines;
  std::vector<Point> points;
};

}  // namespace gelenk
