#pragma once

#include <memory>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

// Ceres Solver on the same residual and the same analytic Jacobian, through the counted evaluator. One
// parameter block an axis, bounded where it has limits and free where it turns fully; a free ball is a
// quaternion on ceres::QuaternionManifold; a limited ball is (u, v, tau) with the square |u|, |v| <= 1 mapped
// onto its swing ellipse by
//   c = centre + radii * (u sqrt(1 - v^2/2), v sqrt(1 - u^2/2)),
// so that bounds on u, v, tau are the limits exactly. Agarwal, Mierle et al., ceres-solver.org.

/// TRUST_REGION, LEVENBERG_MARQUARDT, DENSE_QR.
std::unique_ptr<IkSolver> makeCeresLm();

/// TRUST_REGION, DOGLEG, DENSE_QR.
std::unique_ptr<IkSolver> makeCeresDogleg();

/// LINE_SEARCH, LBFGS with Wolfe conditions. It knows no bounds, so bounded parameters are x = middle + half
/// sin(t); starts are moved off the bounds by 1 % of the range, where the derivative of the sine vanishes.
std::unique_ptr<IkSolver> makeCeresLineSearch();

}  // namespace gelenk
