#include "solvers/problem/judge.h"

#include "kinematics/configuration.h"
#include "solvers/iteration/evaluator.h"

namespace gelenk {

Judgement judge(const IkProblem& problem, const Eigen::VectorXd& q) {
  const Skeleton& skeleton = *problem.skeleton;
  Judgement verdict;
  verdict.finite = q.size() == skeleton.nq() && q.allFinite();
  for (int i = 0; verdict.finite && i < skeleton.jointCount(); ++i)
    if (skeleton.joint(i).ball) verdict.finite = std::abs(ballRotation(skeleton, q, i).norm() - 1.0) < 1e-9;
  if (!verdict.finite) return verdict;

  const Frames frames = forwardKinematics(skeleton, q);
  verdict.limitViolation = limitViolation(skeleton, q);
  verdict.solved = verdict.limitViolation <= 1e-9;
  for (const Goal& goal : problem.goals) {
    Eigen::VectorXd r(residualRows(goal, skeleton));
    goalResidual(goal, skeleton, q, frames, r);
    GoalError error;
    switch (goal.kind) {
      case GoalKind::Position:
      case GoalKind::Pole: error.position = r.norm(); break;
      case GoalKind::Orientation:
      case GoalKind::Aim: error.orientation = r.norm(); break;
      case GoalKind::Pose:
        error.position = r.head<3>().norm();
        error.orientation = r.tail<3>().norm();
        break;
      case GoalKind::Posture: break;
    }
    verdict.solved = verdict.solved && error.position <= problem.positionTolerance &&
                     error.orientation <= problem.orientationTolerance;
    verdict.goals.push_back(error);
  }
  return verdict;
}

}  // namespace gelenk
