#include <stdexcept>

#include "apps/document/session.h"
#include "kinematics/configuration.h"
#include "solvers/iteration/attempt.h"
#include "solvers/tree/drag_solver.h"

namespace gelenk {
namespace {

/// A catalogue solver, started from the present pose with a small budget, so that a frame stays a frame. Time
/// is no part of the budget: the same frames give the same poses on every machine.
class WarmSolver final : public FrameSolver {
 public:
  WarmSolver(const std::string& name, std::shared_ptr<const Skeleton> skeleton)
      : skeleton_(std::move(skeleton)), solver_(makeSolver(name)) {
    solver_->prepare(*skeleton_);
  }

  IkReport frame(const IkProblem& problem) override {
    return solver_->solve(problem, {.maxIterations = 20, .maxSeconds = 3600.0}, TraceLevel::Residuals);
  }

 private:
  std::shared_ptr<const Skeleton> skeleton_;  // before the solver that refers to it
  std::unique_ptr<IkSolver> solver_;
};

/// The stateful drag solver.
class DragFrameSolver final : public FrameSolver {
 public:
  DragFrameSolver(std::shared_ptr<const Skeleton> skeleton, const DragParameters& parameters)
      : skeleton_(std::move(skeleton)), solver_(*skeleton_, options(parameters)) {}

  IkReport frame(const IkProblem& problem) override {
    if (fresh_) solver_.reset(problem.start);
    fresh_ = false;
    goals_ = problem.goals;
    for (Goal& goal : goals_)
      if (goal.role == Role::Pin) goal.weight /= pinWeight;  // pins have their weight in the solver's options
    return leavingSaddles(problem, settle(problem.start));
  }
  void reset() override { fresh_ = true; }
  void setPosture(const Eigen::VectorXd& q) override { solver_.setPosture(q); }

 private:
  /// At rest on a saddle, such as a straight arm with its target on its own line: a small step downhill, from
  /// where the next frames go on.
  IkReport leavingSaddles(const IkProblem& problem, IkReport report) {
    constexpr double step = 0.1;  // radians or metres
    if (report.why != Stop::Stationary || (lastRest_.size() == report.q.size() && lastRest_ == report.q))
      return report;
    Eigen::VectorXd lower;
    if (whyAtRest(problem, report.q, &lower) != Stop::Saddle) {
      lastRest_ = report.q;
      return report;
    }
    report.why = Stop::Saddle;
    if (lower.size() == 0) return report;
    Eigen::VectorXd way = difference(*skeleton_, report.q, lower);
    way *= step / std::max(step, way.lpNorm<Eigen::Infinity>());
    report.q = projectToLimits(*skeleton_, integrate(*skeleton_, report.q, way));
    report.why = Stop::Budget;
    solver_.reset(report.q);
    return report;
  }

  /// A picture lasts as long as hundreds of the solver's frames: while the pose creeps, it gets several, so
  /// that a body that lunges for a target out of reach comes to rest within a few pictures. Large motions
  /// keep the solver's pace.
  IkReport settle(const Eigen::VectorXd& start) {
    constexpr int most = 8;
    constexpr double creeping = 0.03;  // radians or metres since the picture before
    IkReport total = solver_.frame(goals_, TraceLevel::Residuals);
    for (int i = 1; i < most && total.why != Stop::Converged; ++i) {
      if (difference(solver_.skeleton(), start, total.q).lpNorm<Eigen::Infinity>() > creeping) break;
      const IkReport& next = solver_.frame(goals_, TraceLevel::Residuals);
      const bool still = difference(solver_.skeleton(), total.q, next.q).lpNorm<Eigen::Infinity>() < 1e-6;
      total.q = next.q;
      total.why = next.why;
      total.residual = next.residual;
      total.seconds += next.seconds;
      total.counters.iterations += next.counters.iterations;
      total.trace.insert(total.trace.end(), next.trace.begin(), next.trace.end());
      if (still) break;
    }
    return total;
  }

  /// A pelvis pushed 4 cm down on straight legs needs 14 mm against the posture's pull: with the default
  /// correction of at most 10 mm it comes to rest 4 mm above a target that it can reach.
  static DragOptions options(const DragParameters& parameters) {
    DragOptions options;
    options.posture = parameters.posture;
    options.poseArm = parameters.poseArm;
    options.dragBias = 0.04;
    // Twice the default: of eleven targets 1 to 3 m out of reach two ended in a cycle of 0.03 rad a
    // frame without it, none with it, and a hand led at 3 cm a frame stays within 0.1 mm of its target either
    // way.
    options.change = 0.01;
    return options;
  }

  std::shared_ptr<const Skeleton> skeleton_;  // before the solver that refers to it
  DragSolver solver_;
  std::vector<Goal> goals_;
  bool fresh_ = true;
  Eigen::VectorXd lastRest_;  ///< where no saddle was found
};

}  // namespace

std::vector<std::string> frameSolverNames() {
  std::vector<std::string> names{"drag"};
  for (const SolverEntry& entry : solverCatalogue())
    if (entry.name != "drag") names.emplace_back(entry.name);
  return names;
}

std::unique_ptr<FrameSolver> makeFrameSolver(const std::string& name,
                                             std::shared_ptr<const Skeleton> skeleton) {
  const SolverSpec spec = solverSpec(name);
  if (spec.entry->name == "drag")
    return std::make_unique<DragFrameSolver>(std::move(skeleton), withValues<DragParameters>(spec.values));
  return std::make_unique<WarmSolver>(name, std::move(skeleton));
}

}  // namespace gelenk
