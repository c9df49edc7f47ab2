#pragma once

#include <memory>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

// Iterative solvers that differ only in how a step dq follows from J (m x nv) and the residual r (target
// minus current). step_iteration.h tells how limits are kept and attempt.h when they stop. sigma_i, u_i, v_i:
// singular values (falling) and vectors of J with the locked dimensions taken out. Constants with the word
// "ours" were chosen here by experiment.

/// dq = J^T (J J^T)^-1 r, the minimal change of the angles; singular values below 0.01 of the largest are
/// dropped (ours). Steps are shortened to 0.5 rad a coordinate. Lecture 10.1.4, several dimensions, n > m.
std::unique_ptr<IkSolver> makePseudoInverse();

/// The pseudo-inverse in steps of at most 0.02 rad a coordinate: a discretised minimal-change path, the
/// yardstick of the laboratory for joint displacement. Not in the catalogue: it is slow by intent.
std::unique_ptr<IkSolver> makeMinimalChangePath();

/// dq = a J^T r with a = <r, J J^T r> / |J J^T r|^2, the best step length along the gradient. Buss 2004.
std::unique_ptr<IkSolver> makeJacobianTranspose();

/// dq = J^T (J J^T + lambda^2 I)^-1 r with constant lambda = 0.05 (ours). Wampler 1986; Buss 2004.
std::unique_ptr<IkSolver> makeDampedLeastSquares();

/// DLS with lambda^2 = 0.01 (1 - w/w0)^2 where the manipulability w = sqrt(det J J^T) is below w0, else 0. w
/// is divided by the product of the lengths of the rows of J and w0 = 0.02 (ours), so that neither depends on
/// units. Nakamura, Hanafusa 1986.
std::unique_ptr<IkSolver> makeNakamura();

/// dq = sum u_i.r sigma_i / (sigma_i^2 + lambda_i^2) v_i; only the smallest singular value is damped, by
/// lambda^2 = (1 - (sigma_min/eps)^2) lambda_max^2 where sigma_min < eps; eps = lambda_max = 0.04 sigma_1
/// (ours). Maciejewski, Klein 1988; Chiaverini 1997.
std::unique_ptr<IkSolver> makeChiaverini();

/// Selectively damped least squares: each singular vector's contribution is clamped to gamma_i = gamma_max
/// min(1, N_i/M_i), gamma_max = 45 degrees; the residual of each goal is clamped to 0.7 (metres, radians;
/// ours). Buss, Kim 2005.
std::unique_ptr<IkSolver> makeSelectivelyDamped();

/// Levenberg-Marquardt with damping lambda E, E = 1/2 |r|^2, lambda = 0.1. Chan, Lawrence 1988.
std::unique_ptr<IkSolver> makeLmChan();

/// Levenberg-Marquardt with damping E + 1e-3. Sugihara 2011.
std::unique_ptr<IkSolver> makeLmSugihara();

/// Levenberg-Marquardt steered by the gain ratio rho, actual over predicted fall of the cost: mu times
/// max(1/3, 1 - (2 rho - 1)^3) after success, times 2, 4, 8, ... after failure; mu_0 = 1e-3 max diag(J^T J).
/// Marquardt 1963; Nielsen 1999.
std::unique_ptr<IkSolver> makeLmGainRatio();

/// Newton's method on the cost with its exact Hessian H (CountedEvaluator::hessian), shifted until positive
/// definite: (H + s I) dq = J^T r, s = max(mu, 1e-3 |J^T r|), times 4 while Cholesky fails; steps to 1.5 rad
/// a coordinate.
std::unique_ptr<IkSolver> makeExactHessian();

/// Halley's method: d1 from (J J^T + mu), then dq from J + 1/2 dJ(d1) in place of J; d1 alone where dq
/// differs from it by more than half its length. mu by the gain ratio. Lloyd, Irani, Ahmadi 2022 (QuIK).
std::unique_ptr<IkSolver> makeHalley();

/// Levenberg-Marquardt with geodesic acceleration: dq = d1 + 1/2 d2, d2 = -J^+ (dJ(d1) d1) with the same
/// factor, where |d2| <= 3/4 |d1|. Transtrum, Sethna 2012.
std::unique_ptr<IkSolver> makeGeodesic();

}  // namespace gelenk
