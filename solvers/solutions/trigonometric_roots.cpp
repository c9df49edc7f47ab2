#include "solvers/solutions/trigonometric_roots.h"

#include <algorithm>
#include <cmath>

namespace gelenk {
namespace {

constexpr int maxGrid = 16 * TrigonometricPolynomial::maxDegree;

/// cos and sin of the points of the finest grid; every grid used divides it.
struct Circle {
  double cosine[maxGrid], sine[maxGrid];
  Circle() {
    for (int j = 0; j < maxGrid; ++j) {
      cosine[j] = std::cos(2.0 * M_PI * j / maxGrid);
      sine[j] = std::sin(2.0 * M_PI * j / maxGrid);
    }
  }
};
const Circle circle;

struct Sample {
  double t, p, dp, ddp;
};

class RootFinder {
 public:
  RootFinder(const TrigonometricPolynomial& p, double noise) : p_(p), noise_(noise) {}

  TrigonometricRoots run() {
    const int n = p_.degree, grid = 16 * n, step = maxGrid / grid;
    double value[maxGrid + 1], slope[maxGrid + 1], bend[maxGrid + 1];
    for (int j = 0; j < grid; ++j) value[j] = p_.a[0], slope[j] = bend[j] = 0.0;
    for (int k = 1; k <= n; ++k) {
      const double a = p_.a[k], b = p_.b[k];
      third_ += k * k * k * std::sqrt(a * a + b * b);
      double cosine[maxGrid], sine[maxGrid];
      for (int j = 0, at = 0; j < grid; ++j, at = (at + k * step) % maxGrid)
        cosine[j] = circle.cosine[at], sine[j] = circle.sine[at];
      for (int j = 0; j < grid; ++j) {
        const double wave = a * cosine[j] + b * sine[j];
        value[j] += wave;
        bend[j] -= k * k * wave;
        slope[j] += k * (b * cosine[j] - a * sine[j]);
      }
    }
    value[grid] = value[0], slope[grid] = slope[0], bend[grid] = bend[0];
    const double h = 2.0 * M_PI / grid;
    for (int j = 0; j < grid; ++j)
      cell({j * h, value[j], slope[j], bend[j]}, {(j + 1) * h, value[j + 1], slope[j + 1], bend[j + 1]}, 0);
    for (int i = 0; i < grazingCount_ && roots_.count < TrigonometricRoots::most; ++i) {
      roots_.t[roots_.count++] = grazing_[i];
      ++roots_.grazing;
    }
    return roots_;
  }

 private:
  void add(double t) {
    if (roots_.count < TrigonometricRoots::most) roots_.t[roots_.count++] = t;
  }
  void graze(double t) {
    if (grazingCount_ < TrigonometricRoots::most) grazing_[grazingCount_++] = t;
  }
  Sample sample(double t) const {
    const auto v = p_.at(t);
    return {t, v.p, v.dp, v.ddp};
  }

  /// One cell, in which the slope must be shown to vanish at most once; halved where it is not.
  void cell(const Sample& l, const Sample& r, int depth) {
    const double h = r.t - l.t;
    const bool change = (l.p < 0.0) != (r.p < 0.0), turns = (l.dp < 0.0) != (r.dp < 0.0);
    // |p''| in the cell: within half its width of one of its ends.
    const double curvature = std::max(std::abs(l.ddp), std::abs(r.ddp)) + 0.5 * h * third_;
    const double least = std::min(std::abs(l.p), std::abs(r.p));
    if (!change && least > 0.5 * h * std::max(std::abs(l.dp), std::abs(r.dp)) + 0.25 * curvature * h * h)
      return;  // too far from zero to get there and back
    const bool monotonous = !turns && std::abs(l.dp) + std::abs(r.dp) > curvature * h;
    if (change && monotonous) return add(bracketed(l, r));
    if (!change && monotonous) return;
    if (depth < 5) {
      const Sample m = sample(0.5 * (l.t + r.t));
      cell(l, m, depth + 1);
      cell(m, r, depth + 1);
      return;
    }
    // A cell of 1/512 of the spacing of the fastest wave: one extremum or none.
    if (change) return add(bracketed(l, r));
    if (turns && (l.p > 0.0) == (l.dp < 0.0)) touch(l, r);
  }

  double bracketed(Sample l, Sample r) const {
    // Slopes at both ends are known: the first guess is the root of the line through the end nearer to zero.
    double t = std::abs(l.p) < std::abs(r.p) ? l.t - l.p / l.dp : r.t - r.p / r.dp;
    for (int i = 0; i < 60; ++i) {
      if (!(t > l.t && t < r.t)) t = 0.5 * (l.t + r.t);
      const auto v = p_.at(t);
      ((v.p < 0.0) == (l.p < 0.0) ? l : r) = {t, v.p, v.dp, v.ddp};
      const double next = t - v.p / v.dp;
      if (std::abs(next - t) < 1e-11 || r.t - l.t < 1e-15) return std::clamp(next, l.t, r.t);
      t = next;
    }
    return t;
  }

  /// An extremum towards zero: two roots, or a pair of complex ones close by.
  void touch(const Sample& l, const Sample& r) {
    double t = 0.5 * (l.t + r.t);
    TrigonometricPolynomial::Value v = p_.at(t);
    for (int i = 0; i < 6; ++i) {
      const double step = v.ddp != 0.0 ? -v.dp / v.ddp : 0.0;
      t = std::clamp(t + step, l.t, r.t);
      v = p_.at(t);
      if (std::abs(step) < 1e-13) break;
    }
    if ((v.p < 0.0) != (l.p < 0.0)) {
      add(bracketed(l, {t, v.p, v.dp, v.ddp}));
      add(bracketed({t, v.p, v.dp, v.ddp}, r));
      return;
    }
    const double apart = std::sqrt(std::abs(2.0 * v.p / v.ddp));
    if (std::abs(v.p) > noise_ && !(apart < 1e-6)) return;
    graze(t - apart);
    graze(t + apart);
  }

  const TrigonometricPolynomial& p_;
  double noise_, third_ = 0.0;  ///< |p'''| <= third_
  TrigonometricRoots roots_;
  std::array<double, TrigonometricRoots::most> grazing_;
  int grazingCount_ = 0;
};

}  // namespace

TrigonometricPolynomial::Value TrigonometricPolynomial::at(double t) const {
  const double c = std::cos(t), s = std::sin(t);
  double ck = 1.0, sk = 0.0;
  Value v{a[0], 0.0, 0.0};
  for (int k = 1; k <= degree; ++k) {
    const double next = ck * c - sk * s;
    sk = sk * c + ck * s;
    ck = next;
    const double wave = a[k] * ck + b[k] * sk;
    v.p += wave;
    v.dp += k * (b[k] * ck - a[k] * sk);
    v.ddp -= k * k * wave;
  }
  return v;
}

TrigonometricRoots realRoots(const TrigonometricPolynomial& p, double noise) {
  return RootFinder(p, noise).run();
}

}  // namespace gelenk
