#pragma once

#include <Eigen/Core>

#include "skinning/mesh.h"

namespace gelenk {

/// The place of the surface that is nearest to a point. The mesh has a triangle.
Eigen::Vector3d nearestSkin(const Mesh& mesh, const Eigen::Vector3d& point);

}  // namespace gelenk
