#include "solvers/methods/qp.h"

#include <cmath>

#include "solvers/iteration/step_iteration.h"

namespace gelenk {

using Eigen::MatrixXd;
using Eigen::VectorXd;

bool ConvexQp::solve(const MatrixXd& H, const VectorXd& g, const MatrixXd& C, const VectorXd& b,
                     VectorXd& x) {
  const int n = static_cast<int>(H.rows()), k = static_cast<int>(C.rows());
  x.setZero(n);
  y_.setZero(k);
  optimal_ = false;
  H_.compute(H);
  if (H_.info() != Eigen::Success) return false;
  free_ = g;
  H_.solveInPlace(free_);  // the minimum without constraints
  working_.clear();
  isWorking_.assign(k, 0);
  W_.resize(n, n);
  S_.resize(n, n);
  for (int change = 0; change < 10 * (n + k); ++change) {
    // Minimum on the working set: x* = free - H^-1 C_W^T y with C_W x* = b_W.
    const int active = static_cast<int>(working_.size());
    rhs_.resize(active);
    for (int i = 0; i < active; ++i) {
      const int row = working_[i];
      W_.col(i) = C.row(row).transpose();
      H_.matrixL().solveInPlace(W_.col(i));
      rhs_[i] = C.row(row).dot(free_) - b[row];
    }
    if (active > 0) {
      S_.topLeftCorner(active, active).noalias() = W_.leftCols(active).transpose() * W_.leftCols(active);
      schur_.compute(S_.topLeftCorner(active, active));
      rhs_ = schur_.solve(rhs_).eval();
    }
    direction_ = free_ - x;
    for (int i = 0; i < active; ++i) {
      VectorXd column = W_.col(i);
      H_.matrixU().solveInPlace(column);
      direction_ -= rhs_[i] * column;
    }
    if (!direction_.allFinite()) return true;
    double length = 1.0;
    int blocking = -1;
    for (int row = 0; row < k; ++row) {
      if (isWorking_[row]) continue;
      const double speed = C.row(row).dot(direction_);
      if (speed <= 1e-14) continue;
      const double room = std::max(0.0, b[row] - C.row(row).dot(x));
      if (room < length * speed) {
        length = room / speed;
        blocking = row;
      }
    }
    x += length * direction_;
    if (blocking >= 0 && active < n) {
      working_.push_back(blocking);
      isWorking_[blocking] = 1;
      continue;
    }
    int worst = -1;
    for (int i = 0; i < active; ++i)
      if (rhs_[i] < -1e-13 && (worst < 0 || rhs_[i] < rhs_[worst])) worst = i;
    if (worst < 0) {
      for (int i = 0; i < active; ++i) y_[working_[i]] = rhs_[i];
      optimal_ = true;
      return true;
    }
    isWorking_[working_[worst]] = 0;
    working_.erase(working_.begin() + worst);
  }
  return true;
}

namespace {

struct QpDifferential {
  using Parameters = QpDifferentialParameters;
  static constexpr bool monotone = false;
  static constexpr bool ownLimits = true;
  QpDifferential(const IkProblem&, const Parameters& parameters) : p(parameters) {}
  double largestStep() const { return p.largestStep; }
  double damping() const { return damping_; }

  void step(CountedEvaluator&, const LimitSet& limits, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    const int n = static_cast<int>(J.cols());
    damping_ = p.damping * r.squaredNorm() + p.base;
    H.noalias() = J.transpose() * J;
    H.diagonal().array() += damping_;
    g.noalias() = J.transpose() * r;
    const int rows = static_cast<int>(limits.rows().size());
    C.setZero(rows + 2 * n, n);
    b.resize(rows + 2 * n);
    for (int i = 0; i < rows; ++i) {
      const LimitSet::Row& row = limits.rows()[i];
      for (int k = 0; k < row.count; ++k) C(i, row.first + k) = row.normal[k];
      b[i] = row.slack;
    }
    for (int k = 0; k < n; ++k) {
      C(rows + k, k) = 1.0;
      C(rows + n + k, k) = -1.0;
      b[rows + k] = b[rows + n + k] = p.largestStep;
    }
    qp.solve(H, g, C, b, dq);
  }
  Parameters p;
  double damping_ = 0.0;
  MatrixXd H, C;
  VectorXd g, b;
  ConvexQp qp;
};

}  // namespace

std::unique_ptr<IkSolver> makeQpDifferential(const QpDifferentialParameters& parameters) {
  return std::make_unique<StepSolver<QpDifferential>>(parameters);
}

}  // namespace gelenk
