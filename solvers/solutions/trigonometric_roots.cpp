#include "solvers/solutions/trigonometric_roots.h"

#include <algorithm>
#include <cmath>

#include "solvers/serial/simd.h"

namespace gelenk {
namespace {

constexpr int maxGrid = 16 * TrigonometricPolynomial::maxDegree;

/// cos kt and sin kt at the points of the finest grid, k - 1 first; every grid used divides it.
struct Waves {
  double cosine[TrigonometricPolynomial::maxDegree][maxGrid],
      sine[TrigonometricPolynomial::maxDegree][maxGrid];
  Waves() {
    for (int k = 1; k <= TrigonometricPolynomial::maxDegree; ++k)
      for (int j = 0; j < maxGrid; ++j) {
        cosine[k - 1][j] = std::cos(2.0 * M_PI * (k * j % maxGrid) / maxGrid);
        sine[k - 1][j] = std::sin(2.0 * M_PI * (k * j % maxGrid) / maxGrid);
      }
  }
};
const Waves waves;

/// Value, slope and bend at `grid` points of the circle.
GELENK_SIMD_CLONES void onGrid(const TrigonometricPolynomial& p, int grid, double* value, double* slope,
                               double* bend) {
  const int step = maxGrid / grid;
  for (int j = 0; j < grid; ++j) value[j] = p.a[0], slope[j] = bend[j] = 0.0;
  for (int k = 1; k <= p.degree; ++k) {
    const double a = p.a[k], b = p.b[k];
    const double *cosine = waves.cosine[k - 1], *sine = waves.sine[k - 1];
    double own[2][maxGrid];
    if (step > 1) {
      for (int j = 0; j < grid; ++j) own[0][j] = cosine[j * step], own[1][j] = sine[j * step];
      cosine = own[0], sine = own[1];
    }
    for (int j = 0; j < grid; ++j) {
      const double wave = a * cosine[j] + b * sine[j];
      value[j] += wave;
      bend[j] -= k * k * wave;
      slope[j] += k * (b * cosine[j] - a * sine[j]);
    }
  }
}

struct Sample {
  double t, p, dp, ddp;
};

class RootFinder {
 public:
  RootFinder(const TrigonometricPolynomial& p, double noise) : p_(p), noise_(noise) {}

  TrigonometricRoots run() {
    const int n = p_.degree, grid = 16 * n;
    double value[maxGrid + 1], slope[maxGrid + 1], bend[maxGrid + 1];
    onGrid(p_, grid, value, slope, bend);
    for (int j = 0; j < grid; ++j) roots_.drowned += std::abs(value[j]) < noise_;
    for (int k = 1; k <= n; ++k) {
      const double k4 = k * k * k * k, size = k4 * std::sqrt(p_.a[k] * p_.a[k] + p_.b[k] * p_.b[k]);
      fourth_ += size;
      left_ += k4 * size / 40320.0;  // over 8!
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
  static constexpr int order = 8;

  /// p(t + x) = sum of d[m] x^m up to order - 1; what is left out is below left_ |x|^order.
  struct Series {
    double d[order];
  };
  Series seriesAt(double t) const {
    const double c = std::cos(t), s = std::sin(t);
    double ck = 1.0, sk = 0.0;
    Series series{{p_.a[0]}};
    for (int k = 1; k <= p_.degree; ++k) {
      const double next = ck * c - sk * s;
      sk = sk * c + ck * s;
      ck = next;
      double even = p_.a[k] * ck + p_.b[k] * sk, odd = k * (p_.b[k] * ck - p_.a[k] * sk);
      for (int m = 0; m < order; m += 2) {
        series.d[m] += even, series.d[m + 1] += odd;
        even *= -k * k, odd *= -k * k;
      }
    }
    double factorial = 1.0;
    for (int m = 2; m < order; ++m) series.d[m] /= factorial *= m;
    return series;
  }

  /// One cell, in which the slope must be shown to vanish at most once; halved where it is not. The series
  /// about its middle knows how small p is in this part of the circle.
  void cell(const Sample& l, const Sample& r, int depth) {
    const double h = r.t - l.t;
    const bool change = (l.p < 0.0) != (r.p < 0.0);
    // p is no farther from its chord than its bend allows, and the bend no farther from its own.
    const double curvature = std::max(std::abs(l.ddp), std::abs(r.ddp)) + 0.125 * h * h * fourth_;
    if (!change && std::min(std::abs(l.p), std::abs(r.p)) > 0.125 * curvature * h * h) return;
    const double middle = 0.5 * (l.t + r.t), x = 0.5 * h;
    const Series s = seriesAt(middle);
    double away = left_ * x,
           tilt = order * left_;  // what the terms after the first, and after the second, can do
    for (int m = order - 1; m > 0; --m) {
      away = (away + std::abs(s.d[m])) * x;
      tilt = tilt * x + (m > 1 ? m * std::abs(s.d[m]) : 0.0);
    }
    if (!change && std::abs(s.d[0]) > away) return;
    if (std::abs(s.d[1]) > tilt) {
      if (change) add(bracketed(l, r, middle + rootOf(s, x)));
      return;
    }
    if (depth < 5) {
      const Sample m{middle, s.d[0], s.d[1], 2.0 * s.d[2]};
      cell(l, m, depth + 1);
      cell(m, r, depth + 1);
      return;
    }
    // A cell of 1/512 of the spacing of the fastest wave: one extremum or none.
    if (change) return add(bracketed(l, r, middle));
    if ((l.dp < 0.0) != (r.dp < 0.0) && (l.p > 0.0) == (l.dp < 0.0)) touch(l, r);
  }

  /// Newton on the series, from its middle.
  static double rootOf(const Series& s, double within) {
    double x = 0.0;
    for (int i = 0; i < 5; ++i) {
      double value = s.d[order - 1], slope = 0.0;
      for (int m = order - 2; m >= 0; --m) slope = slope * x + value, value = value * x + s.d[m];
      const double step = value / slope;
      x = std::clamp(x - step, -within, within);
      if (std::abs(step) < 1e-9) break;
    }
    return x;
  }

  double bracketed(Sample l, Sample r, double t) const {
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
      add(bracketed(l, {t, v.p, v.dp, v.ddp}, 0.5 * (l.t + t)));
      add(bracketed({t, v.p, v.dp, v.ddp}, r, 0.5 * (t + r.t)));
      return;
    }
    const double apart = std::sqrt(std::abs(2.0 * v.p / v.ddp));
    if (std::abs(v.p) > noise_ && !(apart < 1e-6)) return;
    graze(t - apart);
    graze(t + apart);
  }

  const TrigonometricPolynomial& p_;
  double noise_, fourth_ = 0.0, left_ = 0.0;  ///< |p''''| <= fourth_; left_: see Series
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
