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

struct CeresTrustRegionParameters {
  double initialRadius = 1e4, leastRelativeDecrease = 1e-3;

  static constexpr auto fields() {
    using P = CeresTrustRegionParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::initialRadius, "initial-radius", 1e-6, 1e16, "1", "Ceres Solver's default",
          "First radius of the trust region: 1 over the first damping."},
         {&P::leastRelativeDecrease, "least-decrease", 0.0, 0.9, "1", "Ceres Solver's default",
          "A step is taken where the cost falls by at least this share of what its model promises."}});
  }
};
/// TRUST_REGION, LEVENBERG_MARQUARDT, DENSE_QR.
std::unique_ptr<IkSolver> makeCeresLm(const CeresTrustRegionParameters& parameters = {});

/// TRUST_REGION, DOGLEG, DENSE_QR.
std::unique_ptr<IkSolver> makeCeresDogleg(const CeresTrustRegionParameters& parameters = {});

struct CeresLineSearchParameters {
  int rank = 20;
  double armijo = 1e-4, wolfe = 0.9;

  static constexpr auto fields() {
    using P = CeresLineSearchParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::rank, "rank", 1, 100, "1", "Ceres Solver's default",
          "Pairs that the L-BFGS direction remembers."},
         {&P::armijo, "armijo", 1e-8, 0.5, "1", "Ceres Solver's default",
          "The cost must fall by at least this share of what the slope promises."},
         {&P::wolfe, "wolfe", 0.5, 0.99, "1", "Ceres Solver's default",
          "The slope at the new place must be at most this share of the old one."}});
  }
};
/// LINE_SEARCH, LBFGS with Wolfe conditions. It knows no bounds, so bounded parameters are x = middle + half
/// sin(t); starts are moved off the bounds by 1 % of the range, where the derivative of the sine vanishes.
std::unique_ptr<IkSolver> makeCeresLineSearch(const CeresLineSearchParameters& parameters = {});

}  // namespace gelenk
