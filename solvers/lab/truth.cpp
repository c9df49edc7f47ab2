#include "solvers/lab/truth.h"

#include <cmath>
#include <limits>
#include <optional>

#include "solvers/solutions/complete_set.h"
#include "solvers/solutions/self_motion.h"

namespace gelenk {

using Eigen::Isometry3d;

struct TruthFinder::Arm {
  GoalKind kind;
  Eigen::Vector3d point;
  std::optional<CompleteSet> finite;
  std::optional<SevenJointArm> seven;

  Arm(const Skeleton& skeleton, const Goal& goal) : kind(goal.kind), point(goal.pointInJoint) {
    const CompleteSetTask task{.task = kind == GoalKind::Pose ? TipTask::Pose : TipTask::Position,
                               .pointInTip = point};
    if (CompleteSet::whyNot(skeleton, goal.joint, task).empty()) {
      finite.emplace(skeleton, goal.joint, task);
      return;
    }
    const SerialChainResult chain = extractSerialChain(skeleton, goal.joint);
    if (kind == GoalKind::Pose && chain.whyNot.empty() && chain.chain.n == 7 && !chain.chain.hasPrismatic)
      seven.emplace(chain.chain);
  }
};

TruthFinder::TruthFinder() = default;
TruthFinder::~TruthFinder() = default;

Truth TruthFinder::of(const IkProblem& problem) {
  Truth truth{.solutions = {}, .nearest = std::numeric_limits<double>::quiet_NaN()};
  if (problem.goals.size() != 1) return truth;
  const Goal& goal = problem.goals[0];
  if (goal.kind != GoalKind::Pose && goal.kind != GoalKind::Position) return truth;
  std::unique_ptr<Arm>& arm = arms_[{problem.skeleton, goal.joint}];
  if (!arm || arm->kind != goal.kind || arm->point != goal.pointInJoint)
    arm = std::make_unique<Arm>(*problem.skeleton, goal);
  const Isometry3d target = Eigen::Translation3d(goal.target) * goal.orientation.normalized();
  if (arm->seven) {
    Vector7d start, nearest;
    for (int i = 0; i < 7; ++i) start[i] = problem.start[arm->seven->chain().qIndex[i]];
    const bool reached =
        arm->seven->nearest(target * Eigen::Translation3d(-goal.pointInJoint), start, nearest);
    truth.solutions = reached ? "family" : "0";
    if (reached) truth.nearest = (nearest - start).norm();
  }
  if (!arm->finite) return truth;
  const SerialChain& chain = arm->finite->chain();
  Vector6d start = Vector6d::Zero();
  for (int i = 0; i < chain.n; ++i) start[i] = problem.start[chain.qIndex[i]];
  ArmSolutions found;
  arm->finite->solve(target, start, found);
  if (!found.complete) return truth;
  int within = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (const ArmSolution& s : found.all()) {
    if (s.free != 0) return {"family", truth.nearest};
    if (!s.withinLimits) continue;
    ++within;
    nearest = std::min(nearest, (s.q - start).norm());
  }
  truth.solutions = std::to_string(within);
  if (within > 0) truth.nearest = nearest;
  return truth;
}

}  // namespace gelenk
