#include "solvers/methods/step_rules.h"

#include <cmath>

#include "solvers/iteration/normal_equations.h"
#include "solvers/iteration/step_iteration.h"

namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Rules that take every step and remember nothing.
template <typename P>
struct OpenRule {
  using Parameters = P;
  static constexpr bool monotone = false;
  OpenRule(const IkProblem&, const P& parameters) : p(parameters) {}
  double largestStep() const { return p.largestStep; }
  double damping() const { return damping_; }

 protected:
  P p;
  double damping_ = 0.0;
};

struct PseudoInverse : OpenRule<PseudoInverseParameters> {
  using OpenRule::OpenRule;
  void step(CountedEvaluator&, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    svd.factorise(J);
    dq.setZero();
    for (Eigen::Index i = 0; i < svd.sigma().size(); ++i)
      if (svd.sigma()[i] > p.truncation * svd.sigma()[0])
        dq += svd.U().col(i).dot(r) / svd.sigma()[i] * svd.V().col(i);
  }
  SingularSystem svd;
};

struct JacobianTranspose : OpenRule<JacobianTransposeParameters> {
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

struct DampedLeastSquares : OpenRule<DampedLeastSquaresParameters> {
  using OpenRule::OpenRule;
  void step(CountedEvaluator&, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    damping_ = p.lambda;
    system.factorise(J, p.lambda * p.lambda);
    system.solve(J, r, dq);
  }
  DampedSystem system;
};

struct Nakamura : OpenRule<NakamuraParameters> {
  using OpenRule::OpenRule;
  void step(CountedEvaluator&, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    svd.factorise(J);
    double w = J.rows() <= J.cols() ? 1.0 : 0.0;  // more rows than columns: J J^T is singular
    for (Eigen::Index i = 0; i < J.rows() && w > 0.0; ++i) {
      const double length = J.row(i).norm();
      w *= length > 0.0 ? svd.sigma()[i] / length : 0.0;
    }
    const double lambda = w < p.threshold ? p.largestLambda * (1.0 - w / p.threshold) : 0.0;
    damping_ = lambda;
    dq.setZero();
    for (Eigen::Index i = 0; i < svd.sigma().size(); ++i) {
      const double sigma = svd.sigma()[i], bottom = sigma * sigma + lambda * lambda;
      if (bottom > 0.0) dq += svd.U().col(i).dot(r) * sigma / bottom * svd.V().col(i);
    }
  }
  SingularSystem svd;
};

struct Chiaverini : OpenRule<ChiaveriniParameters> {
  using OpenRule::OpenRule;
  void step(CountedEvaluator&, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    svd.factorise(J);
    const VectorXd& sigma = svd.sigma();
    const double epsilon = p.region * sigma[0], largest = p.largestLambda * sigma[0];
    damping_ = 0.0;
    dq.setZero();
    for (Eigen::Index i = 0; i < sigma.size(); ++i) {
      double lambda2 = 0.0;
      if (sigma[i] < epsilon) {
        lambda2 = (1.0 - sigma[i] * sigma[i] / (epsilon * epsilon)) * largest * largest;
        damping_ = std::sqrt(lambda2);
      }
      const double bottom = sigma[i] * sigma[i] + lambda2;
      if (bottom > 0.0) dq += svd.U().col(i).dot(r) * sigma[i] / bottom * svd.V().col(i);
    }
  }
  SingularSystem svd;
};

struct SelectivelyDamped : OpenRule<SelectivelyDampedParameters> {
  double largestStep() const { return p.gammaMax; }
  SelectivelyDamped(const IkProblem& problem, const SelectivelyDampedParameters& parameters)
      : OpenRule(problem, parameters) {
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
      if (length > p.largestError) clamped.segment(block.row, block.rows) *= p.largestError / length;
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
      const double gamma = p.gammaMax * std::min(1.0, N / M);
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

struct LmChan : OpenRule<LmChanParameters> {
  using OpenRule::OpenRule;
  void step(CountedEvaluator& at, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    damping_ = p.lambda * at.cost();
    system.factorise(J, damping_);
    system.solve(J, r, dq);
    if (!dq.allFinite()) {  // E underflows beside the sizes of J at a singular place
      system.factorise(J, 1e-12 * (1.0 + J.squaredNorm()));
      system.solve(J, r, dq);
    }
  }
  DampedSystem system;
};

struct LmSugihara : OpenRule<LmSugiharaParameters> {
  using OpenRule::OpenRule;
  void step(CountedEvaluator& at, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    damping_ = at.cost() + p.bias;
    system.factorise(J, damping_);
    system.solve(J, r, dq);
  }
  DampedSystem system;
};

/// mu by the gain ratio. Nielsen 1999.
template <typename P>
struct GainRatioRule {
  using Parameters = P;
  static constexpr bool monotone = true;
  GainRatioRule(const IkProblem&, const P& parameters) : p(parameters) {}
  double largestStep() const { return p.largestStep; }
  double damping() const { return mu_; }
  void begin() { mu_ = 0.0; }
  void adapt(double gain) {
    if (gain > 0.0) {
      mu_ *= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * gain - 1.0, 3));
      growth_ = p.growth;
    } else {
      mu_ *= growth_;
      growth_ *= 2.0;
    }
  }

 protected:
  void startDamping(const MatrixXd& J) {
    if (mu_ > 0.0) return;
    mu_ = p.tau * std::max(1e-12, J.colwise().squaredNorm().maxCoeff());
    growth_ = p.growth;
  }
  P p;
  double mu_ = 0.0, growth_ = 0.0;
};

template <typename P>
struct MarquardtRule : GainRatioRule<P> {
  using GainRatioRule<P>::GainRatioRule;
  void step(CountedEvaluator&, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    this->startDamping(J);
    double& mu = this->mu_;
    system.factorise(J, mu);
    system.solve(J, r, dq);
    while (!dq.allFinite() && mu < 1e15) {  // mu has fallen below the rounding of a singular J
      mu = 10.0 * std::max(mu, 1e-16 * (1.0 + J.squaredNorm()));
      system.factorise(J, mu);
      system.solve(J, r, dq);
    }
  }
  DampedSystem system;
};
using LmGainRatio = MarquardtRule<LmGainRatioParameters>;

struct Halley : MarquardtRule<HalleyParameters> {
  using MarquardtRule::MarquardtRule;
  void step(CountedEvaluator& at, const LimitSet& limits, const MatrixXd& J, const VectorXd& r,
            const VectorXd& fixed, VectorXd& dq) {
    MarquardtRule::step(at, limits, J, r, fixed, dq);
    const double length = dq.norm();
    if (!(length < p.longest)) return;  // too long for a second order to tell anything
    at.jacobianDerivative(dq, curved);
    curved = J + 0.5 * curved;
    limits.projectColumns(curved);
    system.factorise(curved, mu_);
    system.solve(curved, r, corrected);
    if (corrected.allFinite() && (corrected - dq).norm() < p.guard * length) dq.swap(corrected);
  }
  MatrixXd curved;
  VectorXd corrected;
};

struct Geodesic : MarquardtRule<GeodesicParameters> {
  using MarquardtRule::MarquardtRule;
  void step(CountedEvaluator& at, const LimitSet& limits, const MatrixXd& J, const VectorXd& r,
            const VectorXd& fixed, VectorXd& dq) {
    MarquardtRule::step(at, limits, J, r, fixed, dq);
    at.jacobianDerivative(dq, curved);
    bend.noalias() = curved * dq;
    system.solve(J, bend, second);
    if (second.allFinite() && second.norm() <= p.guard * dq.norm()) dq -= 0.5 * second;
  }
  MatrixXd curved;
  VectorXd bend, second;
};

struct ExactHessian : GainRatioRule<ExactHessianParameters> {
  using GainRatioRule::GainRatioRule;
  void begin() { mu_ = p.startDamping; }
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
    double shift = std::max(mu_, p.slopeShift * slope);
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

std::unique_ptr<IkSolver> makePseudoInverse(const PseudoInverseParameters& parameters) {
  return std::make_unique<StepSolver<PseudoInverse>>(parameters);
}
std::unique_ptr<IkSolver> makeMinimalChangePath() { return makePseudoInverse({.largestStep = 0.02}); }
std::unique_ptr<IkSolver> makeJacobianTranspose(const JacobianTransposeParameters& parameters) {
  return std::make_unique<StepSolver<JacobianTranspose>>(parameters);
}
std::unique_ptr<IkSolver> makeDampedLeastSquares(const DampedLeastSquaresParameters& parameters) {
  return std::make_unique<StepSolver<DampedLeastSquares>>(parameters);
}
std::unique_ptr<IkSolver> makeNakamura(const NakamuraParameters& parameters) {
  return std::make_unique<StepSolver<Nakamura>>(parameters);
}
std::unique_ptr<IkSolver> makeChiaverini(const ChiaveriniParameters& parameters) {
  return std::make_unique<StepSolver<Chiaverini>>(parameters);
}
std::unique_ptr<IkSolver> makeSelectivelyDamped(const SelectivelyDampedParameters& parameters) {
  return std::make_unique<StepSolver<SelectivelyDamped>>(parameters);
}
std::unique_ptr<IkSolver> makeLmChan(const LmChanParameters& parameters) {
  return std::make_unique<StepSolver<LmChan>>(parameters);
}
std::unique_ptr<IkSolver> makeLmSugihara(const LmSugiharaParameters& parameters) {
  return std::make_unique<StepSolver<LmSugihara>>(parameters);
}
std::unique_ptr<IkSolver> makeLmGainRatio(const LmGainRatioParameters& parameters) {
  return std::make_unique<StepSolver<LmGainRatio>>(parameters);
}
std::unique_ptr<IkSolver> makeExactHessian(const ExactHessianParameters& parameters) {
  return std::make_unique<StepSolver<ExactHessian>>(parameters);
}
std::unique_ptr<IkSolver> makeHalley(const HalleyParameters& parameters) {
  return std::make_unique<StepSolver<Halley>>(parameters);
}
std::unique_ptr<IkSolver> makeGeodesic(const GeodesicParameters& parameters) {
  return std::make_unique<StepSolver<Geodesic>>(parameters);
}

}  // namespace gelenk
