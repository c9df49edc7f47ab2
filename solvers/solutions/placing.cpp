#include "solvers/solutions/placing.h"

#include <Eigen/Eigenvalues>

namespace gelenk {
namespace {

using namespace planar;

constexpr double flat = 1e-9;  ///< sines below this are zero

/// a + b x + c x^2.
struct Quadratic {
  double a, b, c;
  double at(double x) const { return a + x * (b + x * c); }
};
Quadratic operator-(const Quadratic& x, const Quadratic& y) { return {x.a - y.a, x.b - y.b, x.c - y.c}; }
Quadratic operator*(double k, const Quadratic& x) { return {k * x.a, k * x.b, k * x.c}; }
/// |p + d x|^2 of the first n coordinates.
Quadratic squareOf(const Vector3d& p, const Vector3d& d, int n) {
  return {p.head(n).squaredNorm(), 2.0 * p.head(n).dot(d.head(n)), d.head(n).squaredNorm()};
}

/// Real roots; a double one within rounding is one.
int roots(const Quadratic& p, double x[2]) {
  const double size = std::max({std::abs(p.a), std::abs(p.b), std::abs(p.c)});
  if (std::abs(p.c) < rounding * size) {
    if (std::abs(p.b) < rounding * size) return 0;
    x[0] = -p.a / p.b;
    return 1;
  }
  const double d = p.b * p.b - 4.0 * p.a * p.c;
  if (d < -reachRounding * size * size) return 0;
  const double q = -0.5 * (p.b + std::copysign(std::sqrt(std::max(d, 0.0)), p.b));
  x[0] = q / p.c;
  x[1] = q != 0.0 ? p.a / q : x[0];
  return x[0] == x[1] ? 1 : 2;
}

/// Real roots of p[0] + ... + p[4] x^4, p[4] not small: eigenvalues of the companion matrix.
int roots(const double p[5], double x[4]) {
  Eigen::Matrix4d companion = Eigen::Matrix4d::Zero();
  for (int i = 0; i < 4; ++i) companion(i, 3) = -p[i] / p[4];
  for (int i = 0; i < 3; ++i) companion(i + 1, i) = 1.0;
  const Eigen::EigenSolver<Eigen::Matrix4d> eigen(companion, false);
  int count = 0;
  for (const std::complex<double>& z : eigen.eigenvalues())
    if (std::abs(z.imag()) < 1e-7 * (1.0 + std::abs(z))) x[count++] = z.real();
  return count;
}

class Places {
 public:
  Places(const Placing& placing, const double reference[3], Placed out[8])
      : p_(placing),
        R1_(p_.X1->linear()),
        R2_(p_.X2->linear()),
        x1_(p_.X1->translation()),
        x2_(p_.X2->translation()),
        reference_(reference),
        out_(out) {}

  int run() {
    switch (p_.slides) {
      case 7: threeSlide(); break;
      case 6: turnSlideSlide(); break;
      case 5: slideTurnSlide(); break;
      case 4: turnTurnSlide(); break;
      case 2: turnSlideTurn(); break;
    }
    return count_;
  }

 private:
  void add(Turn t1, Turn t2, Turn t3, double l1, double l2, double l3, unsigned free) {
    if (count_ < 8) out_[count_++] = {{t1, t2, t3}, {l1, l2, l3}, free};
  }
  /// The turn of hinge i that takes a to b, or the reference's.
  Turn turned(int i, const Vector3d& a, const Vector3d& b, unsigned& free) const {
    Turn t;
    if (turnFromTo(a, b, t)) return t;
    free |= 1u << i;
    return turnOf(reference_[i]);
  }

  void threeSlide() {
    Matrix3d D;
    D << Vector3d::UnitZ(), R1_.col(2), R1_ * R2_.col(2);
    if (std::abs(D.determinant()) < flat) return;
    const Vector3d s = D.inverse() * (p_.g - x1_ - R1_ * (x2_ + R2_ * p_.c));
    add(none, none, none, s[0], s[1], s[2], 0);
  }

  /// The plane of the two slides turns about axis 1 until the place lies in it.
  void turnSlideSlide() {
    const Vector3d d2 = R1_.col(2), d3 = R1_ * R2_.col(2), e = x1_ + R1_ * (x2_ + R2_ * p_.c),
                   n = d2.cross(d3);
    if (n.norm() < flat) return;
    const Vector3d& g = p_.g;
    Turn t[2];  // n . Rz(-u) g = n . e
    int turns =
        zeros({n.z() * g.z() - n.dot(e), n.x() * g.x() + n.y() * g.y(), n.x() * g.y() - n.y() * g.x()}, t);
    const unsigned free = turns < 0 ? 1u : 0u;
    if (turns < 0) t[0] = turnOf(reference_[0]), turns = 1;
    for (int i = 0; i < turns; ++i) {
      const Vector3d y = aboutZ({t[i].c, -t[i].s}, g) - e;
      const double n2 = n.squaredNorm();
      add(t[i], none, none, 0, y.cross(d3).dot(n) / n2, d2.cross(y).dot(n) / n2, free);
    }
  }

  /// Rz(u2) (v + d s3) = h - a s1: equal heights, equal distances from axis 2.
  void slideTurnSlide() {
    const Vector3d v = x2_ + R2_ * p_.c, d = R2_.col(2), a = R1_.row(2).transpose(),
                   h = R1_.transpose() * (p_.g - x1_);
    if (std::max(std::abs(d.z()), std::abs(a.z())) < flat) return;
    const bool third = std::abs(d.z()) >= std::abs(a.z());  // s3 = rest + share s1, or s1 = rest + share s3
    const double rest = (h.z() - v.z()) / (third ? d.z() : a.z()),
                 share = third ? -a.z() / d.z() : -d.z() / a.z();
    const Quadratic inner = third ? squareOf(v + rest * d, share * d, 2) : squareOf(v, d, 2),
                    outer = third ? squareOf(h, -a, 2) : squareOf(h - rest * a, -share * a, 2);
    double x[2];
    const int found = roots(inner - outer, x);
    for (int i = 0; i < found; ++i) {
      const double s1 = third ? x[i] : rest + share * x[i], s3 = third ? rest + share * x[i] : x[i];
      unsigned free = 0;
      const Turn t = turned(1, v + s3 * d, h - s1 * a, free);
      add(none, t, none, s1, 0, s3, free);
    }
  }

  /// Rz(u1) X1 Rz(u2) (v + d s) = g: as with three turning hinges, the coefficients being polynomials of s.
  void turnTurnSlide() {
    const Vector3d v = x2_ + R2_ * p_.c, d = R2_.col(2), n3 = R1_.transpose() * x1_,
                   m3 = R1_.row(2).transpose();
    const Vector2d n = n3.head<2>(), m = m3.head<2>();
    const Quadratic height{v.z(), d.z(), 0.0};
    const Quadratic alpha = Quadratic{0.5 * (p_.g.squaredNorm() - x1_.squaredNorm()), 0, 0} -
                            0.5 * squareOf(v, d, 3) - n3.z() * height,
                    beta = Quadratic{p_.g.z() - x1_.z(), 0, 0} - m3.z() * height;
    const auto finish = [&](double s, const Vector2d& z) {
      const Vector3d y = v + s * d, w(z.x(), z.y(), y.z());
      unsigned free = 0;
      const Turn t2 = turned(1, y, w, free);
      const Turn t1 = turned(0, *p_.X1 * aboutZ(t2, y), p_.g, free);
      add(t1, t2, none, 0, 0, s, free);
    };
    const double n2 = n.squaredNorm(), m2 = m.squaredNorm(), cross = n.x() * m.y() - n.y() * m.x();
    if (cross * cross > 1e-20 * std::max(n2 * m2, 1e-12)) {
      const Quadratic zx = (1.0 / cross) * (m.y() * alpha - n.y() * beta),
                      zy = (1.0 / cross) * (n.x() * beta - m.x() * alpha), y2 = squareOf(v, d, 2);
      double p[5] = {-y2.a, -y2.b, -y2.c, 0, 0}, s[4];  // the highest: (|m| / (2 cross))^2, for |d| = 1
      for (const Quadratic& z : {zx, zy}) {
        p[0] += z.a * z.a, p[1] += 2.0 * z.a * z.b, p[2] += z.b * z.b + 2.0 * z.a * z.c;
        p[3] += 2.0 * z.b * z.c, p[4] += z.c * z.c;
      }
      const int found = roots(p, s);
      for (int i = 0; i < found; ++i) finish(s[i], {zx.at(s[i]), zy.at(s[i])});
      return;
    }
    const bool useM = m2 >= n2;  // the stronger equation gives z; both together one for s
    if (std::max(n2, m2) < 1e-20) return;
    const double dot = n.dot(m);
    const Quadratic left = useM ? alpha - (dot / m2) * beta : beta - (dot / n2) * alpha;
    double s[2];
    const int found = roots(left, s);
    for (int i = 0; i < found; ++i) {
      const Vector3d y = v + s[i] * d;
      Vector2d z[2];
      const double r = y.head<2>().norm();
      const int points = useM ? onCircle(m, beta.at(s[i]), r, z) : onCircle(n, alpha.at(s[i]), r, z);
      for (int k = 0; k < points; ++k) finish(s[i], z[k]);
    }
  }

  /// Rz(u1) (d s + E(u3)) = g: equal heights, equal distances from the origin.
  void turnSlideTurn() {
    const Vector3d d = R1_.col(2), fixed = x1_ + R1_ * (x2_ + R2_.col(2) * p_.c.z());
    const Matrix3d R = R1_ * R2_;
    const Vector3d ec = R.col(0) * p_.c.x() + R.col(1) * p_.c.y(),
                   es = R.col(1) * p_.c.x() - R.col(0) * p_.c.y();
    const Wave E[3] = {{fixed.x(), ec.x(), es.x()}, {fixed.y(), ec.y(), es.y()}, {fixed.z(), ec.z(), es.z()}};
    const Wave along{fixed.dot(d), ec.dot(d), es.dot(d)};
    const auto finish = [&](Turn t3, double s) {
      unsigned free = 0;
      const Turn t1 = turned(0, fixed + ec * t3.c + es * t3.s + s * d, p_.g, free);
      add(t1, none, t3, 0, s, 0, free);
    };
    if (std::abs(d.z()) > flat) {
      const Wave s = (1.0 / d.z()) * (Wave{p_.g.z(), 0, 0} - E[2]);
      TrigonometricPolynomial p;
      p.degree = 2;
      addProduct(p, 1.0, s, s);
      addProduct(p, 2.0, s, along);
      for (const Wave& e : E) addProduct(p, 1.0, e, e);
      p.a[0] -= p_.g.squaredNorm();
      double size = 1.0;
      for (int k = 0; k <= 2; ++k) size = std::max({size, std::abs(p.a[k]), std::abs(p.b[k])});
      const TrigonometricRoots found = realRoots(p, 1e-13 * size);
      for (int i = 0; i < found.count; ++i) {
        const Turn t3 = turnOf(found.t[i]);
        finish(t3, s.at(t3));
      }
      return;
    }
    Turn t[2];
    const int turns = zeros(E[2] - Wave{p_.g.z(), 0, 0}, t);
    for (int i = 0; i < turns; ++i) {
      const Vector3d e = fixed + ec * t[i].c + es * t[i].s;
      double s[2];
      const int found = roots(squareOf(e, d, 3) - Quadratic{p_.g.squaredNorm(), 0, 0}, s);
      for (int k = 0; k < found; ++k) finish(t[i], s[k]);
    }
  }

  static constexpr Turn none{1.0, 0.0};
  const Placing& p_;
  const Matrix3d R1_, R2_;
  const Vector3d x1_, x2_;
  const double* reference_;
  Placed* out_;
  int count_ = 0;
};

}  // namespace

int place(const Placing& placing, const double reference[3], Placed out[8]) {
  const bool mirrored = placing.slides == 1 || placing.slides == 3;
  if (!mirrored) return Places(placing, reference, out).run();
  // Walked from the other end, against the hinges' sense.
  const Isometry3d X1 = placing.X2->inverse(Eigen::Isometry), X2 = placing.X1->inverse(Eigen::Isometry);
  const double backwards[3] = {-reference[2], -reference[1], -reference[0]};
  const int count =
      Places({&X1, &X2, placing.g, placing.c, placing.slides == 1 ? 4u : 6u}, backwards, out).run();
  for (int k = 0; k < count; ++k) {
    Placed& p = out[k];
    std::swap(p.t[0], p.t[2]);
    std::swap(p.length[0], p.length[2]);
    for (int i = 0; i < 3; ++i) p.t[i].s = -p.t[i].s, p.length[i] = -p.length[i];
    p.free = (p.free & 2u) | (p.free & 1u) << 2 | p.free >> 2;
  }
  return count;
}

}  // namespace gelenk
