#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "solvers/solutions/trigonometric_roots.h"

/// Two equations in the plane and a length, with coefficients that are waves of one angle: what three hinges
/// that place a point, or a direction, come down to.
namespace gelenk::planar {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

inline constexpr double rounding = 1e-12;  ///< lengths and sines below this are zero
inline constexpr double reachRounding =
    1e-9;  ///< a cosine may exceed 1 by this and still mean a stretched arm

/// A direction in the plane: cosine and sine.
struct Turn {
  double c, s;
  double angle() const { return std::atan2(s, c); }
};
inline Matrix3d aboutZ(Turn t) {
  Matrix3d R;
  R << t.c, -t.s, 0, t.s, t.c, 0, 0, 0, 1;
  return R;
}
inline Vector3d aboutZ(Turn t, const Vector3d& v) {
  return {t.c * v.x() - t.s * v.y(), t.s * v.x() + t.c * v.y(), v.z()};
}
/// The turn about z that takes a to b (their planar parts); false where one of them is on the axis.
inline bool turnFromTo(const Vector3d& a, const Vector3d& b, Turn& t) {
  const double c = a.x() * b.x() + a.y() * b.y(), s = a.x() * b.y() - a.y() * b.x(), r2 = c * c + s * s;
  const double aa = a.x() * a.x() + a.y() * a.y(), bb = b.x() * b.x() + b.y() * b.y();
  if (aa < 1e-18 || bb < 1e-18 || r2 == 0.0) return false;
  const double r = 1.0 / std::sqrt(r2);
  t = {c * r, s * r};
  return true;
}
inline Turn turnOf(double angle) { return {std::cos(angle), std::sin(angle)}; }

/// a + b cos t + c sin t.
struct Wave {
  double a, b, c;
  double at(Turn t) const { return a + b * t.c + c * t.s; }
};
inline Wave operator-(const Wave& x, const Wave& y) { return {x.a - y.a, x.b - y.b, x.c - y.c}; }
inline Wave operator*(double k, const Wave& x) { return {k * x.a, k * x.b, k * x.c}; }

inline void addProduct(TrigonometricPolynomial& p, double k, const Wave& x, const Wave& y) {
  p.a[0] += k * (x.a * y.a + 0.5 * (x.b * y.b + x.c * y.c));
  p.a[1] += k * (x.a * y.b + x.b * y.a);
  p.b[1] += k * (x.a * y.c + x.c * y.a);
  p.a[2] += k * 0.5 * (x.b * y.b - x.c * y.c);
  p.b[2] += k * 0.5 * (x.b * y.c + x.c * y.b);
}

/// wave = 0: how many turns do it. -1: every turn does.
inline int zeros(const Wave& w, Turn t[2]) {
  const double r2 = w.b * w.b + w.c * w.c, r = std::sqrt(r2);
  if (r < rounding) return std::abs(w.a) < reachRounding ? -1 : 0;
  double x = -w.a / r;
  if (std::abs(x) > 1.0 + reachRounding) return 0;
  x = std::clamp(x, -1.0, 1.0);
  const double y = std::sqrt((1.0 - x) * (1.0 + x)), b = w.b / r, c = w.c / r;
  t[0] = {b * x - c * y, c * x + b * y};
  t[1] = {b * x + c * y, c * x - b * y};
  return 2;
}

/// Two equations in the plane and a length, all waves of one angle t:
///     n . z = alpha,  m . z = beta,  |z| = |(x, y)|
/// The length is given as a vector: as a square it would lose half its digits where it is small.
struct PlanarSystem {
  Vector2d n, m;
  Wave alpha, beta, x, y;
  double lengthAt(Turn t) const { return std::sqrt(x.at(t) * x.at(t) + y.at(t) * y.at(t)); }
};
struct PlanarSolution {
  Turn t;
  Vector2d z;
  bool free;
  int branch;  ///< the same number on the same continuous branch; -1 where only nearness tells
};

/// z from one equation and its length: two points of a circle on a line.
inline int onCircle(const Vector2d& n, double alpha, double r, Vector2d z[2]) {
  const double length = n.norm();
  double along = alpha / length;
  if (std::abs(along) > r + reachRounding) return 0;
  along = std::clamp(along, -r, r);
  const double across = std::sqrt((r - along) * (r + along));
  const Vector2d e = n / length, f(-e.y(), e.x());
  z[0] = along * e + across * f;
  z[1] = along * e - across * f;
  return 2;
}

inline int solve(const PlanarSystem& s, double freeAngle, PlanarSolution out[8]) {
  const double n2 = s.n.squaredNorm(), m2 = s.m.squaredNorm(), cross = s.n.x() * s.m.y() - s.n.y() * s.m.x();
  int count = 0;
  if (cross * cross > 1e-20 * std::max(n2 * m2, 1e-12)) {
    const Wave zx = (1.0 / cross) * (s.m.y() * s.alpha - s.n.y() * s.beta),
               zy = (1.0 / cross) * (s.n.x() * s.beta - s.m.x() * s.alpha);
    TrigonometricPolynomial p;
    p.degree = 2;
    addProduct(p, 1.0, zx, zx);
    addProduct(p, 1.0, zy, zy);
    double size = 0.0;
    for (int k = 0; k <= 2; ++k) size = std::max({size, std::abs(p.a[k]), std::abs(p.b[k])});
    addProduct(p, -1.0, s.x, s.x);
    addProduct(p, -1.0, s.y, s.y);
    const TrigonometricRoots roots = realRoots(p, 1e-13 * std::max(size, 1.0));
    for (int i = 0; i < roots.count && count < 8; ++i) {
      const Turn t = turnOf(roots.t[i]);
      out[count++] = {t, {zx.at(t), zy.at(t)}, false, -1};
    }
    return count;
  }
  const bool useM = m2 >= n2;  // the stronger equation gives z; both together one for t
  const double big2 = useM ? m2 : n2, dot = s.n.dot(s.m);
  if (big2 < 1e-20) return 0;
  const Wave left = useM ? s.alpha - (dot / m2) * s.beta : s.beta - (dot / n2) * s.alpha;
  Turn t[2];
  int turns = zeros(left, t);
  const bool free = turns < 0;
  if (free) t[0] = turnOf(freeAngle), turns = 1;
  for (int i = 0; i < turns; ++i) {
    Vector2d z[2];
    const double r = s.lengthAt(t[i]);
    const int points = useM ? onCircle(s.m, s.beta.at(t[i]), r, z) : onCircle(s.n, s.alpha.at(t[i]), r, z);
    for (int k = 0; k < points; ++k) out[count++] = {t[i], z[k], free, 2 * i + k};
  }
  return count;
}

}  // namespace gelenk::planar
