#pragma once

#include <memory>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

// Orocos KDL's pose solvers as peers, present where the library was found when this was built (CMake:
// GELENK_PEERS). One pose goal on a serial chain of one-dof joints. Budget::restarts are random starts within
// limits, drawn as ours; the first attempt begins at the start. Budget::maxIterations is each attempt's
// limit; the library's own loops know no clock, so maxSeconds (of processor time) is looked at between
// attempts. KDL's tolerances are set so that its answers stand before the judge: 5e-7 a component (NR), 9e-7
// on the norm with equal weights for metres and radians (LMA).

/// ChainIkSolverPos_NR with the pseudo-inverse (limits unknown to it: an answer that cannot be wrapped into
/// them counts as failed).
std::unique_ptr<IkSolver> makeKdlNewton();
/// ChainIkSolverPos_NR_JL (joints clamped to their limits) with the damped ChainIkSolverVel_wdls, lambda =
/// 0.01.
std::unique_ptr<IkSolver> makeKdlNewtonWithLimits();
/// ChainIkSolverPos_LMA (limits unknown to it).
std::unique_ptr<IkSolver> makeKdlLevenbergMarquardt();

}  // namespace gelenk
