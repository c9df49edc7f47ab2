#pragma once

// What the loops of the skinning methods share: posed bones as columns of four doubles, the twist of a bone
// at a vertex, and the walk over all vertices. For skinning/blend/*.cpp alone.

#include <cmath>
#include <vector>

#include "skinning/blend/skin_method.h"

// GCC compiles a loop twice and the loader takes the better one for the processor at hand. (Not under
// sanitizers, which start later than such a choice is made, and clang 14 has another way.) Compiled
// without errno, so that square roots are taken four at a time.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__)
#define GELENK_FOR_EACH_PROCESSOR __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define GELENK_FOR_EACH_PROCESSOR
#endif
/// Each compilation of a loop must inline its own.
#define GELENK_INLINE [[gnu::always_inline]] inline
#pragma GCC diagnostic ignored "-Wpsabi"  // nothing below is called across files

namespace gelenk::blend {

/// Four doubles that are added and scaled together: (x, y, z, anything), or a quaternion (x, y, z, w).
typedef double Column __attribute__((vector_size(32), aligned(32)));
typedef long long Order __attribute__((vector_size(32)));

/// (y, z, x, w).
#ifdef __clang__
#define GELENK_TURNED(v) __builtin_shufflevector(v, v, 1, 2, 0, 3)
#else
#define GELENK_TURNED(v) __builtin_shuffle(v, gelenk::blend::Order{1, 2, 0, 3})
#endif

GELENK_INLINE Column cross(Column a, Column b) {
  const Column turned = a * GELENK_TURNED(b) - GELENK_TURNED(a) * b;
  return GELENK_TURNED(turned);
}
GELENK_INLINE double dot3(Column a, Column b) {
  const Column m = a * b;
  return m[0] + m[1] + m[2];
}
GELENK_INLINE double dot4(Column a, Column b) {
  const Column m = a * b;
  return (m[0] + m[1]) + (m[2] + m[3]);
}
GELENK_INLINE Column load3(const double* p) { return Column{p[0], p[1], p[2], 0.0}; }
GELENK_INLINE void store3(Column v, double* p) { p[0] = v[0], p[1] = v[1], p[2] = v[2]; }

/// Columns of a 3 x 4 matrix.
struct Columns {
  Column x, y, z, t;
};
GELENK_INLINE void add(Columns& sum, double w, const Columns& m) {
  sum.x += w * m.x;
  sum.y += w * m.y;
  sum.z += w * m.z;
  sum.t += w * m.t;
}
GELENK_INLINE Column linear(const Columns& m, Column v) { return v[0] * m.x + v[1] * m.y + v[2] * m.z; }
GELENK_INLINE Column at(const Columns& m, Column p) { return (p[0] * m.x + m.t) + (p[1] * m.y + p[2] * m.z); }
GELENK_INLINE Column at(const Columns& m, const double* p) {
  return (p[0] * m.x + m.t) + (p[1] * m.y + p[2] * m.z);
}
GELENK_INLINE Column linear(const Columns& m, const double* v) {
  return v[0] * m.x + v[1] * m.y + v[2] * m.z;
}

/// A posed bone: its motion as a matrix and as a unit dual quaternion q + eps p, p = t q / 2.
struct BoneColumns {
  Columns motion;
  Column q, p;
};

/// A bone whose twist is spread. Its motion at a vertex is fixed + cos(phi) even + sin(phi) odd, its dual
/// quaternion cos(phi / 2) (q, p) + sin(phi / 2) (qOdd, pOdd).
struct TwistColumns {
  static constexpr int knots = 65;
  Columns fixed, even, odd;
  Column qOdd, pOdd;
  Column axisByLength;    ///< a / l
  double start;           ///< a . h / l
  double halfSlope;       ///< d(phi / 2) / ds
  double knot[knots][2];  ///< cos, sin of phi / 2 at s = i / 64
};

/// What the loop reads; plain arrays, one entry a vertex unless said otherwise.
struct BlendInput {
  std::size_t count;
  const BoneColumns* bones;  ///< one a joint
  const int* twistOfJoint;   ///< -1: none
  const TwistColumns* twists;
  const Influences* influences;
  const double *positions, *normals;     ///< 3
  const double* slopes;                  ///< 8: along t1, along t2
  const double *centres, *centreSlopes;  ///< 3 and 6
  double *outPositions, *outNormals;     ///< 3
};

/// A bone's motion at a vertex.
struct BoneAt {
  BoneColumns bone;
  bool twisted = false;
  double slope1 = 0.0, slope2 = 0.0;  ///< of phi along the tangents
  Columns motionSlope;                ///< by phi
  Column qSlope, pSlope;
};

/// half: of phi. sine and cosine from the nearest knot, the rest of at most 0.03 a turn by series: 1e-15.
GELENK_INLINE void halfTurn(const TwistColumns& twist, double s, double& cosine, double& sine) {
  const double place = s * (TwistColumns::knots - 1);
  const int k = static_cast<int>(place + 0.5);
  const double r = (place - k) * (1.0 / (TwistColumns::knots - 1)) * twist.halfSlope, r2 = r * r;
  const double sr = r - r * r2 * (1.0 / 6.0 - r2 * (1.0 / 120.0 - r2 * (1.0 / 5040.0)));
  const double cr = 1.0 - r2 * (0.5 - r2 * (1.0 / 24.0 - r2 * (1.0 / 720.0)));
  const double ck = twist.knot[k][0], sk = twist.knot[k][1];
  cosine = ck * cr - sk * sr;
  sine = sk * cr + ck * sr;
}

template <bool dual, bool matrix, bool gradients>
GELENK_INLINE void twistedBone(const BoneColumns& bone, const TwistColumns& twist, Column rest, Column t1,
                               Column t2, BoneAt& out) {
  double s = dot3(twist.axisByLength, rest) - twist.start;
  const bool between = s > 0.0 && s < 1.0;
  s = s < 0.0 ? 0.0 : s > 1.0 ? 1.0 : s;
  double ch, sh;
  halfTurn(twist, s, ch, sh);
  const double c = ch * ch - sh * sh, sn = 2.0 * ch * sh;
  if (matrix) {
    out.bone.motion.x = twist.fixed.x + c * twist.even.x + sn * twist.odd.x;
    out.bone.motion.y = twist.fixed.y + c * twist.even.y + sn * twist.odd.y;
    out.bone.motion.z = twist.fixed.z + c * twist.even.z + sn * twist.odd.z;
    out.bone.motion.t = twist.fixed.t + c * twist.even.t + sn * twist.odd.t;
  }
  out.bone.q = ch * bone.q + sh * twist.qOdd;
  if (dual) out.bone.p = ch * bone.p + sh * twist.pOdd;
  out.twisted = true;
  if (!gradients) return;
  const double slope = between ? 2.0 * twist.halfSlope : 0.0;
  out.slope1 = slope * dot3(twist.axisByLength, t1);
  out.slope2 = slope * dot3(twist.axisByLength, t2);
  if (matrix) {
    out.motionSlope.x = c * twist.odd.x - sn * twist.even.x;
    out.motionSlope.y = c * twist.odd.y - sn * twist.even.y;
    out.motionSlope.z = c * twist.odd.z - sn * twist.even.z;
    out.motionSlope.t = c * twist.odd.t - sn * twist.even.t;
  }
  out.qSlope = 0.5 * (ch * twist.qOdd - sh * bone.q);
  if (dual) out.pSlope = 0.5 * (ch * twist.pOdd - sh * bone.p);
}

/// The two tangents of surfaceTangents.
GELENK_INLINE void tangents(Column n, Column& t1, Column& t2) {
  const double side = static_cast<float>(n[2]) >= 0.0f ? 1.0 : -1.0;
  const double a = -1.0 / (side + n[2]), b = n[0] * n[1] * a;
  t1 = Column{1.0 + side * n[0] * n[0] * a, side * b, -side * n[0], 0.0};
  t2 = Column{b, side + n[1] * n[1] * a, -n[1], 0.0};
}

/// By q / |q|, where twoBySquare = 2 / |q|^2: no square root.
GELENK_INLINE Column rotate(Column q, double twoBySquare, Column v) {
  const Column u = cross(q, v);
  return v + twoBySquare * (q[3] * u + cross(q, u));
}
/// Vector part of a conj(b).
GELENK_INLINE Column vecTimesConjugate(Column a, Column b) { return b[3] * a - a[3] * b - cross(a, b); }

/// A vertex of one bone goes with it, whatever the method.
template <bool twist>
GELENK_INLINE void withOneBone(const BlendInput& in, std::size_t v, Column& position, Column& normal) {
  const int joint = in.influences[v].joints[0];
  const Columns* motion = &in.bones[joint].motion;
  BoneAt here;
  if (twist && in.twistOfJoint[joint] >= 0) {
    twistedBone<false, true, false>(in.bones[joint], in.twists[in.twistOfJoint[joint]],
                                    load3(in.positions + 3 * v), Column{}, Column{}, here);
    motion = &here.bone.motion;
  }
  position = at(*motion, in.positions + 3 * v);
  normal = linear(*motion, in.normals + 3 * v);
}

constexpr std::size_t blockSize = 64;  ///< vertices between two rounds of square roots

/// Method::vertex<twist, gradients>(in, v, position, normal) for every vertex; normals come in any length.
template <class Method, bool twist, bool gradients>
GELENK_INLINE void blendVertices(const BlendInput& in) {
  double scale[blockSize] = {};
  for (std::size_t start = 0; start < in.count; start += blockSize) {
    const std::size_t end = start + blockSize < in.count ? start + blockSize : in.count;
    for (std::size_t v = start; v < end; ++v) {
      Column position, normal;
      Method::template vertex<twist, gradients>(in, v, position, normal);
      store3(position, in.outPositions + 3 * v);
      store3(normal, in.outNormals + 3 * v);
      scale[v - start] = dot3(normal, normal);
    }
    for (std::size_t i = 0; i < blockSize; ++i) scale[i] = 1.0 / std::sqrt(scale[i]);
    for (std::size_t v = start; v < end; ++v)
      for (int k = 0; k < 3; ++k) in.outNormals[3 * v + k] *= scale[v - start];
  }
}

/// The four loops of a method, and which of them a call takes.
#define GELENK_BLEND_LOOPS(Method)                                                                        \
  GELENK_FOR_EACH_PROCESSOR void cheap(const BlendInput& in) { blendVertices<Method, false, false>(in); } \
  GELENK_FOR_EACH_PROCESSOR void exact(const BlendInput& in) { blendVertices<Method, false, true>(in); }  \
  GELENK_FOR_EACH_PROCESSOR void cheapTwisted(const BlendInput& in) {                                     \
    blendVertices<Method, true, false>(in);                                                               \
  }                                                                                                       \
  GELENK_FOR_EACH_PROCESSOR void exactTwisted(const BlendInput& in) { blendVertices<Method, true, true>(in); }
struct Loops {
  void (*cheap)(const BlendInput&), (*exact)(const BlendInput&);
  void (*cheapTwisted)(const BlendInput&), (*exactTwisted)(const BlendInput&);
};
/// Makes the input and runs the loop that fits.
void runLoop(const Loops& loops, const PreparedSkin& prepared, const PosedBones& bones, SkinNormals normals,
             SkinnedVertices& out);

}  // namespace gelenk::blend
