#include "solvers/solutions/arm_solutions.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "solvers/solutions/lanes.h"
#include "solvers/solutions/meeting_pair.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

using namespace lanes;

constexpr double nearMisfit = 1e-5;      ///< axes that miss a class by less are solved as if they did not
constexpr double polishedError = 1e-13;  ///< above it a solution is polished
constexpr double familyError = 2e-12;    ///< the same of a member of a family
constexpr double acceptedError = 1e-9;   ///< of a loop that cannot be polished further (singular)
constexpr int cutsTried = 6;             ///< of the elimination
constexpr int pairsTried = 2;            ///< of the search beside two axes that meet

/// F_i = Rx(alpha) T(a, 0, d), lengths over `scale`.
Isometry3d fixedPart(const ChainConstants& C, int i, double scale) {
  Isometry3d F = Isometry3d::Identity();
  F.linear() << 1, 0, 0, 0, C.cosAlpha[i], -C.sinAlpha[i], 0, C.sinAlpha[i], C.cosAlpha[i];
  F.translation() = Vector3d(C.a[i], -C.sinAlpha[i] * C.d[i], C.cosAlpha[i] * C.d[i]) / scale;
  return F;
}

Vector6d toCut(const Cut& cut, const Vector6d& u) {
  Vector6d out;
  for (int j = 0; j < 6; ++j) out[j] = cut.sign() * u[cut.joint(j)];
  return out;
}
Vector6d fromCut(const Cut& cut, const Vector6d& u) {
  Vector6d out;
  for (int j = 0; j < 6; ++j) out[cut.joint(j)] = cut.sign() * u[j];
  return out;
}
unsigned fromCut(const Cut& cut, unsigned bits) {
  unsigned out = 0;
  for (int j = 0; j < 6; ++j)
    if (bits >> j & 1u) out |= 1u << cut.joint(j);
  return out;
}

bool contains(const LoopSolutions& found, const Vector6d& wanted) {
  for (int k = 0; k < found.count; ++k) {
    bool hit = true;
    for (int i = 0; i < 6 && hit; ++i) hit = std::abs(std::remainder(found.u[k][i] - wanted[i], turn)) < 1e-5;
    if (hit) return true;
  }
  return false;
}

bool parallel(const Isometry3d& link) { return link.linear().col(2).head<2>().norm() < 1e-9; }

}  // namespace

SixJointArm::SixJointArm(const SerialChain& chain) : chain_(chain) {
  if (chain.n != 6)
    throw std::invalid_argument("complete sets need six joints; this chain has " + std::to_string(chain.n));
  scale_ = chain.length / 3.0;
  baseFromWorld_ = chain.worldFromBase.inverse(Eigen::Isometry);
  tipFromLast_ = chain.lastFromTip.inverse(Eigen::Isometry);
  for (int i = 0; i < 5; ++i) fixed_.link[i] = fixedPart(chain.constants, i + 1, scale_);
  fixed_.link[5] = Isometry3d::Identity();
  // The angle of a joint that slides is constant: it belongs to the link behind.
  for (int i = 0; i < 6; ++i) {
    if (chain.constants.revolute[i] > 0.5) continue;
    fixed_.slides |= 1u << i;
    const Isometry3d spin(Eigen::AngleAxisd(chain.constants.theta[i], Vector3d::UnitZ()));
    if (i < 5)
      fixed_.link[i] = spin * fixed_.link[i];
    else
      tipFromLast_ = tipFromLast_ * spin.inverse(Eigen::Isometry);
  }
  for (int i = 0; i < 5; ++i) reach_ += fixed_.link[i].translation().norm();
  if (fixed_.slides) reach_ = INFINITY;
  decomposition_ = decompose(fixed_, nearMisfit);
  if (decomposition_.kind == LoopClass::General) {
    if (fixed_.slides) throw std::invalid_argument(slidingNeedsAWrist);
    rankCuts();
    rankPairs();
    return;
  }
  triple_.emplace(decomposition_.kind, cutAt(fixed_, decomposition_.cut), goalLink(decomposition_.cut));
  if (fixed_.slides && !hasFiniteSets())
    throw std::invalid_argument(
        "the joints that slide leave families of solutions, or none, wherever the arm stands, or need "
        "another "
        "method than three turning joints that meet behind them");
  const bool shoulderAndElbow = !parallel(fixed_.link[0]) && parallel(fixed_.link[1]);
  named_ = shoulderAndElbow && !fixed_.slides &&
           ((decomposition_.kind == LoopClass::SphericalTriple && decomposition_.firstOfThree == 3) ||
            (decomposition_.kind == LoopClass::ParallelTriple && decomposition_.firstOfThree == 1 &&
             !parallel(fixed_.link[3]) && !parallel(fixed_.link[4])));
  if (!named_) return;
  // Where the axes of joints 2 and 3 are parallel, the bend at joint 3 and the one at joint 5 are waves of
  // their own angles.
  const Vector3d x2 = fixed_.link[1].translation(), x3 = fixed_.link[2].translation(),
                 w = fixed_.link[1].linear().transpose() * Vector3d(-x2.y(), x2.x(), 0),
                 in = fixed_.link[3].linear().row(2).transpose(), out = fixed_.link[4].linear().col(2);
  elbow_ = Side(w.x() * x3.x() + w.y() * x3.y(), w.y() * x3.x() - w.x() * x3.y());
  wrist_ = Side(in.x() * out.y() - in.y() * out.x(), in.x() * out.x() + in.y() * out.y());
}

/// Of some random poses one at least is among the solutions of where it puts the tip.
bool SixJointArm::hasFiniteSets() const {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  for (int t = 0; t < 6; ++t) {
    Vector6d q;
    for (int i = 0; i < 6; ++i) q[i] = share(random) * (fixed_.slidesAt(i) ? scale_ : M_PI);
    ArmSolutions found;
    solve(tipFrame(chain_, Eigen::VectorXd(q)), Vector6d::Zero(), found);
    if (isThere(found, q, 1e-6)) return true;
  }
  return false;
}

SixJointArm::Side::Side(double cosine, double sine)
    : size(std::hypot(cosine, sine)), phase(std::atan2(sine, cosine)) {}

std::string SixJointArm::describe() const {
  const int i = decomposition_.firstOfThree + 1;
  const std::string axes =
      "axes " + std::to_string(i) + ", " + std::to_string(i + 1) + " and " + std::to_string(i + 2);
  switch (decomposition_.kind) {
    case LoopClass::SphericalTriple:
      return std::string(i == 4   ? "spherical wrist"
                         : i == 1 ? "spherical shoulder"
                                  : "spherical elbow") +
             ": " + axes + " meet in a point";
    case LoopClass::ParallelTriple: return "three parallel axes: " + axes;
    case LoopClass::General: break;
  }
  return "general: no three neighbouring axes meet in a point or are parallel";
}

/// Over the arm's length; the frame of the last joint before it turns, as the base sees it.
Isometry3d SixJointArm::baseFromLast(const Isometry3d& worldFromTip) const {
  Isometry3d last;
  const Matrix3d left = baseFromWorld_.linear() * worldFromTip.linear();
  last.linear() = left * tipFromLast_.linear();
  last.translation() = (left * tipFromLast_.translation() +
                        baseFromWorld_.linear() * worldFromTip.translation() + baseFromWorld_.translation()) /
                       scale_;
  last.makeAffine();
  return last;
}

void SixJointArm::place(const Isometry3d& worldFromTip, const Cut& cut, Loop& loop) const {
  const Isometry3d last = baseFromLast(worldFromTip);
  loop.link[goalLink(cut)] = cut.reversed ? last : last.inverse(Eigen::Isometry);
}

void SixJointArm::insert(const Vector6d& u, double error, unsigned free, const Vector6d& reference,
                         ArmSolutions& out) const {
  if (out.count == ArmSolutions::most) return;
  ArmSolution& s = out.list[out.count];
  s.shoulder = s.elbow = s.wrist = 0;
  s.withinLimits = true;
  for (int i = 0; i < 6; ++i) {
    s.q[i] = u[i] - chain_.constants.theta[i];
    s.withinLimits &= toNearestImage(s.q[i], chain_.lower[i], chain_.upper[i], reference[i]);
  }
  if (isThere(out, s.q)) return;
  s.error = error;
  s.free = static_cast<unsigned char>(free);
  ++out.count;
}

void SixJointArm::solve(const Isometry3d& worldFromTip, const Vector6d& reference, ArmSolutions& out) const {
  out.count = 0;
  out.complete = true;
  out.noise = out.raw = 0.0;
  const Isometry3d last = baseFromLast(worldFromTip);
  if (last.translation().norm() > reach_ + 1e-9) return;  // the links are too short, whatever they do
  if (decomposition_.kind == LoopClass::General) return solveGeneral(worldFromTip, out, reference);
  const Cut& cut = decomposition_.cut;
  const Isometry3d goal = cut.reversed ? last : last.inverse(Eigen::Isometry);
  Vector6d turned;
  for (int j = 0; j < 6; ++j) {
    const int i = cut.joint(j);
    turned[j] =
        cut.sign() * (fixed_.slidesAt(i) ? reference[i] / scale_ : reference[i] + chain_.constants.theta[i]);
  }
  TripleSolutions found;
  triple_->solve(goal, turned, found);
  int kept = 0;
  for (int k = 0; k < found.count; ++k) {
    out.raw = std::max(out.raw, found.error[k]);
    // A member of a family that is good enough would only be moved along it.
    if (found.error[k] > (found.free[k] ? familyError : polishedError)) {
      Vector6d u = found.at(k);
      double before = 0.0;
      found.alike = true;
      Loop loop = triple_->loop();
      loop.link[goalLink(cut)] = goal;
      if (!polish(loop, u, acceptedError, found.error[k], before)) continue;
      found.set(k, u);
    }
    if (kept != k) found.move(k, kept);
    ++kept;
  }
  found.count = kept;
  toImages(found, last, reference, out);
}

bool SixJointArm::isThere(const ArmSolutions& out, const Vector6d& q, double tolerance) const {
  for (int k = 0; k < out.count; ++k) {
    bool same = true;
    for (int i = 0; i < 6 && same; ++i) {
      const double d = out.list[k].q[i] - q[i];
      same = std::abs(fixed_.slidesAt(i) ? d : wrapped(d)) < tolerance;
    }
    if (same) return true;
  }
  return false;
}

/// Angles of the hinges to those of the joints, with limits and names, four solutions at a time.
GELENK_SIMD_CLONES void SixJointArm::toImages(const TripleSolutions& found, const Isometry3d& last,
                                              const Vector6d& reference, ArmSolutions& out) const {
  const Cut& cut = decomposition_.cut;
  // The wrist's centre (UR: where axes 5 and 6 meet) beside the plane through axis 1 along axis 2.
  Side shoulder;
  if (named_) {
    const Vector3d axis2 = fixed_.link[0].linear().col(2), &p = last.translation();
    shoulder = Side(axis2.x() * p.y() - axis2.y() * p.x(), -axis2.y() * p.y() - axis2.x() * p.x());
  }
  for (int base = 0; base < found.count; base += 4) {
    double q[6][4], name[3][4] = {};
    Mask within = ~Mask{};
    for (int j = 0; j < 6; ++j) {
      const int i = cut.joint(j);
      const Lanes u = cut.sign() * load(found.u[j] + base);
      if (fixed_.slidesAt(i)) {
        constexpr double inside = 1e-9;  // metres
        const double lower = chain_.lower[i], upper = chain_.upper[i];
        Lanes length = scale_ * u;
        within &= (length >= lower - inside) & (length <= upper + inside);
        store(q[i], length);
        continue;
      }
      Lanes angle = u - chain_.constants.theta[i];
      within &= toNearestImage(angle, chain_.lower[i], chain_.upper[i], reference[i]);
      store(q[i], angle);
      if (named_ && i % 2 == 0) {
        const Side& side = i == 0 ? shoulder : i == 2 ? elbow_ : wrist_;
        const Lanes above = side.size * (M_PI / 2 - magnitude(wrapped(Lanes(u - side.phase))));
        store(name[i / 2],
              choose(above > 1e-9, Lanes{} + 1.0, choose(above < -1e-9, Lanes{} - 1.0, Lanes{})));
      }
    }
    for (int l = 0; l < 4 && base + l < found.count; ++l) {
      ArmSolution& s = out.list[out.count];
      for (int i = 0; i < 6; ++i) s.q[i] = q[i][l];
      if (found.alike && isThere(out, s.q)) continue;
      s.withinLimits = within[l] != 0;
      s.error = found.error[base + l];
      s.free = found.free[base + l];
      if (s.free != 0) s.free = static_cast<unsigned char>(fromCut(cut, s.free));
      s.shoulder = static_cast<signed char>(name[0][l]);
      s.elbow = static_cast<signed char>(name[1][l]);
      s.wrist = static_cast<signed char>(name[2][l]);
      ++out.count;
    }
  }
}

/// As many solutions on one side of the singularities as on the other: see loopDeterminant.
bool SixJointArm::balanced(const Isometry3d& worldFromTip, const ArmSolutions& found) const {
  if (found.count % 2 == 1) return false;
  Loop loop = fixed_;
  place(worldFromTip, Cut{}, loop);
  int surplus = 0;
  for (const ArmSolution& s : found.all()) {
    Vector6d u = s.q;
    for (int i = 0; i < 6; ++i) u[i] += chain_.constants.theta[i];
    surplus += loopDeterminant(loop, u) > 0.0 ? 1 : -1;
  }
  return surplus == 0;
}

void SixJointArm::solveGeneral(const Isometry3d& worldFromTip, ArmSolutions& out,
                               const Vector6d& reference) const {
  out.complete = false;
  out.noise = 1.0;
  // Two ways that each find the whole set, where there are two, an elimination that shows nothing suspicious
  // being one of them: then it is complete.
  const size_t pairs = std::min<size_t>(pairsTried, rankedPairs_.size()),
               tries = std::min<size_t>(cutsTried, ranked_.size());
  struct Way {
    int count;
    bool clean;
  } ways[cutsTried + pairsTried];
  int asked = 0, roots = 0;
  const auto agreed = [&] {
    int whole = 0, clean = 0;
    for (int k = 0; k < asked; ++k) {
      if (ways[k].count != out.count) continue;
      ++whole, clean += ways[k].clean;
    }
    return whole >= std::min<int>(2, static_cast<int>(pairs + tries)) && clean > 0 && out.count >= roots &&
           balanced(worldFromTip, out);
  };
  const auto take = [&](const Cut& cut, const LoopSolutions& found, bool clean) {
    out.raw = std::max(out.raw, found.raw);
    for (int i = 0; i < found.count; ++i) insert(fromCut(cut, found.u[i]), found.error[i], 0, reference, out);
    ways[asked++] = {found.count, clean};
  };
  for (size_t k = 0; k < std::max(pairs, tries); ++k) {
    if (k < pairs) {
      Loop loop = cutAt(fixed_, rankedPairs_[k]);
      place(worldFromTip, rankedPairs_[k], loop);
      take(rankedPairs_[k], solveMeetingPair(loop), false);
    }
    if (k < tries) {
      Loop loop = rankedLoop_[k];
      place(worldFromTip, ranked_[k], loop);
      LoopSolutions known;
      for (const ArmSolution& s : out.all()) {
        Vector6d u = s.q;
        for (int i = 0; i < 6; ++i) u[i] += chain_.constants.theta[i];
        known.u[known.count] = toCut(ranked_[k], u);
        known.error[known.count++] = s.error;
      }
      const LoopSolutions found = solveGeneralLoop(loop, known);
      out.noise = std::min(out.noise, found.noise);
      // A start far from its solution may have ended at another's.
      take(ranked_[k], found, found.noise < 1e-9 && found.suspects == 0 && found.raw < 1e-2);
      roots = std::max(roots, found.roots);
    }
    if (agreed()) break;
  }
  out.complete = agreed();
}

/// The places to hold a hinge beside two axes that meet, the one that lost fewest of some known poses first.
void SixJointArm::rankPairs() {
  struct Score {
    Cut cut;
    int missed, rank;
  };
  std::vector<Score> scores;
  for (int c = 0; c < 12; ++c) {
    const Cut cut{c % 6, c >= 6};
    Loop loop = cutAt(fixed_, cut);
    Score score{cut, 0, meetingPairRank(loop, goalLink(cut), 1e-9)};
    if (score.rank == 0) continue;
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> angle(-M_PI, M_PI);
    for (int t = 0; t < 32 && score.missed < 3; ++t) {
      Vector6d q;
      for (double& x : q) x = angle(random);
      place(tipFrame(chain_, Eigen::VectorXd(q)), cut, loop);
      const LoopSolutions found = solveMeetingPair(loop);
      if (found.suspects > 0) score.missed = 3;
      for (int i = 0; i < 6; ++i) q[i] += chain_.constants.theta[i];
      const Vector6d wanted = toCut(cut, q);
      score.missed += !contains(found, wanted);
    }
    if (score.missed < 3) scores.push_back(score);
  }
  std::stable_sort(scores.begin(), scores.end(), [](const Score& a, const Score& b) {
    return a.rank != b.rank ? a.rank > b.rank : a.missed < b.missed;
  });
  for (const Score& s : scores) rankedPairs_.push_back(s.cut);
}

void SixJointArm::rankCuts() {
  struct Score {
    Cut cut;
    int missed = 0, suspect = 0, multiple = 0;
    double noise = 0.0;
  };
  std::vector<Score> scores;
  for (int c = 0; c < 12; ++c) {
    Score score{.cut = {c % 6, c >= 6}};
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> angle(-M_PI, M_PI);
    constexpr int trials = 24;
    Loop loop = cutAt(fixed_, score.cut);
    for (int t = 0; t < trials; ++t) {
      Vector6d q;
      Eigen::VectorXd all(6);
      for (int i = 0; i < 6; ++i) all[i] = q[i] = angle(random);
      place(tipFrame(chain_, all), score.cut, loop);
      const LoopSolutions found = solveGeneralLoop(loop);
      score.noise += std::log10(std::max(found.noise, 1e-16));
      score.suspect += found.suspects > 0 || found.count % 2 == 1;
      score.multiple += found.multiple > 0;
      for (int i = 0; i < 6; ++i) q[i] += chain_.constants.theta[i];
      const Vector6d wanted = toCut(score.cut, q);
      score.missed += !contains(found, wanted);
      if (t == 3 && score.missed == 4) break;
    }
    if (score.missed < 4) scores.push_back(score);
  }
  std::stable_sort(scores.begin(), scores.end(), [](const Score& a, const Score& b) {
    const int badA = 4 * a.missed + a.suspect + a.multiple, badB = 4 * b.missed + b.suspect + b.multiple;
    return badA != badB ? badA < badB : a.noise < b.noise;
  });
  for (const Score& s : scores) {
    ranked_.push_back(s.cut);
    rankedLoop_.push_back(cutAt(fixed_, s.cut));
  }
}

std::string branchName(const ArmSolution& s) {
  std::string name;
  const auto add = [&](const char* part, int side) {
    if (side != 0) name += std::string(name.empty() ? "" : ", ") + part + (side > 0 ? " +" : " -");
  };
  add("shoulder", s.shoulder), add("elbow", s.elbow), add("wrist", s.wrist);
  return name;
}

int imageCount(double q, double lower, double upper) {
  if (!std::isfinite(lower) || !std::isfinite(upper)) return 1;
  const double first = q + turn * std::ceil((lower - q - 1e-9) / turn);
  return first > upper + 1e-9 ? 0 : 1 + static_cast<int>(std::floor((upper - first + 1e-9) / turn));
}

}  // namespace gelenk
