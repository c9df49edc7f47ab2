#include "kinematics/rotation.h"

#include <cmath>

namespace gelenk {

using Eigen::Quaterniond;
using Eigen::Vector3d;

Quaterniond expRotation(const Vector3d& w) {
  const double angle = w.norm();
  const double half = 0.5 * angle;
  // sin(a/2)/a; the series is exact to rounding below 1e-4, where the next term is a^4/3840 < 1e-19.
  const double scale = angle < 1e-4 ? 0.5 - angle * angle / 48.0 : std::sin(half) / angle;
  return Quaterniond(std::cos(half), scale * w.x(), scale * w.y(), scale * w.z());
}

Vector3d logRotation(const Quaterniond& q) {
  const double sign = std::signbit(q.w()) ? -1.0 : 1.0;  // q and -q are one rotation: take |angle| <= pi
  const double sine = q.vec().norm();
  const double cosine = std::abs(q.w());
  if (sine == 0.0) return Vector3d::Zero();
  // 2 atan2(|v|, w) / |v| keeps full precision at both ends; for tiny |v| it tends to 2/w.
  const double scale = sine < 1e-12 * cosine ? 2.0 / cosine : 2.0 * std::atan2(sine, cosine) / sine;
  return sign * scale * q.vec();
}

SwingTwist splitSwingTwist(const Quaterniond& q) {
  const double length = std::hypot(q.w(), q.z());
  if (length < 1e-150) return {Quaterniond(0.0, q.x(), q.y(), 0.0).normalized(), Quaterniond::Identity()};
  const Quaterniond twist(q.w() / length, 0.0, 0.0, q.z() / length);
  Quaterniond swing = q * twist.conjugate();
  swing.w() = length / q.norm();  // by construction; keeps w >= 0 and z = 0 to the last bit
  swing.x() /= q.norm();
  swing.y() /= q.norm();
  swing.z() = 0.0;
  return {swing, twist};
}

Vector3d swingTwistCoordinates(const Quaterniond& q) {
  const SwingTwist s = splitSwingTwist(q);
  double tau = 2.0 * std::atan2(s.twist.z(), s.twist.w());
  if (tau > M_PI) tau -= 2.0 * M_PI;
  if (tau <= -M_PI) tau += 2.0 * M_PI;
  return {2.0 * s.swing.x(), 2.0 * s.swing.y(), tau};
}

Quaterniond fromSwingTwistCoordinates(const Vector3d& c) {
  const double x = 0.5 * c.x(), y = 0.5 * c.y();
  const double w = std::sqrt(std::max(0.0, 1.0 - x * x - y * y));
  const Quaterniond swing(w, x, y, 0.0);
  const Quaterniond twist(std::cos(0.5 * c.z()), 0.0, 0.0, std::sin(0.5 * c.z()));
  return swing * twist;
}

Eigen::Matrix3d swingTwistJacobian(const Eigen::Quaterniond& q) {
  const double w = q.w(), x = q.x(), y = q.y(), z = q.z();
  const double length2 =
      std::max(w * w + z * z, 1e-12);  // 0 at a swing of pi, where the twist is undetermined
  const double length = std::sqrt(length2), c = w / length, s = z / length;
  const double swingX = x * c - y * s, swingY = x * s + y * c;
  Eigen::Matrix3d E;
  for (int k = 0; k < 3; ++k) {
    const Vector3d o = Vector3d::Unit(k);
    const double dw = -0.5 * (x * o.x() + y * o.y() + z * o.z()),
                 dx = 0.5 * (w * o.x() + y * o.z() - z * o.y());
    const double dy = 0.5 * (w * o.y() + z * o.x() - x * o.z()),
                 dz = 0.5 * (w * o.z() + x * o.y() - y * o.x());
    const double dTau = 2.0 * (w * dz - z * dw) / length2;
    E.col(k) << 2.0 * (dx * c - dy * s - 0.5 * swingY * dTau), 2.0 * (dx * s + dy * c + 0.5 * swingX * dTau),
        dTau;
  }
  return E;
}

double squaredAngleAcross(double theta) {
  // The series is exact to rounding below 1e-4, where the next term is theta^4 / 720 < 2e-19.
  return theta < 1e-4 ? 1.0 - theta * theta / 12.0 : 0.5 * theta / std::tan(0.5 * theta);
}

Eigen::Matrix3d squaredAngleHessian(const Vector3d& logR) {
  const double theta = logR.norm();
  if (theta < 1e-12) return Eigen::Matrix3d::Identity();
  const Vector3d u = logR / theta;
  const double across = squaredAngleAcross(theta);
  return across * Eigen::Matrix3d::Identity() + (1.0 - across) * u * u.transpose();
}

Quaterniond rotationBetween(const Vector3d& a, const Vector3d& b) {
  const Vector3d from = a.normalized(), to = b.normalized();
  // (1 + a.b, a x b) has the half angle; |from + to| measures 1 + a.b without cancellation near antiparallel.
  const double w = 0.5 * (from + to).squaredNorm();
  const Vector3d axis = from.cross(to);
  if (w < 1e-14) return Quaterniond(Eigen::AngleAxisd(M_PI, from.unitOrthogonal()));
  return Quaterniond(w, axis.x(), axis.y(), axis.z()).normalized();
}

Eigen::Matrix3d crossMatrix(const Vector3d& w) {
  Eigen::Matrix3d m;
  m << 0.0, -w.z(), w.y(), w.z(), 0.0, -w.x(), -w.y(), w.x(), 0.0;
  return m;
}

}  // namespace gelenk
