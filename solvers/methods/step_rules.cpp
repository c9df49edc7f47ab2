#include "solvers/methods/step_rules.h"

#include <cmath>

#include "solvers/iteration/normal_equations.h"
#include "solvers/iteration/step_iteration.h"

namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Rules that take every step and remember nothing.
struct OpenRule {
  static constexpr double largestStep = 0.5;  // a linearisation holds no farther
  static constexpr bool monotone = false;
  explicit OpenRule(const IkProblem&) {}
  double damping() const { return damping_; }

 protected:
  double damping_ = 0.0;
};

struct PseudoInverse : OpenRule {
  static constexpr double truncation = 0.01;
  using OpenRule::OpenRule;
  void step(CountedEvaluator&, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    svd.factorise(J);
    dq.setZero();
    for (Eigen::Index i = 0; i < svd.sigma().size(); ++i)
      if (svd.sigma()[i] > truncation * svd.sigma()[0])
        dq += svd.U().col(i).dot(r) / svd.sigma()[i] * svd.V().col(i);
  }
  SingularSystem svd;
};

struct MinimalChangePath : PseudoInverse {
  static constexpr double largestStep = 0.02;
  using PseudoInverse::PseudoInverse;
};

struct JacobianTranspose : OpenRule {
  using OpenRule::OpenRule;
  void step(CountedEvaluator&, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    dq.noalias() = J.transpose() * r;
    moved.noalias() = J * dq;
    const double length = moved.squaredNorm();
    dq *= length > 0.0 ? r.dot(moved) / length : 0.0;
  }
  VectorXd moved;
};

struct DampedLeastSquares : OpenRule {
  static constexpr double lambda = 0.05;
  using OpenRule::OpenRule;
  void step(CountedEvaluator&, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    damping_ = lambda;
    system.factorise(J, lambda * lambda);
    system.solve(J, r, dq);
  }
  DampedSystem system;
};

struct Nakamura : OpenRule {
  static constexpr double largestLambda = 0.1, threshold = 0.02;
  using OpenRule::OpenRule;
  void step(CountedEvaluator&, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    svd.factorise(J);
    double w = J.rows() <= J.cols() ? 1.0 : 0.0;  // more rows than columns: J J^T is singular
    for (Eigen::Index i = 0; i < J.rows() && w > 0.0; ++i) {
      const double length = J.row(i).norm();
      w *= length > 0.0 ? svd.sigma()[i] / length : 0.0;
    }
    const double lambda = w < threshold ? largestLambda * (1.0 - w / threshold) : 0.0;
    damping_ = lambda;
    dq.setZero();
    for (Eigen::Index i = 0; i < svd.sigma().size(); ++i) {
      const double sigma = svd.sigma()[i], bottom = sigma * sigma + lambda * lambda;
      if (bottom > 0.0) dq += svd.U().col(i).dot(r) * sigma / bottom * svd.V().col(i);
    }
  }
  SingularSystem svd;
};

struct Chiaverini : OpenRule {
  static constexpr double region = 0.04;
  using OpenRule::OpenRule;
  void step(CountedEvaluator&, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    svd.factorise(J);
    const VectorXd& sigma = svd.sigma();
    const double epsilon = region * sigma[0];
    damping_ = 0.0;
    dq.setZero();
    for (Eigen::Index i = 0; i < sigma.size(); ++i) {
      double lambda2 = 0.0;
      if (sigma[i] < epsilon) {
        lambda2 = (1.0 - sigma[i] * sigma[i] / (epsilon * epsilon)) * epsilon * epsilon;
        damping_ = std::sqrt(lambda2);
      }
      const double bottom = sigma[i] * sigma[i] + lambda2;
      if (bottom > 0.0) dq += svd.U().col(i).dot(r) * sigma[i] / bottom * svd.V().col(i);
    }
  }
  SingularSystem svd;
};

struct SelectivelyDamped : OpenRule {
  static constexpr double largestStep = M_PI / 4.0;
  static constexpr double largestError = 0.7;
  explicit SelectivelyDamped(const IkProblem& problem) : OpenRule(problem) {
    int row = 0;
    for (const Goal& goal : problem.goals) {
      const int end = row + residualRows(goal, *problem.skeleton);
      for (; row < end; row += 3) blocks.push_back({row, std::min(3, end - row)});
      row = end;
    }
  }
  void step(CountedEvaluator&, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    clamped = r;
    for (const Block& block : blocks) {
      const double length = clamped.segment(block.row, block.rows).norm();
      if (length > largestError) clamped.segment(block.row, block.rows) *= largestError / length;
    }
    svd.factorise(J);
    dq.setZero();
    for (Eigen::Index i = 0; i < svd.sigma().size(); ++i) {
      if (!(svd.sigma()[i] > 1e-7 * svd.sigma()[0])) continue;
      double N = 0.0, M = 0.0;
      for (const Block& block : blocks) {
        N += svd.U().col(i).segment(block.row, block.rows).norm();
        for (Eigen::Index k = 0; k < J.cols(); ++k)
          M += std::abs(svd.V()(k, i)) * J.col(k).segment(block.row, block.rows).norm();
      }
      M /= svd.sigma()[i];
      const double gamma = largestStep * std::min(1.0, N / M);
      contribution = svd.U().col(i).dot(clamped) / svd.sigma()[i] * svd.V().col(i);
      const double largest = contribution.lpNorm<Eigen::Infinity>();
      dq += (largest > gamma ? gamma / largest : 1.0) * contribution;
    }
  }
  struct Block {
    int row, rows;
  };
  std::vector<Block> blocks;
  SingularSystem svd;
  VectorXd clamped, contribution;
};

struct LmChan : OpenRule {
  static constexpr double lambda = 0.1;
  static constexpr double largestStep = 1.0;
  using OpenRule::OpenRule;
  void step(CountedEvaluator& at, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    damping_ = lambda * at.cost();
    system.factorise(J, damping_);
    system.solve(J, r, dq);
    if (!dq.allFinite()) {  // E underflows beside the sizes of J at a singular place
      system.factorise(J, 1e-12 * (1.0 + J.squaredNorm()));
      system.solve(J, r, dq);
    }
  }
  DampedSystem system;
};

struct LmSugihara : OpenRule {
  static constexpr double base = 1e-3;
  static constexpr double largestStep = 1.0;
  using OpenRule::OpenRule;
  void step(CountedEvaluator& at, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    damping_ = at.cost() + base;
    system.factorise(J, damping_);
    system.solve(J, r, dq);
  }
  DampedSystem system;
};

/// mu by the gain ratio. Nielsen 1999.
struct GainRatioRule {
  static constexpr double largestStep = 1.5;
  static constexpr bool monotone = true;
  explicit GainRatioRule(const IkProblem&) {}
  double damping() const { return mu_; }
  void begin() { mu_ = 0.0; }
  void adapt(double gain) {
    if (gain > 0.0) {
      mu_ *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain - 1.0, 3));
      growth_ = 2.0;
    } else {
      mu_ *= growth_;
      growth_ *= 2.0;
    }
  }

 protected:
  void startDamping(const MatrixXd& J) {
    if (mu_ > 0.0) return;
    mu_ = 1e-3 * std::max(1e-12, J.colwise().squaredNorm().maxCoeff());
    growth_ = 2.0;
  }
  double mu_ = 0.0, growth_ = 2.0;
};

struct LmGainRatio : GainRatioRule {
  using GainRatioRule::GainRatioRule;
  void step(CountedEvaluator&, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    startDamping(J);
    system.factorise(J, mu_);
    system.solve(J, r, dq);
    while (!dq.allFinite() && mu_ < 1e15) {  // mu has fallen below the rounding of a singular J
      mu_ = 10.0 * std::max(mu_, 1e-16 * (1.0 + J.squaredNorm()));
      system.factorise(J, mu_);
      system.solve(J, r, dq);
    }
  }
  DampedSystem system;
};

struct Halley : LmGainRatio {
  using LmGainRatio::LmGainRatio;
  void step(CountedEvaluator& at, const LimitSet& limits, const MatrixXd& J, const VectorXd& r,
            const VectorXd& fixed, VectorXd& dq) {
    LmGainRatio::step(at, limits, J, r, fixed, dq);
    const double length = dq.norm();
    if (!(length < 1.0)) return;  // too long for a second order to tell anything
    at.jacobianDerivative(dq, curved);
    curved = J + 0.5 * curved;
    limits.projectColumns(curved);
    system.factorise(curved, mu_);
    system.solve(curved, r, corrected);
    if (corrected.allFinite() && (corrected - dq).norm() < 0.5 * length) dq.swap(corrected);
  }
  MatrixXd curved;
  VectorXd corrected;
};

struct Geodesic : LmGainRatio {
  using LmGainRatio::LmGainRatio;
  void step(CountedEvaluator& at, const LimitSet& limits, const MatrixXd& J, const VectorXd& r,
            const VectorXd& fixed, VectorXd& dq) {
    LmGainRatio::step(at, limits, J, r, fixed, dq);
    at.jacobianDerivative(dq, curved);
    bend.noalias() = curved * dq;
    system.solve(J, bend, second);
    if (second.allFinite() && second.norm() <= 0.75 * dq.norm()) dq -= 0.5 * second;
  }
  MatrixXd curved;
  VectorXd bend, second;
};

struct ExactHessian : GainRatioRule {
  using GainRatioRule::GainRatioRule;
  void begin() { mu_ = 1e-6; }
  void step(CountedEvaluator& at, const LimitSet& limits, const MatrixXd& J, const VectorXd&,
            const VectorXd& fixed, VectorXd& dq) {
    H = at.hessian();
    gradient.noalias() = J.transpose() * at.residual();
    const double slope = gradient.norm();
    full.noalias() = at.jacobian().transpose() * at.residual();
    gradient = full;
    gradient.noalias() -= H * fixed;
    limits.project(gradient);
    shifted = H;
    limits.projectBothSides(shifted);
    double shift = std::max(mu_, 1e-3 * slope);
    for (int tries = 0; tries < 60; ++tries, shift *= 4.0) {
      A = shifted;
      A.diagonal().array() += shift;
      llt.compute(A);
      if (llt.info() == Eigen::Success) break;
    }
    used_ = shift;
    dq = gradient;
    llt.solveInPlace(dq);
  }
  double predicted(const VectorXd& dq) {
    Hd.noalias() = H * dq;
    return full.dot(dq) - 0.5 * dq.dot(Hd);
  }
  void adapt(double gain) {
    if (gain > 0.0) {
      mu_ = gain > 0.75 ? mu_ / 5.0 : gain < 0.25 ? std::max(mu_, used_) * 2.0 : mu_;
      mu_ = std::max(mu_, 1e-12);
    } else {
      mu_ = 4.0 * std::max(mu_, used_);
    }
  }
  double damping() const { return mu_; }
  double used_ = 0.0;
  MatrixXd H, shifted, A;
  VectorXd gradient, full, Hd;
  Eigen::LLT<MatrixXd> llt;
};

}  // namespace

std::unique_ptr<IkSolver> makePseudoInverse() { return std::make_unique<StepSolver<PseudoInverse>>(); }
std::unique_ptr<IkSolver> makeMinimalChangePath() {
  return std::make_unique<StepSolver<MinimalChangePath>>();
}
std::unique_ptr<IkSolver> makeJacobianTranspose() {
  return std::make_unique<StepSolver<JacobianTranspose>>();
}
std::unique_ptr<IkSolver> makeDampedLeastSquares() {
  return std::make_unique<StepSolver<DampedLeastSquares>>();
}
std::unique_ptr<IkSolver> makeNakamura() { return std::make_unique<StepSolver<Nakamura>>(); }
std::unique_ptr<IkSolver> makeChiaverini() { return std::make_unique<StepSolver<Chiaverini>>(); }
std::unique_ptr<IkSolver> makeSelectivelyDamped() {
  return std::make_unique<StepSolver<SelectivelyDamped>>();
}
std::unique_ptr<IkSolver> makeLmChan() { return std::make_unique<StepSolver<LmChan>>(); }
std::unique_ptr<IkSolver> makeLmSugihara() { return std::make_unique<StepSolver<LmSugihara>>(); }
std::unique_ptr<IkSolver> makeLmGainRatio() { return std::make_unique<StepSolver<LmGainRatio>>(); }
std::unique_ptr<IkSolver> makeExactHessian() { return std::make_unique<StepSolver<ExactHessian>>(); }
std::unique_ptr<IkSolver> makeHalley() { return std::make_unique<StepSolver<Halley>>(); }
std::unique_ptr<IkSolver> makeGeodesic() { return std::make_unique<StepSolver<Geodesic>>(); }

}  // namespace gelenk
