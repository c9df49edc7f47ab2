#pragma once

#include <memory>

#include "solvers/iteration/attempt.h"

namespace gelenk {

/// The iteration around a step rule: q <- q (+) dq until an Attempt is over. Limits are an active set: what
/// the gradient pushes against is locked; what a step would cross is moved to its bound and locked, and the
/// step is solved again with the rest of the residual.
///
/// A Rule has storage for one solve and
///   using Parameters = ...                its constants, a plain struct (parameters.h)
///   Rule(const IkProblem&, const Parameters&)
///   void step(CountedEvaluator& at, const LimitSet&, const MatrixXd& J, const VectorXd& r,
///             const VectorXd& fixed, VectorXd& dq)
///     J: m x nv with the locked dimensions taken out; r: what is left of the residual after the move
///     `fixed`; dq: out, nv.
///   double largestStep() const            radians or metres a coordinate; longer steps are shortened as a
///                                         whole
///   static constexpr bool monotone        steps that do not lower the cost are taken back; then also
///     void adapt(double gain)             actual over predicted fall of the cost, negative for a rejected
///                                         step
///   double damping() const                for the trace
/// and may have
///   void begin()                          at the start of an attempt
///   static constexpr bool ownLimits       the step keeps the limits itself; no second solve
///   static constexpr bool ownOrder        the last configuration is the answer, not the one of smallest
///                                         residual
///   double predicted(const VectorXd& dq)  fall of the cost by the rule's own model; the linear model
///                                         otherwise
template <typename Rule>
class StepIteration {
 public:
  StepIteration(const IkProblem& problem, const typename Rule::Parameters& parameters)
      : rule_(problem, parameters),
        nv_(problem.skeleton->nv()),
        fixed_(nv_),
        dq_(nv_),
        total_(nv_),
        q_(nv_),
        candidate_(nv_) {}

  void operator()(Attempt& attempt) {
    CountedEvaluator& at = attempt.at;
    if constexpr (requires { rule_.begin(); }) rule_.begin();
    bool moved = true;
    while (!attempt.isOver()) {
      if (moved) {
        if (ownOrder())
          attempt.isStationary();
        else if (attempt.rest() == Attempt::Rest::Over)
          return;
        q_ = at.q();
        J_ = at.jacobian();
        r_ = at.residual();
        gradient_.noalias() = J_.transpose() * r_;
      } else {
        attempt.limits.moveTo(q_);
        attempt.limits.lockBlocked(gradient_);
      }
      findStep(attempt);
      const double length = total_.norm();
      if (!std::isfinite(length)) return attempt.stop(Stop::Failure);
      attempt.countIteration(length, rule_.damping());
      if (length < 1e-14) {
        const Attempt::Rest rest = attempt.rest();
        if (rest == Attempt::Rest::Left) {
          moved = true;
          continue;
        }
        if (rest == Attempt::Rest::No) attempt.stop(ownOrder() ? Stop::Stationary : Stop::Stalled);
        return;
      }
      moved = takeStep(attempt);
    }
  }

 private:
  static constexpr bool ownOrder() {
    if constexpr (requires { Rule::ownOrder; }) return Rule::ownOrder;
    return false;
  }
  static constexpr bool ownLimits() {
    if constexpr (requires { Rule::ownLimits; }) return Rule::ownLimits;
    return false;
  }

  /// Sets total_, the step within the linearised limits.
  void findStep(Attempt& attempt) {
    constexpr int mostPasses = 8;
    fixed_.setZero();
    for (int pass = 0; pass < mostPasses; ++pass) {
      reducedJ_ = J_;
      reducedR_ = r_;
      if (!ownLimits()) {
        attempt.limits.projectColumns(reducedJ_);
        if (pass > 0) reducedR_.noalias() -= J_ * fixed_;
      }
      rule_.step(attempt.at, attempt.limits, reducedJ_, reducedR_, fixed_, dq_);
      ++attempt.at.counters().factorisations;
      if (!ownLimits()) attempt.limits.project(dq_);
      const double largest = dq_.template lpNorm<Eigen::Infinity>();
      if (largest > rule_.largestStep()) dq_ *= rule_.largestStep() / largest;
      total_ = fixed_ + dq_;
      if (ownLimits() || !attempt.limits.lockCrossed(dq_, fixed_)) return;
    }
  }

  /// Moves along total_; false if the step was taken back, which leaves `at` at the old place.
  bool takeStep(Attempt& attempt) {
    CountedEvaluator& at = attempt.at;
    const double before = at.cost();
    attempt.limits.retract(q_, total_, candidate_);
    at.moveTo(candidate_);
    if (!std::isfinite(at.cost())) {
      at.moveTo(q_);
      attempt.stop(Stop::Failure);
      return false;
    }
    if constexpr (Rule::monotone) {
      const double fall = before - at.cost();
      if (!(fall > 0.0)) {
        rule_.adapt(-1.0);
        at.moveTo(q_);
        if (!(rule_.damping() < 1e15)) attempt.stop(Stop::Stalled);
        return false;
      }
      double predicted;
      if constexpr (requires { rule_.predicted(total_); }) {
        predicted = rule_.predicted(total_);
      } else {
        reducedR_ = r_;
        reducedR_.noalias() -= J_ * total_;
        predicted = before - 0.5 * reducedR_.squaredNorm();
      }
      rule_.adapt(predicted > 0.0 ? fall / predicted : 0.0);
    }
    ownOrder() ? attempt.insist() : attempt.consider();
    return true;
  }

  Rule rule_;
  int nv_;
  Eigen::MatrixXd J_, reducedJ_;
  Eigen::VectorXd r_, reducedR_, gradient_, fixed_, dq_, total_, q_, candidate_;
};

template <typename Rule>
class StepSolver final : public IkSolver {
 public:
  explicit StepSolver(const typename Rule::Parameters& parameters) : parameters_(parameters) {}
  std::string whyUnsupported(const IkProblem&) const override { return {}; }
  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const override {
    return solveWithRestarts(problem, budget, trace, StepIteration<Rule>(problem, parameters_));
  }

 private:
  typename Rule::Parameters parameters_;
};

}  // namespace gelenk
