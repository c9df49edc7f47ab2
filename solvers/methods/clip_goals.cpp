#include "solvers/methods/clip_goals.h"

#include <algorithm>

#include "kinematics/forward_kinematics.h"

namespace gelenk {

ClipWithGoals withGoals(const Skeleton& skeleton, const MotionClip& clip,
                        const std::function<std::vector<Goal>(int)>& goalsOfFrame, const IkSolver& solver,
                        const Budget& budget, double stayNear) {
  validate(skeleton, clip);
  ClipWithGoals result{.clip = clip};
  for (int f = 0; f < clip.frameCount(); ++f) {
    IkProblem problem{.skeleton = &skeleton, .start = clip.q.col(f), .goals = goalsOfFrame(f)};
    if (problem.goals.empty()) continue;
    if (stayNear > 0.0) {
      Goal posture{.kind = GoalKind::Posture, .name = "the clip's pose", .weight = stayNear};
      posture.posture = clip.q.col(f);
      problem.goals.push_back(std::move(posture));
    }
    const IkReport report = solver.solve(problem, budget, TraceLevel::Off);
    if (report.why != Stop::Converged) ++result.framesMissed;
    if (report.q.size() == skeleton.nq() && report.q.allFinite()) result.clip.q.col(f) = report.q;
    const Frames frames = forwardKinematics(skeleton, result.clip.q.col(f));
    for (const Goal& goal : problem.goals)
      if (goal.kind == GoalKind::Position)
        result.largestError =
            std::max(result.largestError, (frames[goal.joint] * goal.pointInJoint - goal.target).norm());
  }
  return result;
}

}  // namespace gelenk
