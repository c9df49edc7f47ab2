#pragma once

#include <functional>
#include <vector>

#include "kinematics/motion/motion_clip.h"
#include "solvers/problem/ik_solver.h"

namespace gelenk {

/// What withGoals made of a clip.
struct ClipWithGoals {
  MotionClip clip;
  double largestError = 0.0;  ///< metres: largest distance of a Position goal from its target in any frame,
                              ///< recomputed by forward kinematics
  int framesMissed = 0;       ///< frames in which the solver did not converge; they keep its best pose
};

/// Forward and inverse kinematics at once (lecture, end of 10.1): the goals of each frame are solved starting
/// from the clip's own pose, which a Posture goal of weight `stayNear` (0: none) also keeps in sight. Frames
/// without goals stay as they are. The solver works within the skeleton's limits, so poses of solved frames
/// lie within them even where the clip's did not. goalsOfFrame: frame from 0 -> goals. Throws
/// std::invalid_argument for a clip that does not fit the skeleton.
ClipWithGoals withGoals(const Skeleton& skeleton, const MotionClip& clip,
                        const std::function<std::vector<Goal>(int)>& goalsOfFrame, const IkSolver& solver,
                        const Budget& budget = {}, double stayNear = 0.0);

}  // namespace gelenk
