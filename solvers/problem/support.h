#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

namespace gelenk {

/// A convex polygon upright on a direction: where a centre of mass may be so that a body does not tip over.
/// All heights along `up` are one: only what is across it counts.
struct SupportPolygon {
  std::vector<Eigen::Vector3d> corners;  ///< convex, counter-clockwise seen against `up`; metres
  Eigen::Vector3d up = Eigen::Vector3d::UnitY();

  /// Their convex hull seen along up (unit). Fewer than three corners where they lie on a line or in a point.
  static SupportPolygon hull(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& up);

  /// What is nearest to a point from outside.
  struct Nearest {
    Eigen::Vector3d way = Eigen::Vector3d::Zero();  ///< across up, from the point to the polygon; 0 inside
    Eigen::Vector3d outward = Eigen::Vector3d::Zero();  ///< unit, where the nearest is inside an edge
    bool corner = false;                                ///< the nearest is a corner
  };
  /// The polygon moved inwards by `margin` (metres); a polygon that vanishes so leaves its middle.
  SupportPolygon inset(double margin) const;
  Nearest nearest(const Eigen::Vector3d& point) const { return nearest(corners, up, point); }
  /// The same for corners that are convex already, without a copy.
  static Nearest nearest(std::span<const Eigen::Vector3d> corners, const Eigen::Vector3d& up,
                         const Eigen::Vector3d& point);
  static bool isConvex(std::span<const Eigen::Vector3d> corners, const Eigen::Vector3d& up);
  /// Largest signed distance from the edges' lines, below 0 inside; metres.
  double outside(const Eigen::Vector3d& point) const;
};

}  // namespace gelenk
