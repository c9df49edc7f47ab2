#include "solvers/step_rules.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>

#include "kinematics/configuration.h"
#include "solvers/evaluator.h"

namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct PseudoInverse {
  static constexpr double truncation = 0.01;
  static VectorXd step(const MatrixXd& J, const VectorXd& r) {
    const Eigen::JacobiSVD<MatrixXd> svd(J, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const VectorXd& sigma = svd.singularValues();
    VectorXd scaled = svd.matrixU().transpose() * r;
    for (Eigen::Index i = 0; i < sigma.size(); ++i)
      scaled[i] = sigma[i] > truncation * sigma[0] ? scaled[i] / sigma[i] : 0.0;
    return svd.matrixV() * scaled;
  }
};

struct JacobianTranspose {
  static VectorXd step(const MatrixXd& J, const VectorXd& r) {
    const VectorXd gradient = J.transpose() * r;
    const VectorXd moved = J * gradient;
    const double length = moved.squaredNorm();
    return length > 0.0 ? VectorXd(r.dot(moved) / length * gradient) : VectorXd(VectorXd::Zero(J.cols()));
  }
};

struct DampedLeastSquares {
  static constexpr double lambda = 0.05;
  static VectorXd step(const MatrixXd& J, const VectorXd& r) {
    MatrixXd A = J * J.transpose();
    A.diagonal().array() += lambda * lambda;
    return J.transpose() * A.llt().solve(r);
  }
};

template <typename Rule>
class StepSolver final : public IkSolver {
 public:
  std::string whyUnsupported(const IkProblem&) const override { return {}; }

  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const override {
    constexpr double largestStep = 0.5;  // radians or metres a coordinate: a linearisation holds no farther
    CountedEvaluator at(problem);
    IkReport report;
    at.moveTo(projectToLimits(*problem.skeleton, problem.start));
    VectorXd best = at.q();
    double bestResidual = at.residual().norm();
    for (int& i = at.counters().iterations; i < budget.maxIterations; ++i) {
      if (at.withinTolerance()) {
        report.why = Stop::Converged;
        break;
      }
      if (at.seconds() > budget.maxSeconds) break;
      VectorXd dq = Rule::step(at.jacobian(), at.residual());
      ++at.counters().factorisations;
      const double largest = dq.lpNorm<Eigen::Infinity>();
      if (!std::isfinite(largest)) {
        report.why = Stop::Failure;
        break;
      }
      if (largest > largestStep) dq *= largestStep / largest;
      if (trace != TraceLevel::Off)
        report.trace.push_back({.q = trace == TraceLevel::Full ? at.q() : VectorXd(),
                                .residual = at.residual().norm(),
                                .stepNorm = dq.norm(),
                                .damping = 0.0,
                                .seconds = at.seconds()});
      if (dq.norm() < 1e-12) {
        report.why = Stop::Stationary;
        break;
      }
      at.moveTo(projectToLimits(*problem.skeleton, integrate(*problem.skeleton, at.q(), dq)));
      if (at.residual().norm() < bestResidual) {
        bestResidual = at.residual().norm();
        best = at.q();
      }
    }
    if (report.why == Stop::Failure && at.counters().iterations >= budget.maxIterations) report.why = Stop::Budget;
    if (report.why == Stop::Converged) best = at.q();
    report.q = best;
    report.residual = bestResidual;
    report.counters = at.counters();
    report.seconds = at.seconds();
    return report;
  }
};

}  // namespace

std::unique_ptr<IkSolver> makePseudoInverse() { return std::make_unique<StepSolver<PseudoInverse>>(); }
std::unique_ptr<IkSolver> makeJacobianTranspose() { return std::make_unique<StepSolver<JacobianTranspose>>(); }
std::unique_ptr<IkSolver> makeDampedLeastSquares() { return std::make_unique<StepSolver<DampedLeastSquares>>(); }

}  // namespace gelenk
