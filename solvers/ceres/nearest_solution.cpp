#include "solvers/ceres/nearest_solution.h"

#include <ceres/ceres.h>

#include <Eigen/LU>
#include <random>

#include "kinematics/configuration.h"
#include "solvers/ceres/ceres_options.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

/// Residuals phi - phi_old and sqrt(mu) (g / L + lambda / mu): half their squared sum is the augmented
/// Lagrangian up to a constant.
class AugmentedLagrangian final : public ceres::CostFunction {
 public:
  AugmentedLagrangian(const PlanarChain& chain, const VectorXd& phiOld, const Vector2d& X,
                      const Vector2d& lambda, double mu, double size)
      : chain_(chain), phiOld_(phiOld), X_(X), shift_(lambda / mu), root_(std::sqrt(mu)), size_(size) {
    set_num_residuals(chain.linkCount() + 2);
    mutable_parameter_block_sizes()->push_back(chain.linkCount());
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const int n = chain_.linkCount();
    const VectorXd phi = VectorXd::Map(parameters[0], n);
    Eigen::Map<VectorXd> r(residuals, n + 2);
    r.head(n) = phi - phiOld_;
    r.tail(2) = root_ * ((endEffector(chain_, phi) - X_) / size_ + shift_);
    if (jacobians && jacobians[0]) {
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> J(jacobians[0],
                                                                                           n + 2, n);
      J.topRows(n).setIdentity();
      J.bottomRows(2) = root_ / size_ * jacobian(chain_, phi);
    }
    return true;
  }

 private:
  const PlanarChain& chain_;
  VectorXd phiOld_;
  Vector2d X_, shift_;
  double root_, size_;
};

NearestSolution descend(const PlanarChain& chain, const VectorXd& phiOld, const Vector2d& X, VectorXd phi,
                        double size) {
  NearestSolution found;
  Vector2d lambda = Vector2d::Zero();
  constexpr double mu = 1e4;
  for (int outer = 0; outer < 30; ++outer) {
    ceres::Problem problem;
    problem.AddResidualBlock(new AugmentedLagrangian(chain, phiOld, X, lambda, mu, size), nullptr,
                             phi.data());
    ceres::Solver::Summary summary;
    ceres::Solve(smallDenseOptions(200), &problem, &summary);
    found.iterations += static_cast<int>(summary.iterations.size());
    const Vector2d g = (endEffector(chain, phi) - X) / size;
    if (g.norm() < 1e-14) break;
    lambda += mu * g;
  }
  for (int polish = 0; polish < 2; ++polish) {  // onto the constraint to rounding, by the shortest steps
    const Eigen::MatrixXd D = jacobian(chain, phi);
    const Eigen::Matrix2d DDt = D * D.transpose();
    if (std::abs(DDt.determinant()) > 1e-12 * size * size * size * size)
      phi -= D.transpose() * DDt.inverse() * (endEffector(chain, phi) - X);
  }
  found.phi = phi;
  found.distance = (phi - phiOld).norm();
  found.violation = (endEffector(chain, phi) - X).norm();
  return found;
}

}  // namespace

const std::string_view nearestSolutionMethod = "augmented Lagrangian on Ceres";

NearestSolution nearestSolution(const PlanarChain& chain, const VectorXd& phiOld, const Vector2d& X,
                                const VectorXd& hint) {
  const double size = chain.reach();
  std::mt19937_64 random(1);
  std::vector<VectorXd> starts{phiOld, hint};
  for (int i = 0; i < 16; ++i) {
    VectorXd start = i % 2 ? hint : phiOld;
    for (double& angle : start) angle += 2.0 * uniform01(random) - 1.0;
    starts.push_back(start);
  }
  NearestSolution best;
  int iterations = 0;
  for (const VectorXd& start : starts) {
    const NearestSolution found = descend(chain, phiOld, X, start, size);
    iterations += found.iterations;
    const bool holds = found.violation <= 1e-10 * size,
               bestHolds = best.phi.size() > 0 && best.violation <= 1e-10 * size;
    if (best.phi.size() == 0 || (holds && (!bestHolds || found.distance < best.distance)) ||
        (!bestHolds && found.violation < best.violation))
      best = found;
  }
  best.iterations = iterations;
  return best;
}

}  // namespace gelenk
