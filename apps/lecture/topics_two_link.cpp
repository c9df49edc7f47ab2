// Lecture 10.1.3: the analytic solution for two links.

#include <algorithm>
#include <random>

#include "apps/lecture/derivations.h"
#include "apps/lecture/example.h"
#include "apps/lecture/slide_data.h"
#include "apps/lecture/text.h"
#include "kinematics/configuration.h"
#include "kinematics/notation/planar_chain.h"
#include "solvers/methods/two_link.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double degree = M_PI / 180.0;
constexpr double l = slide::armLength;
const Vector2d origin = Vector2d::Zero();

TwoLinkSolution solution() { return solveTwoLink(origin, l, l, slide::armTarget); }

/// Of the slide's candidates for phi_1 at a given phi_2 (degrees): both, or only those that forward
/// kinematics confirms.
std::vector<double> candidates(double phi2, bool holding) {
  std::vector<double> found;
  for (const ArctangentCandidate& c : arctangentCandidates(origin, l, l, slide::armTarget))
    if (std::abs(c.phi2 / degree - phi2) < 1e-6 && (!holding || c.distance < 1e-9))
      found.push_back(c.phi1 / degree);
  std::sort(found.begin(), found.end());
  return found;
}

/// Worst distance from the target over both branches of random targets inside the annulus, in units of l1 +
/// l2.
double worstInside(int targets) {
  std::mt19937_64 random(1);
  double worst = 0.0;
  for (int i = 0; i < targets; ++i) {
    const double l1 = 0.01 + uniform01(random), l2 = 0.01 + uniform01(random), hole = std::abs(l1 - l2);
    const double r = hole + (l1 + l2 - hole) * uniform01(random), angle = 2.0 * M_PI * uniform01(random);
    const Vector2d X(r * std::cos(angle), r * std::sin(angle));
    const TwoLinkSolution found = solveTwoLink(origin, l1, l2, X);
    for (const TwoLinkBranch& branch : found.branches())
      worst = std::max(
          worst, (endEffector({.base = origin, .lengths = {l1, l2}}, Vector2d(branch.phi1, branch.phi2)) - X)
                         .norm() /
                     (l1 + l2));
  }
  return worst;
}

/// Largest elbow step over target step while a target crosses the pole direction in steps of 1 mm (arm 0.3
/// and 0.27, distance 0.4).
double elbowJump(bool historyAware) {
  const Vector3d base = Vector3d::Zero(), pole = Vector3d::UnitY();
  Vector3d elbow, end;
  double worst = 0.0;
  for (int i = -100; i <= 100; ++i) {
    const Vector3d target(i * 1e-3 + 1e-7, 0.4, 0.0);
    const Vector3d side = historyAware && i > -100 ? carriedPole(base, elbow, end, target, pole) : pole;
    const Bend bend = bendTowards(base, 0.3, 0.27, target, side);
    if (i > -100) worst = std::max(worst, (bend.elbow - elbow).norm() / (target - end).norm());
    elbow = bend.elbow;
    end = bend.end;
  }
  return worst;
}

std::string derivation(const PlanarChain& arm, const Vector2d& X, const std::string& remark) {
  const double l1 = arm.lengths[0], l2 = arm.lengths[1];
  const Vector2d d = X - arm.base;
  std::string out = fmt::format("Given: P_1 = {}, X = {}, l_1 = {:g}, l_2 = {:g}\n", text::point(arm.base),
                                text::point(X), l1, l2);
  const double r = d.norm();
  const bool inside = r >= std::abs(l1 - l2) && r <= l1 + l2;
  out += fmt::format("Reachable workspace: |l_1 - l_2| = {:g} <= |X - P_1| = {:g} <= l_1 + l_2 = {:g}{}\n",
                     std::abs(l1 - l2), r, l1 + l2, inside ? "" : " does not hold");
  out += remark;
  const double cosine = (d.squaredNorm() - l1 * l1 - l2 * l2) / (2 * l1 * l2);
  out += fmt::format("\ncos phi_2 = (dx^2 + dy^2 - l_1^2 - l_2^2) / (2 l_1 l_2) = {:.6g}, so {}\n\n", cosine,
                     std::abs(cosine) <= 1.0
                         ? fmt::format("phi_2 = +-{:.8g} degrees", std::acos(cosine) / degree)
                         : std::string("there is no phi_2: the target is out of reach"));
  out +=
      "tan phi_1 = (dy (l_1 + l_2 c_2) - dx l_2 s_2) / (dx (l_1 + l_2 c_2) + dy l_2 s_2)\n"
      "with c_2 = cos phi_2, s_2 = sin phi_2. The arctangent leaves two candidates, pi apart. Forward "
      "kinematics tells which one holds:\n";
  out += text::heads({"phi_2 [deg]", "phi_1 [deg]", "f(phi)", "", "|f(phi) - X|", " "});
  for (const ArctangentCandidate& c : arctangentCandidates(arm.base, l1, l2, X)) {
    if (!std::isfinite(c.distance)) continue;
    std::vector<std::string> cells{text::fixed(c.phi2 / degree, 3), text::fixed(c.phi1 / degree, 3)};
    text::append(cells, endEffector(arm, Vector2d(c.phi1, c.phi2)), 4);
    cells.push_back(text::fixed(c.distance, 4));
    cells.push_back(c.distance < 1e-9 ? "holds" : "misses");
    out += text::row(cells);
  }
  out += "\nWith atan2(numerator, denominator) only those that hold are left. All branches:\n";
  out += text::heads({"phi_1 [deg]", "phi_2 [deg]", " "});
  const TwoLinkSolution all = solveTwoLink(arm.base, l1, l2, X);
  for (const TwoLinkBranch& branch : all.branches())
    out += text::row({text::fixed(branch.phi1 / degree, 6), text::fixed(branch.phi2 / degree, 6),
                      branch.exact ? "exact" : "nearest"});
  return out;
}

std::string steps() {
  std::string out =
      derivation({.base = origin, .lengths = {l, l}}, slide::armTarget,
                 "  (the slide prints the lower end as l_1 - l_2, which is meant for l_1 >= l_2)\n");
  out += "\nThe borders (same arm unless said otherwise):\n" +
         text::heads({"target", "", "phi_1 [deg]", "phi_2 [deg]", "gap", " "});
  struct Border {
    const char* name;
    double l1, l2;
    Vector2d X;
  };
  for (const Border& b :
       {Border{"at the base, l_1 = l_2", l, l, {0, 0}}, Border{"r = l_1 + l_2", l, l, {2 * l, 0}},
        Border{"r = l_1 - l_2, l_2 = 4", l, 4, {6, 0}}, Border{"outside", l, l, {25, 0}},
        Border{"in the hole, l_2 = 4", l, 4, {2, 0}}, Border{"l_2 = 0", l, 0, {0, l}}}) {
    const TwoLinkSolution s = solveTwoLink(origin, b.l1, b.l2, b.X);
    out += text::row({b.name, toString(s.kind), text::fixed(s.branch[0].phi1 / degree, 1),
                      text::fixed(s.branch[0].phi2 / degree, 1), text::fixed(s.gap, 1),
                      s.branch[0].exact ? "exact" : "nearest point"});
  }
  out += fmt::format("\nWorst error of 100,000 random targets inside the annulus: {:.2e} (l_1 + l_2)\n",
                     worstInside(100'000));
  out += fmt::format(
      "In space, a target crossing the pole direction in 1 mm steps moves the elbow by {:.3g} times the "
      "target's step with a fixed pole, "
      "{:.3g} times with a pole that is carried along.\n",
      elbowJump(false), elbowJump(true));
  return out;
}

}  // namespace

std::string twoLinkDerivation(const PlanarChain& arm, const Vector2d& X) { return derivation(arm, X, ""); }

LectureTopic twoLinkTopic() {
  const std::string section = "10.1.3, numerical example";
  LectureTopic topic{.id = "two-link",
                     .section = "10.1.3",
                     .title = "Analytic inverse kinematics of two links",
                     .steps = &steps,
                     .checks = {}};
  topic.checks = {
      {.id = "two-link-phi2",
       .section = section,
       .what = "phi_2 in {-120, 120} degrees",
       .printed = {-120, 120},
       .tolerance = {1e-10},
       .compute =
           [] {
             return std::vector{solution().branch[1].phi2 / degree, solution().branch[0].phi2 / degree};
           }},
      {.id = "two-link-candidates-plus",
       .section = section,
       .what = "arctangent for phi_2 = 120: {-60, 120}",
       .printed = {-60, 120},
       .tolerance = {1e-10},
       .compute = [] { return candidates(120, false); },
       .note = "of these forward kinematics confirms -60 alone: see two-link-phi1-plus"},
      {.id = "two-link-candidates-minus",
       .section = section,
       .what = "arctangent for phi_2 = -120: {-120, 60}",
       .printed = {-120, 60},
       .tolerance = {1e-10},
       .compute = [] { return candidates(-120, false); },
       .note = "of these forward kinematics confirms 60 alone: see two-link-phi1-minus"},
      {.id = "two-link-phi1-plus",
       .section = section,
       .what = "phi_1 that holds for phi_2 = 120 degrees",
       .printed = {-60},
       .tolerance = {1e-10},
       .compute = [] { return candidates(120, true); }},
      {.id = "two-link-phi1-minus",
       .section = section,
       .what = "phi_1 that holds for phi_2 = -120 degrees",
       .printed = {60},
       .tolerance = {1e-10},
       .compute = [] { return candidates(-120, true); }},
      {.id = "two-link-atan2",
       .section = section,
       .what = "atan2 gives exactly those: (-60, 120), (60, -120)",
       .printed = {-60, 120, 60, -120},
       .tolerance = {1e-10},
       .compute =
           [] {
             std::vector<double> angles;
             const TwoLinkSolution all = solution();
             for (const TwoLinkBranch& b : all.branches())
               angles.insert(angles.end(), {b.phi1 / degree, b.phi2 / degree});
             return angles;
           }},
      {.id = "two-link-annulus",
       .section = "10.1.3, reachable workspace",
       .what = "[l_1 - l_2, l_1 + l_2], here for l_1 = 10, l_2 = 4: gaps at r = 6 and 14",
       .printed = {0, 0},
       .tolerance = {1e-14},
       .compute =
           [] {
             return std::vector{solveTwoLink(origin, l, 4, {l - 4, 0}).gap,
                                solveTwoLink(origin, l, 4, {l + 4, 0}).gap};
           },
       .note =
           "the slide prints the lower end as l1 - l2; for l1 < l2 it is l2 - l1, so |l1 - l2| in general"},
      {.id = "two-link-annulus-swapped",
       .section = "10.1.3, reachable workspace",
       .what = "the same for l1 = 4, l2 = 10 needs |l1 - l2|: gaps at r = 6 and 5",
       .printed = {0, 1},
       .tolerance = {1e-14},
       .compute =
           [] {
             return std::vector{solveTwoLink(origin, 4, l, {l - 4, 0}).gap,
                                solveTwoLink(origin, 4, l, {l - 5, 0}).gap};
           }},
      {.id = "two-link-error",
       .section = "10.1.3, analytic solution",
       .what = "worst error of 20,000 targets inside, units of l1 + l2",
       .printed = {1e-14},
       .tolerance = {0},
       .compute = [] { return std::vector{worstInside(20'000)}; },
       .comparison = Comparison::AtMost},
      {.id = "two-link-pole",
       .section = "10.1.3 in space",
       .what = "elbow step / target step across the pole, carried pole",
       .printed = {5},
       .tolerance = {0},
       .compute = [] { return std::vector{elbowJump(true)}; },
       .comparison = Comparison::AtMost,
       .note = "a fixed pole flips the elbow there"},
  };
  return topic;
}

}  // namespace gelenk
