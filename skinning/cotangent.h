#pragma once

#include <Eigen/SparseCore>

#include "skinning/mesh.h"

namespace gelenk {

/// The lower triangle of the cotangent matrix K of a surface, K w = -laplacian of w integrated around each
/// vertex: off-diagonal entries -(cot a + cot b) / 2, or 0 where that would be positive, rows that sum to 0.
/// areas: a third of the triangles around each vertex.
Eigen::SparseMatrix<double> cotangentMatrix(const Mesh& mesh, Eigen::VectorXd& areas);

}  // namespace gelenk
