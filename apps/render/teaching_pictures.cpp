#include "apps/render/teaching_pictures.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "apps/render/scene_view.h"
#include "kinematics/configuration.h"
#include "kinematics/jacobian.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/solutions/complete_set.h"
#include "solvers/solutions/self_motion.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// What a picture depends on, byte for byte.
std::string keyOf(const VectorXd& q, int joint, const Vector3d& point, const std::string& more = {}) {
  std::string key(reinterpret_cast<const char*>(q.data()),
                  sizeof(double) * static_cast<std::size_t>(q.size()));
  key.append(reinterpret_cast<const char*>(point.data()), sizeof(double) * 3);
  return key + std::to_string(joint) + more;
}

std::vector<int> pathTo(const Skeleton& skeleton, int joint) {
  std::vector<int> path;
  for (int j = joint; j >= 0; j = skeleton.parent(j)) path.insert(path.begin(), j);
  return path;
}

bool isFreeRoot(const Joint& joint) { return joint.parent < 0 && (joint.ball || joint.axes.size() > 1); }

/// Axes (columns) and half lengths of {J dq : |dq| = 1}, the longest first.
struct Ellipsoid {
  Eigen::Matrix3d axes;
  Vector3d lengths;
};
Ellipsoid velocityEllipsoid(const Eigen::Matrix3Xd& J) {
  const Eigen::Matrix3d JJt = J * J.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solved(JJt);
  return {solved.eigenvectors().rowwise().reverse(),
          Vector3d(solved.eigenvalues().reverse().cwiseMax(0.0).cwiseSqrt())};
}

void addEllipse(Overlay& overlay, const Vector3d& centre, const Vector3d& a, const Vector3d& b,
                const Colour& colour, bool filled) {
  std::vector<Vector3d> rim;
  for (int i = 0; i < 64; ++i) {
    const double t = 2.0 * M_PI * i / 64;
    rim.push_back(centre + std::cos(t) * a + std::sin(t) * b);
  }
  if (filled) overlay.fan(centre, rim, withAlpha(colour, 0.14f));
  overlay.polyline(rim, colour, 1.8f, true);
}

void addEllipsoid(Overlay& overlay, const Vector3d& centre, const Eigen::Matrix3d& axes,
                  const Vector3d& lengths, const Colour& colour, bool planar) {
  const auto axis = [&](int k) -> Vector3d { return lengths[k] * axes.col(k); };
  const int pairs = planar ? 1 : 3;
  for (int k = 0; k < pairs; ++k) addEllipse(overlay, centre, axis(k % 3), axis((k + 1) % 3), colour, true);
  for (int k = 0; k < (planar ? 2 : 3); ++k)
    overlay.line(centre - axis(k), centre + axis(k), withAlpha(colour, 0.7f), 1.2f);
}

}  // namespace

ConvergenceMap::Shares ConvergenceMap::shares() const {
  int looked = 0, other = 0, missed = 0;
  for (const Cell& cell : rows) {
    looked += cell.solved;
    missed += cell.solved && !cell.reached;
    other += cell.reached && cell.otherBranch;
  }
  const double all = std::max(looked, 1);
  return {(looked - other - missed) / all, other / all, missed / all};
}

Colour ConvergenceMap::reachedColour(double many, bool otherBranch) {
  constexpr float alpha = 0.78f;
  const auto t = static_cast<float>(std::clamp(many, 0.0, 1.0));
  if (!otherBranch) return withAlpha(viridis(1.0f - 0.92f * t), alpha);
  // Rose, from bright to dark as viridis is: a hue of its own also to those who do not tell red from green.
  constexpr Colour few{1.0f, 0.74f, 0.86f}, most{0.42f, 0.02f, 0.24f};
  return {few.r + t * (most.r - few.r), few.g + t * (most.g - few.g), few.b + t * (most.b - few.b), alpha};
}

Colour ConvergenceMap::notReachedColour() { return {0.5f, 0.5f, 0.52f, 0.3f}; }

Colour ConvergenceMap::colour(const Cell& cell) const {
  if (!cell.reached) return notReachedColour();
  const double least = std::log1p(fewestIterations), most = std::log1p(mostIterations);
  return reachedColour((std::log1p(cell.iterations) - least) / std::max(most - least, 1e-9),
                       cell.otherBranch);
}

std::optional<TeachingPictures::Effector> TeachingPictures::effectorOf(const Session& session,
                                                                       std::optional<GoalId> selected) {
  const auto usable = [](const SceneGoal& goal) {
    return goal.goal.kind == GoalKind::Position || goal.goal.kind == GoalKind::Pose;
  };
  const SceneGoal* best = nullptr;
  for (const SceneGoal& goal : session.goals()) {
    if (!usable(goal)) continue;
    if (session.dragged() == goal.id) return Effector{goal.goal.joint, goal.goal.pointInJoint};
    if (selected == goal.id) best = &goal;
    if (!best || (selected != best->id && goal.state == GoalState::Held && best->state != GoalState::Held))
      best = &goal;
  }
  if (!best) return std::nullopt;
  return Effector{best->goal.joint, best->goal.pointInJoint};
}

void TeachingPictures::add(const Session& session, const Frames& frames, const Look& look, Overlay& inScene,
                           Overlay& onTop, std::vector<Ghost>& ghosts) {
  const ViewOptions& show = session.document().view.show;
  reasons_.clear();
  working_ = false;
  if (!show.solutions) solutions_.clear();
  if (!show.nullSpace) selfMotion_.clear();
  if (!show.velocityEllipsoid && !show.forceEllipsoid && !show.reachable && !show.solutions &&
      !show.nullSpace && !show.convergence)
    return;
  const auto effector = effectorOf(session, look.selected);
  if (!effector) {
    reasons_.push_back("no goal of a point says which effector is meant");
    return;
  }
  if (show.convergence) convergence(session, frames, *effector, look, inScene);
  if (show.reachable) reach(session, *effector, look, inScene);
  if (show.velocityEllipsoid || show.forceEllipsoid) ellipsoids(session, frames, *effector, look, onTop);
  if (show.solutions) otherSolutions(session, frames, *effector, ghosts);
  if (show.nullSpace) nullSpace(session, frames, *effector, ghosts);
}

void TeachingPictures::ellipsoids(const Session& session, const Frames& frames, const Effector& at,
                                  const Look& look, Overlay& overlay) const {
  const ViewOptions& show = session.document().view.show;
  const Ellipsoid velocity =
      velocityEllipsoid(pointJacobian(session.skeleton(), session.q(), frames, at.joint, at.pointInJoint));
  const Vector3d centre = frames[at.joint] * at.pointInJoint;
  const bool planar = session.model().planar;
  const double largest = velocity.lengths[0];
  if (!(largest > 0.0)) return;
  // Drawn at a fifth of a radian a second; forces so that both have the same size where the arm moves equally
  // well everywhere, and never longer than the model.
  constexpr double share = 0.2;
  if (show.velocityEllipsoid)
    addEllipsoid(overlay, centre, velocity.axes, share * velocity.lengths, look.colours->accent, planar);
  if (show.forceEllipsoid) {
    const double unit = share * largest * largest;
    const Vector3d lengths = velocity.lengths.unaryExpr([&](double sigma) {
      return sigma * 0.5 * look.size > 0.3 * unit ? 0.3 * unit / sigma : 0.5 * look.size;
    });
    addEllipsoid(overlay, centre, velocity.axes, lengths, look.colours->held, planar);
  }
}

Eigen::AlignedBox3d TeachingPictures::reachableBox(const Session& session, std::optional<GoalId> selected) {
  Eigen::AlignedBox3d box;
  if (const auto effector = effectorOf(session, selected)) {
    lookForReach(session, *effector);
    for (const Vector3d& point : cloud_) box.extend(point);
  }
  return box;
}

/// Places of the effector over random joint values, and how well it moves there; nothing where they are
/// known.
void TeachingPictures::lookForReach(const Session& session, const Effector& at) {
  const Skeleton& skeleton = session.skeleton();
  const std::vector<int> path = pathTo(skeleton, at.joint);
  VectorXd fixed =
      session.q();  // the path's joints do not matter, the others do not either but for a free root
  for (const int j : path)
    if (!isFreeRoot(skeleton.joint(j))) fixed.segment(skeleton.qIndex(j), skeleton.qCount(j)).setZero();
  if (const std::string key = keyOf(fixed.head(std::min<Eigen::Index>(7, fixed.size())), at.joint,
                                    at.pointInJoint, session.model().name);
      key != cloudKey_) {
    cloudKey_ = key;
    cloud_.clear();
    cloudValue_.clear();
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    VectorXd q = session.q();
    Frames frames;
    float most = 1e-12f;
    for (int i = 0; i < 5000; ++i) {
      for (const int j : path) {
        const Joint& joint = skeleton.joint(j);
        if (isFreeRoot(joint)) continue;
        for (std::size_t k = 0; k < joint.axes.size(); ++k) {
          const AxisDof& axis = joint.axes[k];
          double& value = q[skeleton.qIndex(j) + static_cast<int>(k)];
          if (std::isfinite(axis.lower) && std::isfinite(axis.upper))
            value = axis.lower + unit(random) * (axis.upper - axis.lower);
          else if (axis.kind == AxisDof::Kind::Rotation)
            value = M_PI * (2.0 * unit(random) - 1.0);
        }
        if (joint.ball)
          setBallRotation(skeleton, q, j,
                          Eigen::Quaterniond(unit(random) - 0.5, unit(random) - 0.5, unit(random) - 0.5,
                                             unit(random) - 0.5)
                              .normalized());
      }
      q = projectToLimits(skeleton, q);
      forwardKinematics(skeleton, q, frames);
      cloud_.push_back(frames[at.joint] * at.pointInJoint);
      const Vector3d sigma =
          velocityEllipsoid(pointJacobian(skeleton, q, frames, at.joint, at.pointInJoint)).lengths;
      cloudValue_.push_back(static_cast<float>(session.model().planar ? sigma[0] * sigma[1] : sigma.prod()));
      most = std::max(most, cloudValue_.back());
    }
    for (float& value : cloudValue_) value /= most;
  }
}

/// Brighter where it moves better.
void TeachingPictures::reach(const Session& session, const Effector& at, const Look& look, Overlay& overlay) {
  lookForReach(session, at);
  const Vector3d below =
      session.model().planar ? Vector3d(-0.004 * look.size * session.model().up) : Vector3d::Zero();
  for (std::size_t i = 0; i < cloud_.size(); ++i)
    overlay.point(cloud_[i] + below, withAlpha(viridis(cloudValue_[i]), 0.55f), 3.0f, Overlay::Shape::Plain);
}

namespace {

CompleteSetTask solutionTask(const SerialChain& chain, const TeachingPictures::Effector& at) {
  return {.task = chain.n > 3 ? TipTask::Pose : TipTask::Position, .pointInTip = at.pointInJoint};
}

}  // namespace

std::string TeachingPictures::whyNoSolutions(const Skeleton& skeleton, const Effector& at) {
  const SerialChainResult chain = extractSerialChain(skeleton, at.joint);
  return chain.whyNot.empty() ? CompleteSet::whyNot(skeleton, at.joint, solutionTask(chain.chain, at))
                              : chain.whyNot;
}

std::string TeachingPictures::whyNoSelfMotion(const Skeleton& skeleton, const Effector& at) {
  const SerialChainResult chain = extractSerialChain(skeleton, at.joint);
  if (!chain.whyNot.empty()) return chain.whyNot;
  return chain.chain.n == 7 && !chain.chain.hasPrismatic ? ""
                                                         : "it is drawn for arms of seven turning joints";
}

std::string TeachingPictures::whyNoMap(const Skeleton& skeleton, const Effector& at) {
  const std::vector<int> path = pathTo(skeleton, at.joint);
  return std::ranges::any_of(path, [&](int j) { return isFreeRoot(skeleton.joint(j)); })
             ? "the model's root moves freely, everything can be reached"
             : "";
}

void TeachingPictures::otherSolutions(const Session& session, const Frames& frames, const Effector& at,
                                      std::vector<Ghost>& ghosts) {
  const Skeleton& skeleton = session.skeleton();
  solutions_.clear();
  if (const std::string why = whyNoSolutions(skeleton, at); !why.empty()) {
    reasons_.push_back("all solutions: " + why);
    return;
  }
  const CompleteSet set(skeleton, at.joint, solutionTask(extractSerialChain(skeleton, at.joint).chain, at));
  Vector6d reference = Vector6d::Zero();
  for (int i = 0; i < set.joints(); ++i) reference[i] = session.q()[set.chain().qIndex[i]];
  ArmSolutions found;
  Isometry3d target = frames[at.joint];
  target.translation() = frames[at.joint] * at.pointInJoint;
  set.solve(target, reference, found);
  for (int k = 0; k < found.count; ++k) {
    if (!found.all()[k].withinLimits) continue;
    VectorXd q = session.q();
    double away = 0.0;
    for (int i = 0; i < set.joints(); ++i) {
      q[set.chain().qIndex[i]] = found.all()[k].q[i];
      away = std::max(away, std::abs(std::remainder(found.all()[k].q[i] - reference[i], 2.0 * M_PI)));
    }
    if (away < 1e-4) continue;  // the pose itself
    const float hue = static_cast<float>(solutions_.size()) / 8.0f;
    const Colour tint = viridis(0.15f + 0.75f * std::min(hue, 1.0f));
    ghosts.push_back({.worldFromJoint = forwardKinematics(skeleton, q),
                      .tint = {tint.r, tint.g, tint.b},
                      .opacity = 0.34f});
    solutions_.push_back(std::move(q));
  }
}

void TeachingPictures::nullSpace(const Session& session, const Frames& frames, const Effector& at,
                                 std::vector<Ghost>& ghosts) {
  const Skeleton& skeleton = session.skeleton();
  selfMotionAt_ = 0;
  if (const std::string why = whyNoSelfMotion(skeleton, at); !why.empty()) {
    selfMotion_.clear();
    reasons_.push_back("self-motion: " + why);
    return;
  }
  const SerialChainResult chain = extractSerialChain(skeleton, at.joint);
  Vector7d now;
  for (int i = 0; i < 7; ++i) now[i] = session.q()[chain.chain.qIndex[i]];
  // The tip's pose to a micrometre: along its own self-motion nothing is computed again.
  std::string key = session.model().name;
  for (const double value : frames[at.joint].matrix().reshaped()) key += fmt::format(",{:.6f}", value);
  if (key != selfMotionKey_) {
    selfMotionKey_ = key;
    selfMotion_.clear();
    const SevenJointArm arm(chain.chain);
    double nearest = 1e9;
    for (const SelfMotionCurve& curve : arm.selfMotion(frames[at.joint], {.slices = 32, .step = 0.06})) {
      double away = 1e9;
      for (const Vector7d& q : curve.q) away = std::min(away, (q - now).norm());
      if (away >= nearest) continue;
      nearest = away;
      selfMotion_.clear();
      for (const Vector7d& q : curve.q) {
        VectorXd whole = session.q();
        for (int i = 0; i < 7; ++i) whole[chain.chain.qIndex[i]] = q[i];
        selfMotion_.push_back(std::move(whole));
      }
    }
  }
  if (selfMotion_.empty()) {
    reasons_.push_back("self-motion: none within the joints' limits");
    return;
  }
  double nearest = 1e9;
  for (std::size_t k = 0; k < selfMotion_.size(); ++k)
    if (const double away = (selfMotion_[k] - session.q()).norm(); away < nearest)
      nearest = away, selfMotionAt_ = static_cast<int>(k);
  constexpr int most = 9;
  const int count = static_cast<int>(selfMotion_.size());
  for (int g = 0; g < most; ++g) {
    const int k = count > 1 ? g * (count - 1) / (most - 1) : 0;
    if (std::abs(k - selfMotionAt_) * most < count) continue;  // the arm itself stands there
    const Colour tint = viridis(0.1f + 0.8f * static_cast<float>(g) / (most - 1));
    ghosts.push_back({.worldFromJoint = forwardKinematics(skeleton, selfMotion_[k]),
                      .tint = {tint.r, tint.g, tint.b},
                      .opacity = 0.22f});
  }
}

void TeachingPictures::convergence(const Session& session, const Frames& frames, const Effector& at,
                                   const Look& look, Overlay& overlay) {
  const Skeleton& skeleton = session.skeleton();
  const std::vector<int> path = pathTo(skeleton, at.joint);
  if (const std::string why = whyNoMap(skeleton, at); !why.empty()) {
    reasons_.push_back("convergence map: " + why);
    return;
  }
  const std::string& solver = session.solver();
  std::string text = solver;
  for (const auto& [name, value] : session.parameters()) text += fmt::format(",{}={}", name, value);
  constexpr int finest = 1, coarsest = 8, cells = 96, aFrame = 144;
  if (const std::string key = keyOf(session.q(), at.joint, at.pointInJoint, text); key != mapKey_) {
    mapKey_ = key;
    mapNext_ = 0;
    mapStride_ = coarsest;
    double reach = at.pointInJoint.norm();
    for (const int j : path)
      if (j != path.front()) reach += skeleton.joint(j).parentFromZero.translation().norm();
    int base = path.front();
    for (const int j : path)
      if (skeleton.vCount(j) > 0) {
        base = j;
        break;
      }
    const Vector3d centre = frames[base].translation();
    map_ = {.cells = cells, .rows = std::vector<ConvergenceMap::Cell>(cells * cells)};
    if (session.model().planar) {
      map_.u = 2.1 * reach * Vector3d::UnitX();
      map_.v = 2.1 * reach * Vector3d::UnitY();
    } else {  // the upright plane through the first axis and the effector
      const Vector3d up = session.model().up;
      Vector3d out = frames[at.joint] * at.pointInJoint - centre;
      out -= out.dot(up) * up;
      map_.u = 2.1 * reach * (out.norm() > 1e-6 * reach ? Vector3d(out.normalized()) : up.unitOrthogonal());
      map_.v = 2.1 * reach * up;
    }
    map_.corner = centre - 0.5 * (map_.u + map_.v);
  }

  // Coarse cells first: a pass of every eighth, then of every fourth, and so on; what was solved is kept.
  if (mapStride_ >= finest) {
    const auto method = makeSolver(solver);
    method->prepare(skeleton);
    const int last = path.back();
    int bend = -1;  // the last turning joint before the tip that bends the arm
    for (const int j : path)
      if (skeleton.vCount(j) == 1 && skeleton.joint(j).axes[0].kind == AxisDof::Kind::Rotation) bend = j;
    const auto bendOf = [&](const VectorXd& q) {
      return bend < 0 || !session.model().planar ? 0.0 : std::remainder(q[skeleton.qIndex(bend)], 2.0 * M_PI);
    };
    int left = look.whole ? std::numeric_limits<int>::max() : aFrame;
    while (left > 0 && mapStride_ >= finest) {
      if (mapNext_ >= cells * cells) {
        mapNext_ = 0;
        mapStride_ /= 2;
        continue;
      }
      const int x = mapNext_ % cells, y = mapNext_ / cells;
      ConvergenceMap::Cell& cell = map_.rows[mapNext_];
      mapNext_ += mapStride_;
      if (mapNext_ % cells == 0 || mapNext_ / cells != y) mapNext_ = (y + mapStride_) * cells;
      if (cell.solved) continue;
      --left;
      const Vector3d target = map_.corner + (x + 0.5) / cells * map_.u + (y + 0.5) / cells * map_.v;
      const IkProblem problem{.skeleton = &skeleton,
                              .start = session.q(),
                              .goals = {{.joint = last, .pointInJoint = at.pointInJoint, .target = target}}};
      cell.solved = true;
      if (const std::string why = method->whyUnsupported(problem); !why.empty()) {
        reasons_.push_back("convergence map: " + why);
        mapStride_ = 0;
        break;
      }
      const IkReport report =
          method->solve(problem, {.maxIterations = 60, .maxSeconds = 10.0}, TraceLevel::Off);
      const Judgement verdict = judge(problem, report.q);
      cell.reached = !verdict.goals.empty() && verdict.goals.front().position < session.reachedWithin();
      cell.iterations = report.counters.iterations;
      cell.otherBranch = bendOf(report.q) * bendOf(session.q()) < 0.0;
      if (!cell.reached) continue;
      map_.mostIterations = std::max(map_.mostIterations, cell.iterations);
      map_.fewestIterations = std::min(map_.fewestIterations, cell.iterations);
    }
  }
  working_ = mapStride_ >= finest;

  const int drawn = std::max(1, working_ ? 2 * mapStride_ : 1);  // of the last pass that is complete
  const int stride = std::min(drawn, coarsest);
  const Vector3d below =
      session.model().planar ? Vector3d(-0.006 * look.size * session.model().up) : Vector3d::Zero();
  for (int y = 0; y < cells; y += stride)
    for (int x = 0; x < cells; x += stride) {
      const ConvergenceMap::Cell& cell = map_.rows[y * cells + x];
      if (!cell.solved) continue;
      const Colour colour = map_.colour(cell);
      const auto corner = [&](int i, int j) -> Vector3d {
        return map_.corner + below + static_cast<double>(std::min(x + i * stride, cells)) / cells * map_.u +
               static_cast<double>(std::min(y + j * stride, cells)) / cells * map_.v;
      };
      const Vector3d a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
      overlay.triangle(a, b, c, colour);
      overlay.triangle(a, c, d, colour);
    }
}

}  // namespace gelenk
