#pragma once

#include <vector>

#include "skinning/bodies/body_shape.h"
#include "skinning/mesh.h"

namespace gelenk {

/// Draws the grid together around its centres: cells there are `magnification` times smaller than far away,
/// with a smooth change over `reach` (metres). Two mirrored centres make one lens, which keeps exact
/// symmetry.
struct GridLens {
  std::vector<Eigen::Vector3d> centres;
  double magnification = 1.0;
  double reach = 0.3;
};

struct PolygoniseOptions {
  double cell = 0.016;                ///< size of a grid cell away from the lenses, metres
  std::vector<GridLens> lenses = {};  ///< applied in this order
  bool symmetric = false;  ///< the shape is its own mirror image at x = 0; so is the mesh then, exactly
  int relaxationRounds = 8;
  int threads = 2;  ///< the result does not depend on it
};

/// The surface F = 0 of a body as a closed manifold mesh with normals: dual contouring on a warped grid with
/// one vertex a loop of crossed edges in a cell, then rounds of Delaunay flips, tangential smoothing and
/// projection onto the surface. The grid lives in q-space, p = W(q), W a composition of lenses q - sum kappa
/// L tanh(r / L) (q - c) / r, r = |q - c|, kappa = 1 - 1 / magnification: a contraction, so that distances
/// bound values in q-space too and blocks can be culled. The grid holds the whole surface: it begins as the
/// preimage of the box of the parts, by a proven bound, and grows until its rim lies outside. Parts thinner
/// than about one and a half cells may break apart or fuse. Symmetric meshes list the half with x >= 0 first.
/// A grid on which two edges of the surface would coincide (rare, thin parts) is replaced by one of slightly
/// smaller cells. partner, where given: for each vertex of a symmetric mesh its mirror image (itself at x =
/// 0). Throws std::invalid_argument: a cell that is not positive, or a grid of more than 2^28 cells;
/// std::runtime_error where twelve grids failed.
Mesh polygonise(const BodyShape& shape, const PolygoniseOptions& options,
                std::vector<int>* partner = nullptr);

}  // namespace gelenk
