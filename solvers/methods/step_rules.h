#pragma once

#include <memory>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

// Iterative solvers that differ only in how a step dq follows from J (m x nv) and the residual r (target
// minus current). step_iteration.h tells how limits are kept and attempt.h when they stop. sigma_i, u_i, v_i:
// singular values (falling) and vectors of J with the locked dimensions taken out. Steps longer than
// largestStep in a coordinate are shortened as a whole. The struct before a method holds its constants.

namespace detail {
template <typename P>
constexpr ParameterField<P> largestStepField(std::string_view source = "ours") {
  return {&P::largestStep,
          "largest-step",
          1e-3,
          6.3,
          "rad, m",
          source,
          "Steps longer than this in a coordinate are shortened as a whole."};
}
}  // namespace detail

struct PseudoInverseParameters {
  double truncation = 0.01, largestStep = 0.5;

  static constexpr auto fields() {
    using P = PseudoInverseParameters;
    return std::to_array<ParameterField<P>>({{&P::truncation, "truncation", 0.0, 0.99, "1", "ours",
                                              "Singular values below this share of the largest are dropped."},
                                             detail::largestStepField<P>()});
  }
};
/// dq = J^T (J J^T)^-1 r, the minimal change of the angles. Lecture 10.1.4, several dimensions, n > m.
std::unique_ptr<IkSolver> makePseudoInverse(const PseudoInverseParameters& parameters = {});

/// The pseudo-inverse in steps of at most 0.02 rad a coordinate: a discretised minimal-change path, the
/// yardstick of the laboratory for joint displacement. Not in the catalogue: it is slow by intent.
std::unique_ptr<IkSolver> makeMinimalChangePath();

struct JacobianTransposeParameters {
  double largestStep = 0.5;

  static constexpr auto fields() {
    return std::to_array({detail::largestStepField<JacobianTransposeParameters>()});
  }
};
/// dq = a J^T r with a = <r, J J^T r> / |J J^T r|^2, the best step length along the gradient. Buss 2004.
std::unique_ptr<IkSolver> makeJacobianTranspose(const JacobianTransposeParameters& parameters = {});

struct DampedLeastSquaresParameters {
  double lambda = 0.05, largestStep = 0.5;

  static constexpr auto fields() {
    using P = DampedLeastSquaresParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::lambda, "lambda", 0.0, 10.0, "m", "ours",
          "Damping, the same everywhere: larger is calmer near singular poses and slower elsewhere."},
         detail::largestStepField<P>()});
  }
};
/// dq = J^T (J J^T + lambda^2 I)^-1 r with constant lambda. Wampler 1986; Buss 2004.
std::unique_ptr<IkSolver> makeDampedLeastSquares(const DampedLeastSquaresParameters& parameters = {});

struct NakamuraParameters {
  double largestLambda = 0.1, threshold = 0.02, largestStep = 0.5;

  static constexpr auto fields() {
    using P = NakamuraParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::largestLambda, "largest-lambda", 0.0, 10.0, "m", "ours", "Damping where J has lost its rank."},
         {&P::threshold, "threshold", 1e-6, 1.0, "1", "ours",
          "Manipulability, over the product of the lengths of the rows of J, below which damping begins."},
         detail::largestStepField<P>()});
  }
};
/// DLS with lambda = largest-lambda (1 - w/w0) where the manipulability w = sqrt(det J J^T) is below w0, else
/// 0. w is divided by the product of the lengths of the rows of J, so that neither depends on units.
/// Nakamura, Hanafusa 1986.
std::unique_ptr<IkSolver> makeNakamura(const NakamuraParameters& parameters = {});

struct ChiaveriniParameters {
  double region = 0.04, largestLambda = 0.04, largestStep = 0.5;

  static constexpr auto fields() {
    using P = ChiaveriniParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::region, "region", 1e-6, 1.0, "1", "ours",
          "Singular values below eps, this share of the largest, are damped."},
         {&P::largestLambda, "largest-lambda", 0.0, 1.0, "1", "ours",
          "Damping of a singular value of 0, as a share of the largest one."},
         detail::largestStepField<P>()});
  }
};
/// dq = sum u_i.r sigma_i / (sigma_i^2 + lambda_i^2) v_i; only singular values below eps are damped, by
/// lambda_i^2 = (1 - (sigma_i/eps)^2) lambda_max^2. Maciejewski, Klein 1988; Chiaverini 1997.
std::unique_ptr<IkSolver> makeChiaverini(const ChiaveriniParameters& parameters = {});

struct SelectivelyDampedParameters {
  double gammaMax = M_PI / 4.0, largestError = 0.7;

  static constexpr auto fields() {
    using P = SelectivelyDampedParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::gammaMax, "gamma-max", 1e-3, 6.3, "rad, m", "Buss, Kim 2005",
          "Largest change of a coordinate, of every singular vector's part and of the whole step."},
         {&P::largestError, "largest-error", 1e-3, 1e3, "m, rad", "ours",
          "The residual of a goal counts as no longer than this."}});
  }
};
/// Selectively damped least squares: each singular vector's contribution is clamped to gamma_i = gamma_max
/// min(1, N_i/M_i); the residual of each goal is clamped first. Buss, Kim 2005.
std::unique_ptr<IkSolver> makeSelectivelyDamped(const SelectivelyDampedParameters& parameters = {});

struct LmChanParameters {
  double lambda = 0.1, largestStep = 1.0;

  static constexpr auto fields() {
    using P = LmChanParameters;
    return std::to_array<ParameterField<P>>({{&P::lambda, "lambda", 0.0, 1e3, "1", "Chan, Lawrence 1988",
                                              "Damping is lambda times half the squared residual."},
                                             detail::largestStepField<P>()});
  }
};
/// Levenberg-Marquardt with damping lambda E, E = 1/2 |r|^2. Chan, Lawrence 1988.
std::unique_ptr<IkSolver> makeLmChan(const LmChanParameters& parameters = {});

struct LmSugiharaParameters {
  double bias = 1e-3, largestStep = 1.0;

  static constexpr auto fields() {
    using P = LmSugiharaParameters;
    return std::to_array<ParameterField<P>>({{&P::bias, "bias", 0.0, 1.0, "m^2", "Sugihara 2011",
                                              "Damping that is left where the residual vanishes."},
                                             detail::largestStepField<P>()});
  }
};
/// Levenberg-Marquardt with damping E + bias. Sugihara 2011.
std::unique_ptr<IkSolver> makeLmSugihara(const LmSugiharaParameters& parameters = {});

struct LmGainRatioParameters {
  double tau = 1e-3, growth = 2.0, largestStep = 1.5;

  static constexpr auto fields() {
    using P = LmGainRatioParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::tau, "tau", 1e-12, 1e3, "1", "Nielsen 1999",
          "First damping, as a share of the largest diagonal entry of J^T J."},
         {&P::growth, "growth", 1.1, 100.0, "1", "Nielsen 1999",
          "Damping grows by this after a failure, by its square after the next."},
         detail::largestStepField<P>()});
  }
};
/// Levenberg-Marquardt steered by the gain ratio rho, actual over predicted fall of the cost: mu times
/// max(1/3, 1 - (2 rho - 1)^3) after success, times nu, 2 nu, 4 nu, ... after failure, nu = growth; mu_0 =
/// tau max diag(J^T J). Marquardt 1963; Nielsen 1999.
std::unique_ptr<IkSolver> makeLmGainRatio(const LmGainRatioParameters& parameters = {});

struct ExactHessianParameters {
  double startDamping = 1e-6, slopeShift = 1e-3, largestStep = 1.5;

  static constexpr auto fields() {
    using P = ExactHessianParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::startDamping, "start-damping", 0.0, 1e3, "m^2", "ours", "First mu."},
         {&P::slopeShift, "slope-shift", 0.0, 1e3, "m", "ours", "The shift is at least this times |J^T r|."},
         detail::largestStepField<P>()});
  }
};
/// Newton's method on the cost with its exact Hessian H (CountedEvaluator::hessian), shifted until positive
/// definite: (H + s I) dq = J^T r, s = max(mu, slope-shift |J^T r|), times 4 while Cholesky fails.
std::unique_ptr<IkSolver> makeExactHessian(const ExactHessianParameters& parameters = {});

struct HalleyParameters : LmGainRatioParameters {
  double longest = 1.0, guard = 0.5;

  static constexpr auto fields() {
    using P = HalleyParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::tau, "tau", 1e-12, 1e3, "1", "Nielsen 1999",
          "First damping, as a share of the largest diagonal entry of J^T J."},
         {&P::growth, "growth", 1.1, 100.0, "1", "Nielsen 1999",
          "Damping grows by this after a failure, by its square after the next."},
         {&P::longest, "longest", 0.0, 10.0, "rad, m", "ours",
          "Steps of this length or more are not corrected."},
         {&P::guard, "guard", 0.0, 10.0, "1", "ours",
          "Corrections longer than this share of the step are left out."},
         detail::largestStepField<P>()});
  }
};
/// Halley's method: d1 from (J J^T + mu), then dq from J + 1/2 dJ(d1) in place of J; d1 alone where dq
/// differs from it by more than its guard. mu by the gain ratio. Lloyd, Irani, Ahmadi 2022 (QuIK).
std::unique_ptr<IkSolver> makeHalley(const HalleyParameters& parameters = {});

struct GeodesicParameters : LmGainRatioParameters {
  double guard = 0.75;

  static constexpr auto fields() {
    using P = GeodesicParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::tau, "tau", 1e-12, 1e3, "1", "Nielsen 1999",
          "First damping, as a share of the largest diagonal entry of J^T J."},
         {&P::growth, "growth", 1.1, 100.0, "1", "Nielsen 1999",
          "Damping grows by this after a failure, by its square after the next."},
         {&P::guard, "guard", 0.0, 10.0, "1", "Transtrum, Sethna 2012",
          "Accelerations longer than this share of the step are left out."},
         detail::largestStepField<P>()});
  }
};
/// Levenberg-Marquardt with geodesic acceleration: dq = d1 + 1/2 d2, d2 = -J^+ (dJ(d1) d1) with the same
/// factor, where |d2| <= guard |d1|. Transtrum, Sethna 2012.
std::unique_ptr<IkSolver> makeGeodesic(const GeodesicParameters& parameters = {});

}  // namespace gelenk
