#include "solvers/solutions/shoulder_family.h"

#include <algorithm>
#include <cmath>

#include "solvers/solutions/lanes.h"
#include "solvers/solutions/planar_system.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using namespace lanes;
using Shape = ShoulderFamily::Shape;

constexpr double detour = 1.5;    ///< way between neighbours over their chord, at most
constexpr double inside = 1e-10;  ///< radians beyond a limit that count as within
constexpr double widened = 1e-6;  ///< radians by which intervals reach over the limits they are cut at
constexpr int mostNodes = 32;     ///< of an interval
constexpr int mostIntervals = 24;
constexpr double straight = 0.8;  ///< cosine between the tangents at its ends: it has no corner
constexpr double leaf = 0.25;     ///< radians: a chord this short is nearly straight

/// The wanted pose as the arm sees it.
struct Goal {
  double R[3][3];      ///< baseFromLast
  double shoulder[3];  ///< S in the last frame
};

/// What follows from the last joint's angle and the elbow: joint 4, and SW as seen from both sides.
template <class V>
struct Wrist {
  V c7, s7, c4, s4;
  V x6, y6, z6;    ///< S - W before the turn of joint 6 backwards
  V x5, y5, z5;    ///< S - W before joint 5 turns
  V rise, r2;      ///< of axis 5 over the plane of axis 6 and SW; square of (x6, y6)
  V discriminant;  ///< what must not be negative for joint 6
};

template <class V>
GELENK_INLINE Wrist<V> wristAt(const Shape& S, const Goal& g, V c7, V s7, double elbow) {
  Wrist<V> w;
  w.c7 = c7, w.s7 = s7;
  const V x = c7 * g.shoulder[0] - s7 * g.shoulder[1] - S.wrist[0],
          y = s7 * g.shoulder[0] + c7 * g.shoulder[1] - S.wrist[1];
  const double z = g.shoulder[2] - S.wrist[2];
  w.x6 = x;
  w.y6 = S.cosAlpha[6] * y - S.sinAlpha[6] * z;
  w.z6 = S.sinAlpha[6] * y + S.cosAlpha[6] * z;
  w.r2 = w.x6 * w.x6 + w.y6 * w.y6;
  const V opening = (S.rise - w.r2 - w.z6 * w.z6) * (1.0 / S.pull),
          across = elbow * root(V(1.0 - opening * opening));
  w.c4 = S.foldedCos * opening - S.foldedSin * across;
  w.s4 = S.foldedSin * opening + S.foldedCos * across;
  const V tx = w.c4 * S.shoulder[0] + w.s4 * S.shoulder[1] - S.forearm[0],
          ty = w.c4 * S.shoulder[1] - w.s4 * S.shoulder[0] - S.forearm[1];
  const double tz = S.shoulder[2] - S.forearm[2];
  w.x5 = tx;
  w.y5 = S.cosAlpha[4] * ty + S.sinAlpha[4] * tz;
  w.z5 = S.cosAlpha[4] * tz - S.sinAlpha[4] * ty;
  w.rise = (w.z5 - S.cosAlpha[5] * w.z6) * (1.0 / S.sinAlpha[5]);
  w.discriminant = w.r2 - w.rise * w.rise;
  return w;
}

template <class V>
struct Three {
  V x, y, z;
};
/// Rx(alpha) Rz(angle) v.
template <class V>
GELENK_INLINE Three<V> forth(const Three<V>& v, V c, V s, double ca, double sa) {
  const V x = c * v.x - s * v.y, y = s * v.x + c * v.y;
  return {x, ca * y - sa * v.z, sa * y + ca * v.z};
}
/// Rx(alpha)^T Rz(angle)^T v.
template <class V>
GELENK_INLINE Three<V> back(const Three<V>& v, V c, V s, double ca, double sa) {
  const V x = c * v.x + s * v.y, y = c * v.y - s * v.x;
  return {x, ca * y + sa * v.z, ca * v.z - sa * y};
}

/// The joints on one side of joint 6; the rotation that is left for the shoulder, as its third column m and
/// the x and y of its third row.
template <class V>
struct Forearm {
  V c[4], s[4];  ///< of joints 4 to 7
  Three<V> m;
  V rowX, rowY, cosine, sine;  ///< of joint 2
};

template <class V>
GELENK_INLINE Forearm<V> forearmAt(const Shape& S, const Goal& g, const Wrist<V>& w, double side) {
  Forearm<V> f;
  const V across = side * root(w.discriminant), over = 1.0 / (w.r2 + 1e-300);
  const V c6 = (w.y6 * w.rise - w.x6 * across) * over, s6 = (w.x6 * w.rise + w.y6 * across) * over;
  const V px = c6 * w.x6 - s6 * w.y6, py = s6 * w.x6 + c6 * w.y6;
  const V wy = S.cosAlpha[5] * py - S.sinAlpha[5] * w.z6;
  V c5 = w.x5 * px + w.y5 * wy, s5 = w.y5 * px - w.x5 * wy;
  const V size = 1.0 / (root(V(c5 * c5 + s5 * s5)) + 1e-300);
  c5 *= size, s5 *= size;
  Three<V> m{V{}, V{} + S.sinAlpha[3], V{} + S.cosAlpha[3]};
  m = back(m, w.c4, w.s4, S.cosAlpha[4], S.sinAlpha[4]);
  m = back(m, c5, s5, S.cosAlpha[5], S.sinAlpha[5]);
  m = back(m, c6, s6, S.cosAlpha[6], S.sinAlpha[6]);
  m = back(m, w.c7, w.s7, 1.0, 0.0);
  f.m = {g.R[0][0] * m.x + g.R[0][1] * m.y + g.R[0][2] * m.z,
         g.R[1][0] * m.x + g.R[1][1] * m.y + g.R[1][2] * m.z,
         g.R[2][0] * m.x + g.R[2][1] * m.y + g.R[2][2] * m.z};
  Three<V> r{V{} + g.R[2][0], V{} + g.R[2][1], V{} + g.R[2][2]};
  r = forth(r, w.c7, w.s7, S.cosAlpha[6], S.sinAlpha[6]);
  r = forth(r, c6, s6, S.cosAlpha[5], S.sinAlpha[5]);
  r = forth(r, c5, s5, S.cosAlpha[4], S.sinAlpha[4]);
  r = forth(r, w.c4, w.s4, S.cosAlpha[3], S.sinAlpha[3]);
  f.rowX = r.x, f.rowY = r.y;
  const double c2 = S.cosAlpha[1], s2 = S.sinAlpha[1], c3 = S.cosAlpha[2], s3 = S.sinAlpha[2];
  f.cosine = (c2 * c3 - f.m.z) * (1.0 / (s2 * s3));
  const V ny = -c2 * s3 * f.cosine - s2 * c3;
  f.sine = root(V(f.m.x * f.m.x + f.m.y * f.m.y - ny * ny)) * (1.0 / std::abs(s3));
  f.c[0] = w.c4, f.c[1] = c5, f.c[2] = c6, f.c[3] = w.c7;
  f.s[0] = w.s4, f.s[1] = s5, f.s[2] = s6, f.s[3] = w.s7;
  return f;
}

/// Joints 1 to 3 as vectors in the direction of their angles. shoulder: 0 or 1.
template <class V>
GELENK_INLINE void shoulderAt(const Shape& S, const Forearm<V>& f, int shoulder, V (&c)[3], V (&s)[3]) {
  const double c2 = S.cosAlpha[1], s2 = S.sinAlpha[1], c3 = S.cosAlpha[2], s3 = S.sinAlpha[2];
  const V up = shoulder == 0 ? f.sine : V(-f.sine), nx = s3 * up, rx = s2 * up;
  const V ny = -c2 * s3 * f.cosine - s2 * c3, ry = s2 * c3 * f.cosine + c2 * s3;
  c[0] = nx * f.m.x + ny * f.m.y, s[0] = nx * f.m.y - ny * f.m.x;
  c[1] = f.cosine, s[1] = up;
  c[2] = rx * f.rowX + ry * f.rowY, s[2] = ry * f.rowX - rx * f.rowY;
}

struct Limits {
  double near[7], lower[7], upper[7];
  bool wide[7];  ///< a whole turn or more: several images can be within
};

/// Squares of distances to `near`: by any images; by the ones chosen; by the ones chosen, but of joints that
/// turn a whole turn or more by any (these may have a nearer image within a little farther on).
template <class V>
struct Distances {
  V free, own, sure;
};

/// Moves q to the image nearest to `near` that is within limits, or to the nearest where none is. beyond: how
/// far the worst joint is from its range, by any image (negative: within).
template <class V>
GELENK_INLINE Distances<V> place(const Limits& limits, V (&q)[7], V& beyond) {
  Distances<V> square{V{}, V{}, V{}};
  beyond = V{} - 1e9;
  for (int i = 0; i < 7; ++i) {
    const V d = wrapped(V(q[i] - limits.near[i])), x = limits.near[i] + d;
    const V high = x - limits.upper[i], low = limits.lower[i] - x, out = larger(high, low);
    const V other = choose(high > 0.0, V(x - turn), V(x + turn));
    const V otherOut = larger(V(other - limits.upper[i]), V(limits.lower[i] - other));
    const auto changes = (out > 0.0) & (otherOut < out);
    // The other image only where it is within: else what is nearest goes on smoothly.
    q[i] = choose(changes & (otherOut <= inside), other, x);
    const V own = q[i] - limits.near[i];
    square.free += d * d;
    square.own += own * own;
    square.sure += limits.wide[i] ? d * d : own * own;
    beyond = larger(beyond, choose(changes, otherOut, out));
  }
  return square;
}

struct Interval {
  double middle, half, elbow;
  double at(double s) const { return middle - half * std::cos(s); }
};

/// cos s at the nodes of an interval, and the series of sine and cosine.
struct Chebyshev {
  double node[mostNodes / 4 + 1][mostNodes], sine[11], cosine[11];
  Chebyshev() {
    for (int count = 4; count <= mostNodes; count += 4)
      for (int k = 0; k < count; ++k) node[count / 4][k] = std::cos(M_PI * k / (count - 1));
    double factorial = 1.0;
    for (int i = 0; i < 11; ++i) {
      cosine[i] = factorial;
      sine[i] = factorial /= 2 * i + 1;
      factorial /= -(2 * i + 2);
    }
  }
  const double* at(int count) const { return node[count / 4]; }
};
const Chebyshev chebyshev;

/// cos and sin of t at the nodes s = pi k / (count - 1), count a multiple of four.
struct Nodes {
  double c[mostNodes], s[mostNodes];
  GELENK_INLINE Nodes(const Interval& interval, int count) {
    // By Taylor's series of half the way from the middle, which is below pi / 2, and the double angle.
    constexpr int terms = 11;
    const double c0 = std::cos(interval.middle), s0 = std::sin(interval.middle);
    const double* across = chebyshev.at(count);
    for (int k = 0; k < count; k += 4) {
      const Lanes x = -0.5 * interval.half * load(across + k), x2 = x * x;
      Lanes sine = Lanes{} + chebyshev.sine[terms - 1], cosine = Lanes{} + chebyshev.cosine[terms - 1];
      for (int i = terms - 2; i >= 0; --i)
        sine = sine * x2 + chebyshev.sine[i], cosine = cosine * x2 + chebyshev.cosine[i];
      sine *= x;
      const Lanes sine2 = 2.0 * sine * cosine, cosine2 = 1.0 - 2.0 * sine * sine;
      store(c + k, c0 * cosine2 - s0 * sine2);
      store(s + k, s0 * cosine2 + c0 * sine2);
    }
  }
};

GELENK_SIMD_CLONES void discriminants(const Shape& S, const Goal& g, const Interval& interval, int count,
                                      double* out) {
  const Nodes nodes(interval, count);
  for (int k = 0; k < count; k += 4)
    store(out + k, wristAt<Lanes>(S, g, load(nodes.c + k), load(nodes.s + k), interval.elbow).discriminant);
}

/// Samples of the four branches of an interval.
struct Samples {
  Interval interval;
  int count;
  double q[4][7][mostNodes], free2[4][mostNodes], own2[4][mostNodes], sure2[4][mostNodes],
      beyond[4][mostNodes];
  double bound[4][mostNodes];  ///< of the distance from node k to k + 1; infinite where it is beyond limits
  double sideOf(int branch) const { return branch < 2 ? 1.0 : -1.0; }
};

GELENK_SIMD_CLONES void fill(const Shape& S, const Goal& g, const Limits& limits, Samples& out) {
  const Nodes nodes(out.interval, out.count);
  for (int k = 0; k < out.count; k += 4) {
    const Wrist<Lanes> w = wristAt<Lanes>(S, g, load(nodes.c + k), load(nodes.s + k), out.interval.elbow);
    for (int side = 0; side < 2; ++side) {
      const Forearm<Lanes> forearm = forearmAt<Lanes>(S, g, w, side == 0 ? 1.0 : -1.0);
      Lanes wrist[4];
      for (int i = 0; i < 4; ++i) wrist[i] = angleOf(forearm.s[i], forearm.c[i]) - S.theta[3 + i];
      for (int shoulder = 0; shoulder < 2; ++shoulder) {
        const int b = 2 * side + shoulder;
        Lanes q[7], c[3], s[3], beyond;
        shoulderAt<Lanes>(S, forearm, shoulder, c, s);
        for (int i = 0; i < 3; ++i) q[i] = angleOf(s[i], c[i]) - S.theta[i];
        for (int i = 0; i < 4; ++i) q[3 + i] = wrist[i];
        const Distances<Lanes> square = place<Lanes>(limits, q, beyond);
        for (int i = 0; i < 7; ++i) store(out.q[b][i] + k, q[i]);
        store(out.free2[b] + k, square.free);
        store(out.own2[b] + k, square.own);
        store(out.sure2[b] + k, square.sure);
        store(out.beyond[b] + k, beyond);
      }
    }
  }
}

/// What a stretch between two points cannot come below: the sum of two distances, less the way, over two.
/// sameImage: the joints of one image each are neighbours as they are. Beyond the limits a point's image may
/// be another than its neighbour's within; then nothing is known but the distances by any image.
GELENK_INLINE double stretchBound(double free, double sure, double beyond, double chord, bool sameImage) {
  const double way = detour * chord;
  return beyond > way ? INFINITY : 0.5 * ((sameImage ? sure : free) - way);
}

/// Bounds of the stretches between neighbours.
GELENK_SIMD_CLONES void bound(const Limits& limits, Samples& out) {
  for (int b = 0; b < 4; ++b) {
    double free[mostNodes], sure[mostNodes], chord2[mostNodes] = {}, raw2[mostNodes] = {};
    for (int k = 0; k < out.count; k += 4) {
      store(free + k, root(load(out.free2[b] + k)));
      store(sure + k, root(load(out.sure2[b] + k)));
    }
    for (int i = 0; i < 7; ++i) {
      const double* q = out.q[b][i];
      for (int k = 0; k + 4 < out.count; k += 4) {
        const Lanes step = load(q + k + 1) - load(q + k), d = wrapped(step);
        store(chord2 + k, load(chord2 + k) + (d * d));
        store(raw2 + k, load(raw2 + k) + (limits.wide[i] ? d * d : step * step));
      }
      for (int k = out.count - 4; k + 1 < out.count; ++k) {
        const double step = q[k + 1] - q[k], d = wrapped(step);
        chord2[k] += d * d;
        raw2[k] += limits.wide[i] ? d * d : step * step;
      }
    }
    for (int k = 0; k + 1 < out.count; ++k)
      out.bound[b][k] =
          stretchBound(free[k] + free[k + 1], sure[k] + sure[k + 1], out.beyond[b][k] + out.beyond[b][k + 1],
                       std::sqrt(chord2[k]), raw2[k] < chord2[k] + 1.0);
  }
}

/// Root of f in [a, b], where it has values of different signs, to `width` or to a value of `small`.
template <class F>
double rootBetween(const F& f, double a, double fa, double b, double fb, double width, double small = 0.0) {
  for (int k = 0; k < 60 && std::abs(b - a) > width; ++k) {
    double x = (fa * b - fb * a) / (fa - fb);
    if (!(x > std::min(a, b) && x < std::max(a, b)) || k % 8 == 7) x = 0.5 * (a + b);
    const double fx = f(x);
    if (std::abs(fx) <= small) return x;
    if ((fx < 0.0) == (fb < 0.0)) {
      fa *= 0.5;  // Illinois: the end that stays counts less
    } else {
      a = b, fa = fb;
    }
    b = x, fb = fx;
  }
  return b;
}

struct Intervals {
  int count = 0;
  std::array<Interval, mostIntervals> list;
  void add(double from, double to, double elbow) {
    if (count < mostIntervals && to > from) list[count++] = {0.5 * (from + to), 0.5 * (to - from), elbow};
  }
};

int nodesFor(double half) { return half < 0.3 ? 12 : half < 0.8 ? 16 : half < 1.3 ? 24 : 32; }

/// The parts of [from, to] where joint 6 has solutions.
void split(const Shape& S, const Goal& g, double from, double to, double elbow, Intervals& out) {
  const Interval whole{0.5 * (from + to), 0.5 * (to - from), elbow};
  const int n = nodesFor(whole.half);
  double value[mostNodes];
  discriminants(S, g, whole, n, value);
  const double h = M_PI / (n - 1);
  const auto f = [&](double s) {
    const double t = whole.at(s);
    return wristAt<double>(S, g, std::cos(t), std::sin(t), elbow).discriminant;
  };
  double cut[2 * mostNodes];
  int cuts = 0;
  for (int k = 0; k < n; ++k) {
    // An extremum that the samples straddle may reach over zero.
    const int l = std::max(k - 1, 0), r = std::min(k + 1, n - 1);
    const double own = value[k], left = value[l], right = value[r], sign = own < 0.0 ? 1.0 : -1.0;
    const double near = -sign * own, farLeft = -sign * left, farRight = -sign * right;
    if ((k == 0 || near < farLeft) && near <= farRight && near < std::max(farLeft, farRight) - near) {
      double a = l * h, b = r * h, m = k * h, fm = own;
      constexpr double golden = 0.381966;
      for (int round = 0; round < 40 && b - a > 1e-9 && sign * fm < 0.0; ++round) {
        const double x = b - m > m - a ? m + golden * (b - m) : m - golden * (m - a), fx = f(x);
        const bool better = sign * fx > sign * fm;
        (better == (x > m) ? a : b) = better ? m : x;
        if (better) m = x, fm = fx;
      }
      if (sign * fm > 0.0) {
        cut[cuts++] = rootBetween(f, l * h, left, m, fm, 1e-15);
        cut[cuts++] = rootBetween(f, m, fm, r * h, right, 1e-15);
        continue;
      }
    }
    if (k + 1 < n && (own < 0.0) != (right < 0.0))
      cut[cuts++] = rootBetween(f, k * h, own, (k + 1) * h, right, 1e-15);
  }
  std::sort(cut, cut + cuts);
  double begin = 0.0;
  bool valid = value[0] >= 0.0;
  for (int c = 0; c <= cuts; ++c) {
    const double end = c < cuts ? cut[c] : M_PI;
    if (valid) out.add(whole.at(begin), whole.at(end), elbow);
    begin = end, valid = !valid;
  }
}

/// Where the last joint is within its limits and joint 4 exists, within its limits, on this side.
void intervalsOf(const Shape& S, const Goal& g, const Limits& limits, double elbow, Intervals& out) {
  // The opening of the elbow, in [0, pi], as joint 4's limits allow.
  const double folded = std::atan2(S.foldedSin, S.foldedCos);
  double low = limits.lower[3] + S.theta[3] - folded - widened,
         high = limits.upper[3] + S.theta[3] - folded + widened;
  if (elbow < 0.0) std::swap(low, high), low = -low, high = -high;
  double least = M_PI, most = 0.0;
  if (high - low >= turn) {
    least = 0.0, most = M_PI;
  } else {
    const double shift = turn * std::floor(low / turn);
    for (const double k : {0.0, turn}) {
      const double a = std::max(low - shift - k, 0.0), b = std::min(high - shift - k, M_PI);
      if (a <= b) least = std::min(least, a), most = std::max(most, b);
    }
  }
  if (least > most) return;
  const double lowest = std::cos(most), highest = std::cos(least);
  const double *s = g.shoulder, *w = S.wrist;
  double square = 0.0;
  for (int i = 0; i < 3; ++i) square += s[i] * s[i] + w[i] * w[i];
  const planar::Wave opening{(S.rise - square + 2.0 * s[2] * w[2]) / S.pull,
                             2.0 * (s[0] * w[0] + s[1] * w[1]) / S.pull,
                             2.0 * (s[0] * w[1] - s[1] * w[0]) / S.pull};
  double at[20];
  int cuts = 0;
  for (const double level : {lowest, highest}) {
    planar::Turn t[2];
    const int n = planar::zeros({opening.a - level, opening.b, opening.c}, t);
    for (int k = 0; k < n; ++k) at[cuts++] = t[k].angle();
  }
  const double first = limits.lower[6] + S.theta[6] - widened, last = limits.upper[6] + S.theta[6] + widened;
  const bool ends = last - first < turn;
  if (ends) at[cuts++] = wrapped(first), at[cuts++] = wrapped(last);
  if (cuts < 2) at[cuts++] = -1.0, at[cuts++] = 2.0;
  std::sort(at, at + cuts);
  for (int k = 0; k < cuts; ++k) {
    double from = at[k], to = k + 1 < cuts ? at[k + 1] : at[0] + turn;
    const double middle = 0.5 * (from + to), x = opening.at(planar::turnOf(middle));
    if (x < lowest - 1e-12 || x > highest + 1e-12) continue;
    if (ends) {
      const double beyond = middle - first;
      if (beyond - turn * std::floor(beyond / turn) > last - first) continue;
    }
    if (to - from > 4.0) split(S, g, from, middle, elbow, out), from = middle;
    split(S, g, from, to, elbow, out);
  }
}

}  // namespace

std::optional<ShoulderFamily> ShoulderFamily::of(const SerialChain& chain) {
  if (chain.n != 7 || chain.hasPrismatic) return std::nullopt;
  ShoulderFamily family;
  family.chain_ = chain;
  family.scale_ = chain.length / 3.0;
  Shape& S = family.shape_;
  const ChainConstants& C = chain.constants;
  for (int i = 0; i < 7; ++i) {
    S.a[i] = C.a[i] / family.scale_, S.d[i] = C.d[i] / family.scale_;
    S.cosAlpha[i] = C.cosAlpha[i], S.sinAlpha[i] = C.sinAlpha[i], S.theta[i] = C.theta[i];
    family.lower_[i] = std::max(chain.lower[i], -1e6), family.upper_[i] = std::min(chain.upper[i], 1e6);
  }
  family.misfit_ = std::max({std::abs(S.a[1]), std::abs(S.d[1]), std::abs(S.a[2]), std::abs(S.a[5])});
  if (family.misfit_ > 1e-5) return std::nullopt;
  for (const int i : {1, 2, 5})
    if (std::abs(S.sinAlpha[i]) < 1e-3) return std::nullopt;
  S.a[1] = S.d[1] = S.a[2] = S.a[5] = 0.0;
  const double wrist[3] = {-S.a[6], -S.d[5] * S.sinAlpha[6], -S.d[6] - S.d[5] * S.cosAlpha[6]};
  const double shoulder[3] = {-S.a[3], -S.d[2] * S.sinAlpha[3], -S.d[3] - S.d[2] * S.cosAlpha[3]};
  const double forearm[3] = {S.a[4], -S.sinAlpha[4] * S.d[4], S.cosAlpha[4] * S.d[4]};
  std::copy_n(wrist, 3, S.wrist), std::copy_n(shoulder, 3, S.shoulder), std::copy_n(forearm, 3, S.forearm);
  const double along = shoulder[0] * forearm[0] + shoulder[1] * forearm[1],
               across = shoulder[1] * forearm[0] - shoulder[0] * forearm[1], size = std::hypot(along, across);
  if (size < 1e-6) return std::nullopt;
  S.pull = 2.0 * size, S.foldedCos = along / size, S.foldedSin = across / size;
  S.rise = -2.0 * shoulder[2] * forearm[2];
  for (int i = 0; i < 3; ++i) S.rise += shoulder[i] * shoulder[i] + forearm[i] * forearm[i];
  return family;
}

namespace {

Goal goalOf(const SerialChain& chain, double scale, const Isometry3d& worldFromTip) {
  const Isometry3d last = chain.worldFromBase.inverse(Eigen::Isometry) * worldFromTip *
                          chain.lastFromTip.inverse(Eigen::Isometry);
  Goal g;
  const Vector3d shoulder = -(last.linear().transpose() * last.translation()) / scale;
  for (int i = 0; i < 3; ++i) {
    g.shoulder[i] = shoulder[i];
    for (int j = 0; j < 3; ++j) g.R[i][j] = last.linear()(i, j);
  }
  return g;
}

/// Unit tangent of the self-motion, in either sense: joints 4 to 7 keep S where it is, the shoulder makes up
/// for their turn.
Vector7d tangentAt(const Shape& S, const double* cosine, const double* sine) {
  Vector3d axis[7], moment[7];
  Matrix3d R = Matrix3d::Identity();
  Vector3d p = Vector3d::Zero();
  for (int i = 0; i < 7; ++i) {
    p += R.col(0) * S.a[i];
    const Vector3d y = S.cosAlpha[i] * R.col(1) + S.sinAlpha[i] * R.col(2);
    axis[i] = S.cosAlpha[i] * R.col(2) - S.sinAlpha[i] * R.col(1);
    p += S.d[i] * axis[i];
    moment[i] = p.cross(axis[i]);  // axis x (S - p), S the origin
    const double c = cosine[i], s = sine[i];
    const Vector3d x = R.col(0);
    R.col(0) = c * x + s * y;
    R.col(1) = c * y - s * x;
    R.col(2) = axis[i];
  }
  const auto det = [](const Vector3d& a, const Vector3d& b, const Vector3d& c) { return a.dot(b.cross(c)); };
  Vector7d t;
  t[3] = det(moment[4], moment[5], moment[6]);
  t[4] = -det(moment[3], moment[5], moment[6]);
  t[5] = det(moment[3], moment[4], moment[6]);
  t[6] = -det(moment[3], moment[4], moment[5]);
  const Vector3d w = axis[3] * t[3] + axis[4] * t[4] + axis[5] * t[5] + axis[6] * t[6];
  t.tail<4>() *= det(axis[0], axis[1], axis[2]);
  t[0] = -det(w, axis[1], axis[2]);
  t[1] = -det(axis[0], w, axis[2]);
  t[2] = -det(axis[0], axis[1], w);
  return t / (t.norm() + 1e-300);
}

}  // namespace

struct ShoulderFamily::Search {
  const Shape& S;
  const Goal& goal;
  const Limits& limits;
  double best = INFINITY;
  Vector7d q = Vector7d::Zero();

  struct Point {
    double s;
    Vector7d q;
    double free, own, sure, beyond;  ///< see Distances; beyond the limits
    bool turned = false;             ///< cosine and sine of theta + q are known
    double cosine[7], sine[7];
    bool within() const { return beyond <= inside; }
  };
  struct Branch {
    Interval interval;
    double side;
    int shoulder;
  };

  Point finish(Point p) const {
    double q[7];
    for (int i = 0; i < 7; ++i) q[i] = p.q[i];
    const Distances<double> square = place<double>(limits, q, p.beyond);
    p.q = Vector7d::Map(q);
    p.free = std::sqrt(square.free), p.own = std::sqrt(square.own), p.sure = std::sqrt(square.sure);
    return p;
  }
  Point at(const Branch& b, double s) const {
    const double t = b.interval.at(s);
    const Wrist<double> w = wristAt<double>(S, goal, std::cos(t), std::sin(t), b.interval.elbow);
    const Forearm<double> forearm = forearmAt<double>(S, goal, w, b.side);
    double cosine[3], sine[3];
    shoulderAt<double>(S, forearm, b.shoulder, cosine, sine);
    Point p;
    p.s = s;
    p.turned = true;
    for (int i = 0; i < 7; ++i) {
      p.cosine[i] = i < 3 ? cosine[i] : forearm.c[i - 3], p.sine[i] = i < 3 ? sine[i] : forearm.s[i - 3];
      p.q[i] = angleOf(p.sine[i], p.cosine[i]) - S.theta[i];
    }
    for (const int i : {0, 2}) {
      const double over = 1.0 / (std::sqrt(cosine[i] * cosine[i] + sine[i] * sine[i]) + 1e-300);
      p.cosine[i] *= over, p.sine[i] *= over;
    }
    return finish(p);
  }
  /// Node k of a branch's samples.
  Point at(const Samples& samples, int branch, int k) const {
    Point p;
    p.s = M_PI * k / (samples.count - 1);
    for (int i = 0; i < 7; ++i) p.q[i] = samples.q[branch][i][k];
    p.free = std::sqrt(samples.free2[branch][k]), p.own = std::sqrt(samples.own2[branch][k]);
    p.sure = std::sqrt(samples.sure2[branch][k]);
    p.beyond = samples.beyond[branch][k];
    return p;
  }
  void offer(const Point& p) {
    if (p.within() && p.own < best) best = p.own, q = p.q;
  }

  /// Unit tangent, continuous on a branch, ends included; where its last entry is positive it points on along
  /// the branch. slope: derivative of half the square of the distance.
  struct Course {
    Vector7d tangent;
    double slope;
  };
  Course courseAt(const Point& p) const {
    double c[7], s[7];
    for (int i = 0; i < 7 && !p.turned; ++i)
      c[i] = std::cos(p.q[i] + S.theta[i]), s[i] = std::sin(p.q[i] + S.theta[i]);
    const Vector7d tangent = p.turned ? tangentAt(S, p.cosine, p.sine) : tangentAt(S, c, s);
    return {tangent, tangent.dot(p.q - Vector7d::Map(limits.near))};
  }

  struct Chord {
    double length;
    bool sameImage;  ///< of every joint
    double bound;
  };
  Chord chordOf(const Point& a, const Point& b) const {
    double sum = 0.0, raw = 0.0, narrow = 0.0;
    for (int i = 0; i < 7; ++i) {
      const double step = b.q[i] - a.q[i], d = wrapped(step);
      sum += d * d;
      raw += step * step;
      narrow += limits.wide[i] ? d * d : step * step;
    }
    const double length = std::sqrt(sum);
    return {length, raw < sum + 1.0,
            stretchBound(a.free + b.free, a.sure + b.sure, a.beyond + b.beyond, length, narrow < sum + 1.0)};
  }

  void search(const Branch& branch, const Point& a, const Point& b, int depth) {
    const Chord chord = chordOf(a, b);
    if (chord.bound > best) return;
    const bool both = a.within() && b.within();
    if (chord.length < leaf && (both ? chord.sameImage : a.within() || b.within())) {
      const Course onA = courseAt(a), onB = courseAt(b);
      if (onA.tangent.dot(onB.tangent) > straight || chord.length < 1e-3)
        return settle(branch, a, onA, b, onB);
    }
    // Where a joint changes to another image within limits, the border is found by halving alone.
    if (chord.length < (both ? 1e-8 : 1e-4) || depth > 40) return;
    const Point m = at(branch, 0.5 * (a.s + b.s));
    offer(m);
    if (a.free < b.free) {
      search(branch, a, m, depth + 1);
      search(branch, m, b, depth + 1);
    } else {
      search(branch, m, b, depth + 1);
      search(branch, a, m, depth + 1);
    }
  }

  /// A short stretch with one end within limits at least: the point in it where the distance is least, and
  /// where it leaves the limits.
  void settle(const Branch& branch, const Point& a, const Course& onA, const Point& b, const Course& onB) {
    if (a.within() && b.within()) return between(branch, a, onA, b, onB);
    const Point border = a.within() ? borderOf(branch, a, b) : borderOf(branch, b, a);
    offer(border);
    if (a.within())
      between(branch, a, onA, border, courseAt(border));
    else
      between(branch, border, courseAt(border), b, onB);
  }
  /// Where the stretch leaves the limits, to less than counts as within.
  Point borderOf(const Branch& branch, const Point& in, const Point& out) {
    Point border = in;
    const auto f = [&](double s) {
      border = at(branch, s);
      return border.beyond - 0.5 * inside;
    };
    rootBetween(f, in.s, in.beyond - 0.5 * inside, out.s, out.beyond - 0.5 * inside, 1e-15, 0.4 * inside);
    return border;
  }
  void between(const Branch& branch, const Point& a, const Course& onA, const Point& b, const Course& onB) {
    const double lastA = onA.tangent[6], lastB = onB.tangent[6];
    const double on = (std::abs(lastA) > std::abs(lastB) ? lastA : lastB) > 0.0 ? 1.0 : -1.0;
    if (!(on * onA.slope < 0.0 && on * onB.slope > 0.0)) return;
    Point m = a;
    const auto f = [&](double s) {
      m = at(branch, s);
      offer(m);
      return courseAt(m).slope;
    };
    rootBetween(f, a.s, onA.slope, b.s, onB.slope, 1e-10, 1e-9);
    if (m.within()) return;
    offer(borderOf(branch, a, m));
    offer(borderOf(branch, b, m));
  }
};

bool ShoulderFamily::nearest(const Isometry3d& worldFromTip, const Vector7d& near, bool withLimits,
                             Vector7d& best) const {
  const Goal goal = goalOf(chain_, scale_, worldFromTip);
  Limits limits;
  for (int i = 0; i < 7; ++i) {
    limits.near[i] = near[i];
    limits.lower[i] = withLimits ? lower_[i] : -1e6, limits.upper[i] = withLimits ? upper_[i] : 1e6;
    limits.wide[i] = limits.upper[i] - limits.lower[i] >= turn;
  }
  Intervals intervals;
  for (const double elbow : {1.0, -1.0}) intervalsOf(shape_, goal, limits, elbow, intervals);
  Samples samples[mostIntervals];
  struct Stretch {
    double bound;
    short interval, branch, node;
  };
  Stretch stretch[mostIntervals * 4 * mostNodes];
  int stretches = 0;
  Search search{.S = shape_, .goal = goal, .limits = limits};
  for (int i = 0; i < intervals.count; ++i) {
    Samples& s = samples[i];
    s.interval = intervals.list[i];
    s.count = nodesFor(s.interval.half);
    fill(shape_, goal, limits, s);
    bound(limits, s);
    for (int b = 0; b < 4; ++b)
      for (int k = 0; k < s.count; ++k)
        if (s.beyond[b][k] <= inside && s.own2[b][k] < search.best * search.best)
          search.offer(search.at(s, b, k));
  }
  for (int i = 0; i < intervals.count; ++i)
    for (int b = 0; b < 4; ++b)
      for (int k = 0; k + 1 < samples[i].count; ++k)
        if (samples[i].bound[b][k] < INFINITY && samples[i].bound[b][k] <= search.best)
          stretch[stretches++] = {samples[i].bound[b][k], static_cast<short>(i), static_cast<short>(b),
                                  static_cast<short>(k)};
  std::sort(stretch, stretch + stretches,
            [](const Stretch& a, const Stretch& b) { return a.bound < b.bound; });
  for (int k = 0; k < stretches; ++k) {
    if (stretch[k].bound > search.best) break;
    const Samples& s = samples[stretch[k].interval];
    const int b = stretch[k].branch;
    const int node = stretch[k].node;
    search.search({s.interval, s.sideOf(b), b % 2}, search.at(s, b, node), search.at(s, b, node + 1), 0);
  }
  if (!std::isfinite(search.best)) return false;
  best = search.q;
  if (withLimits) best = best.cwiseMax(lower_).cwiseMin(upper_);
  return true;
}

void ShoulderFamily::sample(const Isometry3d& worldFromTip, double step, std::vector<Vector7d>& out) const {
  const Goal goal = goalOf(chain_, scale_, worldFromTip);
  Limits limits;
  for (int i = 0; i < 7; ++i) {
    limits.lower[i] = lower_[i], limits.upper[i] = upper_[i];
    limits.wide[i] = upper_[i] - lower_[i] >= turn;
    limits.near[i] = std::abs(lower_[i]) + std::abs(upper_[i]) < 1e6 ? 0.5 * (lower_[i] + upper_[i]) : 0.0;
  }
  Intervals intervals;
  for (const double elbow : {1.0, -1.0}) intervalsOf(shape_, goal, limits, elbow, intervals);
  const Search search{.S = shape_, .goal = goal, .limits = limits};
  Samples s;
  for (int i = 0; i < intervals.count; ++i) {
    s.interval = intervals.list[i];
    s.count = nodesFor(s.interval.half);
    fill(shape_, goal, limits, s);
    for (int b = 0; b < 4; ++b) {
      Search::Point last{};
      for (int k = 0; k < s.count; ++k) {
        const Search::Point p = search.at(s, b, k);
        const double chord = k > 0 ? search.chordOf(last, p).length : 0.0;
        if (k > 0 && chord > step && last.beyond + p.beyond < chord) {
          const int more = std::min(static_cast<int>(chord / step), 7);
          for (int m = 1; m <= more; ++m) {
            const Search::Point between =
                search.at({s.interval, s.sideOf(b), b % 2}, last.s + (p.s - last.s) * m / (more + 1.0));
            if (between.within()) out.push_back(between.q.cwiseMax(lower_).cwiseMin(upper_));
          }
        }
        if (p.within()) out.push_back(p.q.cwiseMax(lower_).cwiseMin(upper_));
        last = p;
      }
    }
  }
}

}  // namespace gelenk
