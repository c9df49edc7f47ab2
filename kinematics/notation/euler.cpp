#include "kinematics/notation/euler.h"

#include <cmath>

namespace gelenk {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

const std::array<EulerOrder, 12>& eulerOrders() {
  static constexpr std::array<EulerOrder, 12> orders{{{"xyz", 0, 1, 2},
                                                      {"xzy", 0, 2, 1},
                                                      {"yxz", 1, 0, 2},
                                                      {"yzx", 1, 2, 0},
                                                      {"zxy", 2, 0, 1},
                                                      {"zyx", 2, 1, 0},
                                                      {"xyx", 0, 1, 0},
                                                      {"xzx", 0, 2, 0},
                                                      {"yxy", 1, 0, 1},
                                                      {"yzy", 1, 2, 1},
                                                      {"zxz", 2, 0, 2},
                                                      {"zyz", 2, 1, 2}}};
  return orders;
}

const EulerOrder& lectureEulerOrder() { return eulerOrders()[0]; }

std::optional<EulerOrder> findEulerOrder(std::string_view name) {
  for (const EulerOrder& order : eulerOrders())
    if (order.name == name) return order;
  return std::nullopt;
}

Matrix3d rotationFromEuler(const EulerOrder& order, const Vector3d& angles) {
  return (AngleAxisd(angles[0], Vector3d::Unit(order.first)) *
          AngleAxisd(angles[1], Vector3d::Unit(order.second)) *
          AngleAxisd(angles[2], Vector3d::Unit(order.third)))
      .toRotationMatrix();
}

Vector3d eulerFromRotation(const EulerOrder& order, const Matrix3d& R) {
  // b from the column that R_first(a) R_second(b) makes of the third axis; a from the same column; c from
  // what is left, which turns about the third axis alone and is well defined even where a is not (there a = 0
  // would do as well; c = 0 is chosen).
  const int i = order.first, j = order.second, k = 3 - i - j;
  const double sign = (j - i + 3) % 3 == 1 ? 1.0 : -1.0;  // e_i x e_j = sign e_k
  double a, b;
  if (order.isProper()) {  // R e_i = (cos b, sin b sin a, -sign sin b cos a) along i, j, k
    const double sine = std::hypot(R(j, i), R(k, i));
    b = std::atan2(sine, R(i, i));
    a = std::atan2(R(j, i), -sign * R(k, i));
    if (sine < 1e-9)
      a = std::atan2(sign * R(k, j), R(j, j));  // gimbal lock with c = 0: R e_j = (0, cos a, sign sin a)
  } else {                                      // R e_k = (sign sin b, -sign cos b sin a, cos b cos a)
    const double cosine = std::hypot(R(j, k), R(k, k));
    b = std::atan2(sign * R(i, k), cosine);
    a = std::atan2(-sign * R(j, k), R(k, k));
    if (cosine < 1e-9) a = std::atan2(sign * R(k, j), R(j, j));
  }
  const Matrix3d rest =
      (AngleAxisd(a, Vector3d::Unit(i)) * AngleAxisd(b, Vector3d::Unit(j))).toRotationMatrix().transpose() *
      R;
  const int n = (order.third + 1) % 3, m = (order.third + 2) % 3;
  return {a, b, std::atan2(rest(m, n), rest(n, n))};
}

Matrix3d eulerRates(const EulerOrder& order, const Vector3d& angles) {
  const Matrix3d first = AngleAxisd(angles[0], Vector3d::Unit(order.first)).toRotationMatrix();
  const Matrix3d second = AngleAxisd(angles[1], Vector3d::Unit(order.second)).toRotationMatrix();
  Matrix3d E;
  E << Vector3d::Unit(order.first), first * Vector3d::Unit(order.second),
      first * second * Vector3d::Unit(order.third);
  return E;
}

}  // namespace gelenk
