#include "solvers/methods/quasi_newton.h"

#include <algorithm>
#include <vector>

#include "solvers/iteration/attempt.h"

namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// B, the inverse Hessian as learned so far, in full.
class DenseInverse {
 public:
  using Parameters = BfgsParameters;
  DenseInverse(int nv, const Parameters&) : B_(nv, nv), By_(nv) {}
  void reset() { fresh_ = true; }
  bool fresh() const { return fresh_; }
  void apply(const VectorXd& g, VectorXd& d) { d.noalias() = B_ * g; }
  void update(const VectorXd& s, const VectorXd& y, double sy) {
    if (fresh_) B_.setIdentity() *= sy / y.squaredNorm();
    fresh_ = false;
    By_.noalias() = B_ * y;
    const double yBy = y.dot(By_);
    B_.noalias() += (sy + yBy) / (sy * sy) * s * s.transpose();
    B_.noalias() -= 1.0 / sy * (By_ * s.transpose() + s * By_.transpose());
  }

 private:
  MatrixXd B_;
  VectorXd By_;
  bool fresh_ = true;
};

/// The same product from the last pairs (s, y).
class LimitedInverse {
 public:
  using Parameters = LbfgsParameters;
  LimitedInverse(int nv, const Parameters& parameters)
      : memory_(parameters.memory), pairs_(memory_, {VectorXd(nv), VectorXd(nv), 0.0}), alpha_(memory_) {}
  void reset() { count_ = 0; }
  bool fresh() const { return count_ == 0; }
  void apply(const VectorXd& g, VectorXd& d) {
    d = g;
    const int kept = std::min(count_, memory_);
    for (int i = 0; i < kept; ++i) {
      const Pair& p = newest(i);
      alpha_[i] = p.s.dot(d) / p.sy;
      d -= alpha_[i] * p.y;
    }
    d *= newest(0).sy / newest(0).y.squaredNorm();
    for (int i = kept - 1; i >= 0; --i) {
      const Pair& p = newest(i);
      d += (alpha_[i] - p.y.dot(d) / p.sy) * p.s;
    }
  }
  void update(const VectorXd& s, const VectorXd& y, double sy) {
    Pair& p = pairs_[count_++ % memory_];
    p.s = s;
    p.y = y;
    p.sy = sy;
  }

 private:
  struct Pair {
    VectorXd s, y;
    double sy = 0.0;
  };
  const Pair& newest(int back) const { return pairs_[(count_ - 1 - back) % memory_]; }
  int memory_;
  std::vector<Pair> pairs_;
  std::vector<double> alpha_;
  int count_ = 0;
};

template <typename Inverse>
class QuasiNewton {
 public:
  QuasiNewton(const IkProblem& problem, const typename Inverse::Parameters& parameters)
      : inverse_(problem.skeleton->nv(), parameters), p_(parameters) {}

  void operator()(Attempt& attempt) {
    CountedEvaluator& at = attempt.at;
    inverse_.reset();
    bool havePair = false;
    while (!attempt.isOver()) {
      const Attempt::Rest rest = attempt.rest();
      if (rest == Attempt::Rest::Over) return;
      if (rest == Attempt::Rest::Left) {
        inverse_.reset();
        havePair = false;
      }
      g_.noalias() = at.jacobian().transpose() * at.residual();  // points downhill
      if (havePair) learn();
      q_ = at.q();
      lastG_ = g_;
      findDirection(attempt);
      havePair = search(attempt);
      if (havePair) continue;
      if (inverse_.fresh()) return attempt.stop(Stop::Stalled);  // steepest descent failed as well
      inverse_.reset();
    }
  }

 private:
  void learn() {
    y_ = lastG_ - g_;  // difference of the cost's gradients, which are -g
    const double sy = s_.dot(y_);
    if (sy > 1e-12 * s_.norm() * y_.norm() && y_.squaredNorm() > 0.0) inverse_.update(s_, y_, sy);
  }

  void findDirection(Attempt& attempt) {
    const VectorXd& projected = attempt.projectedGradient();
    if (!inverse_.fresh()) {
      inverse_.apply(projected, d_);
      attempt.limits.project(d_);
      if (d_.allFinite() && d_.dot(projected) > 1e-10 * d_.norm() * projected.norm()) return;
      inverse_.reset();
    }
    moved_.noalias() =
        attempt.at.jacobian() * projected;  // steepest descent with the best length of the linear model
    const double bottom = moved_.squaredNorm();
    d_ = projected * (bottom > 0.0 ? attempt.at.residual().dot(moved_) / bottom : 1.0);
  }

  /// Leaves `at` at a better place and true, or where it was and false.
  bool search(Attempt& attempt) {
    const double largest = d_.template lpNorm<Eigen::Infinity>();
    if (!std::isfinite(largest)) return false;
    if (largest > p_.largestStep) d_ *= p_.largestStep / largest;
    CountedEvaluator& at = attempt.at;
    const double before = at.cost(), slope = d_.dot(attempt.projectedGradient());
    attempt.countIteration(d_.norm(), 0.0);
    double t = 1.0;
    for (int tries = 0; tries < 40; ++tries) {
      s_ = t * d_;
      attempt.limits.retract(q_, s_, candidate_);
      at.moveTo(candidate_);
      const double fall = before - at.cost();
      if (fall >= p_.armijo * t * slope && fall > 0.0) {
        difference(at.skeleton(), q_, candidate_, s_);  // what the projection left of it
        attempt.consider();
        return true;
      }
      // minimum of the parabola through the three facts, kept within [0.1, 0.5] of the last length
      const double parabola = slope * t * t / (2.0 * (slope * t - fall));
      t = std::isfinite(parabola) ? std::clamp(parabola, 0.1 * t, 0.5 * t) : 0.5 * t;
    }
    at.moveTo(q_);
    return false;
  }

  Inverse inverse_;
  typename Inverse::Parameters p_;
  VectorXd q_, candidate_, g_, lastG_, d_, s_, y_, moved_;
};

template <typename Inverse>
class QuasiNewtonSolver final : public IkSolver {
 public:
  explicit QuasiNewtonSolver(const typename Inverse::Parameters& parameters) : parameters_(parameters) {}
  std::string whyUnsupported(const IkProblem&) const override { return {}; }
  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const override {
    return solveWithRestarts(problem, budget, trace, QuasiNewton<Inverse>(problem, parameters_));
  }

 private:
  typename Inverse::Parameters parameters_;
};

}  // namespace

std::unique_ptr<IkSolver> makeBfgs(const BfgsParameters& parameters) {
  return std::make_unique<QuasiNewtonSolver<DenseInverse>>(parameters);
}
std::unique_ptr<IkSolver> makeLbfgs(const LbfgsParameters& parameters) {
  return std::make_unique<QuasiNewtonSolver<LimitedInverse>>(parameters);
}

}  // namespace gelenk
