#include "solvers/methods/two_link.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "kinematics/rotation.h"

namespace gelenk {

using Eigen::Vector2d;
using Eigen::Vector3d;

const char* toString(TwoLinkCase kind) {
  switch (kind) {
    case TwoLinkCase::TwoElbows: return "two elbows";
    case TwoLinkCase::Straight: return "straight";
    case TwoLinkCase::Folded: return "folded";
    case TwoLinkCase::AnyDirection: return "any direction";
    case TwoLinkCase::TooFar: return "too far";
    case TwoLinkCase::TooNear: return "too near";
  }
  return "unknown";
}

namespace {

void requireLengths(double l1, double l2) {
  if (!(l1 >= 0.0) || !(l2 >= 0.0) || !std::isfinite(l1) || !std::isfinite(l2))
    throw std::invalid_argument("the lengths of a two-link arm must be finite and not negative");
}

/// In units of l1 + l2: angle psi between base -> target and the first link, and phi_2, both in [0, pi], for
/// |d| <= rho <= 1 with d = (l1 - l2) / (l1 + l2). Half-angle formulas of the law of cosines: only factors
/// that are exact to rounding, the same in both angles, so that what is lost next to the borders is lost by
/// neither link alone.
struct Triangle {
  double psi, phi2;
};
Triangle solveTriangle(double d, double rho) {
  const double beyondFold = std::max(rho - d, 0.0), beyondOtherFold = std::max(rho + d, 0.0),
               beforeReach = std::max(1.0 - rho, 0.0);
  return {
      .psi = 2.0 * std::atan2(std::sqrt(beyondFold * beforeReach), std::sqrt((1.0 + rho) * beyondOtherFold)),
      .phi2 =
          2.0 * std::atan2(std::sqrt(beforeReach * (1.0 + rho)), std::sqrt(beyondFold * beyondOtherFold))};
}

TwoLinkSolution single(TwoLinkCase kind, double phi1, double phi2, double gap, bool exact) {
  TwoLinkSolution solution{.kind = kind, .count = 1, .gap = gap};
  solution.branch[0] = {.phi1 = phi1, .phi2 = phi2, .exact = exact};
  solution.branch[1] = solution.branch[0];
  return solution;
}

}  // namespace

TwoLinkSolution solveTwoLink(const Vector2d& P1, double l1, double l2, const Vector2d& X) {
  requireLengths(l1, l2);
  if (!P1.allFinite() || !X.allFinite())
    throw std::invalid_argument("base and target of a two-link arm must be finite");
  const double reach = l1 + l2, hole = std::abs(l1 - l2);
  const double dx = X.x() - P1.x(), dy = X.y() - P1.y();
  const double r = std::hypot(dx, dy);
  const double direction = std::atan2(dy, dx);  // 0 for a target at the base
  const double slack = 4.0 * std::numeric_limits<double>::epsilon() * reach;

  if (r >= reach) {
    const double gap = r - reach;
    return single(gap <= slack ? TwoLinkCase::Straight : TwoLinkCase::TooFar, direction, 0.0, gap,
                  gap <= slack);
  }
  if (r <= hole && hole > 0.0) {  // folded; the longer link points at the target
    const double gap = hole - r;
    const double phi1 = l1 >= l2 ? direction : direction + M_PI;
    return single(gap <= slack ? TwoLinkCase::Folded : TwoLinkCase::TooNear, phi1, M_PI, gap, gap <= slack);
  }
  if (r == 0.0) return single(TwoLinkCase::AnyDirection, 0.0, M_PI, 0.0, true);

  const Triangle triangle = solveTriangle((l1 - l2) / reach, r / reach);
  TwoLinkSolution solution{.kind = TwoLinkCase::TwoElbows, .count = 2};
  solution.branch[0] = {.phi1 = direction - triangle.psi, .phi2 = triangle.phi2, .exact = true};
  solution.branch[1] = {.phi1 = direction + triangle.psi, .phi2 = -triangle.phi2, .exact = true};
  return solution;
}

std::array<ArctangentCandidate, 4> arctangentCandidates(const Vector2d& P1, double l1, double l2,
                                                        const Vector2d& X) {
  requireLengths(l1, l2);
  const double dx = X.x() - P1.x(), dy = X.y() - P1.y();
  const double principal =
      std::acos(std::clamp((dx * dx + dy * dy - l1 * l1 - l2 * l2) / (2 * l1 * l2), -1.0, 1.0));
  std::array<ArctangentCandidate, 4> candidates;
  int at = 0;
  for (const double phi2 : {principal, -principal}) {
    const double c2 = std::cos(phi2), s2 = std::sin(phi2);
    const double arctangent =
        std::atan((dy * (l1 + l2 * c2) - dx * l2 * s2) / (dx * (l1 + l2 * c2) + dy * l2 * s2));
    for (const double phi1 : {arctangent, arctangent + (arctangent <= 0.0 ? M_PI : -M_PI)}) {
      const Vector2d reached = P1 + l1 * Vector2d(std::cos(phi1), std::sin(phi1)) +
                               l2 * Vector2d(std::cos(phi1 + phi2), std::sin(phi1 + phi2));
      candidates[at++] = {phi1, phi2, (reached - X).norm()};
    }
  }
  return candidates;
}

Bend bendTowards(const Vector3d& base, double l1, double l2, const Vector3d& target, const Vector3d& pole) {
  const Vector3d toTarget = target - base;
  const double r = toTarget.stableNorm();
  const double poleLength = pole.stableNorm();
  const Vector3d wanted = poleLength > 0.0 ? Vector3d(pole / poleLength) : Vector3d(Vector3d::UnitX());
  const Vector3d u = r > 0.0 ? Vector3d(toTarget / r) : wanted.unitOrthogonal();
  Vector3d e = wanted - u * u.dot(wanted);
  e = e.norm() > 1e-12 ? e.normalized() : u.unitOrthogonal();
  const TwoLinkSolution plane = solveTwoLink({0.0, 0.0}, l1, l2, {r, 0.0});
  const TwoLinkBranch& branch = plane.branch[1];  // phi_2 <= 0: phi_1 >= 0, the elbow on the side of e
  const auto inPlane = [&](double length, double angle) -> Vector3d {
    return length * (std::cos(angle) * u + std::sin(angle) * e);
  };
  Bend bend{.elbow = base + inPlane(l1, branch.phi1), .end = {}, .exact = branch.exact};
  bend.end = bend.elbow + inPlane(l2, branch.phi1 + branch.phi2);
  return bend;
}

Vector3d carriedPole(const Vector3d& base, const Vector3d& elbowBefore, const Vector3d& endBefore,
                     const Vector3d& target, const Vector3d& wantedPole) {
  const Vector3d before = endBefore - base, after = target - base;
  if (before.norm() == 0.0 || after.norm() == 0.0) return elbowBefore - base;
  const Vector3d u = after.normalized();
  const Vector3d carried = rotationBetween(before, after) * (elbowBefore - base);
  Vector3d e = carried - u * u.dot(carried);
  Vector3d wanted = wantedPole - u * u.dot(wantedPole);
  const double h = e.norm();
  if (h < 1e-9 * carried.norm()) return wantedPole;  // a straight arm has no side to carry
  e /= h;
  if (wanted.norm() <= 1e-12 * wantedPole.norm()) return e;
  wanted.normalize();
  const double swivel = std::atan2(e.cross(wanted).dot(u), e.dot(wanted));
  const double largest = std::min(M_PI, 2.0 * (target - endBefore).norm() / h);
  return Eigen::AngleAxisd(std::clamp(swivel, -largest, largest), u) * e;
}

}  // namespace gelenk
