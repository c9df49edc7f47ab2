#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

// Newton's method as on the slides (lecture 10.1.4), one step after the other and with everything that a step
// is made of, to be read, printed and drawn. The catalogue's solvers below take the same steps.

/// phi^{i+1} = phi^i - (f(phi^i) - X) / f'(phi^i), f' by the difference quotient.
struct NewtonStep1d {
  double phi;    ///< phi^i
  double g;      ///< f(phi^i) - X
  double slope;  ///< (f(phi^i + Delta) - f(phi^i)) / Delta
};

/// Iterates until |g| <= tolerance, the slope is 0 or something is no longer finite, at most maxSteps steps;
/// the last entry is where it ended. Lecture 10.1.4, one-dimensional Newton method.
std::vector<NewtonStep1d> newton1d(const std::function<double(double)>& f, double start, double X,
                                   double delta = 1e-6, double tolerance = 1e-14, int maxSteps = 50);

/// Order of convergence p from the last three errors that are above `floor`: log(e2 / e1) / log(e1 / e0). 0
/// where there are not three.
double convergenceOrder(const std::vector<double>& errors, double floor = 1e-13);

/// One step of the method in several dimensions; m = rows of D, n = its columns.
struct NewtonStep {
  Eigen::VectorXd phi;  ///< phi^i, n
  Eigen::VectorXd f;    ///< f(phi^i), m
  Eigen::VectorXd g;    ///< f(phi^i) - X, m
  Eigen::MatrixXd D;    ///< Jacobian matrix, m x n
  Eigen::MatrixXd
      Dplus;  ///< n = m: D^-1; n > m: the pseudo-inverse D^T (D D^T)^-1; n x m. Empty when singular
  Eigen::VectorXd singularValues;  ///< of D, descending
  Eigen::VectorXd step;  ///< phi^{i+1} - phi^i = -D^+ g, n. Empty in the last entry and when singular
  Eigen::VectorXd
      linearised;  ///< h(phi^{i+1}) = f + D step: where the linear function says the step leads, m
};

enum class NewtonStop { Converged, Singular, Budget, NotFinite };
struct NewtonRun {
  std::vector<NewtonStep> steps;  ///< the last one has no step
  NewtonStop why = NewtonStop::Budget;
  int iterations() const { return static_cast<int>(steps.size()) - 1; }
};

using VectorFunction = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;
using MatrixFunction = std::function<Eigen::MatrixXd(const Eigen::VectorXd&)>;

/// D^T (D D^T)^-1 for full row rank (lecture 10.1.4, n > m); for a square D its inverse. Empty where the
/// smallest singular value is below 1e-14 of the largest.
Eigen::MatrixXd pseudoInverse(const Eigen::MatrixXd& D);

/// The method with a full step each time: no damping, no truncation. Ends when |g| <= tolerance.
/// Lecture 10.1.4, n = m and n > m.
NewtonRun newton(const VectorFunction& f, const MatrixFunction& D, const Eigen::VectorXd& start,
                 const Eigen::VectorXd& X, double tolerance = 1e-12, int maxSteps = 50);

/// D by difference quotients, column by column. Lecture 10.1.4, derivative.
Eigen::MatrixXd differenceQuotient(const VectorFunction& f, const Eigen::VectorXd& phi, double delta = 1e-7);

struct Newton1dParameters {
  double delta = 1e-6;

  static constexpr auto fields() {
    using P = Newton1dParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::delta, "delta", 1e-12, 1.0, "rad, m", "ours", "Delta of the difference quotient."}});
  }
};
/// Skeletons of one degree of freedom: the zero of the derivative of half the squared residual, by 1-D Newton
/// with the difference quotient; it ends in the nearest pose where the target cannot be reached.
/// Lecture 10.1.4.
std::unique_ptr<IkSolver> makeNewton1d(const Newton1dParameters& parameters = {});

/// dq = D^+ r with the full step, D analytic; rows that no joint can change are left out. n = m: LU. n > m:
/// D^T (D D^T)^-1. n < m: not of full row rank, not on the slides, unsupported. Lecture 10.1.4.
std::unique_ptr<IkSolver> makeNewton();

struct NewtonDifferenceQuotientParameters {
  double delta = 1e-7;

  static constexpr auto fields() {
    using P = NewtonDifferenceQuotientParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::delta, "delta", 1e-12, 1.0, "rad, m", "ours", "Delta of the difference quotients."}});
  }
};
/// The same with D by difference quotients along the tangent axes.
std::unique_ptr<IkSolver> makeNewtonDifferenceQuotient(
    const NewtonDifferenceQuotientParameters& parameters = {});

}  // namespace gelenk
