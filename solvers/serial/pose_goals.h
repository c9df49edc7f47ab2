#pragma once

#include <memory>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

/// The problem with every position goal and orientation goal of one joint (same weight and priority) as one
/// pose goal: the same residual, in the form that solvers of chains ask for.
IkProblem withPoseGoals(const IkProblem& problem);

/// The solver, given withPoseGoals(problem).
std::unique_ptr<IkSolver> mergingPoseGoals(std::unique_ptr<IkSolver> solver);

}  // namespace gelenk
