// The inner loops of the flagship, for one instruction set: include with GELENK_KERNEL_FUNCTION (the name of
// the function that hands them out) defined. Everything has internal linkage: nothing compiled here may leak into other files.
//
// One template serves a single problem (V = double) and eight side by side (V = Lanes, one problem or start a lane).
// An iteration is Levenberg-Marquardt with damping proportional to the error (Chan and Lawrence 1988), columns of joints that
// stand at a wall and are pushed against it taken out (active set), and the Cayley rotation error
// 2 tan(theta/2) axis, which needs no trigonometry and has no wrong half turn.

#include "solvers/serial_kernel.h"

#if defined(__AVX2__) || defined(__AVX512F__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#endif

#define GELENK_INLINE static inline __attribute__((always_inline))
#ifdef __clang__
#define GELENK_UNROLL _Pragma("clang loop unroll(full)")
#else
#define GELENK_UNROLL _Pragma("GCC unroll 8")
#endif

namespace gelenk {
namespace {

/// As many lanes as a register holds; eight lanes are eight, four and two of them at a time.
#if defined(__AVX512F__)
constexpr int width = 8;
#elif defined(__AVX2__)
constexpr int width = 4;
#else
constexpr int width = 2;
#endif
typedef double Lanes __attribute__((vector_size(8 * width)));
typedef decltype(Lanes{} < Lanes{}) LaneMask;
typedef unsigned long LaneBits __attribute__((vector_size(8 * width)));

template <typename V>
struct Of;
template <>
struct Of<double> {
  using Bits = unsigned long;
  using Mask = bool;
};
template <>
struct Of<Lanes> {
  using Bits = LaneBits;
  using Mask = LaneMask;
};

GELENK_INLINE double select(bool mask, double yes, double no) { return mask ? yes : no; }
GELENK_INLINE Lanes select(LaneMask mask, Lanes yes, Lanes no) { return mask ? yes : no; }
template <typename V>
GELENK_INLINE V larger(V a, V b) {
  return select(a > b, a, b);
}
template <typename V>
GELENK_INLINE V smaller(V a, V b) {
  return select(a < b, a, b);
}
template <typename V>
GELENK_INLINE V fill(double x) {
  if constexpr (sizeof(V) == sizeof(double))
    return x;
  else
    return Lanes{} + x;
}
template <typename V>
GELENK_INLINE V magnitude(V a) {
  using Bits = typename Of<V>::Bits;
  return __builtin_bit_cast(V, __builtin_bit_cast(Bits, a) & 0x7fffffffffffffffUL);
}
template <typename V>
GELENK_INLINE V load(const double* from) {
  V v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}
template <typename V>
GELENK_INLINE void store(V v, double* to) {
  __builtin_memcpy(to, &v, sizeof v);
}

GELENK_INLINE Lanes widen(const float* from) {
  double wide[width];
  for (int l = 0; l < width; ++l) wide[l] = from[l];
  return load<Lanes>(wide);
}

/// One bit a lane.
GELENK_INLINE int bits(LaneMask mask) {
#if defined(__AVX512DQ__)
  return _mm512_movepi64_mask(__builtin_bit_cast(__m512i, mask));
#elif defined(__AVX2__)
  return _mm256_movemask_pd(__builtin_bit_cast(__m256d, mask));
#else
  return (mask[0] & 1) | (mask[1] & 2);
#endif
}

/// Sine and cosine to about 1e-15 for |x| < 1e5: reduction by multiples of pi/2 in two parts (the first has 33 bits, so that its
/// multiples are exact), then Taylor polynomials on [-pi/4, pi/4].
template <typename V>
GELENK_INLINE void sineCosine(V x, V& sine, V& cosine) {
  using Bits = typename Of<V>::Bits;
  constexpr double roundToInteger = 6755399441055744.0;  // 1.5 * 2^52: the sum's low bits hold the integer
  constexpr double halfPiHigh = 0x1.921fb544p+0, halfPiLow = 0x1.0b4611a626331p-34;
  const V shifted = x * 0.63661977236758134308 + roundToInteger;
  const Bits k = __builtin_bit_cast(Bits, shifted);
  const V turns = shifted - roundToInteger;
  const V r = (x - turns * halfPiHigh) - turns * halfPiLow;
  const V r2 = r * r;
  V s = fill<V>(-1.0 / 1307674368000.0);
  s = s * r2 + 1.0 / 6227020800.0;
  s = s * r2 - 1.0 / 39916800.0;
  s = s * r2 + 1.0 / 362880.0;
  s = s * r2 - 1.0 / 5040.0;
  s = s * r2 + 1.0 / 120.0;
  s = s * r2 - 1.0 / 6.0;
  s = r + r * r2 * s;
  V c = fill<V>(1.0 / 20922789888000.0);
  c = c * r2 - 1.0 / 87178291200.0;
  c = c * r2 + 1.0 / 479001600.0;
  c = c * r2 - 1.0 / 3628800.0;
  c = c * r2 + 1.0 / 40320.0;
  c = c * r2 - 1.0 / 720.0;
  c = c * r2 + 1.0 / 24.0;
  c = c * r2 - 0.5;
  c = 1.0 + r2 * c;
  const auto quarter = (k & 1UL) != 0UL;
  const V swappedSine = select(quarter, c, s), swappedCosine = select(quarter, s, c);
  sine = __builtin_bit_cast(V, __builtin_bit_cast(Bits, swappedSine) ^ ((k & 2UL) << 62));
  cosine = __builtin_bit_cast(V, __builtin_bit_cast(Bits, swappedCosine) ^ (((k + 1UL) & 2UL) << 62));
}

template <typename V>
GELENK_INLINE V dot(const V* a, const V* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <typename V>
GELENK_INLINE void cross(const V* a, const V* b, V* out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

template <typename V>
struct Target {
  V x[3], y[3], z[3], p[3];
};

/// Axis and origin of every joint, then x and y of the last frame and the controlled point.
template <typename V, int N>
struct Place {
  V z[N][3], origin[N][3], x[3], y[3], point[3];
};

template <typename V, int N, bool Prismatic>
GELENK_INLINE void jointSinesCosines(const ChainConstants& C, const V* q, V* s, V* c) {
  if constexpr (sizeof(V) == sizeof(double)) {  // a single problem: the joints take the lanes
    alignas(64) double angle[kernelLanes] = {}, sine[kernelLanes], cosine[kernelLanes];
    GELENK_UNROLL for (int i = 0; i < N; ++i) angle[i] = C.theta[i] + (Prismatic ? C.revolute[i] * q[i] : q[i]);
    GELENK_UNROLL for (int first = 0; first < N; first += width) {
      Lanes a, b;
      sineCosine(load<Lanes>(angle + first), a, b);
      store(a, sine + first);
      store(b, cosine + first);
    }
    GELENK_UNROLL for (int i = 0; i < N; ++i) s[i] = sine[i], c[i] = cosine[i];
  } else {
    GELENK_UNROLL for (int i = 0; i < N; ++i) sineCosine<V>((Prismatic ? q[i] * C.revolute[i] : q[i]) + C.theta[i], s[i], c[i]);
  }
}

/// Forward kinematics in the base frame: L_1 * ... * L_n (see SerialChain).
template <typename V, int N, bool Prismatic>
GELENK_INLINE void place(const ChainConstants& C, const KernelTask& task, const V* q, Place<V, N>& at) {
  V s[N], c[N];
  jointSinesCosines<V, N, Prismatic>(C, q, s, c);
  V x[3] = {c[0], s[0], fill<V>(0.0)}, y[3] = {-s[0], c[0], fill<V>(0.0)};
  V z[3] = {fill<V>(0.0), fill<V>(0.0), fill<V>(1.0)}, p[3] = {fill<V>(0.0), fill<V>(0.0), fill<V>(0.0)};
  if constexpr (Prismatic) p[2] = q[0] * (1.0 - C.revolute[0]);
  GELENK_UNROLL for (int k = 0; k < 3; ++k) at.z[0][k] = z[k], at.origin[0][k] = p[k];
  GELENK_UNROLL for (int i = 1; i < N; ++i) {
    V d = fill<V>(C.d[i]);
    if constexpr (Prismatic) d = d + q[i] * (1.0 - C.revolute[i]);
    GELENK_UNROLL for (int k = 0; k < 3; ++k) {
      const V tilted = y[k] * C.cosAlpha[i] + z[k] * C.sinAlpha[i];
      z[k] = z[k] * C.cosAlpha[i] - y[k] * C.sinAlpha[i];
      p[k] = p[k] + x[k] * C.a[i] + z[k] * d;
      y[k] = tilted * c[i] - x[k] * s[i];
      x[k] = x[k] * c[i] + tilted * s[i];
      at.z[i][k] = z[k];
      at.origin[i][k] = p[k];
    }
  }
  GELENK_UNROLL for (int k = 0; k < 3; ++k) at.x[k] = x[k], at.y[k] = y[k], at.point[k] = p[k];
  if (task.hasPoint)
    GELENK_UNROLL for (int k = 0; k < 3; ++k) at.point[k] =
        at.point[k] + x[k] * task.point[0] + y[k] * task.point[1] + z[k] * task.point[2];
}

/// e: target minus point. w: rotation from the current to the wanted orientation as 2 tan(theta/2) axis.
template <typename V, int N>
GELENK_INLINE void errorAt(const KernelTask& task, const Place<V, N>& at, const Target<V>& target, V* e, V* w) {
  GELENK_UNROLL for (int k = 0; k < 3; ++k) {
    e[k] = task.position ? target.p[k] - at.point[k] : fill<V>(0.0);
    w[k] = fill<V>(0.0);
  }
  if (!task.orientation) return;
  V a[3], b[3], c[3];
  cross(at.x, target.x, a);
  cross(at.y, target.y, b);
  cross(at.z[N - 1], target.z, c);
  const V trace = dot(at.x, target.x) + dot(at.y, target.y) + dot(at.z[N - 1], target.z);
  const V factor = 2.0 / larger<V>(1.0 + trace, fill<V>(0.25));  // 4 cos^2(theta/2), bounded below near the half turn
  GELENK_UNROLL for (int k = 0; k < 3; ++k) w[k] = factor * (a[k] + b[k] + c[k]);
}

/// Whether the rotation error is small in truth: near the half turn the bounded w vanishes again, and the trace tells.
template <typename V, int N>
GELENK_INLINE typename Of<V>::Mask facesTarget(const KernelTask& task, const Place<V, N>& at, const Target<V>& target) {
  if (!task.orientation) return fill<V>(0.0) < fill<V>(1.0);
  return dot(at.x, target.x) + dot(at.y, target.y) + dot(at.z[N - 1], target.z) > fill<V>(0.0);
}

/// Solves A d = b in place: A = L D L^T, lower triangle in A[j][i], i <= j. Positive definite by the damping.
template <typename V, int N>
GELENK_INLINE void solveSymmetric(V A[N][N], V* b) {
  GELENK_UNROLL for (int i = 0; i < N; ++i) {
    const V inverse = 1.0 / larger<V>(A[i][i], fill<V>(1e-12));
    GELENK_UNROLL for (int j = i + 1; j < N; ++j) {
      const V l = A[j][i] * inverse;
      GELENK_UNROLL for (int k = i + 1; k <= j; ++k) A[j][k] = A[j][k] - l * A[k][i];
      b[j] = b[j] - l * b[i];
    }
    GELENK_UNROLL for (int j = i + 1; j < N; ++j) A[j][i] = A[j][i] * inverse;
    b[i] = b[i] * inverse;
  }
  GELENK_UNROLL for (int i = N - 1; i >= 0; --i) GELENK_UNROLL for (int j = i + 1; j < N; ++j) b[i] = b[i] - A[j][i] * b[j];
}

template <typename V, int N, bool Prismatic>
GELENK_INLINE void jacobianColumn(const ChainConstants& C, const KernelTask& task, const Place<V, N>& at, int i, V* J) {
  if (i == N - 1 && !task.hasPoint) {  // the point is the origin of the last frame: on its own axis
    J[0] = J[1] = J[2] = fill<V>(0.0);
  } else {
    const V arm[3] = {at.point[0] - at.origin[i][0], at.point[1] - at.origin[i][1], at.point[2] - at.origin[i][2]};
    cross(at.z[i], arm, J);
  }
  GELENK_UNROLL for (int k = 0; k < 3; ++k) J[3 + k] = at.z[i][k];
  if constexpr (Prismatic) GELENK_UNROLL for (int k = 0; k < 3; ++k) {
    J[k] = J[k] * C.revolute[i] + at.z[i][k] * (1.0 - C.revolute[i]);
    J[3 + k] = J[3 + k] * C.revolute[i];
  }
  if (!task.position) J[0] = J[1] = J[2] = fill<V>(0.0);
  if (!task.orientation) J[3] = J[4] = J[5] = fill<V>(0.0);
}

/// One iteration: the squared error at q, what the step promises to take off it, whether it is within the tolerances, and q
/// moved by the step. Where q is within the tolerances the step is a refinement, taken only when it is small.
template <typename V, int N, bool Prismatic>
GELENK_INLINE typename Of<V>::Mask iterate(const ChainConstants& C, const KernelTask& task, const Target<V>& target, V* q, V& error2,
                                               V& promise) {
  constexpr double dampingPerError = 0.05, leastDamping = 1e-9, longestStep = 1.2, refinement = 1e-4;
  Place<V, N> at;
  place<V, N, Prismatic>(C, task, q, at);
  V e[3], w[3];
  errorAt<V, N>(task, at, target, e, w);
  const V position2 = dot(e, e), orientation2 = dot(w, w);
  error2 = position2 + orientation2;
  const auto solved = (position2 <= task.positionTolerance2) & (orientation2 <= task.orientationTolerance2) &
                      facesTarget<V, N>(task, at, target);

  V J[N][6], d[N], A[N][N], ownDamping[N];
  const V damping = error2 * dampingPerError + leastDamping;
  GELENK_UNROLL for (int i = 0; i < N; ++i) {
    jacobianColumn<V, N, Prismatic>(C, task, at, i, J[i]);
    const V slope = dot(J[i], e) + dot(J[i] + 3, w);
    const auto locked = ((q[i] <= C.lower[i]) & (slope < 0.0)) | ((q[i] >= C.upper[i]) & (slope > 0.0));
    const V isFree = select(locked, fill<V>(0.0), fill<V>(1.0));
    GELENK_UNROLL for (int k = 0; k < 6; ++k) J[i][k] = J[i][k] * isFree;
    d[i] = slope * isFree;
    // A joint that is driven towards its wall is damped the more the closer it is, so that a redundant arm moves others.
    const V room = select(slope < 0.0, q[i] - C.lower[i], C.upper[i] - q[i]);
    ownDamping[i] = damping + damping / (room * room + 0.05);
  }
  GELENK_UNROLL for (int i = 0; i < N; ++i) {
    GELENK_UNROLL for (int j = i; j < N; ++j) A[j][i] = dot(J[i], J[j]) + dot(J[i] + 3, J[j] + 3);
    A[i][i] = A[i][i] + ownDamping[i];
  }
  V downhill[N];
  GELENK_UNROLL for (int i = 0; i < N; ++i) downhill[i] = d[i];
  solveSymmetric<V, N>(A, d);
  promise = fill<V>(0.0);
  GELENK_UNROLL for (int i = 0; i < N; ++i) promise = promise + d[i] * downhill[i];

  V longest = fill<V>(0.0);
  GELENK_UNROLL for (int i = 0; i < N; ++i) longest = larger<V>(longest, magnitude(d[i]));
  const V scale = smaller<V>(fill<V>(1.0), longestStep / larger<V>(longest, fill<V>(1e-300)));
  auto stays = longest > refinement;  // a solution is refined only by a small step that meets no wall
  V moved[N];
  GELENK_UNROLL for (int i = 0; i < N; ++i) {
    const V wanted = q[i] + d[i] * scale;
    moved[i] = smaller<V>(larger<V>(wanted, fill<V>(C.lower[i])), fill<V>(C.upper[i]));
    stays = stays | (moved[i] != wanted);
  }
  stays = stays & solved;
  GELENK_UNROLL for (int i = 0; i < N; ++i) q[i] = select(stays, q[i], moved[i]);
  return solved;
}

/// SplitMix64 (Steele, Lea, Flood 2014): the n-th number follows from the seed alone.
GELENK_INLINE double uniform(std::uint64_t& state) {
  std::uint64_t x = (state += 0x9e3779b97f4a7c15ULL);
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return static_cast<double>((x ^ (x >> 31)) >> 11) * 0x1p-53;
}

template <int N>
GELENK_INLINE void randomStart(const ChainConstants& C, std::uint64_t& state, double (*q)[kernelLanes], int lane) {
  for (int i = 0; i < N; ++i) q[i][lane] = C.seedLower[i] + (C.seedUpper[i] - C.seedLower[i]) * uniform(state);
}

template <typename V>
GELENK_INLINE void broadcast(const KernelTarget& from, Target<V>& to) {
  for (int k = 0; k < 3; ++k) {
    to.x[k] = fill<V>(from.x[k]);
    to.y[k] = fill<V>(from.y[k]);
    to.z[k] = fill<V>(from.z[k]);
    to.p[k] = fill<V>(from.p[k]);
  }
}

/// Eight lanes in memory, so that single lanes can be read and replaced.
template <int N>
struct alignas(64) LaneState {
  double q[N][kernelLanes];
  double x[3][kernelLanes], y[3][kernelLanes], z[3][kernelLanes], p[3][kernelLanes];
  double error2[kernelLanes], age[kernelLanes];

  void aim(const KernelTarget& target, int lane) {
    for (int k = 0; k < 3; ++k) {
      x[k][lane] = target.x[k];
      y[k][lane] = target.y[k];
      z[k][lane] = target.z[k];
      p[k][lane] = target.p[k];
    }
  }
};

/// Lanes that were within the tolerances, and those and the ones whose attempt is over.
struct LaneEvents {
  int solved, done;
};

/// An attempt is over when the linear model promises to take away less than this share of the squared error: a local minimum.
constexpr double leastPromise = 0.1;

/// One iteration of all lanes.
template <int N, bool Prismatic>
static __attribute__((noinline)) LaneEvents iterateLanes(const ChainConstants& C, const KernelTask& task, LaneState<N>& state) {
  LaneEvents events{0, 0};
  for (int first = 0; first < kernelLanes; first += width) {
    Lanes q[N], error2, promise;
    Target<Lanes> target;
    GELENK_UNROLL for (int i = 0; i < N; ++i) q[i] = load<Lanes>(state.q[i] + first);
    GELENK_UNROLL for (int k = 0; k < 3; ++k) {
      target.x[k] = load<Lanes>(state.x[k] + first);
      target.y[k] = load<Lanes>(state.y[k] + first);
      target.z[k] = load<Lanes>(state.z[k] + first);
      target.p[k] = load<Lanes>(state.p[k] + first);
    }
    const LaneMask solved = iterate<Lanes, N, Prismatic>(C, task, target, q, error2, promise);
    const Lanes age = load<Lanes>(state.age + first) + 1.0;
    events.solved |= bits(solved) << first;
    const LaneMask spent = (age >= fill<Lanes>(task.attemptIterations)) | ((age >= 3.0) & (promise < leastPromise * error2));
    events.done |= bits(solved | spent) << first;
    store(age, state.age + first);
    GELENK_UNROLL for (int i = 0; i < N; ++i) store(q[i], state.q[i] + first);
    store(error2, state.error2 + first);
  }
  return events;
}

/// atan2(s, c) of any length to about 1e-3: for starts.
GELENK_INLINE Lanes roughAngle(Lanes c, Lanes s) {
  const Lanes ac = magnitude(c), as = magnitude(s);
  const Lanes t = smaller<Lanes>(ac, as) / larger<Lanes>(larger<Lanes>(ac, as), fill<Lanes>(1e-300)), t2 = t * t;
  Lanes angle = t * (0.9986 + t2 * (-0.3076 + t2 * 0.0945));  // least squares for atan on [0, 1]
  angle = select(as > ac, 1.5707963267948966 - angle, angle);
  angle = select(c < 0.0, 3.1415926535897932 - angle, angle);
  return select(s < 0.0, -angle, angle);
}

/// The angle by whole turns next to the range's middle; true where that is within it.
GELENK_INLINE LaneMask intoRange(Lanes angle, double lower, double upper, double* to) {
  constexpr double roundToInteger = 6755399441055744.0, turn = 6.283185307179586;
  const double middle = lower > -1e299 && upper < 1e299 ? 0.5 * (lower + upper) : 0.0;
  const Lanes turns = ((angle - middle) * (1.0 / turn) + roundToInteger) - roundToInteger;
  const Lanes wrapped = angle - turns * turn;
  store(wrapped, to);
  return (wrapped >= lower) & (wrapped <= upper);
}

template <int N, bool Prismatic>
struct Loops {
  static void attempt(const ChainConstants& C, const KernelTask& task, const KernelTarget& goal, const double* start, KernelAnswer& answer) {
    Target<double> target;
    broadcast(goal, target);
    double q[N], before[N];
    for (int i = 0; i < N; ++i) q[i] = start[i];
    answer.solved = 0;
    answer.attempts = 1;
    answer.error2 = 1e300;
    int iteration = 0;
    while (iteration < task.attemptIterations) {
      double error2, promise;
      for (int i = 0; i < N; ++i) before[i] = q[i];
      const bool solved = iterate<double, N, Prismatic>(C, task, target, q, error2, promise);
      ++iteration;
      if (error2 < answer.error2 || solved) {
        answer.error2 = error2;
        for (int i = 0; i < N; ++i) answer.q[i] = solved ? q[i] : before[i];
      }
      if (solved) {
        answer.solved = 1;
        break;
      }
    }
    answer.iterations = iteration;
  }

  static void race(const ChainConstants& C, const KernelTask& task, const KernelTarget& goal, const LaneStarts& starts, int maxAttempts,
                   std::uint64_t randomSeed, KernelAnswer& answer) {
    LaneState<N> state;
    for (int l = 0; l < kernelLanes; ++l) state.aim(goal, l);
    __builtin_memcpy(state.q, starts.q, sizeof state.q);
    for (int l = 0; l < kernelLanes; ++l) {
      state.age[l] = 0.0;
      if (!(starts.valid >> l & 1)) randomStart<N>(C, randomSeed, state.q, l);
    }
    answer.solved = answer.iterations = 0;
    answer.attempts = kernelLanes;
    answer.error2 = 1e300;
    while (true) {
      const LaneEvents events = iterateLanes<N, Prismatic>(C, task, state);
      answer.iterations += kernelLanes;
      if (events.solved) {
        const int lane = __builtin_ctz(events.solved);
        answer.solved = 1;
        answer.error2 = state.error2[lane];
        for (int i = 0; i < N; ++i) answer.q[i] = state.q[i][lane];
        return;
      }
      for (int done = events.done; done; done &= done - 1) {
        const int l = __builtin_ctz(done);
        if (state.error2[l] < answer.error2) {  // of the step before: a start for the search of the closest pose
          answer.error2 = state.error2[l];
          for (int i = 0; i < N; ++i) answer.q[i] = state.q[i][l];
        }
        if (answer.attempts >= maxAttempts) return;
        state.age[l] = 0.0;
        randomStart<N>(C, randomSeed, state.q, l);
        ++answer.attempts;
      }
    }
  }

  static void batch(const ChainConstants& C, const KernelTask& task, const KernelTarget* goals, int count, const double* seeds,
                    int seedsEach, int maxAttempts, std::uint64_t randomSeed, KernelAnswer* answers) {
    LaneState<N> state;
    __builtin_memset(&state, 0, sizeof state);
    int problem[kernelLanes], live = 0, next = 0, busy = 0;
    std::uint64_t random[kernelLanes] = {};
    const auto nextStart = [&](int lane) __attribute__((always_inline)) {
      KernelAnswer& answer = answers[problem[lane]];
      state.age[lane] = 0.0;
      if (answer.attempts < seedsEach)
        for (int i = 0; i < N; ++i)
          state.q[i][lane] = seeds[(static_cast<long>(problem[lane]) * seedsEach + answer.attempts) * N + i];
      else
        randomStart<N>(C, random[lane], state.q, lane);
      ++answer.attempts;
    };
    const auto nextProblem = [&](int lane) __attribute__((always_inline)) {
      problem[lane] = next < count ? next++ : -1;
      if (problem[lane] < 0) {
        busy &= ~(1 << lane);
        return;
      }
      busy |= 1 << lane;
      ++live;
      random[lane] = randomSeed + 0xd1342543de82ef95ULL * static_cast<std::uint64_t>(problem[lane] + 1);
      state.aim(goals[problem[lane]], lane);
      KernelAnswer& answer = answers[problem[lane]];
      answer.solved = answer.iterations = answer.attempts = 0;
      answer.error2 = 1e300;
      nextStart(lane);
    };
    for (int l = 0; l < kernelLanes; ++l) nextProblem(l);
    while (live > 0) {
      const LaneEvents events = iterateLanes<N, Prismatic>(C, task, state);
      for (int done = events.done & busy; done; done &= done - 1) {
        const int l = __builtin_ctz(done);
        KernelAnswer& answer = answers[problem[l]];
        const bool isSolved = events.solved >> l & 1;
        answer.iterations += static_cast<int>(state.age[l]);
        if (isSolved || state.error2[l] < answer.error2) {
          answer.solved = isSolved;
          answer.error2 = state.error2[l];
          for (int i = 0; i < N; ++i) answer.q[i] = state.q[i][l];
        }
        if (!isSolved && answer.attempts < maxAttempts) {
          nextStart(l);
        } else {
          --live;
          nextProblem(l);
        }
      }
    }
  }

  static void frameAndJacobian(const ChainConstants& C, const double* base, const double* point, const double* q, double* frame, double* J) {
    double s[N], c[N];
    jointSinesCosines<double, N, Prismatic>(C, q, s, c);
    double x[3], y[3], z[3], p[3], axis[N][3], origin[N][3];
    for (int k = 0; k < 3; ++k) {
      z[k] = base[6 + k];
      p[k] = base[9 + k];
      if constexpr (Prismatic) p[k] += z[k] * q[0] * (1.0 - C.revolute[0]);
      x[k] = base[k] * c[0] + base[3 + k] * s[0];
      y[k] = base[3 + k] * c[0] - base[k] * s[0];
      axis[0][k] = z[k];
      origin[0][k] = p[k];
    }
    GELENK_UNROLL for (int i = 1; i < N; ++i) {
      double d = C.d[i];
      if constexpr (Prismatic) d += q[i] * (1.0 - C.revolute[i]);
      GELENK_UNROLL for (int k = 0; k < 3; ++k) {
        const double tilted = y[k] * C.cosAlpha[i] + z[k] * C.sinAlpha[i];
        z[k] = z[k] * C.cosAlpha[i] - y[k] * C.sinAlpha[i];
        p[k] = p[k] + x[k] * C.a[i] + z[k] * d;
        y[k] = tilted * c[i] - x[k] * s[i];
        x[k] = x[k] * c[i] + tilted * s[i];
        axis[i][k] = z[k];
        origin[i][k] = p[k];
      }
    }
    for (int k = 0; k < 3; ++k) {
      p[k] += x[k] * point[0] + y[k] * point[1] + z[k] * point[2];
      frame[k] = x[k], frame[3 + k] = y[k], frame[6 + k] = z[k], frame[9 + k] = p[k];
    }
    GELENK_UNROLL for (int i = 0; i < N; ++i) {
      const double arm[3] = {p[0] - origin[i][0], p[1] - origin[i][1], p[2] - origin[i][2]};
      double* column = J + 6 * i;
      cross(axis[i], arm, column);
      for (int k = 0; k < 3; ++k) {
        column[3 + k] = axis[i][k];
        if constexpr (Prismatic) {
          column[k] = column[k] * C.revolute[i] + axis[i][k] * (1.0 - C.revolute[i]);
          column[3 + k] *= C.revolute[i];
        }
      }
    }
  }

  static void turnSeeds(const ChainConstants& C, const KernelTarget& goal, const SeedCell& cell, int count, LaneStarts& starts) {
    const double radius2 = goal.p[0] * goal.p[0] + goal.p[1] * goal.p[1];
    const double perRadius = radius2 > 0.0 ? 1.0 / __builtin_sqrt(radius2) : 0.0;
    const double c = radius2 > 0.0 ? goal.p[0] * perRadius : 1.0, s = goal.p[1] * perRadius;
    const double x[3] = {c * goal.x[0] + s * goal.x[1], c * goal.x[1] - s * goal.x[0], goal.x[2]};
    const double y[3] = {c * goal.y[0] + s * goal.y[1], c * goal.y[1] - s * goal.y[0], goal.y[2]};
    starts.valid = 0;
    for (int first = 0; first < kernelLanes; first += width) {
      Lanes ex[3], ey[3];
      for (int k = 0; k < 3; ++k) ex[k] = widen(cell.x[k] + first), ey[k] = widen(cell.y[k] + first);
      const Lanes cosineRoll = ex[0] * x[0] + ex[1] * x[1] + ex[2] * x[2] + ey[0] * y[0] + ey[1] * y[1] + ey[2] * y[2];
      const Lanes sineRoll = ex[0] * y[0] + ex[1] * y[1] + ex[2] * y[2] - ey[0] * x[0] - ey[1] * x[1] - ey[2] * x[2];
      for (int i = 1; i < N - 1; ++i) store(widen(cell.q[i] + first), starts.q[i] + first);
      const Lanes base = widen(cell.q[0] + first);
      const LaneMask spins = intoRange(base + roughAngle(fill<Lanes>(c), fill<Lanes>(s)), C.lower[0], C.upper[0], starts.q[0] + first);
      const LaneMask rolls = intoRange(roughAngle(cosineRoll, sineRoll), C.lower[N - 1], C.upper[N - 1], starts.q[N - 1] + first);
      starts.valid |= bits(spins & rolls) << first;
    }
    starts.valid &= (1 << count) - 1;
  }

  static double error(const ChainConstants& C, const KernelTask& task, const KernelTarget& goal, const double* q) {
    Target<double> target;
    broadcast(goal, target);
    Place<double, N> at;
    place<double, N, Prismatic>(C, task, q, at);
    double e[3], w[3];
    errorAt<double, N>(task, at, target, e, w);
    return dot(e, e) + dot(w, w);
  }

  static constexpr SerialKernel table{&attempt, &race, &batch, &frameAndJacobian, &turnSeeds, &error};
};

template <bool Prismatic>
const SerialKernel* kernelFor(int n) {
  switch (n) {
    case 1: return &Loops<1, Prismatic>::table;
    case 2: return &Loops<2, Prismatic>::table;
    case 3: return &Loops<3, Prismatic>::table;
    case 4: return &Loops<4, Prismatic>::table;
    case 5: return &Loops<5, Prismatic>::table;
    case 6: return &Loops<6, Prismatic>::table;
    case 7: return &Loops<7, Prismatic>::table;
    case 8: return &Loops<8, Prismatic>::table;
    default: return nullptr;
  }
}

}  // namespace

const SerialKernel* GELENK_KERNEL_FUNCTION(int n, bool prismatic) {
  // Only arms of 6 and 7 revolute joints have loops of their own; the rest share the general ones.
  if (prismatic || n < 6 || n > 7) return kernelFor<true>(n);
  return n == 6 ? &Loops<6, false>::table : &Loops<7, false>::table;
}

}  // namespace gelenk
