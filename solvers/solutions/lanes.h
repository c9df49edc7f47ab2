#pragma once

#include <cmath>

#include "solvers/serial/simd.h"

/// One formula for a number and for four of them side by side. Files that use it are compiled without errno
/// in square roots; functions that take vectors are inlined into ones marked GELENK_SIMD_CLONES.
namespace gelenk::lanes {

inline constexpr double turn = 2.0 * M_PI;

/// Four numbers side by side; in memory neighbours, of any alignment.
typedef double Lanes __attribute__((vector_size(32)));
GELENK_INLINE Lanes load(const double* from) {
  Lanes v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}
GELENK_INLINE void store(double* to, Lanes v) { __builtin_memcpy(to, &v, sizeof v); }

typedef decltype(Lanes{} < Lanes{}) Mask;  ///< of four long integers, 0 or -1
GELENK_INLINE double choose(bool mask, double yes, double no) { return mask ? yes : no; }
GELENK_INLINE Lanes choose(Mask mask, Lanes yes, Lanes no) { return mask ? yes : no; }
GELENK_INLINE Mask choose(Mask mask, Mask yes, Mask no) { return (mask & yes) | (~mask & no); }
GELENK_INLINE bool any(bool mask) { return mask; }
GELENK_INLINE bool any(Mask mask) { return (mask[0] | mask[1] | mask[2] | mask[3]) != 0; }
GELENK_INLINE double magnitude(double x) { return std::abs(x); }
GELENK_INLINE Lanes magnitude(Lanes x) { return x < 0.0 ? -x : x; }
/// Square root; 0 below 0.
GELENK_INLINE double root(double x) { return std::sqrt(x > 0.0 ? x : 0.0); }
GELENK_INLINE Lanes root(Lanes x) {
  x = x > 0.0 ? x : Lanes{};
  return Lanes{std::sqrt(x[0]), std::sqrt(x[1]), std::sqrt(x[2]), std::sqrt(x[3])};
}
GELENK_INLINE double angleOf(double y, double x) { return std::atan2(y, x); }
/// atan2 to 1e-15: reduced to |z| < tan(pi / 8), where a polynomial in z^2 (interpolated at Chebyshev's
/// points) is good to 1.2e-17.
GELENK_INLINE Lanes angleOf(Lanes y, Lanes x) {
  constexpr double c[] = {1,
                          -0.33333333333328441,
                          0.19999999998855095,
                          -0.14285714180973505,
                          0.11111106180335059,
                          -0.090907730725334771,
                          0.076899534744669401,
                          -0.066402338338738695,
                          0.056883491886823789,
                          -0.043480533438954326,
                          0.021135400583752725};
  const Lanes ax = x < 0.0 ? -x : x, ay = y < 0.0 ? -y : y;
  const auto steep = ay > ax;
  const Lanes big = steep ? ay : ax, small = steep ? ax : ay;
  const auto tilted = small > big * 0.41421356237309503;
  const Lanes below = tilted ? big + small : big, z = (tilted ? small - big : small) / (below + 1e-300),
              z2 = z * z;
  Lanes p = Lanes{} + c[10];
  for (int k = 9; k >= 0; --k) p = p * z2 + c[k];
  Lanes angle = z * p + (tilted ? Lanes{} + M_PI / 4 : Lanes{});
  angle = steep ? M_PI / 2 - angle : angle;
  angle = x < 0.0 ? M_PI - angle : angle;
  return y < 0.0 ? -angle : angle;
}
GELENK_INLINE double larger(double a, double b) { return a > b ? a : b; }
GELENK_INLINE Lanes larger(Lanes a, Lanes b) { return a > b ? a : b; }
/// To the nearest whole number, by adding one that leaves no room for a fraction; |x| < 2^51.
template <class V>
GELENK_INLINE V nearestWhole(V x) {
  constexpr double magic = 6755399441055744.0;  // 1.5 2^52
  return (x + magic) - magic;
}
template <class V>
GELENK_INLINE V wholeAbove(V x) {
  const V near = nearestWhole(x);
  return choose(near < x, V(near + 1.0), near);
}
/// By whole turns to [-pi, pi].
template <class V>
GELENK_INLINE V wrapped(V x) {
  return x - turn * nearestWhole(V(x * (1.0 / turn)));
}

/// An angle by whole turns to the image in [lower, upper] nearest to the reference; where there is none
/// (false), to the nearest.
template <class V>
GELENK_INLINE auto toNearestImage(V& angle, double lower, double upper, double reference) {
  constexpr double inside = 1e-9;  // radians beyond a limit that count as on it
  angle -= turn * nearestWhole(V((angle - reference) * (1.0 / turn)));
  V x = angle;
  x = choose(x < lower, V(x + turn * wholeAbove(V((lower - x - inside) * (1.0 / turn)))), x);
  x = choose(x > upper, V(x - turn * wholeAbove(V((x - upper - inside) * (1.0 / turn)))), x);
  const auto within = (x >= lower - inside) & (x <= upper + inside);
  x = choose(x < lower, V(V{} + lower), choose(x > upper, V(V{} + upper), x));
  angle = choose(within, x, angle);
  return within;
}

}  // namespace gelenk::lanes
