#pragma once

#include <Eigen/Geometry>

namespace gelenk {

/// Unit quaternion of the rotation vector w (axis times angle, radians). Exact at 0, smooth everywhere.
Eigen::Quaterniond expRotation(const Eigen::Vector3d& w);

/// Rotation vector of q, |w| <= pi. Exact at 0 and at pi: at a half turn both signs of the axis describe the
/// same rotation and the one with q's own vector part is returned. q need not be normalised, only non-zero.
Eigen::Vector3d logRotation(const Eigen::Quaterniond& q);

/// q = swing * twist: the twist turns about z, the swing about an axis in the x-y plane (z component 0, w >=
/// 0). At a swing of exactly pi the twist is undetermined; it is then the identity.
struct SwingTwist {
  Eigen::Quaterniond swing;
  Eigen::Quaterniond twist;
};
SwingTwist splitSwingTwist(const Eigen::Quaterniond& q);

/// Swing-twist coordinates c = (2x, 2y, tau) of q = S T(tau), S = (w, x, y, 0) with w >= 0, tau in (-pi, pi].
/// |(2x, 2y)| = 2 sin(swing angle / 2): no trigonometry is needed for the swing.
Eigen::Vector3d swingTwistCoordinates(const Eigen::Quaterniond& q);

/// The rotation with the swing-twist coordinates c; |(c.x, c.y)| <= 2.
Eigen::Quaterniond fromSwingTwistCoordinates(const Eigen::Vector3d& c);

/// d(swingTwistCoordinates(q)) / d(omega) for q <- q * exp(omega), 3 x 3. Finite but meaningless at a swing
/// of exactly pi.
Eigen::Matrix3d swingTwistJacobian(const Eigen::Quaterniond& q);

/// Hessian of 1/2 |log R|^2 in exponential coordinates about R with log R = theta u:
/// u u^T + (theta / 2) cot(theta / 2) (I - u u^T). The same for R exp(d) and exp(d) R. Positive below a half
/// turn.
Eigen::Matrix3d squaredAngleHessian(const Eigen::Vector3d& logR);
/// Its factor across u, (theta / 2) cot(theta / 2); exact at 0.
double squaredAngleAcross(double theta);

/// Smallest rotation that turns direction a into direction b (neither need be a unit vector, neither may be
/// zero). Antiparallel directions have no unique axis: one perpendicular to a is chosen.
Eigen::Quaterniond rotationBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

/// [w]x, the matrix with [w]x v = w x v.
Eigen::Matrix3d crossMatrix(const Eigen::Vector3d& w);

}  // namespace gelenk
