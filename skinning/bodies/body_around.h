#pragma once

#include <cstdint>

#include "skinning/bodies/body_shape.h"
#include "skinning/bodies/polygonise.h"
#include "skinning/skin.h"

namespace gelenk {

struct BodyAroundOptions {
  double thickness = 1.0;  ///< factor on all radii
  int vertices = 12000;    ///< wanted, roughly; thin parts may need more
};

/// A body of rounded links around the bones of any skeleton in its rest pose, free of units: radii follow
/// from lengths. A bone of length l gets r = 0.13 l^0.7 L^0.3, L the longest one, but is no thinner than what
/// it carries: the radii of its children add up as r^2.5 (da Vinci's rule for trees), up to 0.19 L. A head
/// whose face has joints of its own is one round part. A mechanism that moves in one plane gets a flat body.
BodyShape shapeAround(const Skeleton& skeleton);

/// The same as a closed manifold mesh with normals, in the skeleton's rest pose.
Mesh bodyAround(const Skeleton& skeleton, const BodyAroundOptions& options = {});

/// The mesh bound to the skeleton by heat weights.
Skin bodySkin(const Skeleton& skeleton, const BodyAroundOptions& options = {});

/// A fingerprint of all that bodySkin (with default options) depends on: the rest pose, which joints move,
/// the version of the method.
std::uint64_t bodySkinKey(const Skeleton& skeleton);

}  // namespace gelenk
