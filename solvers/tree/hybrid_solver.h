#pragma once

#include <memory>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

struct HybridParameters {
  double posture = 1e-3, poseArm = 0.3;

  static constexpr auto fields() {
    using P = HybridParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::posture, "posture", 0.0, 1.0, "1", "ours",
          "Pull towards the rest pose in the first step; it fades tenfold a step."},
         {&P::poseArm, "pose-arm", 1e-3, 10.0, "unit", "ours",
          "Orientations count as three points on arms of this length, in body units."}});
  }
};
/// The drag solver's steps (exact Hessian far from a solution, Gauss-Newton near one, on the skeleton's tree)
/// as a cold solve: DragSolver::solve. docs/solvers/hybrid.md.
std::unique_ptr<IkSolver> makeHybrid(const HybridParameters& parameters = {});

}  // namespace gelenk
