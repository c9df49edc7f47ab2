#pragma once

#include <Eigen/Core>
#include <random>

#include "kinematics/configuration.h"
#include "solvers/iteration/evaluator.h"
#include "solvers/iteration/limit_set.h"
#include "solvers/iteration/moving_joints.h"
#include "solvers/problem/ik_solver.h"

namespace gelenk {

/// What every iterative method shares in one attempt from one start: the counted evaluator, the limits, the
/// budget, the best configuration so far, the trace, and the tests that end it.
class Attempt {
 public:
  Attempt(const IkProblem& problem, const Budget& budget, TraceLevel trace);

  CountedEvaluator at;
  LimitSet limits;

  /// Moves to a start (projected to the limits) and forgets the last attempt.
  void begin(const Eigen::VectorXd& start);

  /// True when the attempt is over; then why() holds the reason. Call it with `at` where the iteration
  /// stands. Tests, in this order: tolerances met; iterations or time spent; no progress in the last 30
  /// iterations.
  bool isOver();
  /// Moves the limits to at.q(), locks those that the descent direction J^T r leaves, and says whether
  /// nothing is left of it: |P J^T r| <= 1e-8 |J| |r|, a cosine that no unit can change.
  bool isStationary();

  enum class Rest { No, Left, Over };
  /// What to do where nothing is left of the slope. The cost's second derivatives decide: where none is
  /// negative the attempt ends as Stationary (Over); where one is, the attempt goes on from a lower place
  /// along it (Left: `at` has moved, what a method remembers is void), or ends as a Saddle if there is none.
  /// No: there is a slope.
  Rest rest();
  const Eigen::VectorXd& projectedGradient() const { return gradient_; }

  /// Counts one iteration and traces it with the step about to be taken.
  void countIteration(double stepNorm, double damping);
  /// Ends the attempt.
  void stop(Stop why) {
    why_ = why;
    over_ = true;
  }
  Stop why() const { return why_; }

  const Budget& budget() const { return budget_; }
  std::mt19937_64& random() { return random_; }
  /// A random configuration within the limits; joints off the goals' paths where the problem's start has
  /// them.
  Eigen::VectorXd randomStart();
  const MovingJoints& movingJoints() const { return moving_; }
  /// Moves to q, wrapped and projected to the limits, and considers it.
  void propose(const Eigen::VectorXd& q);
  /// Keeps at.q() if it is the best of the attempt.
  void consider();
  /// Replaces the best by at.q(), for methods whose order of importance is not the weighted residual.
  void insist();

 private:
  friend IkReport reportOf(Attempt& attempt, const Eigen::VectorXd& q, Stop why, double residual);
  template <typename Method>
  friend IkReport solveWithRestarts(const IkProblem&, const Budget&, TraceLevel, Method&&);

  void trace(double stepNorm, double damping);
  bool leaveSaddle();
  Eigen::MatrixXd curvature();

  const IkProblem& problem_;
  MovingJoints moving_;
  Budget budget_;
  TraceLevel traceLevel_;
  std::mt19937_64 random_;
  Eigen::VectorXd bestQ_, gradient_, zero_, proposed_;
  double bestResidual_ = 0.0, windowResidual_ = 0.0;
  int iterationsAtBegin_ = 0, windowBegin_ = 0, saddlesLeft_ = 0;
  bool over_ = false;
  Stop why_ = Stop::Failure;
  std::vector<IterationRecord> trace_;
};

IkReport reportOf(Attempt& attempt, const Eigen::VectorXd& q, Stop why, double residual);

/// What a solver returns for a problem that it does not do: the start, untouched.
IkReport unsupported(const IkProblem& problem);

/// Why a configuration where a method found no further step is one to rest at: Stationary by first and second
/// derivatives of the cost within the limits, Saddle, or Stalled where there is still a slope.
/// lower: where the cost is lower, if a saddle can be left.
Stop whyAtRest(const IkProblem& problem, const Eigen::VectorXd& q, Eigen::VectorXd* lower = nullptr);

/// Runs method(attempt) from problem.start and then, while nothing converged and the budget allows, from
/// random configurations within the limits, drawn from budget.seed; joints off the goals' paths stay where
/// the start has them. Reports the attempt with the smallest residual. method: void(Attempt&), ends with
/// attempt.stop(...) or attempt.isOver().
template <typename Method>
IkReport solveWithRestarts(const IkProblem& problem, const Budget& budget, TraceLevel trace,
                           Method&& method) {
  Attempt attempt(problem, budget, trace);
  Eigen::VectorXd bestQ;
  double bestResidual = 0.0;
  Stop why = Stop::Failure;
  for (int i = 0; i <= budget.restarts; ++i) {
    if (i > 0) {
      if (attempt.at.seconds() > budget.maxSeconds) break;
      ++attempt.at.counters().restarts;
    }
    attempt.begin(i == 0 ? problem.start : attempt.randomStart());
    method(attempt);
    attempt.trace(0.0, 0.0);
    if (i == 0 || attempt.bestResidual_ < bestResidual || attempt.why() == Stop::Converged) {
      bestQ = attempt.bestQ_;
      bestResidual = attempt.bestResidual_;
      why = attempt.why();
    }
    if (why == Stop::Converged) break;
  }
  return reportOf(attempt, bestQ, why, bestResidual);
}

}  // namespace gelenk
