#pragma once

#include <memory>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

struct TaskPriorityParameters {
  double damping = 1e-2, base = 1e-12, truncation = 1e-3, largestStep = 0.5;

  static constexpr auto fields() {
    using P = TaskPriorityParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::damping, "damping", 0.0, 1e3, "1", "ours",
          "Share of a level's squared residual in its lambda^2, against algorithmic singularities."},
         {&P::base, "base", 0.0, 1.0, "m^2", "ours", "lambda^2 that is left where the residual vanishes."},
         {&P::truncation, "truncation", 0.0, 0.99, "1", "ours",
          "Directions with a singular value below this share of the largest stay free for later levels."},
         {&P::largestStep, "largest-step", 1e-3, 6.3, "rad, m", "ours",
          "Steps longer than this in a coordinate are shortened as a whole."}});
  }
};
/// Goals in order of Goal::priority, each in the null space of all before it:
///   dq_k = dq_{k-1} + (J_k N_{k-1})^# (r_k - J_k dq_{k-1}),   N_k = N_{k-1} - (J_k N_{k-1})^+ (J_k N_{k-1}),
///   dq_0 = 0, N_0 = I,
/// ^# damped by lambda^2 = damping |r_k|^2 + base against algorithmic singularities, ^+ truncated. A Posture
/// goal comes last whatever its priority. Where no step is left it reports Stationary, and its answer is the
/// last configuration, not the one of smallest residual. Nakamura 1987; Siciliano, Slotine 1991; Chiaverini
/// 1997.
std::unique_ptr<IkSolver> makeTaskPriority(const TaskPriorityParameters& parameters = {});

}  // namespace gelenk
