#include "solvers/tree/hybrid_solver.h"

#include "kinematics/configuration.h"
#include "solvers/iteration/attempt.h"
#include "solvers/problem/judge.h"
#include "solvers/tree/drag_solver.h"

namespace gelenk {
namespace {

class HybridSolver final : public IkSolver {
 public:
  explicit HybridSolver(const HybridParameters& parameters) : p_(parameters) {}
  std::string whyUnsupported(const IkProblem& problem) const override {
    for (const Goal& goal : problem.goals)
      if (goal.kind == GoalKind::Pole &&
          (problem.skeleton->parent(goal.joint) < 0 || problem.skeleton->children(goal.joint).empty()))
        return "a pole goal needs a joint with a parent and a child";
    return {};
  }

  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const override {
    if (!whyUnsupported(problem).empty())
      return {.q = problem.start, .why = Stop::Unsupported, .counters = {}, .trace = {}};
    DragSolver solver(*problem.skeleton, {.posture = p_.posture, .poseArm = p_.poseArm});
    IkReport report = solver.solve(problem, budget, trace);
    // Its own objective holds posture too, and may rest on a place that meets the goals or on a saddle of
    // them.
    IkProblem below = problem;
    for (int saddles = 0; saddles < 20; ++saddles) {
      if (report.why != Stop::Stationary || judge(problem, report.q).solved) break;
      Eigen::VectorXd lower;
      report.why = whyAtRest(problem, report.q, &lower);
      if (lower.size() == 0) break;
      below.start = lower;
      IkReport next = solver.solve(below, budget, trace);
      next.counters += report.counters;
      next.seconds += report.seconds;
      next.trace.insert(next.trace.begin(), report.trace.begin(), report.trace.end());
      report = std::move(next);
    }
    MovingJoints(problem).restore(report.q);
    const Eigen::VectorXd& q = report.q;
    const Frames frames = forwardKinematics(*problem.skeleton, q);
    double squared = 0.0;
    Eigen::VectorXd r;
    for (const Goal& goal : problem.goals) {
      r.resize(residualRows(goal, *problem.skeleton));
      goalResidual(goal, *problem.skeleton, q, frames, r);
      squared += goal.weight * r.squaredNorm();
    }
    report.residual = std::sqrt(squared);
    if (judge(problem, q).solved) report.why = Stop::Converged;
    return report;
  }

 private:
  HybridParameters p_;
};

}  // namespace

std::unique_ptr<IkSolver> makeHybrid(const HybridParameters& parameters) {
  return std::make_unique<HybridSolver>(parameters);
}

}  // namespace gelenk
