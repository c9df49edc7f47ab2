// The inner loops of the flagship, for one instruction set: include with GELENK_KERNEL_FUNCTION (the name of
// the function that hands them out) defined. Everything has internal linkage: nothing compiled here may leak
// into other files.
//
// One template serves a single problem (V = double), sixteen starts or problems side by side in single
// precision (V = Floats), which only has to come close, and eight in double precision (V = Doubles) that are
// finished together. An iteration is Levenberg-Marquardt with damping proportional to the error (Chan and
// Lawrence 1988), columns of joints that stand at a wall and are pushed against it taken out (active set),
// and the Cayley rotation error 2 tan(theta/2) axis, which needs no trigonometry and has no wrong half turn.

#include <cstdint>
#include <type_traits>

#include "solvers/serial/serial_kernel.h"

#if defined(__AVX2__) || defined(__AVX512F__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#elif defined(__wasm_simd128__)
#include <wasm_simd128.h>
#endif

#define GELENK_INLINE static inline __attribute__((always_inline))
#ifdef __clang__
#define GELENK_UNROLL _Pragma("clang loop unroll(full)")
#else
#define GELENK_UNROLL _Pragma("GCC unroll 8")
#endif

namespace gelenk {
namespace {

/// Registers of this instruction set. Sixteen float lanes and eight double lanes are as many registers of
/// them as it takes.
#if defined(__AVX512F__)
constexpr int width = 8;
#elif defined(__AVX2__)
constexpr int width = 4;
#else
constexpr int width = 2;
#endif
typedef double Doubles __attribute__((vector_size(8 * width)));
typedef float Floats __attribute__((vector_size(8 * width)));
typedef decltype(Doubles{} < Doubles{}) DoublesMask;
typedef decltype(Floats{} < Floats{}) FloatsMask;
typedef std::uint64_t DoublesBits __attribute__((vector_size(8 * width)));
typedef std::uint32_t FloatsBits __attribute__((vector_size(8 * width)));

template <typename V>
struct Of;
template <>
struct Of<double> {
  using Scalar = double;
  using Bits = std::uint64_t;
  using Mask = bool;
};
template <>
struct Of<Doubles> {
  using Scalar = double;
  using Bits = DoublesBits;
  using Mask = DoublesMask;
};
template <>
struct Of<Floats> {
  using Scalar = float;
  using Bits = FloatsBits;
  using Mask = FloatsMask;
};
template <typename V>
using Scalar = typename Of<V>::Scalar;
template <typename V>
constexpr int lanesIn = sizeof(V) / sizeof(Scalar<V>);  // of one register

GELENK_INLINE double select(bool mask, double yes, double no) { return mask ? yes : no; }
GELENK_INLINE Doubles select(DoublesMask mask, Doubles yes, Doubles no) { return mask ? yes : no; }
GELENK_INLINE Floats select(FloatsMask mask, Floats yes, Floats no) { return mask ? yes : no; }
template <typename V>
GELENK_INLINE V larger(V a, V b) {
  return select(a > b, a, b);
}
template <typename V>
GELENK_INLINE V smaller(V a, V b) {
  return select(a < b, a, b);
}
template <typename V>
GELENK_INLINE V fill(Scalar<V> x) {
  if constexpr (lanesIn<V> == 1)
    return x;
  else
    return V{} + x;
}
template <typename V>
GELENK_INLINE V clamped(V x, Scalar<V> lower, Scalar<V> upper) {
  return smaller<V>(larger<V>(x, fill<V>(lower)), fill<V>(upper));
}
template <typename V>
GELENK_INLINE V magnitude(V a) {
  using Bits = typename Of<V>::Bits;
  if constexpr (sizeof(Scalar<V>) == 8)
    return __builtin_bit_cast(V, __builtin_bit_cast(Bits, a) & 0x7fffffffffffffffUL);
  else
    return __builtin_bit_cast(V, __builtin_bit_cast(Bits, a) & 0x7fffffffU);
}
template <typename V>
GELENK_INLINE V load(const Scalar<V>* from) {
  V v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}
template <typename V>
GELENK_INLINE void store(V v, Scalar<V>* to) {
  __builtin_memcpy(to, &v, sizeof v);
}

/// One bit a lane.
GELENK_INLINE int bits(DoublesMask mask) {
#if defined(__AVX512DQ__)
  return _mm512_movepi64_mask(__builtin_bit_cast(__m512i, mask));
#elif defined(__AVX2__)
  return _mm256_movemask_pd(__builtin_bit_cast(__m256d, mask));
#elif defined(__wasm_simd128__)
  return static_cast<int>(wasm_i64x2_bitmask(__builtin_bit_cast(v128_t, mask)));
#else
  return (mask[0] & 1) | (mask[1] & 2);
#endif
}
GELENK_INLINE int bits(FloatsMask mask) {
#if defined(__AVX512DQ__)
  return _mm512_movepi32_mask(__builtin_bit_cast(__m512i, mask));
#elif defined(__AVX2__)
  return _mm256_movemask_ps(__builtin_bit_cast(__m256, mask));
#elif defined(__wasm_simd128__)
  return static_cast<int>(wasm_i32x4_bitmask(__builtin_bit_cast(v128_t, mask)));
#else
  return (mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8);
#endif
}

/// Sine and cosine to about 1e-15 (double, |x| < 1e5) or 3e-7 (float, |x| < 1e3): reduction by multiples of
/// pi/2 in two parts (the first is short, so that its multiples are exact), then Taylor polynomials on
/// [-pi/4, pi/4].
template <typename V>
GELENK_INLINE void sineCosine(V x, V& sine, V& cosine) {
  using S = Scalar<V>;
  using Bits = typename Of<V>::Bits;
  constexpr bool wide = sizeof(S) == 8;
  constexpr S roundToInteger =
      wide ? 6755399441055744.0 : 12582912.0;  // 1.5 * 2^52 or 2^23: the sum's low bits hold the integer
  constexpr S halfPiHigh = wide ? 0x1.921fb544p+0 : 0x1.92p+0,
              halfPiLow = wide ? 0x1.0b4611a626331p-34 : 0x1.fb5444p-12;
  const V shifted = x * S(0.63661977236758134308) + roundToInteger;
  const Bits k = __builtin_bit_cast(Bits, shifted);
  const V turns = shifted - roundToInteger;
  const V r = (x - turns * halfPiHigh) - turns * halfPiLow;
  const V r2 = r * r;
  V s, c;
  if constexpr (wide) {
    s = fill<V>(-1.0 / 1307674368000.0);
    s = s * r2 + 1.0 / 6227020800.0;
    s = s * r2 - 1.0 / 39916800.0;
    s = s * r2 + 1.0 / 362880.0;
    s = s * r2 - 1.0 / 5040.0;
    c = fill<V>(1.0 / 20922789888000.0);
    c = c * r2 - 1.0 / 87178291200.0;
    c = c * r2 + 1.0 / 479001600.0;
    c = c * r2 - 1.0 / 3628800.0;
    c = c * r2 + 1.0 / 40320.0;
  } else {
    s = fill<V>(S(-1.0 / 5040.0));
    c = fill<V>(S(1.0 / 40320.0));
  }
  s = s * r2 + S(1.0 / 120.0);
  s = s * r2 - S(1.0 / 6.0);
  s = r + r * r2 * s;
  c = c * r2 - S(1.0 / 720.0);
  c = c * r2 + S(1.0 / 24.0);
  c = c * r2 - S(0.5);
  c = S(1.0) + r2 * c;
  using Word = std::conditional_t<wide, std::uint64_t, std::uint32_t>;
  const auto quarter = (k & Word(1)) != Word(0);
  const V swappedSine = select(quarter, c, s), swappedCosine = select(quarter, s, c);
  constexpr int toSign = 8 * sizeof(S) - 2;
  sine = __builtin_bit_cast(V, __builtin_bit_cast(Bits, swappedSine) ^ ((k & Word(2)) << toSign));
  cosine =
      __builtin_bit_cast(V, __builtin_bit_cast(Bits, swappedCosine) ^ (((k + Word(1)) & Word(2)) << toSign));
}

template <typename V, typename W>
GELENK_INLINE V dot(const V* a, const W* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <typename V>
GELENK_INLINE void cross(const V* a, const V* b, V* out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

/// The chain's constants in single precision; where there is no wall a far one.
struct FloatConstants {
  float a[maxChainDofs], d[maxChainDofs], cosAlpha[maxChainDofs], sinAlpha[maxChainDofs], theta[maxChainDofs],
      revolute[maxChainDofs];
  float lower[maxChainDofs], upper[maxChainDofs], seedLower[maxChainDofs], seedRange[maxChainDofs];

  explicit FloatConstants(const ChainConstants& C) {
    for (int i = 0; i < maxChainDofs; ++i) {
      a[i] = static_cast<float>(C.a[i]);
      d[i] = static_cast<float>(C.d[i]);
      cosAlpha[i] = static_cast<float>(C.cosAlpha[i]);
      sinAlpha[i] = static_cast<float>(C.sinAlpha[i]);
      theta[i] = static_cast<float>(C.theta[i]);
      revolute[i] = static_cast<float>(C.revolute[i]);
      lower[i] = static_cast<float>(C.lower[i] < -1e9 ? -1e9 : C.lower[i]);
      upper[i] = static_cast<float>(C.upper[i] > 1e9 ? 1e9 : C.upper[i]);
      seedLower[i] = static_cast<float>(C.seedLower[i]);
      seedRange[i] = static_cast<float>(C.seedUpper[i] - C.seedLower[i]);
    }
  }
};
template <typename V>
using Constants = std::conditional_t<sizeof(Scalar<V>) == sizeof(double), ChainConstants, FloatConstants>;

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
GELENK_INLINE void jointSinesCosines(const Constants<V>& C, const V* q, V* s, V* c) {
  using S = Scalar<V>;
  if constexpr (lanesIn<V> == 1) {  // a single problem: the joints take the lanes
    alignas(64) double angle[maxChainDofs] = {}, sine[maxChainDofs], cosine[maxChainDofs];
    GELENK_UNROLL for (int i = 0; i < N; ++i) angle[i] =
        C.theta[i] + (Prismatic ? C.revolute[i] * q[i] : q[i]);
    GELENK_UNROLL for (int first = 0; first < N; first += width) {
      Doubles a, b;
      sineCosine(load<Doubles>(angle + first), a, b);
      store(a, sine + first);
      store(b, cosine + first);
    }
    GELENK_UNROLL for (int i = 0; i < N; ++i) s[i] = sine[i], c[i] = cosine[i];
  } else {
    GELENK_UNROLL for (int i = 0; i < N; ++i)
        sineCosine<V>((Prismatic ? q[i] * S(C.revolute[i]) : q[i]) + S(C.theta[i]), s[i], c[i]);
  }
}

/// Forward kinematics in the base frame: L_1 * ... * L_n (see SerialChain).
template <typename V, int N, bool Prismatic, bool Pose>
GELENK_INLINE void place(const Constants<V>& C, const KernelTask& task, const V* q, Place<V, N>& at) {
  using S = Scalar<V>;
  V s[N], c[N];
  jointSinesCosines<V, N, Prismatic>(C, q, s, c);
  V x[3] = {c[0], s[0], fill<V>(0)}, y[3] = {-s[0], c[0], fill<V>(0)};
  V z[3] = {fill<V>(0), fill<V>(0), fill<V>(1)}, p[3] = {fill<V>(0), fill<V>(0), fill<V>(0)};
  if constexpr (Prismatic) p[2] = q[0] * (S(1) - C.revolute[0]);
  GELENK_UNROLL for (int k = 0; k < 3; ++k) at.z[0][k] = z[k], at.origin[0][k] = p[k];
  GELENK_UNROLL for (int i = 1; i < N; ++i) {
    V d = fill<V>(C.d[i]);
    if constexpr (Prismatic) d = d + q[i] * (S(1) - C.revolute[i]);
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
  if (!Pose && task.hasPoint)
    GELENK_UNROLL for (int k = 0; k < 3; ++k) at.point[k] =
        at.point[k] + x[k] * S(task.point[0]) + y[k] * S(task.point[1]) + z[k] * S(task.point[2]);
}

/// e: target minus point. w: rotation from the current to the wanted orientation as 2 tan(theta/2) axis.
template <typename V>
struct Error {
  V e[3], w[3], position2, orientation2, squared;
  typename Of<V>::Mask faces;  ///< false near the half turn, where the bounded w vanishes again
};

template <typename V, int N, bool Pose>
GELENK_INLINE void errorAt(const KernelTask& task, const Place<V, N>& at, const Target<V>& target,
                           Error<V>& error) {
  using S = Scalar<V>;
  GELENK_UNROLL for (int k = 0; k < 3; ++k) {
    error.e[k] = Pose || task.position ? target.p[k] - at.point[k] : fill<V>(0);
    error.w[k] = fill<V>(0);
  }
  error.faces = fill<V>(0) < fill<V>(1);
  if (Pose || task.orientation) {
    V a[3], b[3], c[3];
    cross(at.x, target.x, a);
    cross(at.y, target.y, b);
    cross(at.z[N - 1], target.z, c);
    const V trace = dot(at.x, target.x) + dot(at.y, target.y) + dot(at.z[N - 1], target.z);
    const V factor =
        S(2) / larger<V>(S(1) + trace, fill<V>(0.25));  // 4 cos^2(theta/2), bounded below near the half turn
    GELENK_UNROLL for (int k = 0; k < 3; ++k) error.w[k] = factor * (a[k] + b[k] + c[k]);
    error.faces = trace > fill<V>(0);
  }
  error.position2 = dot(error.e, error.e);
  error.orientation2 = dot(error.w, error.w);
  error.squared = error.position2 + error.orientation2;
}

template <typename V, int N, bool Prismatic, bool Pose>
GELENK_INLINE void evaluate(const Constants<V>& C, const KernelTask& task, const Target<V>& target,
                            const V* q, Place<V, N>& at, Error<V>& error) {
  place<V, N, Prismatic, Pose>(C, task, q, at);
  errorAt<V, N, Pose>(task, at, target, error);
}

template <typename V>
GELENK_INLINE typename Of<V>::Mask isWithin(const Error<V>& error, double position2, double orientation2) {
  using S = Scalar<V>;
  return (error.position2 <= S(position2)) & (error.orientation2 <= S(orientation2)) & error.faces;
}

/// Solves A d = b in place: A = L D L^T, lower triangle in A[j][i], i <= j. Positive definite by the damping.
/// The second pivot of a pair comes from the pair's determinant, so that its division need not wait for the
/// first one's.
template <typename V, int N>
GELENK_INLINE void solveSymmetric(V A[N][N], V* b) {
  using S = Scalar<V>;
  constexpr S least = 1e-12;
  V inverse, next = fill<V>(0);
  GELENK_UNROLL for (int i = 0; i < N; ++i) {
    if (i % 2 == 0) {
      const V pivot = larger<V>(A[i][i], fill<V>(least));
      inverse = S(1) / pivot;
      if (i + 1 < N)
        next = pivot / larger<V>(pivot * A[i + 1][i + 1] - A[i + 1][i] * A[i + 1][i], least * pivot);
    } else {
      inverse = next;
    }
    GELENK_UNROLL for (int j = i + 1; j < N; ++j) {
      const V l = A[j][i] * inverse;
      GELENK_UNROLL for (int k = i + 1; k <= j; ++k) A[j][k] = A[j][k] - l * A[k][i];
      b[j] = b[j] - l * b[i];
    }
    GELENK_UNROLL for (int j = i + 1; j < N; ++j) A[j][i] = A[j][i] * inverse;
    b[i] = b[i] * inverse;
  }
  GELENK_UNROLL for (int i = N - 1; i >= 0; --i) GELENK_UNROLL for (int j = i + 1; j < N; ++j) b[i] =
      b[i] - A[j][i] * b[j];
}

template <typename V, int N, bool Prismatic, bool Pose>
GELENK_INLINE void jacobianColumn(const Constants<V>& C, const KernelTask& task, const Place<V, N>& at, int i,
                                  V* J) {
  using S = Scalar<V>;
  if (i == N - 1 && (Pose || !task.hasPoint)) {  // the point is the origin of the last frame: on its own axis
    J[0] = J[1] = J[2] = fill<V>(0);
  } else {
    const V arm[3] = {at.point[0] - at.origin[i][0], at.point[1] - at.origin[i][1],
                      at.point[2] - at.origin[i][2]};
    cross(at.z[i], arm, J);
  }
  GELENK_UNROLL for (int k = 0; k < 3; ++k) J[3 + k] = at.z[i][k];
  if constexpr (Prismatic) GELENK_UNROLL for (int k = 0; k < 3; ++k) {
      J[k] = J[k] * C.revolute[i] + at.z[i][k] * (S(1) - C.revolute[i]);
      J[3 + k] = J[3 + k] * C.revolute[i];
    }
  if (!Pose && !task.position) J[0] = J[1] = J[2] = fill<V>(0);
  if (!Pose && !task.orientation) J[3] = J[4] = J[5] = fill<V>(0);
}

/// Moves q by one step. Returns what the linear model promises to take off the squared error.
template <typename V, int N, bool Prismatic, bool Pose>
GELENK_INLINE V step(const Constants<V>& C, const KernelTask& task, const Place<V, N>& at,
                     const Error<V>& error, V* q) {
  using S = Scalar<V>;
  constexpr S dampingPerError = 0.05, longestStep = 1.2;
  constexpr S leastDamping = sizeof(S) == sizeof(double) ? 1e-9 : 1e-5;  // above the rounding of J^T J
  V J[N][6], d[N], downhill[N], A[N][N];
  const V damping = error.squared * dampingPerError + leastDamping;
  GELENK_UNROLL for (int i = 0; i < N; ++i) {
    jacobianColumn<V, N, Prismatic, Pose>(C, task, at, i, J[i]);
    const V slope = dot(J[i], error.e) + dot(J[i] + 3, error.w);
    const V toLower = q[i] - S(C.lower[i]), toUpper = S(C.upper[i]) - q[i];
    const V room = select(slope < fill<V>(0), toLower, toUpper);
    const V isFree =
        select(room <= fill<V>(0), fill<V>(0), fill<V>(1));  // at the wall that it is driven towards: locked
    GELENK_UNROLL for (int k = 0; k < 6; ++k) J[i][k] = J[i][k] * isFree;
    d[i] = downhill[i] = slope * isFree;
    // A joint that is driven towards its wall is damped the more the closer it is, so that a redundant arm
    // moves others.
    A[i][i] = damping + damping / (room * room + S(0.05));
  }
  GELENK_UNROLL for (int i = 0; i < N; ++i) {
    A[i][i] = A[i][i] + dot(J[i], J[i]) + dot(J[i] + 3, J[i] + 3);
    GELENK_UNROLL for (int j = i + 1; j < N; ++j) A[j][i] = dot(J[i], J[j]) + dot(J[i] + 3, J[j] + 3);
  }
  solveSymmetric<V, N>(A, d);
  V promise = fill<V>(0), longest = fill<V>(0);
  GELENK_UNROLL for (int i = 0; i < N; ++i) {
    promise = promise + d[i] * downhill[i];
    longest = larger<V>(longest, magnitude(d[i]));
  }
  const V scale = smaller<V>(fill<V>(1), longestStep / larger<V>(longest, fill<V>(S(1e-30))));
  GELENK_UNROLL for (int i = 0; i < N; ++i) q[i] = clamped<V>(q[i] + d[i] * scale, C.lower[i], C.upper[i]);
  return promise;
}

/// A well mixed 32-bit word of a counter (constants of Wellons's hash prospector, 2018): the n-th random
/// start follows from n alone.
template <typename Word>
GELENK_INLINE Word mixed(Word x) {
  x = (x ^ (x >> 16)) * 0x7feb352dU;
  x = (x ^ (x >> 15)) * 0x846ca68bU;
  return x ^ (x >> 16);
}
GELENK_INLINE unsigned int folded(std::uint64_t seed) {
  return mixed(static_cast<unsigned int>(seed) ^ mixed(static_cast<unsigned int>(seed >> 32) + 0x9e3779b9U));
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

constexpr int finishLanes = 8;  // problems that are finished side by side

/// Lanes in memory, so that single ones can be read and replaced.
template <typename V, int N>
struct alignas(64) LaneState {
  static constexpr int count = sizeof(Scalar<V>) == sizeof(double) ? finishLanes : kernelLanes;
  using S = Scalar<V>;
  S q[N][count];
  S x[3][count], y[3][count], z[3][count], p[3][count];
  S error2[count], age[count];

  void aim(const KernelTarget& target, int lane) {
    for (int k = 0; k < 3; ++k) {
      x[k][lane] = S(target.x[k]);
      y[k][lane] = S(target.y[k]);
      z[k][lane] = S(target.z[k]);
      p[k][lane] = S(target.p[k]);
    }
  }
  void read(int first, V* lanesQ, Target<V>& target) const {
    GELENK_UNROLL for (int i = 0; i < N; ++i) lanesQ[i] = load<V>(q[i] + first);
    GELENK_UNROLL for (int k = 0; k < 3; ++k) {
      target.x[k] = load<V>(x[k] + first);
      target.y[k] = load<V>(y[k] + first);
      target.z[k] = load<V>(z[k] + first);
      target.p[k] = load<V>(p[k] + first);
    }
  }
};

/// Lanes that are close enough to be finished in double precision, and the ones whose attempt is over.
struct LaneEvents {
  int close, spent;
};

/// An attempt is over when the linear model promises to take away less than this share of the squared error:
/// a local minimum.
constexpr double leastPromise = 0.1;
/// Squared error (chain lengths, radians) from which the step to be taken leads to where double precision
/// finishes in one or two.
constexpr double close2 = 5e-7;
constexpr int finishSteps = 8;  // at most, in double precision

/// One iteration of all lanes.
template <int N, bool Prismatic, bool Pose>
static __attribute__((noinline)) LaneEvents iterateLanes(const FloatConstants& C, const KernelTask& task,
                                                         LaneState<Floats, N>& state) {
  LaneEvents events{0, 0};
  for (int first = 0; first < kernelLanes; first += lanesIn<Floats>) {
    Floats q[N];
    Target<Floats> target;
    Place<Floats, N> at;
    Error<Floats> error;
    state.read(first, q, target);
    evaluate<Floats, N, Prismatic, Pose>(C, task, target, q, at, error);
    const Floats promise = step<Floats, N, Prismatic, Pose>(C, task, at, error, q);
    const Floats age = load<Floats>(state.age + first) + 1.0f;
    const FloatsMask spent = (age >= fill<Floats>(static_cast<float>(task.attemptIterations))) |
                             ((age >= 3.0f) & (promise < static_cast<float>(leastPromise) * error.squared));
    events.close |= bits(isWithin(error, larger(close2, task.positionTolerance2),
                                  larger(close2, task.orientationTolerance2)))
                    << first;
    events.spent |= bits(spent) << first;
    store(age, state.age + first);
    GELENK_UNROLL for (int i = 0; i < N; ++i) store(q[i], state.q[i] + first);
    store(error.squared, state.error2 + first);
  }
  events.spent &= ~events.close;
  return events;
}

/// One problem in double precision from answer.q on, until within the tolerances, after `most` steps, or
/// (early) when a step promises little. answer: the solution, or the best point met; its counts grow.
template <int N, bool Prismatic, bool Pose>
static __attribute__((noinline)) bool descend(const ChainConstants& C, const KernelTask& task,
                                              const Target<double>& target, int most, bool early,
                                              KernelAnswer& answer) {
  double q[N];
  for (int i = 0; i < N; ++i) q[i] = clamped<double>(answer.q[i], C.lower[i], C.upper[i]);
  answer.error2 = 1e300;
  for (int taken = 0;; ++taken) {
    Place<double, N> at;
    Error<double> error;
    evaluate<double, N, Prismatic, Pose>(C, task, target, q, at, error);
    ++answer.evaluations;
    const bool solved = isWithin(error, task.positionTolerance2, task.orientationTolerance2);
    if (solved || error.squared < answer.error2) {
      answer.error2 = error.squared;
      for (int i = 0; i < N; ++i) answer.q[i] = q[i];
      for (int k = 0; k < 3; ++k) answer.e[k] = error.e[k], answer.w[k] = error.w[k];
    }
    if (solved || taken == most) return solved;
    const double promise = step<double, N, Prismatic, Pose>(C, task, at, error, q);
    ++answer.iterations;
    if (early && taken >= 2 && promise < leastPromise * error.squared) return false;
  }
}

/// atan2(s, c) of any length to about 1e-3: for starts.
GELENK_INLINE Floats roughAngle(Floats c, Floats s) {
  const Floats ac = magnitude(c), as = magnitude(s);
  const Floats t = smaller<Floats>(ac, as) / larger<Floats>(larger<Floats>(ac, as), fill<Floats>(1e-30f)),
               t2 = t * t;
  Floats angle = t * (0.9986f + t2 * (-0.3076f + t2 * 0.0945f));  // least squares for atan on [0, 1]
  angle = select(as > ac, 1.57079633f - angle, angle);
  angle = select(c < 0.0f, 3.14159265f - angle, angle);
  return select(s < 0.0f, -angle, angle);
}

/// The angle by whole turns next to the range's middle; true where that is within it.
GELENK_INLINE FloatsMask intoRange(Floats angle, double lower, double upper, float* to) {
  constexpr float roundToInteger = 12582912.0f, turn = 6.28318531f;
  const float middle = lower > -1e299 && upper < 1e299 ? static_cast<float>(0.5 * (lower + upper)) : 0.0f;
  const Floats turns = ((angle - middle) * (1.0f / turn) + roundToInteger) - roundToInteger;
  const Floats wrapped = angle - turns * turn;
  store(wrapped, to);
  const float low = static_cast<float>(larger(lower, -1e9)), high = static_cast<float>(smaller(upper, 1e9));
  return (wrapped >= low) & (wrapped <= high);
}

template <int N, bool Prismatic, bool Pose>
struct Loops {
  /// Dof i of the number-th random start of a seed.
  GELENK_INLINE float randomDof(const FloatConstants& C, unsigned int seed, int number, int i) {
    const unsigned int word = mixed(seed + static_cast<unsigned int>(number * N + i));
    return C.seedLower[i] + C.seedRange[i] * (static_cast<float>(static_cast<int>(word >> 8)) * 0x1p-24f);
  }

  static void randomStart(const FloatConstants& C, unsigned int seed, int number, LaneState<Floats, N>& state,
                          int lane) {
    for (int i = 0; i < N; ++i) state.q[i][lane] = randomDof(C, seed, number, i);
  }

  /// The starts given, and random ones in the other lanes, numbered by the lane.
  static void firstStarts(const FloatConstants& C, const LaneStarts& starts, unsigned int seed,
                          LaneState<Floats, N>& state) {
    for (int i = 0; i < N; ++i)
      for (int l = 0; l < kernelLanes; ++l)
        state.q[i][l] = starts.valid >> l & 1 ? starts.q[i][l] : randomDof(C, seed, l, i);
    for (int l = 0; l < kernelLanes; ++l) state.age[l] = 0.0f;
  }

  static void attempt(const ChainConstants& C, const KernelTask& task, const KernelTarget& goal,
                      const double* start, KernelAnswer& answer) {
    Target<double> target;
    broadcast(goal, target);
    for (int i = 0; i < N; ++i) answer.q[i] = answer.start[i] = start[i];
    answer.iterations = answer.evaluations = 0;
    answer.attempts = 1;
    answer.solved = descend<N, Prismatic, Pose>(C, task, target, task.attemptIterations, false, answer);
  }

  /// Finishes a lane that came close.
  static bool finish(const ChainConstants& C, const KernelTask& task, const Target<double>& target,
                     const LaneState<Floats, N>& state, int lane, KernelAnswer& answer) {
    for (int i = 0; i < N; ++i) answer.q[i] = state.q[i][lane];
    return descend<N, Prismatic, Pose>(C, task, target, finishSteps, true, answer);
  }

  static void race(const ChainConstants& C, const KernelTask& task, const KernelTarget& goal,
                   const LaneStarts& starts, int maxAttempts, std::uint64_t randomSeed,
                   KernelAnswer& answer) {
    const FloatConstants rough(C);
    LaneState<Floats, N> state;
    Target<double> target;
    broadcast(goal, target);
    for (int l = 0; l < kernelLanes; ++l) state.aim(goal, l);
    const unsigned int seed = folded(randomSeed);
    firstStarts(rough, starts, seed, state);
    answer.solved = answer.iterations = answer.evaluations = 0;
    int live = maxAttempts < kernelLanes ? (1 << maxAttempts) - 1 : (1 << kernelLanes) - 1;  // lanes at work
    answer.attempts = __builtin_popcount(live);
    int number[kernelLanes];  // of a lane's random start; -1: a given one
    for (int l = 0; l < kernelLanes; ++l) number[l] = starts.valid >> l & 1 ? -1 : l;
    answer.error2 = 1e300;
    double best = 1e300, bestQ[N] = {};
    while (live) {
      const LaneEvents events = iterateLanes<N, Prismatic, Pose>(rough, task, state);
      answer.iterations += __builtin_popcount(live);
      answer.evaluations += __builtin_popcount(live);
      for (int done = (events.close | events.spent) & live; done; done &= done - 1) {
        const int l = __builtin_ctz(done);
        if (events.close >> l & 1 && finish(C, task, target, state, l, answer)) {
          answer.solved = 1;
          if (number[l] >= 0) randomStart(rough, seed, number[l], state, l);
          for (int i = 0; i < N; ++i) answer.start[i] = number[l] >= 0 ? state.q[i][l] : starts.q[i][l];
          return;
        }
        if (state.error2[l] < best) {  // of the step before: a start for the search of the closest pose
          best = state.error2[l];
          for (int i = 0; i < N; ++i) bestQ[i] = state.q[i][l];
        }
        if (answer.attempts >= maxAttempts) {
          live &= ~(1 << l);
          continue;
        }
        state.age[l] = 0.0f;
        number[l] = answer.attempts++;
        randomStart(rough, seed, number[l], state, l);
      }
    }
    for (int i = 0; i < N; ++i) answer.q[i] = bestQ[i];
    answer.error2 = best;
  }

  /// Lanes of problems in work; those that come close wait until finishLanes of them are finished side by
  /// side.
  struct Batch {
    const ChainConstants& C;
    const KernelTask& task;
    const KernelTarget* goals;
    int count;
    const double* seeds;
    int seedsEach, maxAttempts;
    std::uint64_t randomSeed;
    KernelAnswer* answers;
    const FloatConstants rough{C};

    LaneState<Floats, N> state{};
    LaneState<Doubles, N> waiting{};
    int problem[kernelLanes] = {}, waitingFor[finishLanes] = {}, again[2 * kernelLanes] = {};
    int next = 0, busy = 0, waitingCount = 0, againCount = 0;

    void nextStart(int lane) {
      KernelAnswer& answer = answers[problem[lane]];
      state.age[lane] = 0.0f;
      if (answer.attempts < seedsEach) {
        const double* seed = seeds + (static_cast<long>(problem[lane]) * seedsEach + answer.attempts) * N;
        for (int i = 0; i < N; ++i) state.q[i][lane] = static_cast<float>(seed[i]);
      } else {  // numbers of the problem and the attempt alone
        const std::uint64_t seed =
            randomSeed + 0xd1342543de82ef95ULL * static_cast<std::uint64_t>(problem[lane] + 1);
        randomStart(rough, folded(seed), answer.attempts, state, lane);
      }
      ++answer.attempts;
    }

    void nextProblem(int lane) {
      if (againCount > 0) {
        problem[lane] = again[--againCount];
      } else if (next < count) {
        problem[lane] = next++;
        KernelAnswer& answer = answers[problem[lane]];
        answer.solved = answer.iterations = answer.evaluations = answer.attempts = 0;
        answer.error2 = 1e300;
      } else {
        busy &= ~(1 << lane);
        return;
      }
      busy |= 1 << lane;
      state.aim(goals[problem[lane]], lane);
      nextStart(lane);
    }

    /// The waiting ones in double precision: steps side by side, alone where that did not do.
    void finishWaiting() {
      constexpr int together = 3;
      for (int w = waitingCount; w < finishLanes; ++w) {
        for (int i = 0; i < N; ++i) waiting.q[i][w] = waiting.q[i][0];
        waiting.aim(goals[waitingFor[0]], w);
      }
      int solved = 0;
      for (int first = 0; first < finishLanes; first += lanesIn<Doubles>) {
        Doubles q[N];
        Target<Doubles> target;
        waiting.read(first, q, target);
        GELENK_UNROLL for (int i = 0; i < N; ++i) q[i] = clamped<Doubles>(q[i], C.lower[i], C.upper[i]);
        constexpr int all = (1 << lanesIn<Doubles>)-1;
        Doubles steps = fill<Doubles>(0);
        for (int taken = 0;; ++taken) {
          Place<Doubles, N> at;
          Error<Doubles> error;
          evaluate<Doubles, N, Prismatic, Pose>(C, task, target, q, at, error);
          const DoublesMask within = isWithin(error, task.positionTolerance2, task.orientationTolerance2);
          const int solvedHere = bits(within);
          if (solvedHere == all || taken == together) {
            solved |= solvedHere << first;
            store(error.squared, waiting.error2 + first);
            store(steps, waiting.age + first);
            break;
          }
          Doubles moved[N];
          GELENK_UNROLL for (int i = 0; i < N; ++i) moved[i] = q[i];
          step<Doubles, N, Prismatic, Pose>(C, task, at, error, moved);
          GELENK_UNROLL for (int i = 0; i < N; ++i) q[i] = select(within, q[i], moved[i]);
          steps = steps + select(within, fill<Doubles>(0), fill<Doubles>(1));
        }
        GELENK_UNROLL for (int i = 0; i < N; ++i) store(q[i], waiting.q[i] + first);
      }
      for (int w = 0; w < waitingCount; ++w) settle(w, solved >> w & 1);
      waitingCount = 0;
    }

    void settle(int w, bool solved) {
      KernelAnswer& answer = answers[waitingFor[w]];
      KernelAnswer here;
      here.iterations = static_cast<int>(waiting.age[w]);
      here.evaluations = here.iterations + 1;
      here.error2 = waiting.error2[w];
      for (int i = 0; i < N; ++i) here.q[i] = waiting.q[i][w];
      if (!solved) {
        Target<double> target;
        broadcast(goals[waitingFor[w]], target);
        solved = descend<N, Prismatic, Pose>(C, task, target, finishSteps, true, here);
      }
      answer.iterations += here.iterations;
      answer.evaluations += here.evaluations;
      if (solved || here.error2 < answer.error2) {
        answer.solved = solved;
        answer.error2 = here.error2;
        for (int i = 0; i < N; ++i) answer.q[i] = here.q[i];
      }
      if (!solved && answer.attempts < maxAttempts) again[againCount++] = waitingFor[w];
    }

    void run() {
      for (int l = 0; l < kernelLanes; ++l) nextProblem(l);
      while (busy || waitingCount > 0) {
        if (!busy) {
          finishWaiting();
          for (int l = 0; l < kernelLanes && againCount > 0; ++l) nextProblem(l);
          continue;
        }
        const LaneEvents events = iterateLanes<N, Prismatic, Pose>(rough, task, state);
        for (int done = (events.close | events.spent) & busy; done; done &= done - 1) {
          const int l = __builtin_ctz(done);
          KernelAnswer& answer = answers[problem[l]];
          answer.iterations += static_cast<int>(state.age[l]);
          answer.evaluations += static_cast<int>(state.age[l]);
          if (events.close >> l & 1) {
            for (int i = 0; i < N; ++i) waiting.q[i][waitingCount] = state.q[i][l];
            waiting.aim(goals[problem[l]], waitingCount);
            waitingFor[waitingCount++] = problem[l];
            if (waitingCount == finishLanes) finishWaiting();
            nextProblem(l);
            continue;
          }
          if (state.error2[l] < answer.error2) {
            answer.error2 = state.error2[l];
            for (int i = 0; i < N; ++i) answer.q[i] = state.q[i][l];
          }
          if (answer.attempts < maxAttempts)
            nextStart(l);
          else
            nextProblem(l);
        }
      }
    }
  };

  static void batch(const ChainConstants& C, const KernelTask& task, const KernelTarget* goals, int count,
                    const double* seeds, int seedsEach, int maxAttempts, std::uint64_t randomSeed,
                    KernelAnswer* answers) {
    Batch{C, task, goals, count, seeds, seedsEach, maxAttempts, randomSeed, answers}.run();
  }

  static void frameAndJacobian(const ChainConstants& C, const double* base, const double* point,
                               const double* q, double* frame, double* J) {
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

  static void turnSeeds(const ChainConstants& C, const KernelTarget& goal, const SeedCell& cell, int count,
                        LaneStarts& starts) {
    const double radius2 = goal.p[0] * goal.p[0] + goal.p[1] * goal.p[1];
    const double perRadius = radius2 > 0.0 ? 1.0 / __builtin_sqrt(radius2) : 0.0;
    const double c = radius2 > 0.0 ? goal.p[0] * perRadius : 1.0, s = goal.p[1] * perRadius;
    const float x[3] = {float(c * goal.x[0] + s * goal.x[1]), float(c * goal.x[1] - s * goal.x[0]),
                        float(goal.x[2])};
    const float y[3] = {float(c * goal.y[0] + s * goal.y[1]), float(c * goal.y[1] - s * goal.y[0]),
                        float(goal.y[2])};
    starts.valid = 0;
    for (int first = 0; first < kernelLanes; first += lanesIn<Floats>) {
      Floats ex[3], ey[3];
      for (int k = 0; k < 3; ++k)
        ex[k] = load<Floats>(cell.x[k] + first), ey[k] = load<Floats>(cell.y[k] + first);
      const Floats cosineRoll = dot(ex, x) + dot(ey, y), sineRoll = dot(ey, x) - dot(ex, y);
      for (int i = 1; i < N - 1; ++i) store(load<Floats>(cell.q[i] + first), starts.q[i] + first);
      const Floats azimuth = roughAngle(fill<Floats>(float(c)), fill<Floats>(float(s)));
      const FloatsMask spins =
          intoRange(load<Floats>(cell.q[0] + first) + azimuth, C.lower[0], C.upper[0], starts.q[0] + first);
      const FloatsMask rolls = intoRange(roughAngle(cosineRoll, sineRoll), C.lower[N - 1], C.upper[N - 1],
                                         starts.q[N - 1] + first);
      starts.valid |= bits(spins & rolls) << first;
    }
    starts.valid &= (1 << count) - 1;
  }

  static double error(const ChainConstants& C, const KernelTask& task, const KernelTarget& goal,
                      const double* q) {
    Target<double> target;
    Place<double, N> at;
    Error<double> error;
    broadcast(goal, target);
    evaluate<double, N, Prismatic, Pose>(C, task, target, q, at, error);
    return error.squared;
  }
};

/// The loops for one kind of chain: a pose of the last frame has loops of its own where Pose is set, the
/// other goals share one.
template <int N, bool Prismatic>
struct Dispatch {
  using General = Loops<N, Prismatic, false>;
  using Pose = Loops<N, Prismatic, !Prismatic>;
  static bool isPose(const KernelTask& task) { return task.position && task.orientation && !task.hasPoint; }

  static void attempt(const ChainConstants& C, const KernelTask& task, const KernelTarget& goal,
                      const double* start, KernelAnswer& answer) {
    (isPose(task) ? Pose::attempt : General::attempt)(C, task, goal, start, answer);
  }
  static void race(const ChainConstants& C, const KernelTask& task, const KernelTarget& goal,
                   const LaneStarts& starts, int maxAttempts, std::uint64_t randomSeed,
                   KernelAnswer& answer) {
    (isPose(task) ? Pose::race : General::race)(C, task, goal, starts, maxAttempts, randomSeed, answer);
  }
  static void batch(const ChainConstants& C, const KernelTask& task, const KernelTarget* goals, int count,
                    const double* seeds, int seedsEach, int maxAttempts, std::uint64_t randomSeed,
                    KernelAnswer* answers) {
    (isPose(task) ? Pose::batch : General::batch)(C, task, goals, count, seeds, seedsEach, maxAttempts,
                                                  randomSeed, answers);
  }
  static constexpr SerialKernel table{
      &attempt, &race, &batch, &General::frameAndJacobian, &General::turnSeeds, &General::error};
};

template <bool Prismatic>
const SerialKernel* kernelFor(int n) {
  switch (n) {
    case 1: return &Dispatch<1, Prismatic>::table;
    case 2: return &Dispatch<2, Prismatic>::table;
    case 3: return &Dispatch<3, Prismatic>::table;
    case 4: return &Dispatch<4, Prismatic>::table;
    case 5: return &Dispatch<5, Prismatic>::table;
    case 6: return &Dispatch<6, Prismatic>::table;
    case 7: return &Dispatch<7, Prismatic>::table;
    case 8: return &Dispatch<8, Prismatic>::table;
    default: return nullptr;
  }
}

}  // namespace

const SerialKernel* GELENK_KERNEL_FUNCTION(int n, bool prismatic) {
  // Only arms of 6 and 7 revolute joints have loops of their own; the rest share the general ones.
  if (prismatic || n < 6 || n > 7) return kernelFor<true>(n);
  return n == 6 ? &Dispatch<6, false>::table : &Dispatch<7, false>::table;
}

}  // namespace gelenk
