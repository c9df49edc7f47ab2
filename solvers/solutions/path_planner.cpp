#include "solvers/solutions/path_planner.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double turn = 2.0 * M_PI;

double largestTurn(const VectorXd& a, const VectorXd& b) { return (a - b).cwiseAbs().maxCoeff(); }

/// Fewest jumps, then least motion.
struct Cost {
  int jumps = std::numeric_limits<int>::max();
  double motion = 0.0;
  bool operator<(const Cost& o) const { return jumps != o.jumps ? jumps < o.jumps : motion < o.motion; }
};

/// The best way to every candidate of a pose: from a neighbour that is near enough, found among those whose
/// first joint is, or, where that is no way with the fewest jumps, by a jump from one that is.
void advance(const MatrixXd& before, const std::vector<Cost>& costBefore, const MatrixXd& now, double jump,
             std::vector<Cost>& cost, std::vector<int>& from) {
  const Eigen::Index n = now.rows();
  int fewest = std::numeric_limits<int>::max();
  for (const Cost& c : costBefore) fewest = std::min(fewest, c.jumps);
  std::vector<std::pair<double, int>> byFirst;
  for (Eigen::Index i = 0; i < before.cols(); ++i) byFirst.emplace_back(before(0, i), static_cast<int>(i));
  std::sort(byFirst.begin(), byFirst.end());
  cost.assign(now.cols(), {});
  from.assign(now.cols(), -1);
  const auto consider = [&](Eigen::Index j, int i, const Cost& c) {
    if (c < cost[j]) cost[j] = c, from[j] = i;
  };
  for (Eigen::Index j = 0; j < now.cols(); ++j) {
    const double* b = now.col(j).data();
    for (auto it = std::lower_bound(byFirst.begin(), byFirst.end(), std::pair(b[0] - jump, -1));
         it != byFirst.end() && it->first <= b[0] + jump; ++it) {
      const double* a = before.col(it->second).data();
      double square = 0.0;
      bool near = true;
      for (Eigen::Index k = 0; k < n && near; ++k) {
        const double d = b[k] - a[k];
        near = std::abs(d) <= jump;
        square += d * d;
      }
      const Cost& c = costBefore[it->second];
      if (near) consider(j, it->second, {c.jumps, c.motion + std::sqrt(square)});
    }
    if (cost[j].jumps <= fewest) continue;
    for (Eigen::Index i = 0; i < before.cols(); ++i)
      if (costBefore[i].jumps == fewest)
        consider(j, static_cast<int>(i),
                 {fewest + 1, costBefore[i].motion + (now.col(j) - before.col(i)).norm()});
  }
}

void addImages(const SerialChain& chain, const VectorXd& q, int joint, VectorXd& image,
               std::vector<VectorXd>& out) {
  if (joint == chain.n) {
    out.push_back(image);
    return;
  }
  if (chain.constants.revolute[joint] < 0.5) {
    image[joint] = q[joint];
    return addImages(chain, q, joint + 1, image, out);
  }
  const double lower = std::isfinite(chain.lower[joint]) ? chain.lower[joint] : -M_PI,
               upper = std::isfinite(chain.upper[joint]) ? chain.upper[joint] : M_PI;
  for (double x = q[joint] + turn * std::ceil((lower - q[joint] - 1e-9) / turn); x <= upper + 1e-9;
       x += turn) {
    image[joint] = std::clamp(x, lower, upper);
    addImages(chain, q, joint + 1, image, out);
  }
}

}  // namespace

PathPlanner::PathPlanner(const Skeleton& skeleton, int tipJoint) {
  const SerialChainResult result = extractSerialChain(skeleton, tipJoint);
  if (!result.whyNot.empty()) throw std::invalid_argument(result.whyNot);
  if (result.chain.n == 7 && !result.chain.hasPrismatic)
    seven_.emplace(result.chain);
  else
    finite_.emplace(skeleton, tipJoint);
}

MatrixXd PathPlanner::candidates(const Isometry3d& pose, const PathOptions& options) const {
  std::vector<VectorXd> list;
  const SerialChain& c = chain();
  VectorXd image(c.n);
  if (seven_ && seven_->family()) {
    std::vector<Vector7d> along;
    seven_->family()->sample(pose, options.step, along);
    list.assign(along.begin(), along.end());
  } else if (seven_) {
    const int held = seven_->heldJoint();
    const double lower = std::isfinite(c.lower[held]) ? c.lower[held] : -M_PI,
                 upper = std::isfinite(c.upper[held]) ? c.upper[held] : M_PI;
    const Vector7d middle =
        (0.5 * (c.lower + c.upper)).unaryExpr([](double x) { return std::isfinite(x) ? x : 0.0; });
    SliceSolutions found;
    for (int k = 0; k < options.slices; ++k) {
      const double angle = lower + (upper - lower) * (k + 0.5) / options.slices;
      seven_->slice(pose, angle, middle, found);
      for (int i = 0; i < found.count; ++i)
        if (found.withinLimits[i]) list.push_back(found.q[i]);
    }
  } else {
    ArmSolutions found;
    finite_->solve(pose, Vector6d::Zero(), found);
    for (const ArmSolution& s : found.all())
      if (s.withinLimits) addImages(c, s.q.head(c.n), 0, image, list);
  }
  MatrixXd all(c.n, static_cast<Eigen::Index>(list.size()));
  for (size_t i = 0; i < list.size(); ++i) all.col(static_cast<Eigen::Index>(i)) = list[i];
  return all;
}

std::string PathPlanner::branchOf(const Isometry3d& pose, const VectorXd& q) const {
  if (seven_) return "";
  ArmSolutions found;
  Vector6d reference = Vector6d::Zero();
  reference.head(q.size()) = q;
  finite_->solve(pose, reference, found);
  const ArmSolution* best = nullptr;
  for (const ArmSolution& s : found.all())
    if (!best || (s.q - reference).norm() < (best->q - reference).norm()) best = &s;
  return best ? branchName(*best) : "";
}

PathPlan PathPlanner::plan(std::span<const Isometry3d> poses, const PathOptions& options,
                           const VectorXd* start) const {
  PathPlan plan;
  if (poses.empty()) return plan;
  std::vector<MatrixXd> sets(poses.size());
  std::vector<std::vector<int>> from(poses.size());
  std::vector<Cost> cost, next;
  for (size_t k = 0; k < poses.size(); ++k) {
    sets[k] = candidates(poses[k], options);
    if (sets[k].cols() == 0) {
      plan.unreachable = static_cast<int>(k);
      return plan;
    }
    if (k == 0) {
      cost.assign(sets[0].cols(), {.jumps = 0});
      if (start)
        for (Eigen::Index i = 0; i < sets[0].cols(); ++i) cost[i].motion = (sets[0].col(i) - *start).norm();
      continue;
    }
    advance(sets[k - 1], cost, sets[k], options.jump, next, from[k]);
    std::swap(cost, next);
  }
  int at = static_cast<int>(std::min_element(cost.begin(), cost.end()) - cost.begin());
  plan.q.resize(poses.size());
  for (size_t k = poses.size(); k-- > 0;) {
    plan.q[k] = sets[k].col(at);
    if (k > 0) at = from[k][at];
  }
  if (seven_) refine(poses, options, plan);
  measure(poses, options, plan);
  return plan;
}

/// Every pose slides along its self-motion so that the whole gets shorter: Gauss-Newton on the sum of the
/// distances between neighbours, each weighted by one over itself (so that it is the length, not its square,
/// that gets least), which is a tridiagonal system for the steps along the tangents. Across a jump nothing
/// pulls; a pose that would leave the limits goes as far as it can.
void PathPlanner::refine(std::span<const Isometry3d> poses, const PathOptions& options,
                         PathPlan& plan) const {
  const int count = static_cast<int>(plan.q.size());
  std::vector<Vector7d> q(plan.q.begin(), plan.q.end()), moved(count), tangent(count);
  std::vector<char> linked(count, 0);  // to the next
  for (int k = 0; k + 1 < count; ++k) linked[k] = largestTurn(q[k], q[k + 1]) <= options.jump;
  const auto lengthOf = [&](const std::vector<Vector7d>& way) {
    double sum = 0.0;
    for (int k = 0; k + 1 < count; ++k)
      if (linked[k]) {
        if (largestTurn(way[k], way[k + 1]) > options.jump) return std::numeric_limits<double>::infinity();
        sum += (way[k + 1] - way[k]).norm();
      }
    return sum;
  };
  double length = lengthOf(q);
  std::vector<double> main(count), beside(count), step(count);
  for (int round = 0; round < options.rounds; ++round) {
    for (int k = 0; k < count; ++k) tangent[k] = seven_->tangent(q[k]);
    std::fill(main.begin(), main.end(), 1e-9);
    std::fill(beside.begin(), beside.end(), 0.0);
    std::fill(step.begin(), step.end(), 0.0);
    const double floor = 1e-3 + 0.1 * length / count;
    for (int k = 0; k + 1 < count; ++k) {
      if (!linked[k]) continue;
      const Vector7d d = q[k + 1] - q[k];
      const double weight = 1.0 / (d.norm() + floor);
      main[k] += weight, main[k + 1] += weight;
      beside[k] = -weight * tangent[k].dot(tangent[k + 1]);
      step[k] += weight * tangent[k].dot(d), step[k + 1] -= weight * tangent[k + 1].dot(d);
    }
    for (int k = 0; k + 1 < count; ++k) {  // Thomas
      const double factor = beside[k] / main[k];
      main[k + 1] -= factor * beside[k], step[k + 1] -= factor * step[k];
    }
    double most = 0.0;
    for (int k = count - 1; k >= 0; --k) {
      step[k] = (step[k] - (k + 1 < count ? beside[k] * step[k + 1] : 0.0)) / main[k];
      most = std::max(most, std::abs(step[k]));
    }
    bool shorter = false;
    for (double share = std::min(1.0, 0.3 / (most + 1e-12)); share > 0.02 && !shorter; share *= 0.5) {
      for (int k = 0; k < count; ++k) {
        moved[k] = q[k];
        for (double part = share; part > 0.1 * share; part *= 0.5)
          if (seven_->slide(poses[k], part * step[k] * tangent[k], moved[k])) break;
      }
      const double now = lengthOf(moved);
      if (now >= length) continue;
      shorter = now < length * (1.0 - 1e-4);
      std::swap(q, moved);
      length = now;
      break;
    }
    if (!shorter) break;
  }
  plan.q.assign(q.begin(), q.end());
}

void PathPlanner::measure(std::span<const Isometry3d> poses, const PathOptions& options,
                          PathPlan& plan) const {
  plan.length = 0.0;
  plan.jumps.clear();
  for (size_t k = 0; k + 1 < plan.q.size(); ++k) {
    plan.length += (plan.q[k + 1] - plan.q[k]).norm();
    const double step = largestTurn(plan.q[k], plan.q[k + 1]);
    if (step > options.jump)
      plan.jumps.push_back({static_cast<int>(k), step, whyItEnds(poses[k], poses[k + 1], plan.q[k])});
    else
      plan.largestStep = std::max(plan.largestStep, step);
  }
}

/// Follows the solution q from one pose towards the next in small steps of damped Newton, until a limit, a
/// singularity or the next pose is met.
std::string PathPlanner::whyItEnds(const Isometry3d& from, const Isometry3d& to,
                                   const VectorXd& start) const {
  const SerialChain& c = chain();
  VectorXd q = start;
  constexpr int steps = 64;
  for (int s = 1; s <= steps; ++s) {
    const Isometry3d goal = between(from, to, static_cast<double>(s) / steps);
    for (int i = 0; i < c.n; ++i)
      if (q[i] < c.lower[i] - 1e-6 || q[i] > c.upper[i] + 1e-6)
        return "joint " + std::to_string(i + 1) + " comes to the end of its range";
    const Singularity where = singularity(c, q);
    if (where.sigmaMin < 3e-3) return "the solution ends at a singularity";
    if (seven_) {
      // Least motion: the neighbour in the slice of the held joint's own value.
      SliceSolutions found;
      seven_->slice(goal, q[seven_->heldJoint()], Vector7d(q), found);
      double best = INFINITY;
      Vector7d next = Vector7d::Zero();
      for (const Vector7d& x : found.all())
        if ((x - Vector7d(q)).norm() < best) best = (x - Vector7d(q)).norm(), next = x;
      if (!(best < 0.3)) return "the solution ends at a singularity or with the reach of the held joint";
      q = next;
    } else {
      ArmSolutions found;
      Vector6d reference = Vector6d::Zero();
      reference.head(c.n) = q;
      finite_->solve(goal, reference, found);
      double best = INFINITY;
      VectorXd next = q;
      for (const ArmSolution& x : found.all()) {
        VectorXd d = x.q.head(c.n) - q;
        for (int i = 0; i < c.n; ++i)
          if (c.constants.revolute[i] > 0.5) d[i] = std::remainder(d[i], turn);
        if (d.norm() < best) best = d.norm(), next = q + d;
      }
      if (!(best < 0.3)) return "the solution ends at a singularity";
      q = next;
    }
  }
  for (int i = 0; i < c.n; ++i)
    if (q[i] < c.lower[i] - 1e-6 || q[i] > c.upper[i] + 1e-6)
      return "joint " + std::to_string(i + 1) + " comes to the end of its range";
  return "the poses lie farther apart than a step: the solution goes on, but turns a joint by more than a "
         "jump";
}

Isometry3d between(const Isometry3d& a, const Isometry3d& b, double s) {
  const Eigen::Quaterniond p(a.linear()), q(b.linear());
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() = p.slerp(s, q).toRotationMatrix();
  pose.translation() = (1.0 - s) * a.translation() + s * b.translation();
  return pose;
}

std::vector<Isometry3d> splineThrough(std::span<const Isometry3d> keys, int count) {
  if (keys.size() < 2) throw std::invalid_argument("a path needs two keys at least");
  if (count < 2) throw std::invalid_argument("a path needs two poses at least");
  const int spans = static_cast<int>(keys.size()) - 1;
  const auto at = [&](double t) {
    const int i = std::clamp(static_cast<int>(t), 0, spans - 1);
    const double s = t - i;
    const auto place = [&](int k) -> Vector3d {
      if (k < 0) return 2.0 * keys[0].translation() - keys[1].translation();
      if (k > spans) return 2.0 * keys[spans].translation() - keys[spans - 1].translation();
      return keys[k].translation();
    };
    const Vector3d p0 = place(i - 1), p1 = place(i), p2 = place(i + 1), p3 = place(i + 2);
    Isometry3d pose = between(keys[i], keys[i + 1], s);
    pose.translation() = 0.5 * (2.0 * p1 + (p2 - p0) * s + (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) * s * s +
                                (3.0 * p1 - p0 - 3.0 * p2 + p3) * s * s * s);
    return pose;
  };
  constexpr int fine = 64;
  std::vector<double> way{0.0};
  for (int k = 1; k <= fine * spans; ++k)
    way.push_back(way.back() +
                  (at(k / double(fine)).translation() - at((k - 1) / double(fine)).translation()).norm());
  std::vector<Isometry3d> path;
  size_t k = 0;
  for (int i = 0; i < count; ++i) {
    const double share = i / double(count - 1);
    double t = share * spans;
    if (way.back() > 1e-9) {
      const double wanted = share * way.back();
      while (k + 2 < way.size() && way[k + 1] < wanted) ++k;
      const double width = way[k + 1] - way[k];
      t = (k + (width > 0.0 ? std::clamp((wanted - way[k]) / width, 0.0, 1.0) : 0.0)) / fine;
    }
    path.push_back(at(t));
  }
  return path;
}

}  // namespace gelenk
