#pragma once

#include <memory>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

/// The solver that fits the problem: the pose solver of serial chains where it can do it, else the descent on
/// the tree (figures, ball joints, free roots, several goals), else Levenberg-Marquardt by the gain ratio.
std::unique_ptr<IkSolver> makeFitting();

}  // namespace gelenk
