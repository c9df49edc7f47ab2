#pragma once

#include <Eigen/Cholesky>
#include <memory>
#include <vector>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

/// Strictly convex quadratic program: minimise 1/2 x^T H x - g^T x subject to C x <= b with b >= 0, so that x
/// = 0 is feasible. Primal active-set method with the Schur complement of the working set (Nocedal, Wright
/// 2006, ch. 16). Ends after finitely many changes of the working set; after 10 (n + k) of them the feasible
/// point reached is returned. H: n x n positive definite, C: k x n, normals in rows. Keeps its storage.
class ConvexQp {
 public:
  /// False if H is not positive definite; x is then 0.
  bool solve(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, const Eigen::MatrixXd& C,
             const Eigen::VectorXd& b, Eigen::VectorXd& x);
  /// Lagrange multipliers of the last solve, k, all >= 0 at the optimum: H x - g + C^T y = 0.
  const Eigen::VectorXd& multipliers() const { return y_; }
  bool optimal() const { return optimal_; }

 private:
  Eigen::LLT<Eigen::MatrixXd> H_;
  Eigen::LDLT<Eigen::MatrixXd> schur_;
  Eigen::MatrixXd W_, S_;  ///< W = H^-1 C_W^T
  Eigen::VectorXd y_, free_, direction_, rhs_;
  std::vector<int> working_;
  std::vector<char> isWorking_;
  bool optimal_ = false;
};

struct QpDifferentialParameters {
  double damping = 1e-3, base = 1e-9, largestStep = 0.5;

  static constexpr auto fields() {
    using P = QpDifferentialParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::damping, "damping", 0.0, 1e3, "1", "ours; form: Sugihara 2011",
          "Share of the squared residual in the damping mu."},
         {&P::base, "base", 1e-15, 1.0, "m^2", "ours", "Damping that is left where the residual vanishes."},
         {&P::largestStep, "largest-step", 1e-3, 6.3, "rad, m", "ours",
          "Bound on every coordinate of a step, a constraint of the program."}});
  }
};
/// Differential IK as a quadratic program: minimise |J dq - r|^2 + mu |dq|^2 within the linearised limits and
/// |dq_k| <= largest-step, with mu = damping |r|^2 + base. The limits bound the step itself instead of
/// correcting it. Escande, Mansard, Wieber 2014; the damping after Sugihara 2011.
std::unique_ptr<IkSolver> makeQpDifferential(const QpDifferentialParameters& parameters = {});

}  // namespace gelenk
