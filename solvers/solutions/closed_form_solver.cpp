#include "solvers/solutions/closed_form_solver.h"

#include <chrono>
#include <cmath>

#include "kinematics/configuration.h"
#include "solvers/problem/judge.h"
#include "solvers/serial/same_joints.h"
#include "solvers/serial/serial_pose.h"
#include "solvers/solutions/complete_set.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::VectorXd;

std::string refusal(const IkProblem& problem) {
  if (problem.goals.size() != 1)
    return "solves exactly one goal, not " + std::to_string(problem.goals.size());
  const GoalKind kind = problem.goals[0].kind;
  return kind == GoalKind::Pose || kind == GoalKind::Position ? "" : "solves pose and position goals only";
}

CompleteSetTask taskOf(const Goal& goal) {
  if (goal.kind == GoalKind::Pose) return {};  // the point is put into the target instead
  return {.task = TipTask::Position, .pointInTip = goal.pointInJoint};
}

class ClosedForm final : public IkSolver {
 public:
  /// A set for every joint that can have one; general arms take some milliseconds to rank their cuts.
  void prepare(const Skeleton& skeleton) override {
    prepared_ = skeleton.joints();
    sets_.clear();
    for (int j = 0; j < skeleton.jointCount(); ++j)
      sets_.push_back(skeleton.children(j).empty() && CompleteSet::whyNot(skeleton, j).empty()
                          ? std::make_unique<CompleteSet>(skeleton, j)
                          : nullptr);
  }

  std::string whyUnsupported(const IkProblem& problem) const override {
    const std::string reason = refusal(problem);
    if (!reason.empty()) return reason;
    return CompleteSet::whyNot(*problem.skeleton, problem.goals[0].joint, taskOf(problem.goals[0]));
  }

  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const override {
    const auto begin = std::chrono::steady_clock::now();
    IkReport report;
    report.q = problem.start;
    report.why = Stop::Unsupported;
    if (!refusal(problem).empty()) return report;
    const Goal& goal = problem.goals[0];
    std::unique_ptr<CompleteSet> fresh;
    const CompleteSet* set = nullptr;
    if (goal.kind == GoalKind::Pose && !prepared_.empty() &&
        sameJoints(prepared_, problem.skeleton->joints()))
      set = sets_[goal.joint].get();
    if (!set) {
      if (!whyUnsupported(problem).empty()) return report;
      fresh = std::make_unique<CompleteSet>(*problem.skeleton, goal.joint, taskOf(goal));
      set = fresh.get();
    }
    report.why = Stop::Failure;
    if (!problem.start.allFinite() || !goal.target.allFinite() || !goal.orientation.coeffs().allFinite())
      return report;
    report.q = projectToLimits(*problem.skeleton, problem.start);
    if (!takeNearest(*set, problem, report)) takeClosest(problem, budget, trace, report);
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return report;
  }

 private:
  static bool takeNearest(const CompleteSet& set, const IkProblem& problem, IkReport& report) {
    const Goal& goal = problem.goals[0];
    const SerialChain& chain = set.chain();
    Isometry3d target = Eigen::Translation3d(goal.target) * goal.orientation.normalized();
    if (goal.kind == GoalKind::Pose) target = target * Eigen::Translation3d(-goal.pointInJoint);
    Vector6d start = Vector6d::Zero();
    for (int i = 0; i < chain.n; ++i) start[i] = report.q[chain.qIndex[i]];
    ArmSolutions found;
    set.solve(target, start, found);
    VectorXd q = report.q, best;
    double bestDistance = INFINITY;
    for (const ArmSolution& s : found.all()) {
      const double distance = (s.q - start).norm();
      if (!s.withinLimits || distance >= bestDistance) continue;
      for (int i = 0; i < chain.n; ++i) q[chain.qIndex[i]] = s.q[i];
      problem.skeleton->couple(q);
      ++report.counters.forwardKinematics;
      if (!judge(problem, q).solved) continue;
      bestDistance = distance;
      best = q;
    }
    if (!std::isfinite(bestDistance)) return false;
    report.q = best;
    report.why = Stop::Converged;
    const Judgement verdict = judge(problem, best);
    report.residual =
        std::sqrt(goal.weight) * std::hypot(verdict.goals[0].position, verdict.goals[0].orientation);
    return true;
  }

  static void takeClosest(const IkProblem& problem, const Budget& budget, TraceLevel trace,
                          IkReport& report) {
    const int work = report.counters.forwardKinematics;
    report = makeSerialPose()->solve(problem, budget, trace);
    report.counters.forwardKinematics += work;
  }

  std::vector<Joint> prepared_;
  std::vector<std::unique_ptr<CompleteSet>> sets_;
};

}  // namespace

std::unique_ptr<IkSolver> makeClosedForm() { return std::make_unique<ClosedForm>(); }

}  // namespace gelenk
