#pragma once

#include "skinning/mesh.h"

namespace gelenk {

/// How often the surface winds around p: 1 inside and 0 outside of a closed mesh whose triangles face
/// outwards; of an open one the solid angle over 4 pi (Jacobson, Kavan and Sorkine-Hornung 2013). Triangles
/// further away than four times their extent count by their area and direction alone, to about 2 % of theirs.
double windingNumber(const Mesh& mesh, const Eigen::Vector3d& p);

}  // namespace gelenk
