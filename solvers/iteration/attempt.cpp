#include "solvers/iteration/attempt.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "kinematics/configuration.h"

namespace gelenk {

using Eigen::VectorXd;

namespace {
constexpr int progressWindow = 30;        // iterations in which the best residual must fall ...
constexpr double progressFactor = 0.999;  // ... at least by this factor
constexpr double stationaryCosine = 1e-8;
constexpr double flat =
    1e-7;  // of the largest second derivative: what rounding and the tolerance above leave
constexpr int mostSaddles = 20;  // left in one attempt
}  // namespace

Attempt::Attempt(const IkProblem& problem, const Budget& budget, TraceLevel trace)
    : at(problem),
      limits(*problem.skeleton),
      problem_(problem),
      moving_(problem),
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
  saddlesLeft_ = 0;
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

Attempt::Rest Attempt::rest() {
  bool left = false;
  while (isStationary()) {
    if (!leaveSaddle()) return Rest::Over;
    left = true;
    if (isOver()) return Rest::Over;
  }
  return left ? Rest::Left : Rest::No;
}

/// The second derivatives of the cost at at.q(), nv x nv: exact where the goals say them, else by central
/// differences of the slope.
Eigen::MatrixXd Attempt::curvature() {
  const bool exact = std::all_of(problem_.goals.begin(), problem_.goals.end(),
                                 [](const Goal& goal) { return goalType(goal.kind).addHessian != nullptr; });
  if (exact) return at.hessian();
  constexpr double h = 1e-5;
  const int nv = problem_.skeleton->nv();
  const VectorXd q = at.q();
  Eigen::MatrixXd H(nv, nv);
  const auto slopeAt = [&](int k, double by) -> VectorXd {
    at.moveTo(integrate(*problem_.skeleton, q, by * VectorXd::Unit(nv, k)));
    return at.jacobian().transpose() * at.residual();
  };
  for (int k = 0; k < nv; ++k) H.col(k) = (slopeAt(k, -h) - slopeAt(k, h)) / (2.0 * h);
  at.moveTo(q);
  return 0.5 * (H + H.transpose());
}

/// At a stationary place, limits moved there and locked: false where it is one to end at, which why() says.
bool Attempt::leaveSaddle() {
  if (problem_.skeleton->nv() == 0) {
    stop(Stop::Stationary);
    return false;
  }
  Eigen::MatrixXd H = curvature();
  const double size = H.cwiseAbs().maxCoeff();
  limits.projectBothSides(H);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(H);
  if (!(eigen.eigenvalues()[0] < -flat * size)) {
    stop(Stop::Stationary);
    return false;
  }
  const VectorXd from = at.q();
  const double cost = at.cost();
  for (Eigen::Index i = 0;
       i < H.rows() && saddlesLeft_ < mostSaddles && eigen.eigenvalues()[i] < -flat * size; ++i) {
    VectorXd way = eigen.eigenvectors().col(i);
    Eigen::Index largest = 0;
    way.cwiseAbs().maxCoeff(&largest);
    if (way[largest] < 0.0) way = -way;  // the same way on every machine
    for (double length = 0.5; length > 1e-4; length *= 0.5) {
      VectorXd best;
      double lowest =
          cost + 0.25 * eigen.eigenvalues()[i] * length * length;  // half of what the curvature promises
      for (const double sign : {1.0, -1.0}) {
        limits.retract(from, sign * length * way, proposed_);
        at.moveTo(proposed_);
        if (at.cost() < lowest) lowest = at.cost(), best = proposed_;
      }
      if (best.size() == 0) continue;
      at.moveTo(from);
      countIteration(length, 0.0);
      at.moveTo(best);
      consider();
      ++saddlesLeft_;
      return true;
    }
  }
  at.moveTo(from);
  // Limits that the place touches without being pressed against may bar the way: on what is left the cost may
  // be lowest all the same.
  isStationary();
  limits.lockTouched();
  H = curvature();
  limits.projectBothSides(H);
  const bool lowest =
      !(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(H, Eigen::EigenvaluesOnly).eigenvalues()[0] <
        -flat * size);
  stop(lowest ? Stop::Stationary : Stop::Saddle);
  return false;
}

VectorXd Attempt::randomStart() {
  VectorXd q = randomWithinLimits(*problem_.skeleton, random_);
  moving_.restore(q);
  return q;
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
  attempt.moving_.restore(report.q);  // steps of length 0 and the way through a chart change last bits
  report.why = why;
  report.residual = residual;
  report.counters = attempt.at.counters();
  report.seconds = attempt.at.seconds();
  report.trace = std::move(attempt.trace_);
  return report;
}

Stop whyAtRest(const IkProblem& problem, const VectorXd& q, VectorXd* lower) {
  Attempt attempt(problem, {.maxIterations = 1 << 30, .maxSeconds = 1e9}, TraceLevel::Off);
  attempt.begin(q);
  switch (attempt.rest()) {
    case Attempt::Rest::No: return Stop::Stalled;
    case Attempt::Rest::Left: break;
    case Attempt::Rest::Over:
      if (attempt.why() != Stop::Converged) return attempt.why();
      break;
  }
  if (lower) *lower = attempt.at.q();
  return Stop::Saddle;
}

IkReport unsupported(const IkProblem& problem) {
  IkReport report;
  report.q = problem.start;
  report.why = Stop::Unsupported;
  return report;
}

}  // namespace gelenk
