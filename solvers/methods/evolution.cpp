#include "solvers/methods/evolution.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "solvers/iteration/attempt.h"
#include "solvers/iteration/normal_equations.h"

namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

class Evolution {
 public:
  Evolution(const IkProblem& problem, const EvolutionParameters& parameters)
      : p_(parameters), nv_(problem.skeleton->nv()), people_(parameters.population) {
    for (Individual& one : people_) one = {VectorXd(problem.skeleton->nq()), VectorXd::Zero(nv_)};
  }

  void operator()(Attempt& attempt) {
    populate(attempt, true);
    double reference = people_[0].cost;
    int patient = 0;
    while (!attempt.isOver()) {
      attempt.countIteration(0.0, 0.0);
      for (int i = 0; i < p_.elite; ++i)
        if (polish(attempt, people_[i])) return;
      for (int i = p_.parents; i < p_.population; ++i) breed(attempt, people_[i]);
      sort();
      if (people_[0].cost < 0.99 * reference) {
        reference = people_[0].cost;
        patient = 0;
      } else if (++patient >= p_.patience) {
        populate(attempt, false);
        reference = people_[0].cost;
        patient = 0;
      }
      attempt.at.moveTo(people_[0].q);
    }
  }

 private:
  struct Individual {
    VectorXd q, momentum;
    double cost = 0.0;
  };

  void sort() {
    std::sort(people_.begin(), people_.end(),
              [](const Individual& a, const Individual& b) { return a.cost < b.cost; });
  }

  void evaluate(Attempt& attempt, Individual& one) {
    attempt.at.moveTo(one.q);
    one.cost = attempt.at.cost();
    attempt.consider();
  }

  void populate(Attempt& attempt, bool keepStart) {
    people_[0].q = attempt.at.q();
    for (int i = 0; i < p_.population; ++i) {
      if (i > 0 || !keepStart) people_[i].q = attempt.randomStart();
      people_[i].momentum.setZero();
      evaluate(attempt, people_[i]);
    }
    sort();
    attempt.at.moveTo(people_[0].q);
  }

  /// Sum of twelve uniform numbers less six: bell-shaped, variance 1, the same on every platform.
  static double bell(std::mt19937_64& random) {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += uniform01(random);
    return sum;
  }

  void breed(Attempt& attempt, Individual& child) {
    std::mt19937_64& random = attempt.random();
    const Individual& a = people_[random() % p_.parents];
    const Individual& b = people_[random() % p_.parents];
    difference(attempt.at.skeleton(), a.q, b.q, between_);
    const double width = p_.mutation * between_.norm() / std::sqrt(static_cast<double>(nv_)) + 1e-4;
    for (int k = 0; k < nv_; ++k) {
      const double mix = uniform01(random);
      move_[k] = mix * between_[k] + 0.5 * uniform01(random) * a.momentum[k];
      if (uniform01(random) < 2.0 / nv_) move_[k] += width * bell(random);
    }
    attempt.movingJoints().silence(move_);
    child.momentum = 0.3 * move_;
    attempt.limits.retract(a.q, move_, child.q);
    evaluate(attempt, child);
  }

  /// True if the attempt is over.
  bool polish(Attempt& attempt, Individual& one) {
    CountedEvaluator& at = attempt.at;
    at.moveTo(one.q);
    double mu = 1e-3 * at.cost() + 1e-12;
    for (int i = 0; i < p_.polish; ++i) {
      if (at.withinTolerance()) return attempt.isOver();
      attempt.limits.moveTo(one.q);
      J_ = at.jacobian();
      r_ = at.residual();
      step_.noalias() = J_.transpose() * r_;
      attempt.limits.lockBlocked(step_);
      attempt.limits.projectColumns(J_);
      system_.factorise(J_, mu);
      system_.solve(J_, r_, step_);
      ++at.counters().factorisations;
      if (!step_.allFinite()) return false;
      const double largest = step_.lpNorm<Eigen::Infinity>();
      if (largest > 0.5) step_ *= 0.5 / largest;
      attempt.limits.retract(one.q, step_, candidate_);
      at.moveTo(candidate_);
      if (at.cost() < one.cost) {
        one.q.swap(candidate_);
        one.momentum = 0.3 * step_;
        one.cost = at.cost();
        attempt.consider();
        mu = 1e-3 * one.cost + 1e-12;
      } else {
        at.moveTo(one.q);
        mu = 10.0 * mu + 1e-6;
      }
    }
    return at.withinTolerance() && attempt.isOver();
  }

  EvolutionParameters p_;
  int nv_;
  std::vector<Individual> people_;
  VectorXd between_ = VectorXd(nv_), move_ = VectorXd(nv_), step_ = VectorXd(nv_), r_, candidate_;
  MatrixXd J_;
  DampedSystem system_;
};

class EvolutionSolver final : public IkSolver {
 public:
  explicit EvolutionSolver(const EvolutionParameters& parameters) : parameters_(parameters) {}
  std::string whyUnsupported(const IkProblem&) const override { return {}; }
  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const override {
    return solveWithRestarts(problem, budget, trace, Evolution(problem, parameters_));
  }

 private:
  EvolutionParameters parameters_;
};

}  // namespace

std::unique_ptr<IkSolver> makeEvolution(const EvolutionParameters& p) {
  if (p.parents > p.population)
    throw std::invalid_argument("evolution.parents must not exceed evolution.population, " +
                                std::to_string(p.population) + ", but is " + std::to_string(p.parents));
  if (p.elite > p.parents)
    throw std::invalid_argument("evolution.elite must not exceed evolution.parents, " +
                                std::to_string(p.parents) + ", but is " + std::to_string(p.elite));
  return std::make_unique<EvolutionSolver>(p);
}

}  // namespace gelenk
