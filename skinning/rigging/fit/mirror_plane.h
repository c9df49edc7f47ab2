#pragma once

#include <Eigen/Core>
#include <vector>

#include "skinning/rigging/fit/surface_samples.h"

namespace gelenk {

/// The plane {p : normal . p = offset} and how well the surface is its own mirror image there.
struct MirrorPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitX();
  double offset = 0.0;
  double misfit =
      1.0;  ///< mean distance of mirrored samples from the surface, cut at 5 % of `size`, over size
};

/// Planes of symmetry, best first: closest-point fits of the surface to its mirror image from nine starts
/// (the principal axes and the directions half-way between two). Planes within 5 degrees of a better one are
/// left out. size: of the body, same unit as the samples.
std::vector<MirrorPlane> mirrorPlanes(const SurfaceSamples& samples, double size);

}  // namespace gelenk
