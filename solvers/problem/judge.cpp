#include "solvers/problem/judge.h"

#include "kinematics/configuration.h"

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
    const GoalType& type = goalType(goal.kind);
    Eigen::VectorXd r(type.rows(skeleton));
    type.residual(goal, {skeleton, q, frames}, r);
    const GoalError error = type.judged ? type.error(r) : GoalError{};
    verdict.solved = verdict.solved && error.position <= problem.positionTolerance &&
                     error.orientation <= problem.orientationTolerance;
    verdict.goals.push_back(error);
  }
  return verdict;
}

}  // namespace gelenk
