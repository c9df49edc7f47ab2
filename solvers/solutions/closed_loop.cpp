#include "solvers/solutions/closed_loop.h"

#include "solvers/solutions/planar_system.h"

namespace gelenk {
namespace {

using namespace planar;

void put(TripleSolutions& out, Turn a, Turn b, Turn c, Turn d, Turn e, Turn f, unsigned free) {
  if (out.count == TripleSolutions::most) return;
  out.u[out.count] << a.angle(), b.angle(), c.angle(), d.angle(), e.angle(), f.angle();
  out.free[out.count++] = static_cast<unsigned char>(free);
}

}  // namespace

void solveSphericalTriple(const Loop& loop, const Vector6d& reference, TripleSolutions& out) {
  // The point where the axes meet, after hinge 3 and before hinge 1.
  const Isometry3d &X1 = loop.link[0], &X2 = loop.link[1];
  const Matrix3d &R4 = loop.link[3].linear(), R5 = loop.link[4].linear();
  // Slide the origins of hinges 4 and 6 to the point: along 4 by what makes axis 5 start there.
  const Vector3d x4 = loop.link[3].translation(), x5 = loop.link[4].translation();
  // Axis 4 is z through 0, axis 5 is R4 z through x4: they meet at height h4 of axis 4.
  const Vector3d z5 = R4.col(2);
  const double across = z5.x() * z5.x() + z5.y() * z5.y();
  const double h4 = x4.z() - z5.z() * (x4.x() * z5.x() + x4.y() * z5.y()) / across;
  // Axis 6 seen from behind: axis 5 is R5^T z through -R5^T x5.
  const Vector3d back = -R5.transpose() * x5, z5behind = R5.row(2).transpose();
  const double acrossBehind = z5behind.x() * z5behind.x() + z5behind.y() * z5behind.y();
  const double h6 =
      back.z() - z5behind.z() * (back.x() * z5behind.x() + back.y() * z5behind.y()) / acrossBehind;
  const Vector3d c = loop.link[2] * Vector3d(0, 0, h4);
  const Matrix3d R6 = loop.link[5].linear();
  const Vector3d g = R6.transpose() * (Vector3d(0, 0, h6) - loop.link[5].translation());

  // v = X2 Rz(u3) c as waves of u3; Rz(u2) v = w must satisfy |X1 w| = |g| and (X1 w).z = g.z.
  const Matrix3d R1 = X1.linear(), R2 = X2.linear();
  const Vector3d x1 = X1.translation(), x2 = X2.translation();
  const Vector3d fixed = x2 + R2.col(2) * c.z(), vc = R2.col(0) * c.x() + R2.col(1) * c.y(),
                 vs = R2.col(1) * c.x() - R2.col(0) * c.y();
  const Wave vz{fixed.z(), vc.z(), vs.z()};
  const Wave vv{fixed.squaredNorm() + vc.squaredNorm(), 2.0 * fixed.dot(vc), 2.0 * fixed.dot(vs)};
  const Vector3d n = R1.transpose() * x1, m = R1.row(2).transpose();
  PlanarSystem system;
  system.n = n.head<2>(), system.m = m.head<2>();
  system.alpha = Wave{0.5 * (g.squaredNorm() - x1.squaredNorm()), 0, 0} - 0.5 * vv - n.z() * vz;
  system.beta = Wave{g.z() - x1.z(), 0, 0} - m.z() * vz;
  system.square.degree = 2;
  system.square.a[0] = vv.a, system.square.a[1] = vv.b, system.square.b[1] = vv.c;
  addProduct(system.square, -1.0, vz, vz);
  PlanarSolution planar[8];
  const int count = solve(system, reference[2], planar);

  const double r4 = R4(2, 2) * R5(2, 2);
  const Wave bend{r4, R4(2, 0) * R5(0, 2) + R4(2, 1) * R5(1, 2), R4(2, 1) * R5(0, 2) - R4(2, 0) * R5(1, 2)};
  for (int k = 0; k < count; ++k) {
    const Turn t3 = planar[k].t;
    unsigned free = planar[k].free ? 1u << 2 : 0u;
    const Vector3d v = fixed + vc * t3.c + vs * t3.s, w(planar[k].z.x(), planar[k].z.y(), v.z());
    Turn t2, t1;
    Vector3d wrist = w;
    if (!turnFromTo(v, w, t2)) t2 = turnOf(reference[1]), free |= 1u << 1, wrist = aboutZ(t2, v);
    if (!turnFromTo(X1 * wrist, g, t1)) t1 = turnOf(reference[0]), free |= 1u;
    const Matrix3d R123 = aboutZ(t1) * R1 * aboutZ(t2) * R2 * aboutZ(t3) * loop.link[2].linear();
    const Matrix3d M = R123.transpose() * R6.transpose();  // Rz(u4) R4 Rz(u5) R5 Rz(u6)
    Turn t5[2];
    // Axes 4 and 6 in line is read off the wanted rotation, whose sine is exact where a cosine near one is
    // not.
    const bool inLine = std::hypot(M(0, 2), M(1, 2)) < 1e-9;
    int bends = zeros(bend - Wave{M(2, 2), 0, 0}, t5);
    if (inLine) {
      const double r = std::hypot(bend.b, bend.c), side = M(2, 2) > bend.a ? 1.0 : -1.0;
      t5[0] = {side * bend.b / r, side * bend.c / r};
      bends = std::abs(bend.a + side * r - M(2, 2)) < reachRounding ? 1 : 0;
    }
    for (int b = 0; b < bends; ++b) {
      const Matrix3d N = R4 * aboutZ(t5[b]) * R5;
      Turn t4, t6;
      unsigned wristFree = 0;
      if (inLine) {
        t4 = turnOf(reference[3]), wristFree = 1u << 3;
        const Matrix3d last = N.transpose() * aboutZ({t4.c, -t4.s}) * M;
        t6 = {last(0, 0), last(1, 0)};
      } else {
        turnFromTo(N.col(2), M.col(2), t4);
        turnFromTo(M.row(2).transpose(), N.row(2).transpose(), t6);
      }
      put(out, t1, t2, t3, t4, t5[b], t6, free | wristFree);
    }
  }
}

void solveParallelTriple(const Loop& loop, const Vector6d& reference, TripleSolutions& out) {
  const Isometry3d &X1 = loop.link[0], &X2 = loop.link[1], &X3 = loop.link[2], &X4 = loop.link[3],
                   &X5 = loop.link[4];
  const double sense5 = X4.linear()(2, 2) > 0.0 ? 1.0 : -1.0;  // axis 5 along or against axis 4
  const double sense6 = X5.linear()(2, 2) > 0.0 ? sense5 : -sense5;
  const Isometry3d back = loop.link[5].inverse(Eigen::Isometry);  // frame of hinge 6, turned, before hinge 1
  const Vector3d h3 = X3.linear().col(2), h0 = sense6 * back.linear().col(2);  // axis 4 from both sides
  const double along = X4.translation().z() + sense5 * X5.translation().z();
  const double height = h0.dot(back.translation()) - along - h3.dot(X3.translation());

  // Rz(-u1) h0 as waves of u1.
  const auto waveOf = [&](const Vector3d& a) {  // a . Rz(-u1) h0
    return Wave{a.z() * h0.z(), a.x() * h0.x() + a.y() * h0.y(), a.x() * h0.y() - a.y() * h0.x()};
  };
  const Matrix3d R1 = X1.linear(), R2 = X2.linear();
  const Vector3d x1 = X1.translation(), x2 = X2.translation(), r2 = R2.col(2);
  const Wave etaZ = waveOf(R1.col(2));
  PlanarSystem system;
  system.n = x2.head<2>(), system.m = r2.head<2>();
  system.alpha = Wave{height, 0, 0} - waveOf(x1) - x2.z() * etaZ;
  system.beta = Wave{h3.z(), 0, 0} - r2.z() * etaZ;
  system.square.degree = 2;
  system.square.a[0] = 1.0;
  addProduct(system.square, -1.0, etaZ, etaZ);
  PlanarSolution planar[8];
  const int count = solve(system, reference[0], planar);

  const Vector2d p4 = X4.translation().head<2>();
  const Matrix3d R4 = X4.linear();
  const Vector2d x5 = X5.translation().head<2>(), q5c = R4.topLeftCorner<2, 2>() * x5,
                 q5s = R4.topLeftCorner<2, 2>() * Vector2d(-x5.y(), x5.x());
  for (int k = 0; k < count; ++k) {
    const Turn t1 = planar[k].t;
    unsigned free = planar[k].free ? 1u : 0u;
    const Vector3d eta = R1.transpose() * aboutZ({t1.c, -t1.s}, h0);
    Vector3d w(planar[k].z.x(), planar[k].z.y(), eta.z());
    Turn t2, t3;
    if (!turnFromTo(w, eta, t2)) t2 = turnOf(reference[1]), free |= 1u << 1, w = aboutZ({t2.c, -t2.s}, eta);
    if (!turnFromTo(h3, R2.transpose() * w, t3)) t3 = turnOf(reference[2]), free |= 1u << 2;
    Isometry3d before = Isometry3d::Identity();
    before.linear() = aboutZ(t1) * R1;
    before.translation() = aboutZ(t1, x1) + before.linear() * aboutZ(t2, x2);
    before.linear() = before.linear() * aboutZ(t2) * R2 * aboutZ(t3);
    before.translation() += before.linear() * X3.translation();
    before.linear() = before.linear() * X3.linear();
    const Matrix3d K = before.linear().transpose() * back.linear();
    const Vector3d k3 = before.linear().transpose() * (back.translation() - before.translation());
    const Vector2d goal = k3.head<2>();
    Turn t5[2];
    const int elbows = zeros(
        {p4.squaredNorm() + x5.squaredNorm() - goal.squaredNorm(), 2.0 * p4.dot(q5c), 2.0 * p4.dot(q5s)}, t5);
    for (int b = 0; b < elbows; ++b) {
      const Vector2d arm = p4 + q5c * t5[b].c + q5s * t5[b].s;
      Turn t4;
      unsigned elbowFree = 0;
      if (!turnFromTo({arm.x(), arm.y(), 0}, k3, t4)) t4 = turnOf(reference[3]), elbowFree = 1u << 3;
      const Matrix3d last = (aboutZ(t4) * R4 * aboutZ(t5[b]) * X5.linear()).transpose() * K;
      put(out, t1, t2, t3, t4, t5[b], {last(0, 0), last(1, 0)}, free | elbowFree);
    }
  }
}

Decomposition decompose(const Loop& loop, double tolerance) {
  Decomposition best;
  double bestCost = INFINITY;
  for (int i = 0; i + 2 < 6; ++i) {
    const Isometry3d &A = loop.link[i], &B = loop.link[i + 1];
    const double sineA = A.linear().col(2).head<2>().norm(), sineB = B.linear().col(2).head<2>().norm();
    const auto candidate = [&](LoopClass kind, double misfit) {
      if (misfit > tolerance) return;
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
