#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "skinning/mesh.h"
#include "skinning/rigging/fit/placement.h"

namespace gelenk {

/// The crotch in the template's space: where the cut through the middle is lowest. Nothing where that is
/// further than `reach` from `about` upwards or downwards: a skirt, or legs that touch. It may lie anywhere
/// in the cut: no closed or oriented surface is needed.
std::optional<Eigen::Vector3d> findCrotch(const Mesh& mesh, const BodyFrame& frame,
                                          const Eigen::Vector3d& about, double reach);

/// Places that hold the template along its limbs, by the present fit: the crotch, and how far the hands
/// reach.
std::vector<Landmark> findLandmarks(const TemplateBody& body, const Mesh& mesh, const BodyFrame& frame,
                                    const FitTarget& target, const PieceMaps& maps);

}  // namespace gelenk
