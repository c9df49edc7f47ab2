#pragma once

#include <array>

namespace gelenk {

/// A real trigonometric polynomial p(t) = a_0 + sum_{k=1..degree} a_k cos kt + b_k sin kt, degree <= 8.
struct TrigonometricPolynomial {
  static constexpr int maxDegree = 8;
  int degree = 0;
  std::array<double, maxDegree + 1> a{}, b{};

  struct Value {
    double p, dp, ddp;
  };
  Value at(double t) const;
};

/// Real roots in [0, 2 pi), ascending but for the last `grazing`.
struct TrigonometricRoots {
  static constexpr int most = 24;
  int count = 0;
  int grazing = 0;  ///< how many of them, at the end of the list, are no proven roots: extrema that come
                    ///< within the noise of zero, where two roots merge
  int drowned = 0;  ///< points of the grid at which p is below the noise: roots may hide there
  std::array<double, most> t;
};

/// All real roots: sign changes on a grid of 16 points a degree and in the halves of any cell where the
/// derivative might vanish twice, then safeguarded Newton. noise: size of the errors of p; extrema that come
/// closer to zero than this, or whose pair of complex roots lies within 1e-6 of the real line, are reported
/// as grazing, once for each root of the pair. No allocation.
TrigonometricRoots realRoots(const TrigonometricPolynomial& p, double noise);

}  // namespace gelenk
