#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string_view>

namespace gelenk {

/// An order of three elementary rotations about the axes first, second, third (0 x, 1 y, 2 z):
/// R(a, b, c) = R_first(a) R_second(b) R_third(c); as moving axes read from the left. Lecture 10.2.
struct EulerOrder {
  std::string_view name;
  int first, second, third;

  /// first == third (zxz, ...): singular at b = 0 and pi; else (xyz, ...): singular at b = +-pi/2.
  bool isProper() const { return first == third; }
};

/// The twelve orders whose neighbours differ: six of three axes (Tait-Bryan), six with the first axis again
/// (proper Euler).
const std::array<EulerOrder, 12>& eulerOrders();

/// The lecture's R(phi^x, phi^y, phi^z): x, y, z. Lecture 10.2.
const EulerOrder& lectureEulerOrder();

std::optional<EulerOrder> findEulerOrder(std::string_view name);

Eigen::Matrix3d rotationFromEuler(const EulerOrder& order, const Eigen::Vector3d& angles);

/// Angles (a, b, c), radians, with rotationFromEuler(order, angles) == R: a, c in [-pi, pi]; b in [-pi/2,
/// pi/2] for three axes, in [0, pi] for proper orders. At gimbal lock only a + c or a - c is determined: c is
/// then 0. R must be a rotation matrix.
Eigen::Vector3d eulerFromRotation(const EulerOrder& order, const Eigen::Matrix3d& R);

/// omega = E(angles) (da, db, dc), world axes. |det E| is |cos b| or |sin b|: 0 is gimbal lock, where a
/// direction of turning is lost.
Eigen::Matrix3d eulerRates(const EulerOrder& order, const Eigen::Vector3d& angles);

}  // namespace gelenk
