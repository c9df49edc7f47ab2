#pragma once

#include <memory>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

/// Goals in order of Goal::priority, each in the null space of all before it:
///   dq_k = dq_{k-1} + (J_k N_{k-1})^# (r_k - J_k dq_{k-1}),   N_k = N_{k-1} - (J_k N_{k-1})^+ (J_k N_{k-1}),
///   dq_0 = 0, N_0 = I,
/// ^# damped by lambda^2 = 1e-2 |r_k|^2 + 1e-12 (ours) against algorithmic singularities, ^+ truncated at
/// 1e-3 of the largest singular value. A Posture goal comes last whatever its priority. Where no step is left
/// it reports Stationary, and its answer is the last configuration, not the one of smallest residual.
/// Nakamura 1987; Siciliano, Slotine 1991; Chiaverini 1997.
std::unique_ptr<IkSolver> makeTaskPriority();

}  // namespace gelenk
