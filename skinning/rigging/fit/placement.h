#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "skinning/rigging/fit/body_fit.h"
#include "skinning/rigging/fit/mirror_plane.h"

namespace gelenk {

/// Where a body stands: world = origin + scale * axes * p for p in the template's space; the columns of axes
/// are the body's left, up and front.
struct BodyFrame {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double scale = 1.0;

  Eigen::Vector3d toWorld(const Eigen::Vector3d& p) const { return origin + scale * (axes * p); }
  Eigen::Vector3d toBody(const Eigen::Vector3d& p) const { return axes.transpose() * (p - origin) / scale; }
};

struct Placement {
  BodyFrame frame;
  PieceMaps maps;          ///< a rough fit
  std::string pose;        ///< of the template's poses, the one it began with
  bool symmetric = false;  ///< the body is its own mirror image
  double misfit = 1.0;     ///< of the rough fit, in template heights
  bool authored = false;   ///< stands with y up and faces z, as most files do
};

struct PlacementWishes {
  std::optional<Eigen::Vector3d> up, front;  ///< unit vectors; nothing: searched for
};

/// Of two ways to stand that fit about as well the one that most files are made in is taken.
inline constexpr double authoredBonus = 0.9;

/// Finds how the body stands: planes of symmetry give the side axis, the principal axes within the plane the
/// upright one; every way to stand and face and every pose of the template is tried with a short fit. Best
/// first, and after it the best of each other way to stand whose misfit is within a quarter of its own. Empty
/// where the wishes leave none.
std::vector<Placement> placeBody(const TemplateBody& body, const SurfaceSamples& samples,
                                 const PlacementWishes& wishes);

/// The samples in the template's space.
SurfaceSamples inBodySpace(const SurfaceSamples& samples, const BodyFrame& frame);

}  // namespace gelenk
