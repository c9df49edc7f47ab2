#pragma once

#include <memory>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

// Quasi-Newton methods on the cost 1/2 |r|^2: only gradients J^T r are used, curvature is learned from their
// differences. Blocked limits are taken out of the direction (two-metric projection, Bertsekas 1982) and the
// line search backtracks along the projected path until Armijo's condition holds.

struct BfgsParameters {
  double armijo = 1e-4, largestStep = 1.0;

  static constexpr auto fields() {
    using P = BfgsParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::armijo, "armijo", 1e-8, 0.5, "1", "Nocedal, Wright 2006, ch. 3",
          "A step is taken where the cost falls by at least this share of what the slope promises."},
         {&P::largestStep, "largest-step", 1e-3, 6.3, "rad, m", "ours",
          "Steps longer than this in a coordinate are shortened as a whole."}});
  }
};
struct LbfgsParameters : BfgsParameters {
  int memory = 8;

  static constexpr auto fields() {
    using P = LbfgsParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::memory, "memory", 1, 64, "1", "Nocedal, Wright 2006, ch. 7 (3 to 20); value ours",
          "Pairs of steps and gradient changes that are remembered."},
         {&P::armijo, "armijo", 1e-8, 0.5, "1", "Nocedal, Wright 2006, ch. 3",
          "A step is taken where the cost falls by at least this share of what the slope promises."},
         {&P::largestStep, "largest-step", 1e-3, 6.3, "rad, m", "ours",
          "Steps longer than this in a coordinate are shortened as a whole."}});
  }
};

/// Inverse Hessian nv x nv, updated where s.y > 0; scaled by s.y / y.y before the first update. Nocedal,
/// Wright 2006, ch. 6; for IK: Zhao, Badler 1994.
std::unique_ptr<IkSolver> makeBfgs(const BfgsParameters& parameters = {});

/// Two-loop recursion over the last pairs, projected for bounds. Nocedal 1980; Byrd, Lu, Nocedal, Zhu 1995
/// for bounds.
std::unique_ptr<IkSolver> makeLbfgs(const LbfgsParameters& parameters = {});

}  // namespace gelenk
