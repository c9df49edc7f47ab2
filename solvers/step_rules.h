#pragma once

#include <memory>

#include "solvers/ik_solver.h"

namespace gelenk {

// Iterative solvers that differ only in how a step dq follows from J and the residual r (target minus current).
// All clamp |dq| per entry, project to the limits after the step, and stop by the rules in step_rules.cpp.

/// dq = J^T (J J^T)^-1 r, the minimal change of the angles; singular values below 0.01 of the largest are dropped.
/// Lecture 10.1.4, several dimensions, n > m.
std::unique_ptr<IkSolver> makePseudoInverse();

/// dq = a J^T r with a = <r, J J^T r> / |J J^T r|^2, the best step length along the gradient. Buss 2004.
std::unique_ptr<IkSolver> makeJacobianTranspose();

/// dq = J^T (J J^T + lambda^2 I)^-1 r with constant lambda = 0.05. Wampler 1986; Buss 2004.
std::unique_ptr<IkSolver> makeDampedLeastSquares();

}  // namespace gelenk
