#include "solvers/solutions/closed_loop.h"

#include <algorithm>

#include "solvers/solutions/lane_vectors.h"
#include "solvers/solutions/placing.h"
#include "solvers/solutions/planar_system.h"

namespace gelenk {
namespace {

using namespace planar;
using namespace lanes;

constexpr double inLineSine = 1e-12;  ///< between axes 4 and 6 of a wrist: only their sum is determined
constexpr double merging = 1e-6;      ///< branches nearer to each other than this may be one
// A point, or the tip of a direction, beside the axis of a hinge that has to turn it:
constexpr double onAxis = 1e-11;    ///< so near that the hinge may take any value
constexpr double nearAxis = 1e-6;   ///< so near that rounding may have chosen the value
constexpr double nearReach = 1e-4;  ///< a cosine this far beyond 1 may come of such a value

/// The first three hinges of four branches; of those that slide the length, and no turn.
struct First {
  Turns t[3];
  Mask free;
  Lanes length[3] = {};
};

/// The ways that a planar system leaves, and four of them.
struct PlanarWays {
  PlanarSystem system;
  int count = 0;
  bool alike = false;
  PlanarSolution list[8];

  void solve(double freeAngle) {
    count = planar::solve(system, freeAngle, list);
    for (int i = 0; i < count; ++i)
      for (int k = 0; k < i; ++k)
        alike |= std::abs(list[i].t.c - list[k].t.c) + std::abs(list[i].t.s - list[k].t.s) < merging &&
                 (list[i].z - list[k].z).squaredNorm() < merging * merging;
  }
  GELENK_INLINE void four(int base, Turns& t, Lanes& zx, Lanes& zy, Mask& free) const {
    double in[4][4];
    for (int l = 0; l < 4; ++l) {
      const PlanarSolution& p = list[std::min(base + l, count - 1)];
      in[0][l] = p.t.c, in[1][l] = p.t.s, in[2][l] = p.z.x(), in[3][l] = p.z.y();
      free[l] = p.free ? -1L : 0L;
    }
    t = {load(in[0]), load(in[1])}, zx = load(in[2]), zy = load(in[3]);
  }
};

}  // namespace

Vector6d TripleSolutions::at(int k) const {
  Vector6d angles;
  for (int j = 0; j < 6; ++j) angles[j] = u[j][k];
  return angles;
}
void TripleSolutions::set(int k, const Vector6d& angles) {
  for (int j = 0; j < 6; ++j) u[j][k] = angles[j];
}

void TripleSolutions::move(int from, int to) {
  for (int j = 0; j < 6; ++j) u[j][to] = u[j][from];
  error[to] = error[from], free[to] = free[from];
}

TripleLoop::TripleLoop(LoopClass kind, const Loop& loop, int goalLink)
    : kind_(kind), loop_(loop), goalLink_(goalLink) {
  const Matrix3d R4 = loop.link[3].linear(), R5 = loop.link[4].linear();
  const Vector3d x4 = loop.link[3].translation(), x5 = loop.link[4].translation();
  if (kind == LoopClass::SphericalTriple) {
    // Axis 4 is z through 0, axis 5 is R4 z through x4: they meet at this height of axis 4; axis 6 seen from
    // behind is R5^T z through -R5^T x5.
    const auto height = [](const Vector3d& p, const Vector3d& z) {
      return p.z() - z.z() * (p.x() * z.x() + p.y() * z.y()) / (z.x() * z.x() + z.y() * z.y());
    };
    before_ = height(x4, R4.col(2));
    after_ = height(-R5.transpose() * x5, R5.row(2).transpose());
    const Vector3d in = R4.row(2).transpose(), out = R5.col(2);
    const double twist = std::atan2(std::hypot(in.x(), in.y()), in.z()),
                 next = std::atan2(std::hypot(out.x(), out.y()), out.z());
    bend_.alongGap = 2.0 * std::pow(std::sin(0.5 * (twist - next)), 2);
    bend_.againstGap = 2.0 * std::pow(std::cos(0.5 * (twist + next)), 2);
    bend_.middle = R4(2, 2) * R5(2, 2);
    bend_.cos = R4(2, 0) * R5(0, 2) + R4(2, 1) * R5(1, 2);
    bend_.sin = R4(2, 1) * R5(0, 2) - R4(2, 0) * R5(1, 2);
  } else {
    const Vector2d p4 = x4.head<2>(), q5 = x5.head<2>(), q5c = R4.topLeftCorner<2, 2>() * q5,
                   q5s = R4.topLeftCorner<2, 2>() * Vector2d(-q5.y(), q5.x());
    bend_.middle = p4.squaredNorm() + q5.squaredNorm();
    bend_.cos = 2.0 * p4.dot(q5c);
    bend_.sin = 2.0 * p4.dot(q5s);
  }
  bend_.size = std::hypot(bend_.cos, bend_.sin);
  if (bend_.size > 0.0) bend_.cos /= bend_.size, bend_.sin /= bend_.size;
}

namespace {

/// Where three axes meet, g seen from before hinge 1: v = X2 Rz(u3) c as waves of u3; Rz(u2) v = w must
/// satisfy |X1 w| = |g| and (X1 w).z = g.z.
struct SphericalFront : PlanarWays {
  static constexpr bool spherical = true;
  Vector3d fixed, vc, vs, g;

  SphericalFront(const Isometry3d& X1, const Isometry3d& X2, const Vector3d& c, const Vector3d& g,
                 const Vector6d& reference)
      : g(g) {
    const Matrix3d R1 = X1.linear(), R2 = X2.linear();
    const Vector3d x1 = X1.translation();
    fixed = X2.translation() + R2.col(2) * c.z();
    vc = R2.col(0) * c.x() + R2.col(1) * c.y();
    vs = R2.col(1) * c.x() - R2.col(0) * c.y();
    const Wave vz{fixed.z(), vc.z(), vs.z()};
    const Wave vv{fixed.squaredNorm() + vc.squaredNorm(), 2.0 * fixed.dot(vc), 2.0 * fixed.dot(vs)};
    const Vector3d n = R1.transpose() * x1, m = R1.row(2).transpose();
    system.n = n.head<2>(), system.m = m.head<2>();
    system.alpha = Wave{0.5 * (g.squaredNorm() - x1.squaredNorm()), 0, 0} - 0.5 * vv - n.z() * vz;
    system.beta = Wave{g.z() - x1.z(), 0, 0} - m.z() * vz;
    system.x = {fixed.x(), vc.x(), vs.x()}, system.y = {fixed.y(), vc.y(), vs.y()};
    solve(reference[2]);
  }

  GELENK_INLINE First at(int base, const Isometry3d& X1, const Isometry3d&, const Vector6d& reference,
                         double axis) const {
    First first{};
    Turns& t3 = first.t[2];
    Lanes zx, zy;
    four(base, t3, zx, zy, first.free);
    first.free &= 4L;
    const Vectors v{fixed.x() + vc.x() * t3.c + vs.x() * t3.s, fixed.y() + vc.y() * t3.c + vs.y() * t3.s,
                    fixed.z() + vc.z() * t3.c + vs.z() * t3.s};
    first.t[1] = turnsFromTo(v, {zx, zy, v.z}, reference[1], axis, 2L, first.free);
    first.t[0] = turnsFromTo(moved(X1, turned(first.t[1], v)), same(g), reference[0], axis, 1L, first.free);
    return first;
  }
};

/// Where three axes are parallel: the common direction, h0 seen from before hinge 1 and h3 from before
/// hinge 4, and the height along it must come out right.
struct ParallelFront : PlanarWays {
  static constexpr bool spherical = false;
  Vector3d h0, h3;

  ParallelFront(const Isometry3d& X1, const Isometry3d& X2, const Vector3d& h0, const Vector3d& h3,
                double height, const Vector6d& reference)
      : h0(h0), h3(h3) {
    const auto waveOf = [&](const Vector3d& a) {  // a . Rz(-u1) h0
      return Wave{a.z() * h0.z(), a.x() * h0.x() + a.y() * h0.y(), a.x() * h0.y() - a.y() * h0.x()};
    };
    const Matrix3d R1 = X1.linear(), R2 = X2.linear();
    const Vector3d x2 = X2.translation(), r2 = R2.col(2);
    const Wave etaZ = waveOf(R1.col(2));
    system.n = x2.head<2>(), system.m = r2.head<2>();
    system.alpha = Wave{height, 0, 0} - waveOf(X1.translation()) - x2.z() * etaZ;
    system.beta = Wave{h3.z(), 0, 0} - r2.z() * etaZ;
    system.x = waveOf(R1.col(0)), system.y = waveOf(R1.col(1));
    solve(reference[0]);
  }

  GELENK_INLINE First at(int base, const Isometry3d& X1, const Isometry3d& X2, const Vector6d& reference,
                         double axis) const {
    First first{};
    Turns& t1 = first.t[0];
    Lanes zx, zy;
    four(base, t1, zx, zy, first.free);
    first.free &= 1L;
    const Vectors eta = timesBack(X1, turnedBack(t1, same(h0)));
    first.t[1] = turnsFromTo({zx, zy, eta.z}, eta, reference[1], axis, 2L, first.free);
    first.t[2] =
        turnsFromTo(same(h3), timesBack(X2, turnedBack(first.t[1], eta)), reference[2], axis, 4L, first.free);
    return first;
  }
};

/// Three axes that meet behind hinges of which some slide.
struct SlidingFront {
  static constexpr bool spherical = true;
  int count = 0;
  bool alike = true;
  Placed list[8];

  SlidingFront(const Placing& placing, const Vector6d& reference)
      : count(place(placing, reference.data(), list)) {}

  GELENK_INLINE First at(int base, const Isometry3d&, const Isometry3d&, const Vector6d&, double) const {
    First first{};
    for (int l = 0; l < 4; ++l) {
      const Placed& p = list[std::min(base + l, count - 1)];
      for (int i = 0; i < 3; ++i)
        first.t[i].c[l] = p.t[i].c, first.t[i].s[l] = p.t[i].s, first.length[i][l] = p.length[i];
      first.free[l] = p.free;
    }
    return first;
  }
};

/// X3^-1 H3^-1 X2^-1 H2^-1 X1^-1 H1^-1 v: of a direction, of a point.
GELENK_INLINE Vectors directionBehind(const Isometry3d* const X[3], const First& first, Vectors v) {
  for (int i = 0; i < 3; ++i) v = timesBack(*X[i], turnedBack(first.t[i], v));
  return v;
}
GELENK_INLINE Vectors pointBehind(const Isometry3d* const X[3], const First& first, Vectors v) {
  for (int i = 0; i < 3; ++i) {
    v.z -= first.length[i];
    v = movedBack(*X[i], turnedBack(first.t[i], v));
  }
  return v;
}

/// What three hinges leave for the triple: Rz(u4) R4 Rz(u5) R5 Rz(u6) = (K0, K1, K2), and the place k to
/// which it leads.
struct Left {
  Vectors K0, K1, K2, k;
  Mask inLine;          ///< axes 4 and 6 of a wrist
  Lanes x, less, more;  ///< the cosine of the bend, and what is left of 1 - x and 1 + x
  Mask reached;
};

template <bool spherical>
GELENK_INLINE Left leftBehind(const First& first, const Isometry3d* const X[3], const Isometry3d& back,
                              const TripleBend& bend) {
  Left left{.K0 = directionBehind(X, first, same(back.linear().col(0))),
            .K1 = directionBehind(X, first, same(back.linear().col(1))),
            .K2 = {},
            .k = pointBehind(X, first, same(back.translation())),
            .inLine = {},
            .x = {},
            .less = {},
            .more = {},
            .reached = {}};
  left.K2 = cross(left.K0, left.K1);
  const Vectors &K2 = left.K2, &k = left.k;
  const bool bends = bend.size > rounding;  // else every bend will do, or none
  const double scale = bends ? 1.0 / bend.size : 0.0;
  const Lanes over = (spherical ? K2.z : k.x * k.x + k.y * k.y) - bend.middle;
  left.x = over * scale, left.less = 1.0 - left.x, left.more = 1.0 + left.x;
  if (spherical) {
    // Axes 4 and 6 nearly in line: the sine between them is exact where a cosine near one is not.
    const Lanes sine2 = K2.x * K2.x + K2.y * K2.y, rest = sine2 / (1.0 + magnitude(K2.z));
    left.inLine = sine2 < inLineSine * inLineSine;
    const Mask ahead = K2.z > 0.0;
    left.less = (choose(ahead, rest, 1.0 - K2.z) - bend.alongGap) * scale;
    left.more = (choose(ahead, 1.0 + K2.z, rest) - bend.againstGap) * scale;
  }
  left.reached = bends ? magnitude(left.x) <= 1.0 + reachRounding : magnitude(over) < reachRounding;
  return left;
}

/// The turn nearest to 0 at which a wave of degree two, known by its values at five equal steps of a turn, is
/// 1 or -1; none: NaN.
double nearestTouch(const double (&values)[5]) {
  TrigonometricPolynomial wave;
  wave.degree = 2;
  for (int k = 0; k < 5; ++k) {
    wave.a[0] += values[k] / 5.0;
    for (int n = 1; n <= 2; ++n) {
      wave.a[n] += 0.4 * values[k] * std::cos(turn / 5.0 * n * k);
      wave.b[n] += 0.4 * values[k] * std::sin(turn / 5.0 * n * k);
    }
  }
  double nearest = NAN;
  for (const double end : {1.0, -1.0}) {
    TrigonometricPolynomial beyond = wave;
    beyond.a[0] -= end;
    const TrigonometricRoots roots = realRoots(beyond, reachRounding);
    for (int i = 0; i < roots.count; ++i) {
      const double t = wrapped(roots.t[i]);
      if (!(std::abs(t) >= std::abs(nearest))) nearest = t;
    }
  }
  return nearest;
}

/// Branches out of reach of the bend only because a hinge that could take any value has the reference's, or
/// one that rounding chose: such a hinge is put where the bend is just reached, at the nearest such place.
/// The cosine of the bend is a wave of degree two of each hinge.
template <class Make, class Front>
[[gnu::noinline]] void moveIntoReach(const Make& frontAt, const Front& front, int base,
                                     const Isometry3d* const X[3], const Isometry3d& back,
                                     const TripleBend& bend, const Vector6d& reference, const Left& left,
                                     First& first) {
  const First near = front.at(base, *X[0], *X[1], reference, nearAxis);
  for (int l = 0; l < 4 && base + l < front.count; ++l) {
    if (left.reached[l]) continue;
    const bool isNear = std::abs(left.x[l]) < 1.0 + nearReach;
    for (int h = 0; h < 3; ++h) {
      const bool isFree = first.free[l] >> h & 1;
      if (!isFree && !(isNear && near.free[l] >> h & 1)) continue;
      Vector6d at = reference;
      const double present = std::atan2(first.t[h].s[l], first.t[h].c[l]);
      const auto member = [&](double by, double axis, First& there) {
        at[h] = present + by;
        const Front family = frontAt(at);
        if (base + l < family.count) there = family.at(base, *X[0], *X[1], at, axis);
        return base + l < family.count;
      };
      const double axis = isFree ? onAxis : nearAxis;
      First there;
      double x[5];
      bool isWhole = true;
      for (int k = 0; k < 5 && isWhole; ++k) {
        isWhole = member(turn / 5.0 * k, axis, there);
        if (isWhole) x[k] = leftBehind<Front::spherical>(there, X, back, bend).x[l];
      }
      const double touch = isWhole ? nearestTouch(x) : NAN;
      if (std::isnan(touch) || !member(touch, axis, there)) continue;
      for (int i = 0; i < 3; ++i) {
        first.t[i].c[l] = there.t[i].c[l], first.t[i].s[l] = there.t[i].s[l];
        first.length[i][l] = there.length[i][l];
      }
      if (isFree) first.free[l] = there.free[l];
      break;
    }
  }
}

}  // namespace

/// frontAt(reference): the branches of the first three hinges; what could take any value takes the
/// reference's.
template <class Make>
GELENK_INLINE void TripleLoop::solveBehind(const Make& frontAt, const Isometry3d& goal,
                                           const Vector6d& reference, TripleSolutions& out) const {
  const auto front = frontAt(reference);
  constexpr bool spherical = decltype(frontAt(reference))::spherical;
  const Isometry3d* const X[3] = {&link(0, goal), &link(1, goal), &link(2, goal)};
  const Isometry3d &X4 = loop_.link[3], &X5 = loop_.link[4];
  const Isometry3d back = link(5, goal).inverse(Eigen::Isometry);
  const bool bends = bend_.size > rounding;
  out.alike |= front.alike;
  for (int base = 0; base < front.count; base += 4) {
    First first = front.at(base, *X[0], *X[1], reference, onAxis);
    Left left = leftBehind<spherical>(first, X, back, bend_);
    const Mask missed = ~left.reached & ((first.free != 0) | (magnitude(left.x) < 1.0 + nearReach));
    if (bends && any(missed)) {
      moveIntoReach(frontAt, front, base, X, back, bend_, reference, left, first);
      left = leftBehind<spherical>(first, X, back, bend_);
    }
    if (!any(left.reached)) continue;
    const auto& [K0, K1, K2, k, inLine, cosine, less, more, reached] = left;
    const Lanes x = choose(cosine < 0.0, larger(cosine, Lanes{} - 1.0), -larger(-cosine, Lanes{} - 1.0));
    const Lanes y = root(less * more);
    const Mask second = bends ? reached & (y > 0.0) & ~inLine : Mask{};
    out.alike |= any(second & (y < merging));

    double u[2][6][4], error[2][4];
    Mask valid[2] = {reached, second}, free[2];
    for (int i = 0; i < 3; ++i) {
      const Lanes angle = angleOf(first.t[i].s, first.t[i].c) + first.length[i];
      store(u[0][i], angle), store(u[1][i], angle);
    }
    for (int b = 0; b < 2; ++b) {
      if (b == 1 && !any(second)) continue;
      free[b] = first.free;
      const Lanes side = b == 0 ? y : -y;
      Turns t5{bend_.cos * x - bend_.sin * side, bend_.sin * x + bend_.cos * side};
      if (!bends) {
        t5 = {Lanes{} + std::cos(reference[4]), Lanes{} + std::sin(reference[4])};
        free[b] |= ~Mask{} & 16L;
      }
      const auto behind5 = [&](const Vector3d& v) { return times(X4, turned(t5, same(v))); };
      Vectors N0 = behind5(X5.linear().col(0)), N1 = behind5(X5.linear().col(1)), N2 = cross(N0, N1);
      Vectors arm = moved(X4, turned(t5, same(X5.translation())));
      const Vectors toward{choose(inLine, Lanes{}, K2.x), choose(inLine, Lanes{}, K2.y), K2.z};
      const Turns t4 =
          turnsFromTo(spherical ? N2 : arm, spherical ? toward : k, reference[3], onAxis, 8L, free[b]);
      N0 = turned(t4, N0), N1 = turned(t4, N1), N2 = turned(t4, N2), arm = turned(t4, arm);
      Turns t6{dot(N0, K0), dot(N1, K0)};
      const Lanes unit = 1.0 / root(t6.c * t6.c + t6.s * t6.s + 1e-300);
      t6.c *= unit, t6.s *= unit;
      const auto between = [](Lanes p, const Vectors& a, Lanes q, const Vectors& b, const Vectors& c) {
        const Vectors d{p * a.x + q * b.x - c.x, p * a.y + q * b.y - c.y, p * a.z + q * b.z - c.z};
        return dot(d, d);
      };
      store(error[b], root(between(t6.c, N0, t6.s, N1, K0) * 0.5 + between(t6.c, N1, -t6.s, N0, K1) * 0.5 +
                           between(Lanes{} + 1.0, N2, Lanes{}, N2, K2) * 0.5 +
                           between(Lanes{} + 1.0, arm, Lanes{}, arm, k)));
      store(u[b][3], angleOf(t4.s, t4.c));
      store(u[b][4], angleOf(t5.s, t5.c));
      store(u[b][5], angleOf(t6.s, t6.c));
    }
    for (int l = 0; l < 4 && base + l < front.count; ++l)
      for (int b = 0; b < 2 && out.count < TripleSolutions::most; ++b) {
        if (!valid[b][l]) continue;
        for (int j = 0; j < 6; ++j) out.u[j][out.count] = u[b][j][l];
        out.error[out.count] = error[b][l];
        out.free[out.count++] = static_cast<unsigned char>(free[b][l]);
      }
  }
}

GELENK_SIMD_CLONES void TripleLoop::solve(const Isometry3d& goal, const Vector6d& reference,
                                          TripleSolutions& out) const {
  out.count = 0;
  out.alike = false;
  const Isometry3d &X1 = link(0, goal), &X2 = link(1, goal), &X3 = link(2, goal), &X6 = link(5, goal);
  if (kind_ == LoopClass::SphericalTriple) {
    const Vector3d g = X6.linear().transpose() * (Vector3d(0, 0, after_) - X6.translation());
    const Vector3d c = X3 * Vector3d(0, 0, before_);
    if (loop_.slides)
      solveBehind(
          [&](const Vector6d& at) {
            return SlidingFront({&X1, &X2, c, g, loop_.slides}, at);
          },
          goal, reference, out);
    else
      solveBehind([&](const Vector6d& at) { return SphericalFront(X1, X2, c, g, at); }, goal, reference, out);
  } else {
    const Isometry3d &X4 = loop_.link[3], &X5 = loop_.link[4], back = X6.inverse(Eigen::Isometry);
    const double sense5 = X4.linear()(2, 2) > 0.0 ? 1.0 : -1.0;  // axis 5 along or against axis 4
    const double sense6 = X5.linear()(2, 2) > 0.0 ? sense5 : -sense5;
    const Vector3d h3 = X3.linear().col(2), h0 = sense6 * back.linear().col(2);
    const double along = X4.translation().z() + sense5 * X5.translation().z();
    const double height = h0.dot(back.translation()) - along - h3.dot(X3.translation());
    solveBehind([&](const Vector6d& at) { return ParallelFront(X1, X2, h0, h3, height, at); }, goal,
                reference, out);
  }
}

Decomposition decompose(const Loop& loop, double tolerance) {
  Decomposition best;
  double bestCost = INFINITY;
  for (int i = 0; i + 2 < 6; ++i) {
    const Isometry3d &A = loop.link[i], &B = loop.link[i + 1];
    const double sineA = A.linear().col(2).head<2>().norm(), sineB = B.linear().col(2).head<2>().norm();
    const unsigned three = 7u << i;
    const auto candidate = [&](LoopClass kind, double misfit) {
      if (misfit > tolerance) return;
      // Hinges that slide are solved where three that turn meet behind them.
      if (kind == LoopClass::SphericalTriple ? loop.slides & three : loop.slides) return;
      for (const bool reversed : {false, true}) {
        // The triple comes last: hinge 1 of the cut follows it.
        const Cut cut{reversed ? (i + 5) % 6 : (i + 3) % 6, reversed};
        const Loop l = cutAt(loop, cut);
        const auto far = [](double x) { return x > 1e-9 ? 1.0 : 0.0; };
        double cost = kind == LoopClass::SphericalTriple ? 0.0 : 10.0;
        // The polynomial has degree one where n and m of the planar system are in line; the link that holds
        // the goal is in general position.
        const int links[2] = {0, 1};
        const int which = kind == LoopClass::SphericalTriple ? links[0] : links[1];
        const Isometry3d& X = l.link[which];
        const bool goal = (reversed ? (cut.joint(which) + 5) % 6 : cut.joint(which)) == 5;
        const Vector3d n = kind == LoopClass::SphericalTriple
                               ? Vector3d(X.linear().transpose() * X.translation())
                               : Vector3d(X.translation()),
                       m = kind == LoopClass::SphericalTriple ? Vector3d(X.linear().row(2).transpose())
                                                              : Vector3d(X.linear().col(2));
        cost += goal ? 2.0 : far(std::abs(n.x() * m.y() - n.y() * m.x()));
        if (cost < bestCost) bestCost = cost, best = {kind, cut, i, misfit};
      }
    };
    if (sineA > 1e-3 && sineB > 1e-3) {
      // Heights on the middle axis where the others meet it, and how far they pass it.
      const Isometry3d behind = A.inverse(Eigen::Isometry);
      const Vector3d pa = behind.translation(), za = behind.linear().col(2), pb = B.translation(),
                     zb = B.linear().col(2);
      const auto meets = [](const Vector3d& p, const Vector3d& z, double& miss) {
        const double s2 = z.x() * z.x() + z.y() * z.y();
        miss = std::abs(p.x() * z.y() - p.y() * z.x()) / std::sqrt(s2);
        return p.z() - z.z() * (p.x() * z.x() + p.y() * z.y()) / s2;
      };
      double missA, missB;
      const double ha = meets(pa, za, missA), hb = meets(pb, zb, missB);
      candidate(LoopClass::SphericalTriple, std::max({missA, missB, std::abs(ha - hb)}));
    }
    candidate(LoopClass::ParallelTriple, std::max(sineA, sineB));
  }
  return best;
}

}  // namespace gelenk
