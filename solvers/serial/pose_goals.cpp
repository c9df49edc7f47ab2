#include "solvers/serial/pose_goals.h"

#include <algorithm>

namespace gelenk {
namespace {

bool makeOnePose(const Goal& a, const Goal& b) {
  return a.kind == GoalKind::Position && b.kind == GoalKind::Orientation && a.joint == b.joint &&
         a.weight == b.weight && a.servedAs() == b.servedAs();
}

bool anyToMerge(const IkProblem& problem) {
  for (const Goal& a : problem.goals)
    for (const Goal& b : problem.goals)
      if (makeOnePose(a, b)) return true;
  return false;
}

class MergingPoseGoals final : public IkSolver {
 public:
  explicit MergingPoseGoals(std::unique_ptr<IkSolver> solver) : solver_(std::move(solver)) {}
  void prepare(const Skeleton& skeleton) override { solver_->prepare(skeleton); }
  std::string whyUnsupported(const IkProblem& problem) const override {
    return anyToMerge(problem) ? solver_->whyUnsupported(withPoseGoals(problem))
                               : solver_->whyUnsupported(problem);
  }
  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const override {
    return anyToMerge(problem) ? solver_->solve(withPoseGoals(problem), budget, trace)
                               : solver_->solve(problem, budget, trace);
  }

 private:
  std::unique_ptr<IkSolver> solver_;
};

}  // namespace

IkProblem withPoseGoals(const IkProblem& problem) {
  IkProblem merged = problem;
  for (std::size_t i = 0; i < merged.goals.size(); ++i) {
    const auto other = std::find_if(merged.goals.begin(), merged.goals.end(),
                                    [&](const Goal& b) { return makeOnePose(merged.goals[i], b); });
    if (other == merged.goals.end()) continue;
    merged.goals[i].kind = GoalKind::Pose;
    merged.goals[i].orientation = other->orientation;
    const auto at = static_cast<std::size_t>(other - merged.goals.begin());
    merged.goals.erase(other);
    if (at < i) --i;
  }
  return merged;
}

std::unique_ptr<IkSolver> mergingPoseGoals(std::unique_ptr<IkSolver> solver) {
  return std::make_unique<MergingPoseGoals>(std::move(solver));
}

}  // namespace gelenk
