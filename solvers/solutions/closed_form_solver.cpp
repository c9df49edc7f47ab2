#include "solvers/solutions/closed_form_solver.h"

#include <chrono>
#include <cmath>
#include <optional>

#include "kinematics/configuration.h"
#include "solvers/problem/judge.h"
#include "solvers/serial/same_joints.h"
#include "solvers/serial/serial_pose.h"
#include "solvers/solutions/complete_set.h"
#include "solvers/solutions/self_motion.h"

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

/// The chain of seven turning joints that shall reach a pose; none where it is no such task.
std::optional<SerialChain> sevenJoints(const Skeleton& skeleton, int joint, const CompleteSetTask& task) {
  SerialChainResult serial = extractSerialChain(skeleton, joint);
  if (task.task != TipTask::Pose || !serial.whyNot.empty() || serial.chain.n != 7 ||
      serial.chain.hasPrismatic)
    return std::nullopt;
  return std::move(serial.chain);
}

std::string whyNoArm(const Skeleton& skeleton, int joint, const CompleteSetTask& task) {
  return sevenJoints(skeleton, joint, task) ? "" : CompleteSet::whyNot(skeleton, joint, task);
}

/// What an arm's solutions come from: a finite set, or the curves of seven joints.
struct Arm {
  std::unique_ptr<const CompleteSet> set;
  std::unique_ptr<const SevenJointArm> seven;

  Arm(const Skeleton& skeleton, int joint, const CompleteSetTask& task) {
    if (const std::optional<SerialChain> chain = sevenJoints(skeleton, joint, task))
      seven = std::make_unique<SevenJointArm>(*chain);
    else
      set = std::make_unique<CompleteSet>(skeleton, joint, task);
  }
  const SerialChain& chain() const { return set ? set->chain() : seven->chain(); }
};

class ClosedForm final : public IkSolver {
 public:
  /// An arm for every end; general ones take some milliseconds to rank their cuts.
  void prepare(const Skeleton& skeleton) override {
    prepared_ = skeleton.joints();
    arms_.clear();
    for (int j = 0; j < skeleton.jointCount(); ++j)
      arms_.push_back(skeleton.children(j).empty() && whyNoArm(skeleton, j, {}).empty()
                          ? std::make_unique<Arm>(skeleton, j, CompleteSetTask{})
                          : nullptr);
  }

  std::string whyUnsupported(const IkProblem& problem) const override {
    const std::string reason = refusal(problem);
    if (!reason.empty()) return reason;
    return whyNoArm(*problem.skeleton, problem.goals[0].joint, taskOf(problem.goals[0]));
  }

  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const override {
    const auto begin = std::chrono::steady_clock::now();
    IkReport report;
    report.q = problem.start;
    report.why = Stop::Unsupported;
    if (!refusal(problem).empty()) return report;
    const Goal& goal = problem.goals[0];
    std::unique_ptr<const Arm> fresh;
    const Arm* arm = nullptr;
    if (goal.kind == GoalKind::Pose && !prepared_.empty() &&
        sameJoints(prepared_, problem.skeleton->joints()))
      arm = arms_[goal.joint].get();
    if (!arm) {
      if (!whyUnsupported(problem).empty()) return report;
      fresh = std::make_unique<Arm>(*problem.skeleton, goal.joint, taskOf(goal));
      arm = fresh.get();
    }
    report.why = Stop::Failure;
    if (!problem.start.allFinite() || !goal.target.allFinite() || !goal.orientation.coeffs().allFinite())
      return report;
    report.q = projectToLimits(*problem.skeleton, problem.start);
    if (!takeNearest(*arm, problem, report)) takeClosest(problem, budget, trace, report);
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return report;
  }

 private:
  static bool takeNearest(const Arm& arm, const IkProblem& problem, IkReport& report) {
    const Goal& goal = problem.goals[0];
    const SerialChain& chain = arm.chain();
    Isometry3d target = Eigen::Translation3d(goal.target) * goal.orientation.normalized();
    if (goal.kind == GoalKind::Pose) target = target * Eigen::Translation3d(-goal.pointInJoint);
    VectorXd start(chain.n), q = report.q, best;
    for (int i = 0; i < chain.n; ++i) start[i] = report.q[chain.qIndex[i]];
    double bestDistance = INFINITY;
    const auto consider = [&](const auto& solution) {
      const double distance = (solution.head(chain.n) - start).norm();
      if (distance >= bestDistance) return;
      for (int i = 0; i < chain.n; ++i) q[chain.qIndex[i]] = solution[i];
      problem.skeleton->couple(q);
      ++report.counters.forwardKinematics;
      if (!judge(problem, q).solved) return;
      bestDistance = distance;
      best = q;
    };
    if (arm.seven) {
      Vector7d nearest;
      if (arm.seven->nearest(target, start, nearest)) consider(nearest);
    } else {
      Vector6d reference = Vector6d::Zero();
      reference.head(chain.n) = start;
      ArmSolutions found;
      arm.set->solve(target, reference, found);
      for (const ArmSolution& s : found.all())
        if (s.withinLimits) consider(s.q);
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
  std::vector<std::unique_ptr<const Arm>> arms_;
};

}  // namespace

std::unique_ptr<IkSolver> makeClosedForm() { return std::make_unique<ClosedForm>(); }

}  // namespace gelenk
