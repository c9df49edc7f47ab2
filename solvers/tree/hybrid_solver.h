#pragma once

#include <memory>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

/// The drag solver's steps (exact Hessian far from a solution, Gauss-Newton near one, on the skeleton's tree)
/// as a cold solve: DragSolver::solve. docs/solvers/hybrid.md.
std::unique_ptr<IkSolver> makeHybrid();

}  // namespace gelenk
