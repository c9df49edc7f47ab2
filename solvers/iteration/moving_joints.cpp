#include "solvers/iteration/moving_joints.h"

#include <algorithm>
#include <cmath>

#include "kinematics/configuration.h"
#include "solvers/problem/goal_type.h"

namespace gelenk {

MovingJoints::MovingJoints(const IkProblem& problem)
    : skeleton_(problem.skeleton), moves_(problem.skeleton->jointCount(), 0) {
  for (const Goal& goal : problem.goals) {
    const GoalType& type = goalType(goal.kind);
    if (!type.joints) {
      std::fill(moves_.begin(), moves_.end(), 1);
      continue;
    }
    if (!whyMisplaced(goal, *skeleton_).empty()) continue;
    std::vector<int> ends;
    type.joints(goal, *skeleton_, ends);
    for (int joint : ends)
      for (; joint >= 0; joint = skeleton_->parent(joint)) moves_[joint] = 1;
  }
  for (const int i : skeleton_->followers())
    if (moves_[i]) moves_[skeleton_->joint(i).coupling->source] = 1;
  for (const int i : skeleton_->followers()) moves_[i] = moves_[skeleton_->joint(i).coupling->source];
  all_ = std::all_of(moves_.begin(), moves_.end(), [](char moves) { return moves; });
  if (all_) return;
  home_ = projectToLimits(*skeleton_, problem.start);
  for (int i = 0; i < skeleton_->jointCount(); ++i) {
    const bool unit =
        !skeleton_->joint(i).ball || std::abs(ballRotation(*skeleton_, problem.start, i).norm() - 1.0) < 1e-9;
    if (const int n = skeleton_->qCount(i);
        n > 0 && unit &&
        limitViolation(*skeleton_, problem.start, i) <= 0.0)  // projecting may change last bits
      home_.segment(skeleton_->qIndex(i), n) = problem.start.segment(skeleton_->qIndex(i), n);
  }
  skeleton_->couple(home_);
}

void MovingJoints::restore(Eigen::VectorXd& q) const {
  if (all_) return;
  for (int i = 0; i < skeleton_->jointCount(); ++i)
    if (const int n = skeleton_->qCount(i); !moves_[i] && n > 0)
      q.segment(skeleton_->qIndex(i), n) = home_.segment(skeleton_->qIndex(i), n);
}

void MovingJoints::silence(Eigen::VectorXd& dq) const {
  if (all_) return;
  for (int i = 0; i < skeleton_->jointCount(); ++i)
    if (const int n = skeleton_->vCount(i); !moves_[i] && n > 0)
      dq.segment(skeleton_->vIndex(i), n).setZero();
}

}  // namespace gelenk
