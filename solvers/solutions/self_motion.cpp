#include "solvers/solutions/self_motion.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "solvers/solutions/lanes.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

constexpr double turn = 2.0 * M_PI;

Matrix3d aboutZ(double t) {
  const double c = std::cos(t), s = std::sin(t);
  Matrix3d R;
  R << c, -s, 0, s, c, 0, 0, 0, 1;
  return R;
}

Vector7d wrapped(Vector7d d) {
  for (double& x : d) x = std::remainder(x, turn);
  return d;
}

/// Joints of the loop, in order, when joint `held` is no hinge.
int hingeJoint(int held, int hinge) { return hinge < held ? hinge : hinge + 1; }

}  // namespace

/// Pose and Jacobian of the last frame; lengths over scale_.
struct SevenJointArm::Frame {
  Matrix3d R;
  Vector3d p;
  Eigen::Matrix<double, 6, 7> J;
};

SevenJointArm::SevenJointArm(const SerialChain& chain) : chain_(chain) {
  if (chain.n != 7 || chain.hasPrismatic)
    throw std::invalid_argument("self-motions are for seven revolute joints; this chain has " +
                                std::to_string(chain.n) +
                                (chain.hasPrismatic ? ", not all of them revolute" : ""));
  family_ = ShoulderFamily::of(chain);
  scale_ = chain.length / 3.0;
  const ChainConstants& C = chain.constants;
  for (int i = 0; i < 7; ++i) {
    Isometry3d& F = fixed_[i];
    F = Isometry3d::Identity();
    F.linear() << 1, 0, 0, 0, C.cosAlpha[i], -C.sinAlpha[i], 0, C.sinAlpha[i], C.cosAlpha[i];
    F.translation() = Vector3d(C.a[i], -C.sinAlpha[i] * C.d[i], C.cosAlpha[i] * C.d[i]) / scale_;
  }
  // The joint to hold: the one that leaves a class with closed forms, the later the better for the triple's
  // links to stay fixed; the third joint where both ends are spherical.
  for (const int held : {2, 6, 3, 4, 0, 1, 5}) {
    held_ = held;
    Loop loop;
    Decomposition at[2];
    for (int k = 0; k < 2; ++k) {
      place(tipFrame(chain_, Eigen::VectorXd::Constant(7, 0.7)), 0.4 + 1.3 * k, loop);
      loop.link[5] = Isometry3d::Identity();
      at[k] = decompose(loop, 1e-9);
    }
    if (at[0].kind == LoopClass::General || at[0].kind != at[1].kind ||
        at[0].firstOfThree != at[1].firstOfThree)
      continue;
    decomposition_ = at[0];
    return;
  }
  // General: a cut that works for a random pose.
  held_ = 6;
  decomposition_ = {};
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> angle(-M_PI, M_PI);
  double best = INFINITY;
  for (int c = 0; c < 12; ++c) {
    const Cut cut{c % 6, c >= 6};
    double score = 0.0;
    for (int trial = 0; trial < 8; ++trial) {
      Eigen::VectorXd q(7);
      for (double& x : q) x = angle(random);
      Loop loop;
      place(tipFrame(chain_, q), q[held_] + C.theta[held_], loop);
      const LoopSolutions found = solveGeneralLoop(cutAt(loop, cut));
      score +=
          std::log10(std::max(found.noise, 1e-16)) + (found.count == 0 ? 20.0 : 0.0) + 5.0 * found.suspects;
    }
    if (score < best) best = score, generalCut_ = cut;
  }
}

std::string SevenJointArm::describe() const {
  if (family_) return "closed form over joint 7: axes 1, 2 and 3 meet, and axes 5 and 6";
  const std::string joint = std::to_string(held_ + 1);
  return decomposition_.kind == LoopClass::General
             ? "general: joint " + joint + " held, the other six by elimination"
             : "closed forms with joint " + joint + " held";
}

Isometry3d SevenJointArm::lastFrame(const Isometry3d& worldFromTip) const {
  Isometry3d last = chain_.worldFromBase.inverse(Eigen::Isometry) * worldFromTip *
                    chain_.lastFromTip.inverse(Eigen::Isometry);
  last.translation() /= scale_;
  return last;
}

void SevenJointArm::place(const Isometry3d& worldFromTip, double heldTurn, Loop& loop) const {
  const Isometry3d back = lastFrame(worldFromTip).inverse(Eigen::Isometry);
  Isometry3d spin = Isometry3d::Identity();
  spin.linear() = aboutZ(heldTurn);
  for (int h = 0; h < 6; ++h) {
    const int joint = hingeJoint(held_, h), next = joint + 1;
    Isometry3d link = Isometry3d::Identity();
    if (next == held_) link = fixed_[next] * spin;
    const int after = next == held_ ? next + 1 : next;
    link = after < 7 ? Isometry3d(link * fixed_[after]) : Isometry3d(link * back);
    if (after >= 7 && held_ == 0) link = link * spin * fixed_[1];
    loop.link[h] = link;
  }
}

void SevenJointArm::solveLoop(const Loop& loop, const Vector6d& reference, LoopSolutions& out) const {
  const Cut& cut = decomposition_.kind == LoopClass::General ? generalCut_ : decomposition_.cut;
  const Loop l = cutAt(loop, cut);
  LoopSolutions found;
  if (decomposition_.kind == LoopClass::General) {
    found = solveGeneralLoop(l);
  } else {
    Vector6d ref;
    for (int j = 0; j < 6; ++j) ref[j] = cut.sign() * reference[cut.joint(j)];
    TripleSolutions triple;
    TripleLoop(decomposition_.kind, l, 5).solve(l.link[5], ref, triple);
    for (int k = 0; k < triple.count; ++k) {
      Vector6d u = triple.at(k);
      double before, error = triple.error[k];
      if (error > 1e-12 && !polish(l, u, 1e-9, error, before)) continue;
      add(found, u, error);
    }
  }
  out.count = found.count;
  for (int k = 0; k < found.count; ++k)
    for (int j = 0; j < 6; ++j) out.u[k][cut.joint(j)] = cut.sign() * found.u[k][j];
}

bool SevenJointArm::toLimits(Vector7d& q, const Vector7d& reference) const {
  bool inside = true;
  for (int i = 0; i < 7; ++i)
    inside &= lanes::toNearestImage(q[i], chain_.lower[i], chain_.upper[i], reference[i]);
  return inside;
}

void SevenJointArm::slice(const Isometry3d& worldFromTip, double angle, const Vector7d& reference,
                          SliceSolutions& out) const {
  const ChainConstants& C = chain_.constants;
  Loop loop;
  place(worldFromTip, angle + C.theta[held_], loop);
  Vector6d ref;
  for (int h = 0; h < 6; ++h) ref[h] = reference[hingeJoint(held_, h)] + C.theta[hingeJoint(held_, h)];
  LoopSolutions found;
  solveLoop(loop, ref, found);
  out.count = 0;
  for (int k = 0; k < found.count; ++k) {
    Vector7d q;
    for (int h = 0; h < 6; ++h) q[hingeJoint(held_, h)] = found.u[k][h] - C.theta[hingeJoint(held_, h)];
    q[held_] = angle;
    out.withinLimits[out.count] = toLimits(q, reference);
    out.q[out.count++] = q;
  }
}

SevenJointArm::Frame SevenJointArm::frameAt(const Vector7d& q) const {
  Frame f;
  f.R.setIdentity();
  f.p.setZero();
  Vector3d axis[7], origin[7];
  for (int i = 0; i < 7; ++i) {
    f.p += f.R * fixed_[i].translation();
    f.R = f.R * fixed_[i].linear();
    axis[i] = f.R.col(2), origin[i] = f.p;
    f.R = f.R * aboutZ(q[i] + chain_.constants.theta[i]);
  }
  for (int i = 0; i < 7; ++i) f.J.col(i) << axis[i].cross(f.p - origin[i]), axis[i];
  return f;
}

/// Newton onto the curve, across the tangent.
bool SevenJointArm::correct(const Isometry3d& goal, const Vector7d& tangent, Vector7d& q) const {
  for (int iteration = 0; iteration < 8; ++iteration) {
    const Frame f = frameAt(q);
    const Matrix3d E = goal.linear() * f.R.transpose();
    Vector7d rhs;
    rhs << goal.translation() - f.p, 0.5 * Vector3d(E(2, 1) - E(1, 2), E(0, 2) - E(2, 0), E(1, 0) - E(0, 1)),
        0.0;
    const double error = rhs.norm();
    if (error < 1e-13) return true;
    if (error > 1.0 || E.trace() < 1.0) return false;
    Matrix7d A;
    A << f.J, tangent.transpose();
    const Vector7d step = A.partialPivLu().solve(rhs);
    if (!step.allFinite() || step.norm() > 1.0) return error < 1e-10;
    q += step;
    if (step.norm() < 1e-13) return true;
  }
  const Frame f = frameAt(q);
  return (goal.translation() - f.p).norm() + (goal.linear() - f.R).norm() < 1e-9;
}

/// Unit null vector of the Jacobian that goes on in the sense of `before`.
Vector7d SevenJointArm::tangentAt(const Vector7d& q, const Vector7d& before) const {
  Matrix7d A;
  A << frameAt(q).J, before.transpose();
  Vector7d t = A.partialPivLu().solve(Vector7d(Vector7d::Unit(6)));
  if (!t.allFinite() || t.norm() < 1e-12) return before;
  return t.normalized();
}

SelfMotionCurve SevenJointArm::walk(const Isometry3d& goal, const Vector7d& from, double step) const {
  SelfMotionCurve curve;
  curve.q.push_back(from);
  curve.arcLength.push_back(0.0);
  Vector7d first = Vector7d::Constant(1.0).normalized();
  for (int k = 0; k < 3; ++k) first = tangentAt(from, first);
  Vector7d tangent = first, q = from;
  double h = step;
  constexpr int most = 20000;
  for (int k = 0; k < most && h > 1e-6;) {
    Vector7d next = q + h * tangent;
    const bool good = correct(goal, tangent, next);
    const Vector7d ahead = good ? tangentAt(next, tangent) : tangent;
    if (!good || (next - q).norm() > 2.0 * h || ahead.dot(tangent) < 0.9) {
      h *= 0.5;
      continue;
    }
    curve.arcLength.push_back(curve.arcLength.back() + (next - q).norm());
    curve.q.push_back(next);
    q = next, tangent = ahead;
    h = std::min(step, 1.5 * h);
    ++k;
    const Vector7d gap = wrapped(from - q);
    if (k > 2 && gap.norm() < 1.2 * h && gap.dot(tangent) > 0.0 && tangent.dot(first) > 0.5) {
      curve.closed = true;
      curve.arcLength.push_back(curve.arcLength.back() + gap.norm());
      curve.q.push_back(q + gap);
      break;
    }
  }
  return curve;
}

void SevenJointArm::cutByLimits(const Isometry3d& goal, const SelfMotionCurve& whole,
                                std::vector<SelfMotionCurve>& pieces) const {
  // The walk is continuous; a pose within limits by its images is carried on by the neighbour's.
  const size_t n = whole.q.size();
  std::vector<Vector7d> image(whole.q);
  std::vector<char> inside(n);
  const Vector7d middle =
      0.5 * (chain_.lower + chain_.upper).unaryExpr([](double x) { return std::isfinite(x) ? x : 0.0; });
  for (size_t k = 0; k < n; ++k) {
    const bool goesOn = k > 0 && inside[k - 1];
    inside[k] = toLimits(image[k], goesOn ? image[k - 1] : middle);
  }
  bool allInside = std::all_of(inside.begin(), inside.end(), [](char c) { return c == 1; });
  for (size_t k = 1; k < n; ++k) allInside &= (image[k] - image[k - 1]).norm() < 1.0;
  if (allInside) {
    SelfMotionCurve piece = whole;
    piece.q = image;
    pieces.push_back(piece);
    return;
  }
  // Start a closed walk outside, so that no piece is cut at its seam.
  size_t offset = 0;
  if (whole.closed)
    while (offset + 1 < n && inside[offset] == 1) ++offset;
  const size_t steps = whole.closed ? n - 1 : n;
  SelfMotionCurve piece;
  const auto finish = [&] {
    if (!piece.q.empty()) pieces.push_back(piece);
    piece = {};
  };
  const auto append = [&](const Vector7d& q) {
    piece.arcLength.push_back(piece.q.empty() ? 0.0 : piece.arcLength.back() + (q - piece.q.back()).norm());
    piece.q.push_back(q);
  };
  /// Where the chord from a pose inside to one outside leaves the limits.
  const auto border = [&](const Vector7d& in, const Vector7d& out) {
    const Vector7d way = wrapped(out - in), along = way.normalized();
    double low = 0.0, high = 1.0;
    Vector7d best = in;
    for (int i = 0; i < 30; ++i) {
      const double mid = 0.5 * (low + high);
      Vector7d q = in + mid * way;
      const bool ok = correct(goal, along, q) && toLimits(q, in) && (q - in).norm() < 1.0;
      (ok ? low : high) = mid;
      if (ok) best = q;
    }
    return best;
  };
  for (size_t s = 0; s < steps; ++s) {
    const size_t k = (offset + s) % steps, previous = (k + steps - 1) % steps;
    if (!inside[k]) {
      if (!piece.q.empty()) append(border(piece.q.back(), whole.q[k]));
      finish();
      continue;
    }
    Vector7d q = image[k];
    if (!piece.q.empty() && (!toLimits(q, piece.q.back()) || (q - piece.q.back()).norm() > 1.0)) {
      finish();  // it goes on by a whole turn of a joint, which is beyond a limit
      q = image[k];
    }
    if (piece.q.empty() && (s > 0 || whole.closed) && !inside[previous]) append(border(q, whole.q[previous]));
    append(q);
  }
  finish();
}

std::vector<SelfMotionCurve> SevenJointArm::selfMotion(const Isometry3d& worldFromTip,
                                                       const SelfMotionOptions& options) const {
  const Isometry3d goal = lastFrame(worldFromTip);
  std::vector<Vector7d> seeds;
  SliceSolutions found;
  for (int k = 0; k < options.slices; ++k) {
    slice(worldFromTip, -M_PI + turn * (k + 0.5) / options.slices, Vector7d::Zero(), found);
    for (const Vector7d& q : found.all()) seeds.push_back(wrapped(q));
  }
  std::vector<char> visited(seeds.size(), 0);
  std::vector<SelfMotionCurve> curves;
  for (size_t s = 0; s < seeds.size(); ++s) {
    if (visited[s]) continue;
    const SelfMotionCurve whole = walk(goal, seeds[s], options.step);
    for (size_t k = 0; k + 1 < whole.q.size(); ++k) {
      const Vector7d chord = whole.q[k + 1] - whole.q[k];
      const double length2 = chord.squaredNorm();
      for (size_t i = s; i < seeds.size(); ++i) {
        if (visited[i]) continue;
        const Vector7d d = wrapped(seeds[i] - whole.q[k]);
        const double along = length2 > 0.0 ? std::clamp(d.dot(chord) / length2, 0.0, 1.0) : 0.0;
        if ((d - along * chord).norm() < 0.25 * options.step) visited[i] = 1;
      }
    }
    visited[s] = 1;
    if (options.limits)
      cutByLimits(goal, whole, curves);
    else
      curves.push_back(whole);
  }
  return curves;
}

/// Down the distance along the curve, within limits; returns the distance.
double SevenJointArm::descend(const Isometry3d& goal, const Vector7d& near, bool limits, Vector7d& q) const {
  double distance = (q - near).norm();
  double trust = 0.3;
  Vector7d tangent = Vector7d::Constant(1.0).normalized();
  for (int k = 0; k < 3; ++k) tangent = tangentAt(q, tangent);
  for (int iteration = 0; iteration < 40; ++iteration) {
    tangent = tangentAt(q, tangent);
    const double slope = tangent.dot(q - near);  // of half the squared distance
    if (std::abs(slope) < 1e-10) break;
    // Curvature by a difference of the slope a little ahead; a minimum has a positive one.
    Vector7d ahead = q + 1e-4 * tangent;
    double curvature = 1.0;
    if (correct(goal, tangent, ahead))
      curvature = (tangentAt(ahead, tangent).dot(ahead - near) - slope) / 1e-4;
    double step =
        std::clamp(curvature > 1e-3 ? -slope / curvature : (slope > 0.0 ? -trust : trust), -trust, trust);
    bool moved = false;
    for (int half = 0; half < 24 && std::abs(step) > 1e-12; ++half, step *= 0.5) {
      Vector7d next = q + step * tangent;
      if (!correct(goal, tangent, next) || (next - q).norm() > 3.0 * std::abs(step)) continue;
      bool inside = true;
      for (int i = 0; i < 7; ++i)
        inside &= !limits || (next[i] >= chain_.lower[i] && next[i] <= chain_.upper[i]);
      const double there = (next - near).norm();
      if (!inside || there >= distance) continue;
      q = next, distance = there, moved = true;
      break;
    }
    if (!moved) break;
  }
  return distance;
}

Vector7d SevenJointArm::tangent(const Vector7d& q) const {
  return tangentAt(q, tangentAt(q, Vector7d::Constant(1.0).normalized()));
}

bool SevenJointArm::slide(const Isometry3d& worldFromTip, const Vector7d& step, Vector7d& q) const {
  const double size = step.norm();
  if (size < 1e-9) return true;
  Vector7d next = q + step;
  if (!correct(lastFrame(worldFromTip), step / size, next) || (next - q).norm() > 2.0 * size) return false;
  for (int i = 0; i < 7; ++i)
    if (next[i] < chain_.lower[i] || next[i] > chain_.upper[i]) return false;
  q = next;
  return true;
}

bool SevenJointArm::nearest(const Isometry3d& worldFromTip, const Vector7d& near, Vector7d& best,
                            const SelfMotionOptions& options) const {
  const Isometry3d goal = lastFrame(worldFromTip);
  if (family_) {
    if (!family_->nearest(worldFromTip, near, options.limits, best)) return false;
    correct(goal, tangentAt(best, Vector7d::Constant(1.0)), best);
    if (family_->misfit() > 1e-12) descend(goal, near, options.limits, best);
    if (options.limits) best = best.cwiseMax(chain_.lower).cwiseMin(chain_.upper);
    return true;
  }
  return nearestByWalking(worldFromTip, near, best, options);
}

bool SevenJointArm::nearestByWalking(const Isometry3d& worldFromTip, const Vector7d& near, Vector7d& best,
                                     const SelfMotionOptions& options) const {
  const Isometry3d goal = lastFrame(worldFromTip);
  double bestDistance = INFINITY;
  for (SelfMotionCurve& piece : selfMotion(worldFromTip, options)) {
    if (!options.limits)  // an image of the whole curve each: the nearest of each pose
      for (Vector7d& q : piece.q) q = near + wrapped(q - near);
    const auto distance = [&](size_t k) { return (piece.q[k] - near).norm(); };
    for (size_t k = 0; k < piece.q.size(); ++k) {
      const double own = distance(k);
      if (own - 2.0 * options.step > bestDistance) continue;
      if ((k > 0 && distance(k - 1) < own) || (k + 1 < piece.q.size() && distance(k + 1) < own)) continue;
      Vector7d q = piece.q[k];
      const double d = descend(goal, near, options.limits, q);
      if (d < bestDistance) bestDistance = d, best = q;
    }
  }
  return std::isfinite(bestDistance);
}

}  // namespace gelenk
