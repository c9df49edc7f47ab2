// What the lecture's examples let Ceres solve, by routes of its own for the page, which is built without that
// library: the same problems to the same minima. Iterations are counted by these methods.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <random>
#include <stdexcept>

#include "kinematics/configuration.h"
#include "solvers/ceres/nearest_solution.h"
#include "solvers/ceres/quaternion_chain.h"

namespace gelenk {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// ---- the nearest solution: Newton's method on the conditions of Lagrange

/// phi - phi_old + D^T lambda = 0 and f(phi) = X. The second derivative of f after phi_j and phi_k is minus
/// the vector from joint max(j, k) to the end, and that vector is column max(j, k) of D turned back by a
/// right angle.
NearestSolution descend(const PlanarChain& chain, const VectorXd& phiOld, const Vector2d& X, VectorXd phi) {
  const int n = chain.linkCount();
  NearestSolution found;
  Vector2d lambda = Vector2d::Zero();
  for (int i = 0; i < 200; ++i, ++found.iterations) {
    const MatrixXd D = jacobian(chain, phi);
    MatrixXd K = MatrixXd::Zero(n + 2, n + 2);
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) {
        const int last = std::max(j, k);
        K(j, k) = (j == k) - lambda.dot(Vector2d(D(1, last), -D(0, last)));
      }
    if (K.topLeftCorner(n, n).llt().info() != Eigen::Success) K.topLeftCorner(n, n).setIdentity();
    K.topRightCorner(n, 2) = D.transpose();
    K.bottomLeftCorner(2, n) = D;
    VectorXd right(n + 2);
    right << phiOld - phi, X - endEffector(chain, phi);
    const VectorXd step = K.fullPivLu().solve(right);
    const double length = step.head(n).norm();
    if (!std::isfinite(length)) break;
    phi += std::min(1.0, 0.5 / std::max(length, 1e-300)) * step.head(n);
    lambda = step.tail(2);
    if (length < 1e-15) break;
  }
  found.phi = phi;
  found.distance = (phi - phiOld).norm();
  found.violation = (endEffector(chain, phi) - X).norm();
  return found;
}

// ---- quaternions: Levenberg-Marquardt

struct Linearised {
  VectorXd r;
  MatrixXd J;
};

/// Minimises |r|^2 from x on; step(x, d) goes along d. Returns the iterations.
template <class X, class Residuals, class Step>
int levenbergMarquardt(X& x, const Residuals& residuals, const Step& step) {
  double damping = 1e-4;
  Linearised at = residuals(x);
  for (int i = 0; i < 2000; ++i) {
    const VectorXd gradient = at.J.transpose() * at.r;
    MatrixXd A = at.J.transpose() * at.J;
    if (gradient.norm() < 1e-15) return i;
    A.diagonal().array() += damping;
    const VectorXd d = -A.ldlt().solve(gradient);
    const X next = step(x, d);
    const Linearised then = residuals(next);
    if (then.r.squaredNorm() <= at.r.squaredNorm()) {
      if (d.norm() < 1e-14) return i;
      x = next;
      at = then;
      damping = std::max(1e-12, 0.2 * damping);
    } else {
      damping *= 4.0;
      if (damping > 1e12) return i;
    }
  }
  return 2000;
}

Matrix3d cross(const Vector3d& v) {
  return (Matrix3d() << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0).finished();
}

/// The unit quaternion's formula on any q, as it stands on paper.
Vector3d turn(const Quaterniond& q, const Vector3d& p) {
  return p + 2.0 * q.w() * q.vec().cross(p) + 2.0 * q.vec().cross(q.vec().cross(p));
}
Matrix3d turnMatrix(const Quaterniond& q) {
  const Matrix3d V = cross(q.vec());
  return Matrix3d::Identity() + 2.0 * q.w() * V + 2.0 * V * V;
}
/// Of turn(q, p) after w, x, y, z.
Eigen::Matrix<double, 3, 4> turnDerivative(const Quaterniond& q, const Vector3d& p) {
  const Vector3d v = q.vec();
  Eigen::Matrix<double, 3, 4> D;
  D.col(0) = 2.0 * v.cross(p);
  D.rightCols<3>() = -2.0 * q.w() * cross(p) +
                     2.0 * (v.dot(p) * Matrix3d::Identity() + v * p.transpose() - 2.0 * p * v.transpose());
  return D;
}

using Joints = std::vector<Quaterniond>;

/// p[i]: what joint i turns, so that p[0] turned by joint 0 is the end.
std::vector<Vector3d> turnedPoints(const std::vector<double>& lengths, const Joints& q) {
  std::vector<Vector3d> p(3);
  p[2] = Vector3d(lengths[2], 0.0, 0.0);
  for (int i = 1; i >= 0; --i) p[i] = Vector3d(lengths[i], 0.0, 0.0) + turn(q[i + 1], p[i + 1]);
  return p;
}

}  // namespace

const std::string_view nearestSolutionMethod = "Newton's method on the conditions of Lagrange",
                       quaternionChainMethod = "Levenberg-Marquardt";

NearestSolution nearestSolution(const PlanarChain& chain, const VectorXd& phiOld, const Vector2d& X,
                                const VectorXd& hint) {
  double size = 0.0;
  for (const double length : chain.lengths) size += length;
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
    const NearestSolution found = descend(chain, phiOld, X, start);
    iterations += found.iterations;
    const bool holds = found.violation <= 1e-10 * size;
    const bool bestHolds = best.phi.size() > 0 && best.violation <= 1e-10 * size;
    if (best.phi.size() == 0 || (holds && (!bestHolds || found.distance < best.distance)) ||
        (!bestHolds && found.violation < best.violation))
      best = found;
  }
  best.iterations = iterations;
  return best;
}

Vector3d quaternionChainEnd(const std::vector<double>& lengths, const Joints& q) {
  Joints unit;
  for (const Quaterniond& each : q) unit.push_back(each.normalized());
  return turn(unit[0], turnedPoints(lengths, unit)[0]);
}

QuaternionChainFit fitQuaternionChain(const std::vector<double>& lengths, const Joints& start,
                                      const Vector3d& target, UnitConstraint constraint,
                                      double penaltyWeight) {
  if (lengths.size() != 3 || start.size() != 3)
    throw std::invalid_argument("the quaternion chain has exactly three joints");
  QuaternionChainFit fit{.q = start};
  const bool manifold = constraint == UnitConstraint::Manifold;
  const auto residuals = [&](const Joints& q) {
    Linearised at{VectorXd::Zero(manifold ? 3 : 6), MatrixXd::Zero(manifold ? 3 : 6, manifold ? 9 : 12)};
    const std::vector<Vector3d> p = turnedPoints(lengths, q);
    at.r.head<3>() = turn(q[0], p[0]) - target;
    Matrix3d before = Matrix3d::Identity();
    for (int i = 0; i < 3; ++i) {
      if (manifold) {
        at.J.block<3, 3>(0, 3 * i) = -before * cross(turn(q[i], p[i]));
      } else {
        at.J.block<3, 4>(0, 4 * i) = before * turnDerivative(q[i], p[i]);
        at.r[3 + i] = penaltyWeight * (q[i].squaredNorm() - 1.0);
        at.J.block<1, 4>(3 + i, 4 * i) =
            2.0 * penaltyWeight * Eigen::RowVector4d(q[i].w(), q[i].x(), q[i].y(), q[i].z());
      }
      before = before * turnMatrix(q[i]);
    }
    return at;
  };
  const auto step = [&](Joints q, const VectorXd& d) {
    for (int i = 0; i < 3; ++i) {
      if (manifold) {
        const Vector3d turnBy = d.segment<3>(3 * i);
        const double angle = turnBy.norm();
        if (angle > 0.0) q[i] = (Quaterniond(Eigen::AngleAxisd(angle, turnBy / angle)) * q[i]).normalized();
      } else {
        q[i] = Quaterniond(q[i].w() + d[4 * i], q[i].x() + d[4 * i + 1], q[i].y() + d[4 * i + 2],
                           q[i].z() + d[4 * i + 3]);
      }
    }
    return q;
  };
  fit.iterations = levenbergMarquardt(fit.q, residuals, step);
  for (const Quaterniond& q : fit.q)
    fit.constraintError = std::max(fit.constraintError, std::abs(q.norm() - 1.0));
  fit.claimedError = (turn(fit.q[0], turnedPoints(lengths, fit.q)[0]) - target).norm();
  fit.trueError = (quaternionChainEnd(lengths, fit.q) - target).norm();
  return fit;
}

}  // namespace gelenk
