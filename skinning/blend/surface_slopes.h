#pragma once

#include <Eigen/Core>
#include <vector>

#include "skinning/mesh.h"
#include "skinning/skin.h"

namespace gelenk {

/// Two unit tangents t1, t2 of the surface with unit normal n: t1 x t2 = n. Without branches (Duff et al.
/// 2017); the vertex shader has the same, so the side is chosen by the normal as a float.
Eigen::Matrix<double, 3, 2> surfaceTangents(const Eigen::Vector3d& n);

/// Neighbours of every vertex along edges, and those of the vertices that lie in its place (seams of texture
/// coordinates), itself left out. Ascending.
std::vector<std::vector<int>> surfaceRings(const Mesh& mesh);

/// Derivatives of the weights along the tangents by least squares over the neighbours. The weights of a
/// vertex's own four bones, as shares of their sum: each column sums to 0.
std::vector<Eigen::Matrix<double, 4, 2>> weightSlopes(const Skin& skin);

/// The same of points that belong to vertices; only between vertices where `defined`.
std::vector<Eigen::Matrix<double, 3, 2>> pointSlopes(const Mesh& mesh,
                                                     const std::vector<Eigen::Vector3d>& points,
                                                     const std::vector<bool>& defined);

}  // namespace gelenk
