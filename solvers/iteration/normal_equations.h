#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <limits>

namespace gelenk {

/// dq = J^T (J J^T + damping I)^-1 r = (J^T J + damping I)^-1 J^T r, by whichever is smaller. Keeps its
/// storage.
class DampedSystem {
 public:
  /// m x nv. damping >= 0; where the matrix is not positive definite dq is not finite.
  void factorise(const Eigen::MatrixXd& J, double damping) {
    wide_ = J.rows() <= J.cols();
    if (wide_)
      A_.noalias() = J * J.transpose();
    else
      A_.noalias() = J.transpose() * J;
    A_.diagonal().array() += damping;
    llt_.compute(A_);
  }
  void solve(const Eigen::MatrixXd& J, const Eigen::VectorXd& r, Eigen::VectorXd& dq) {
    if (llt_.info() != Eigen::Success) {
      dq.setConstant(J.cols(), std::numeric_limits<double>::quiet_NaN());
    } else if (wide_) {
      y_ = r;
      llt_.solveInPlace(y_);
      dq.noalias() = J.transpose() * y_;
    } else {
      dq.noalias() = J.transpose() * r;
      llt_.solveInPlace(dq);
    }
  }

 private:
  bool wide_ = true;
  Eigen::MatrixXd A_;
  Eigen::VectorXd y_;
  Eigen::LLT<Eigen::MatrixXd> llt_;
};

/// Singular values (falling) and vectors of J from the eigenvalues of the smaller of J J^T and J^T J: exact
/// to about 1e-8 of the largest, ample for methods that damp or drop singular values below 1e-3 of it. Keeps
/// its storage.
class SingularSystem {
 public:
  void factorise(const Eigen::MatrixXd& J) {
    const bool wide = J.rows() <= J.cols();
    if (wide)
      A_.noalias() = J * J.transpose();
    else
      A_.noalias() = J.transpose() * J;
    eigen_.compute(A_);
    const Eigen::Index n = A_.rows();
    sigma_ = eigen_.eigenvalues().reverse().cwiseMax(0.0).cwiseSqrt();
    U_.resize(J.rows(), n);
    V_.resize(J.cols(), n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto vector = eigen_.eigenvectors().col(n - 1 - i);
      const double scale = sigma_[i] > 0.0 ? 1.0 / sigma_[i] : 0.0;
      if (wide) {
        U_.col(i) = vector;
        V_.col(i).noalias() = J.transpose() * vector;
        V_.col(i) *= scale;
      } else {
        V_.col(i) = vector;
        U_.col(i).noalias() = J * vector;
        U_.col(i) *= scale;
      }
    }
  }
  const Eigen::VectorXd& sigma() const { return sigma_; }
  const Eigen::MatrixXd& U() const { return U_; }  ///< m x min(m, nv)
  const Eigen::MatrixXd& V() const { return V_; }  ///< nv x min(m, nv)

 private:
  Eigen::MatrixXd A_, U_, V_;
  Eigen::VectorXd sigma_;
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen_;
};

}  // namespace gelenk
