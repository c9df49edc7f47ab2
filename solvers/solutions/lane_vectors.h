#pragma once

#include <Eigen/Geometry>

#include "solvers/solutions/lanes.h"

/// Vectors and turns about z of four branches at once.
namespace gelenk::lanes {

struct Turns {
  Lanes c, s;
};
struct Vectors {
  Lanes x, y, z;
};

GELENK_INLINE Lanes dot(const Vectors& a, const Vectors& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
GELENK_INLINE Vectors cross(const Vectors& a, const Vectors& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
GELENK_INLINE Vectors operator-(const Vectors& a, const Vectors& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
GELENK_INLINE Vectors operator+(const Vectors& a, const Vectors& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
GELENK_INLINE Vectors same(const Eigen::Vector3d& v) {
  return {Lanes{} + v.x(), Lanes{} + v.y(), Lanes{} + v.z()};
}
/// Rz(t) v.
GELENK_INLINE Vectors turned(const Turns& t, const Vectors& v) {
  return {t.c * v.x - t.s * v.y, t.s * v.x + t.c * v.y, v.z};
}
GELENK_INLINE Vectors turnedBack(const Turns& t, const Vectors& v) {
  return {t.c * v.x + t.s * v.y, t.c * v.y - t.s * v.x, v.z};
}
/// R v, R^T v.
GELENK_INLINE Vectors times(const Eigen::Isometry3d& X, const Vectors& v) {
  const auto& R = X.matrix();
  return {R(0, 0) * v.x + R(0, 1) * v.y + R(0, 2) * v.z, R(1, 0) * v.x + R(1, 1) * v.y + R(1, 2) * v.z,
          R(2, 0) * v.x + R(2, 1) * v.y + R(2, 2) * v.z};
}
GELENK_INLINE Vectors timesBack(const Eigen::Isometry3d& X, const Vectors& v) {
  const auto& R = X.matrix();
  return {R(0, 0) * v.x + R(1, 0) * v.y + R(2, 0) * v.z, R(0, 1) * v.x + R(1, 1) * v.y + R(2, 1) * v.z,
          R(0, 2) * v.x + R(1, 2) * v.y + R(2, 2) * v.z};
}
GELENK_INLINE Vectors moved(const Eigen::Isometry3d& X, const Vectors& v) {
  const Vectors r = times(X, v);
  const auto& M = X.matrix();
  return {r.x + M(0, 3), r.y + M(1, 3), r.z + M(2, 3)};
}
GELENK_INLINE Vectors movedBack(const Eigen::Isometry3d& X, const Vectors& v) {
  const auto& M = X.matrix();
  return timesBack(X, {v.x - M(0, 3), v.y - M(1, 3), v.z - M(2, 3)});
}

/// The turns about z that take a to b (their planar parts); where one of them is nearer to the axis than
/// `onAxis` the reference, and then `bit` is set in `free`.
GELENK_INLINE Turns turnsFromTo(const Vectors& a, const Vectors& b, double reference, double onAxis, long bit,
                                Mask& free) {
  const Lanes c = a.x * b.x + a.y * b.y, s = a.x * b.y - a.y * b.x, r2 = c * c + s * s;
  const double near = onAxis * onAxis;
  const Mask none = (a.x * a.x + a.y * a.y < near) | (b.x * b.x + b.y * b.y < near) | (r2 <= 0.0);
  const Lanes r = 1.0 / root(choose(none, Lanes{} + 1.0, r2));
  Turns t{c * r, s * r};
  if (any(none)) {
    t.c = choose(none, Lanes{} + std::cos(reference), t.c);
    t.s = choose(none, Lanes{} + std::sin(reference), t.s);
    free |= none & bit;
  }
  return t;
}

}  // namespace gelenk::lanes
