#pragma once

#include <memory>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

// Quasi-Newton methods on the cost 1/2 |r|^2: only gradients J^T r are used, curvature is learned from their
// differences. Blocked limits are taken out of the direction (two-metric projection, Bertsekas 1982) and the
// line search backtracks along the projected path until Armijo's condition with 1e-4 holds.

/// Inverse Hessian nv x nv, updated where s.y > 0; scaled by s.y / y.y before the first update. Nocedal,
/// Wright 2006, ch. 6; for IK: Zhao, Badler 1994.
std::unique_ptr<IkSolver> makeBfgs();

/// Two-loop recursion over the last 8 pairs, projected for bounds. Nocedal 1980; Byrd, Lu, Nocedal, Zhu 1995
/// for bounds.
std::unique_ptr<IkSolver> makeLbfgs();

}  // namespace gelenk
