#include "solvers/iteration/attempt.h"

#include "kinematics/configuration.h"

namespace gelenk {

using Eigen::VectorXd;

namespace {
constexpr int progressWindow = 30;        // iterations in which the best residual must fall ...
constexpr double progressFactor = 0.999;  // ... at least by this factor
constexpr double stationaryCosine = 1e-8;
}  // namespace

Attempt::Attempt(const IkProblem& problem, const Budget& budget, TraceLevel trace)
    : at(problem),
      limits(*problem.skeleton),
      problem_(problem),
      budget_(budget),
      traceLevel_(trace),
      random_(budget.seed) {
  gradient_.resize(problem.skeleton->nv());
  zero_.setZero(problem.skeleton->nv());
  if (trace != TraceLevel::Off) trace_.reserve(std::min(budget.maxIterations, 1000) + 1);
}

void Attempt::begin(const VectorXd& start) {
  over_ = false;
  why_ = Stop::Failure;
  iterationsAtBegin_ = windowBegin_ = at.counters().iterations;
  limits.retract(start, zero_, bestQ_);
  at.moveTo(bestQ_);
  bestResidual_ = windowResidual_ = at.residual().norm();
  if (!std::isfinite(bestResidual_)) stop(Stop::Failure);
}

void Attempt::propose(const VectorXd& q) {
  limits.retract(q, zero_, proposed_);
  at.moveTo(proposed_);
  consider();
}

void Attempt::consider() {
  const double residual = at.residual().norm();
  if (!(residual < bestResidual_)) return;
  bestResidual_ = residual;
  bestQ_ = at.q();
}

void Attempt::insist() {
  bestResidual_ = at.residual().norm();
  bestQ_ = at.q();
}

bool Attempt::isOver() {
  if (over_) return true;
  if (at.withinTolerance()) {
    insist();
    stop(Stop::Converged);
    return true;
  }
  const int iterations = at.counters().iterations;
  if (iterations - iterationsAtBegin_ >= budget_.maxIterations || at.seconds() > budget_.maxSeconds) {
    stop(Stop::Budget);
    return true;
  }
  if (bestResidual_ < progressFactor * windowResidual_) {
    windowResidual_ = bestResidual_;
    windowBegin_ = iterations;
  } else if (iterations - windowBegin_ >= progressWindow) {
    stop(Stop::Stalled);
    return true;
  }
  return false;
}

bool Attempt::isStationary() {
  limits.moveTo(at.q());
  gradient_.noalias() = at.jacobian().transpose() * at.residual();
  limits.lockBlocked(gradient_);
  limits.project(gradient_);
  return gradient_.norm() <= stationaryCosine * at.jacobian().norm() * at.residual().norm();
}

void Attempt::countIteration(double stepNorm, double damping) {
  trace(stepNorm, damping);
  ++at.counters().iterations;
}

void Attempt::trace(double stepNorm, double damping) {
  if (traceLevel_ == TraceLevel::Off) return;
  trace_.push_back({.q = traceLevel_ == TraceLevel::Full ? at.q() : VectorXd(),
                    .residual = at.residual().norm(),
                    .stepNorm = stepNorm,
                    .damping = damping,
                    .seconds = at.seconds()});
}

IkReport reportOf(Attempt& attempt, const VectorXd& q, Stop why, double residual) {
  IkReport report;
  report.q = q;
  report.why = why;
  report.residual = residual;
  report.counters = attempt.at.counters();
  report.seconds = attempt.at.seconds();
  report.trace = std::move(attempt.trace_);
  return report;
}

IkReport unsupported(const IkProblem& problem) {
  IkReport report;
  report.q = problem.start;
  report.why = Stop::Unsupported;
  return report;
}

}  // namespace gelenk
