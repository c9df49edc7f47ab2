#pragma once

#include "solvers/solutions/loop.h"

namespace gelenk {

/// Real solutions of a loop, at most sixteen.
struct LoopSolutions {
  static constexpr int most = 16;
  int count = 0;
  std::array<Vector6d, most> u;    ///< radians, (-pi, pi]
  std::array<double, most> error;  ///< of the closed loop after polishing: lengths and radians
  double raw = 0.0;                ///< the largest such error before polishing
  double noise = 0.0;              ///< of the resultant, of its largest value: 1e-15 is perfect, 1 useless
  int suspects = 0;  ///< roots that led to no solution of their own, and places where roots may hide below
                     ///< the noise: another cut should be asked
  int roots = 0;     ///< proven real roots of the resultant
  int multiple = 0;  ///< roots that several solutions share
};

/// Error of the loop: how far it is from closing (translation, lengths; rotation, 2 sin(angle / 2) axis).
Vector6d loopError(const Loop& loop, const Vector6d& u);

/// Determinant of the loop's Jacobian (lengths and radians; columns: hinges). Over all solutions of a pose
/// that is not singular as many are positive as negative: the signed count is the same for every pose,
/// reachable or not.
double loopDeterminant(const Loop& loop, const Vector6d& u);

/// Newton on the closed loop. False where it does not come below `accepted`.
/// error: |loopError| at the end; before: at the beginning.
bool polish(const Loop& loop, Vector6d& u, double accepted, double& error, double& before);

/// Adds the solution unless it is there already; true where it was new.
bool add(LoopSolutions& solutions, const Vector6d& u, double error);

/// The general arm. The third hinge of the cut is the hidden variable: the fourteen equations of Raghavan and
/// Roth (1990) leave, once hinges 1 and 2 are eliminated linearly, six that are linear in the cosines and
/// sines of hinges 4 and 5. Times cos(u_4 / 2) and sin(u_4 / 2) they are twelve in
///     {cos, sin of u_4 / 2, cos, sin of 3 u_4 / 2} x {1, cos u_5, sin u_5},
/// and their determinant is a trigonometric polynomial of degree eight in u_3: sixteen roots, none of them at
/// infinity in any variable, which is what the tangents of half angles cannot say. Its coefficients come from
/// samples round the circle (an orthogonal transform, so nothing is lost); what is left in the harmonics 9 to
/// 12, which must vanish, is its noise. Lengths should be about one. No allocation.
/// known: solutions that are known already, for which nothing is solved again where the determinant has a
/// root of theirs; the others are not among the solutions returned.
LoopSolutions solveGeneralLoop(const Loop& loop, const LoopSolutions& known = {});

}  // namespace gelenk
