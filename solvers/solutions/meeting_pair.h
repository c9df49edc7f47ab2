#pragma once

#include "solvers/solutions/general_loop.h"

namespace gelenk {

/// How well a loop suits solveMeetingPair: its axes 4 and 5 meet in a point (within `tolerance`, lengths of
/// the loop), are not parallel, and the link between them is not the goal's. 0: not at all, 1: hinges 1 to 3
/// place a point by a polynomial of degree two, 2: by square roots alone. goalLink: which link changes with
/// the goal.
int meetingPairRank(const Loop& loop, int goalLink, double tolerance);

/// Loops in which two neighbouring axes, those of hinges 4 and 5, meet. With hinge 6 held the meeting point
/// is known, hinges 1 to 3 place it there in up to four ways, and what is left is one equation: the angle
/// between the axes. It is followed round the circle of u_6, branch by branch, with its slope: cells in which
/// it changes sign, or may touch zero by the tangents at both ends, or in which a branch ends, are halved;
/// Newton's method on the closed loop ends it. Nothing is eliminated, so nothing is ill-conditioned; what it
/// can overlook is a pair of solutions within one cell whose tangents do not point at zero.
LoopSolutions solveMeetingPair(const Loop& loop);

}  // namespace gelenk
