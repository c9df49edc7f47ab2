#include "solvers/solutions/meeting_pair.h"

#include "solvers/solutions/lane_vectors.h"
#include "solvers/solutions/planar_system.h"

namespace gelenk {
namespace {

using namespace planar;
using namespace lanes;

constexpr int cells = 64;
constexpr int deepest = 9;         ///< halvings of a cell
constexpr int deepestAtEnds = 12;  ///< of one in which a branch ends
constexpr int deepestUnseen = 2;   ///< of one without any branch at its ends
constexpr int mostHalvings = 600;
constexpr double onAxis = 1e-9;  ///< a point nearer to a hinge than this does not tell its turn

/// Hinges 1 to 3 with the point where it belongs.
struct Branch {
  Turn t1, t2, t3;
  double e, slope;  ///< cosine of the angle between axes 4 and 5 less what it must be; by u_6
  int number;       ///< see PlanarSolution
};

struct Sample {
  double u6;
  int count = 0;
  Branch branch[8];
};

class Circuit {
 public:
  Circuit(const Loop& loop, LoopSolutions& out) : loop_(loop), out_(out) {
    const Vector3d x4 = loop.link[3].translation(), z5 = loop.link[3].linear().col(2);
    const double across = z5.x() * z5.x() + z5.y() * z5.y();
    h4_ = x4.z() - z5.z() * (x4.x() * z5.x() + x4.y() * z5.y()) / across;
    const Vector3d meeting(0, 0, h4_);
    wanted_ = z5.z();
    c_ = loop.link[2] * meeting;
    const Isometry3d back5 = loop.link[4].inverse(Eigen::Isometry);
    back6_ = loop.link[5].inverse(Eigen::Isometry);
    const double h5 = (loop.link[3].inverse(Eigen::Isometry) * meeting).z();
    point_ = back5 * Vector3d(0, 0, h5);
    axis_ = back5.linear().col(2);
    const Matrix3d R1 = loop.link[0].linear(), R2 = loop.link[1].linear();
    const Vector3d x1 = loop.link[0].translation(), x2 = loop.link[1].translation();
    fixed_ = x2 + R2.col(2) * c_.z();
    vc_ = R2.col(0) * c_.x() + R2.col(1) * c_.y();
    vs_ = R2.col(1) * c_.x() - R2.col(0) * c_.y();
    const Wave vz{fixed_.z(), vc_.z(), vs_.z()};
    const Wave vv{fixed_.squaredNorm() + vc_.squaredNorm(), 2.0 * fixed_.dot(vc_), 2.0 * fixed_.dot(vs_)};
    const Vector3d n = R1.transpose() * x1, m = R1.row(2).transpose();
    system_.n = n.head<2>(), system_.m = m.head<2>();
    alpha_ = Wave{-0.5 * x1.squaredNorm(), 0, 0} - 0.5 * vv - n.z() * vz;
    beta_ = Wave{-x1.z(), 0, 0} - m.z() * vz;
    system_.x = {fixed_.x(), vc_.x(), vs_.x()}, system_.y = {fixed_.y(), vc_.y(), vs_.y()};
  }

  void run() {
    Sample first, left, right;
    at(0.0, first);
    left = first;
    for (int k = 1; k <= cells; ++k) {
      if (k < cells) {
        at(2.0 * M_PI * k / cells, right);
      } else {
        right = first;
        right.u6 = 2.0 * M_PI;
      }
      cell(left, right, 0);
      left = right;
    }
    if (halvings_ >= mostHalvings) ++out_.suspects;
  }

 private:
  void at(double u6, Sample& sample) const;

  static double apart(const Branch& a, const Branch& b) {
    return 3.0 - (a.t1.c * b.t1.c + a.t1.s * b.t1.s) - (a.t2.c * b.t2.c + a.t2.s * b.t2.s) -
           (a.t3.c * b.t3.c + a.t3.s * b.t3.s);
  }

  /// match[i]: which branch of r goes on with branch i of l; -1: none. False where it is not certain.
  static bool matched(const Sample& l, const Sample& r, int match[8]) {
    bool taken[8] = {}, certain = l.count == r.count;
    for (int i = 0; i < l.count; ++i) {
      match[i] = -1;
      double best = 0.6, second = INFINITY;
      for (int k = 0; k < r.count; ++k) {
        if (taken[k] || l.branch[i].number != r.branch[k].number) continue;
        const double d = apart(l.branch[i], r.branch[k]);
        if (d < best)
          second = best, best = d, match[i] = k;
        else
          second = std::min(second, d);
      }
      if (match[i] < 0)
        certain = false;
      else
        taken[match[i]] = true;
      if (l.branch[i].number < 0 && second < 4.0 * best) certain = false;
    }
    return certain;
  }

  void cell(const Sample& l, const Sample& r, int depth) {
    if (l.count == 0 && r.count == 0 && depth >= deepestUnseen) return;
    int match[8];
    const bool certain = matched(l, r, match);
    const double h = r.u6 - l.u6;
    bool halve = !certain;
    bool root[8] = {};
    if (l.count == 0 && r.count == 0) halve = true;
    if (certain)
      for (int i = 0; i < l.count; ++i) {
        const Branch &a = l.branch[i], &b = r.branch[match[i]];
        if ((a.e < 0.0) != (b.e < 0.0)) {
          root[i] = true;
          // More than one in the cell: a slope against the change.
          const double rise = b.e - a.e;
          if (a.slope * rise < 0.0 || b.slope * rise < 0.0 || std::abs(a.slope * h) > 8.0 * std::abs(rise) ||
              std::abs(b.slope * h) > 8.0 * std::abs(rise))
            halve = true;
        } else if (a.e * a.slope < 0.0 && b.e * b.slope > 0.0) {
          // Towards zero and back: the tangents meet nearer to zero than the curve comes if it is convex.
          const double x = (b.e - a.e - b.slope * h) / (a.slope - b.slope), low = a.e + a.slope * x;
          if (low * a.e < 0.1 * a.e * a.e) halve = true;
        } else if (std::abs(a.slope) * h > 2.0 * std::abs(a.e) &&
                   std::abs(b.slope) * h > 2.0 * std::abs(b.e)) {
          halve = true;
        }
      }
    if (halve && depth < (certain ? deepest : deepestAtEnds) && halvings_ < mostHalvings) {
      ++halvings_;
      Sample m;
      at(0.5 * (l.u6 + r.u6), m);
      cell(l, m, depth + 1);
      cell(m, r, depth + 1);
      return;
    }
    if (certain) {
      for (int i = 0; i < l.count; ++i) {
        if (root[i])
          bracketed(l, i, r, match[i], 0);
        else if (halve)
          take(std::abs(l.branch[i].e) < std::abs(r.branch[match[i]].e) ? l.u6 : r.u6,
               std::abs(l.branch[i].e) < std::abs(r.branch[match[i]].e) ? l.branch[i] : r.branch[match[i]]);
      }
      return;
    }
    // Ends of branches, or branches too near to each other to be told apart: what is close to zero.
    for (const Sample* s : {&l, &r})
      for (int i = 0; i < s->count; ++i)
        if (std::abs(s->branch[i].e) < 0.1) take(s->u6, s->branch[i]);
  }

  /// Root in [0, 1] of the cubic with these values and slopes at its ends, from that of the chord.
  static double cubicRoot(double left, double leftSlope, double right, double rightSlope) {
    const double c2 = 3.0 * (right - left) - 2.0 * leftSlope - rightSlope,
                 c3 = leftSlope + rightSlope - 2.0 * (right - left);
    double x = left / (left - right);
    for (int i = 0; i < 4; ++i) {
      const double step =
          (left + x * (leftSlope + x * (c2 + x * c3))) / (leftSlope + x * (2.0 * c2 + 3.0 * x * c3));
      if (!(x - step > 0.0 && x - step < 1.0)) break;
      x -= step;
    }
    return x;
  }

  void bracketed(Sample l, int i, Sample r, int k, int depth) {
    const Branch &a = l.branch[i], &b = r.branch[k];
    const double share = std::clamp(cubicRoot(a.e, a.slope * (r.u6 - l.u6), b.e, b.slope * (r.u6 - l.u6)),
                                    0.02, 0.98),
                 u6 = l.u6 + share * (r.u6 - l.u6);
    Sample m;
    at(u6, m);
    int toMiddle[8];
    matched(l, m, toMiddle);
    const int j = toMiddle[i];
    if (j < 0) {
      take(l.u6, a);
      take(r.u6, b);
      return;
    }
    if (take(u6, m.branch[j], l.u6 - 1e-6, r.u6 + 1e-6) || depth > 12) return;
    if ((m.branch[j].e < 0.0) == (a.e < 0.0))
      bracketed(m, j, r, k, depth + 1);
    else
      bracketed(l, i, m, j, depth + 1);
  }

  /// Polishes and adds; false where Newton leads nowhere, or out of the interval.
  bool take(double u6, const Branch& b, double lower = -INFINITY, double upper = INFINITY) {
    const Matrix3d R123 = aboutZ(b.t1) * loop_.link[0].linear() * aboutZ(b.t2) * loop_.link[1].linear() *
                          aboutZ(b.t3) * loop_.link[2].linear();
    const Turn back{std::cos(u6), -std::sin(u6)};
    const Matrix3d M = R123.transpose() * back6_.linear() * aboutZ(back) * loop_.link[4].linear().transpose();
    const Matrix3d R4 = loop_.link[3].linear();  // M = Rz(u4) R4 Rz(u5)
    Turn t4, t5;
    if (!turnFromTo(R4.col(2), M.col(2), t4) || !turnFromTo(M.row(2).transpose(), R4.row(2).transpose(), t5))
      return false;
    Vector6d u;
    u << b.t1.angle(), b.t2.angle(), b.t3.angle(), t4.angle(), t5.angle(), u6;
    double error, raw;
    if (!polish(loop_, u, 1e-10, error, raw)) return false;
    const double middle = 0.5 * (lower + upper);
    if (std::isfinite(middle) && std::abs(wrapped(u[5] - middle)) > 0.5 * (upper - lower)) return false;
    for (double& angle : u) angle = wrapped(angle);
    if (add(out_, u, error)) out_.raw = std::max(out_.raw, raw);
    return true;
  }

  const Loop& loop_;
  LoopSolutions& out_;
  int halvings_ = 0;
  double h4_, wanted_;
  Vector3d c_, point_, axis_, fixed_, vc_, vs_;
  Isometry3d back6_;
  Wave alpha_, beta_;
  PlanarSystem system_;
};

/// Every way to place the point, four at a time.
GELENK_SIMD_CLONES void Circuit::at(double u6, Sample& sample) const {
  sample.u6 = u6;
  sample.count = 0;
  const Turn back{std::cos(u6), -std::sin(u6)};
  const Vector3d g = back6_ * aboutZ(back, point_), d = back6_.linear() * aboutZ(back, axis_);
  PlanarSystem system = system_;
  system.alpha = alpha_, system.beta = beta_;
  system.alpha.a += 0.5 * g.squaredNorm(), system.beta.a += g.z();
  PlanarSolution planar[8];
  const int count = planar::solve(system, 0.0, planar);
  const Vector3d axis6 = back6_.linear().col(2), arm = g - back6_.translation();
  const Vector3d pointMoves = -axis6.cross(arm), axisTurns = -axis6.cross(d);
  const Isometry3d &X1 = loop_.link[0], &X2 = loop_.link[1], &X3 = loop_.link[2];
  for (int base = 0; base < count; base += 4) {
    double in[4][4];
    for (int l = 0; l < 4; ++l) {
      const PlanarSolution& p = planar[std::min(base + l, count - 1)];
      in[0][l] = p.t.c, in[1][l] = p.t.s, in[2][l] = p.z.x(), in[3][l] = p.z.y();
    }
    const Turns t3{load(in[0]), load(in[1])};
    Mask undefined{};
    const Vectors v{fixed_.x() + vc_.x() * t3.c + vs_.x() * t3.s,
                    fixed_.y() + vc_.y() * t3.c + vs_.y() * t3.s,
                    fixed_.z() + vc_.z() * t3.c + vs_.z() * t3.s};
    const Turns t2 = turnsFromTo(v, {load(in[2]), load(in[3]), v.z}, 0.0, onAxis, 1L, undefined);
    const Turns t1 = turnsFromTo(moved(X1, turned(t2, v)), same(g), 0.0, onAxis, 1L, undefined);
    const auto before2 = [&](const Vectors& a) { return turned(t1, times(X1, a)); };
    const auto before3 = [&](const Vectors& a) { return before2(turned(t2, times(X2, a))); };
    const Vectors p2 = turned(t1, same(X1.translation())),
                  p3 = p2 + before2(turned(t2, same(X2.translation())));
    const Vectors axis2 = turned(t1, same(X1.linear().col(2))),
                  axis3 = before2(turned(t2, same(X2.linear().col(2)))),
                  axis4 = before3(turned(t3, same(X3.linear().col(2))));
    // How fast hinges 1 to 3 turn to keep up with the point.
    const Vectors J1 = same({-g.y(), g.x(), 0}), J2 = cross(axis2, same(g) - p2),
                  J3 = cross(axis3, same(g) - p3);
    const Vectors J23 = cross(J2, J3), moves = same(pointMoves), turn4 = cross(axis4, same(d));
    const Lanes det = dot(J1, J23), rate1 = dot(J23, moves), rate2 = dot(cross(J3, J1), moves),
                rate3 = dot(cross(J1, J2), moves);
    // (spin x axis4) . d = spin . (axis4 x d)
    const Lanes spun = rate1 * turn4.z + rate2 * dot(axis2, turn4) + rate3 * dot(axis3, turn4);
    double e[4], slope[4], c1[4], s1[4], c2[4], s2[4];
    store(e, dot(axis4, same(d)) - wanted_);
    store(slope, spun / det + dot(axis4, same(axisTurns)));
    store(c1, t1.c), store(s1, t1.s), store(c2, t2.c), store(s2, t2.s);
    for (int l = 0; l < 4 && base + l < count; ++l) {
      const PlanarSolution& p = planar[base + l];
      if (p.free || undefined[l] || !std::isfinite(slope[l])) continue;
      sample.branch[sample.count++] = {{c1[l], s1[l]}, {c2[l], s2[l]}, p.t, e[l], slope[l], p.branch};
    }
  }
}

}  // namespace

int meetingPairRank(const Loop& loop, int goalLink, double tolerance) {
  if (goalLink == 3) return 0;
  const Vector3d z = loop.link[3].linear().col(2), x = loop.link[3].translation();
  const double sine = std::hypot(z.x(), z.y());
  if (sine < 1e-3 || std::abs(x.x() * z.y() - x.y() * z.x()) > tolerance * sine) return 0;
  if (goalLink == 0) return 1;
  const Vector3d n = loop.link[0].linear().transpose() * loop.link[0].translation(),
                 m = loop.link[0].linear().row(2).transpose();
  return std::abs(n.x() * m.y() - n.y() * m.x()) < 1e-10 ? 2 : 1;
}

LoopSolutions solveMeetingPair(const Loop& loop) {
  LoopSolutions solutions;
  Circuit(loop, solutions).run();
  return solutions;
}

}  // namespace gelenk
