#pragma once

#include <memory>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

/// A memetic search in the manner of bio_ik: 16 configurations within the limits; every generation the better
/// half stays, children are drawn between two parents with the parents' momentum and a mutation whose width
/// follows the parents' distance, and the 2 best are polished by 4 Levenberg-Marquardt steps. A population
/// whose best has not fallen by 1 % for 10 generations is drawn anew; the best answer so far is kept.
/// Iterations count generations. Random numbers come from Budget::seed alone. Ruppel, Hendrich, Starke, Zhang
/// 2018; Starke, Hendrich, Zhang 2018.
std::unique_ptr<IkSolver> makeEvolution();

}  // namespace gelenk
