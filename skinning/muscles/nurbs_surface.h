#pragma once

#include <Eigen/Core>
#include <vector>

#include "skinning/mesh.h"

namespace gelenk {

/// A tensor-product NURBS surface, the lecture's skin layer (10.3):
///     S(u, v) = sum_ij N_i,p(u) N_j,q(v) w_ij P_ij / sum_ij N_i,p(u) N_j,q(v) w_ij.
/// Piegl and Tiller, The NURBS Book, chapters 2 to 4.
struct NurbsSurface {
  int degreeU = 3, degreeV = 3;
  int countU = 0, countV = 0;  ///< control points in each direction
  std::vector<double> knotsU,
      knotsV;  ///< non-decreasing, countU + degreeU + 1 and countV + degreeV + 1 values
  std::vector<Eigen::Vector3d> points;  ///< metres, index i countV + j
  std::vector<double> weights;          ///< > 0, one a point

  double lowerU() const { return knotsU[degreeU]; }
  double upperU() const { return knotsU[countU]; }
  double lowerV() const { return knotsV[degreeV]; }
  double upperV() const { return knotsV[countV]; }
};

/// Throws std::invalid_argument that says which count, knot or weight is wrong and what was expected.
void validate(const NurbsSurface& surface);

struct NurbsPoint {
  Eigen::Vector3d position, du, dv;  ///< and the first partial derivatives
};
/// u, v are clamped to the domain.
NurbsPoint evaluate(const NurbsSurface& surface, double u, double v);

/// A triangle mesh on a regular grid of stepsU x stepsV cells with the surface's own normals. Grid points
/// that coincide (a surface closed on itself, a pole) become one vertex; triangles that collapse are dropped.
/// Counter-clockwise along du x dv.
Mesh tessellate(const NurbsSurface& surface, int stepsU, int stepsV);

/// A cross-section of a tube: the ellipse centre + cos(t) halfAxisA + sin(t) halfAxisB, metres.
struct TubeRing {
  Eigen::Vector3d centre, halfAxisA, halfAxisB;
};
/// A closed tube: cubic in u through control rings (of which it passes near all but the first and last),
/// exactly elliptical in v (rational quadratic, nine points, Piegl and Tiller 7.5). Its ends are poles in the
/// centres of the first and last ring, which lie in the tangent planes there, so the ends are round. A x B
/// must point along the tube for du x dv to point outwards. Throws std::invalid_argument for fewer than two
/// rings.
NurbsSurface closedTube(const std::vector<TubeRing>& rings);

/// The index of the knot span [u_i, u_i+1) that holds u, the last one for the upper end.
int knotSpan(const std::vector<double>& knots, int degree, int count, double u);

}  // namespace gelenk
