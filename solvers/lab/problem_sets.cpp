#include "solvers/lab/problem_sets.h"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>

#include "kinematics/configuration.h"
#include "kinematics/rotation.h"
#include "solvers/iteration/evaluator.h"
#include "solvers/methods/step_rules.h"
#include "solvers/problem/goal_text.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/problem/judge.h"
#include "solvers/solutions/complete_set.h"

namespace gelenk {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr std::array sets{
    ProblemSetEntry{"D1", "Reachable, uniform in joint space", "unused", ProblemFamily::Reachable, true},
    ProblemSetEntry{"D2", "Near singular", "wanted sigma_min: 0, 1e-3, 1e-2", ProblemFamily::NearSingular,
                    true},
    ProblemSetEntry{"D3", "At the reach boundary",
                    "distance over the reach in that direction: 0.95, 0.99, 0.999, 0.9999",
                    ProblemFamily::ReachBoundary, true},
    ProblemSetEntry{"D4", "Unreachable", "distance over the reach in that direction: 1.05, 1.3, 3",
                    ProblemFamily::Unreachable, false},
    ProblemSetEntry{"D5", "Drags with warm start", "radians or metres a frame: 0.005, 0.02, 0.1",
                    ProblemFamily::Drag, true},
    ProblemSetEntry{"D6", "Tight limits", "share of every range: 0.5, 0.25, 0.1", ProblemFamily::TightLimits,
                    true},
    ProblemSetEntry{"D7", "Effectors in conflict", "unused", ProblemFamily::Conflict, false},
    ProblemSetEntry{
        "D8", "By the number of solutions",
        "solutions of the goal, limits left out: 2, 4, ..., 16 as the arm has them; 1: where branches "
        "merge; 0: just out of reach, not to be solved",
        ProblemFamily::Solutions, true},
};

/// splitmix64, to make independent seeds of (seed, set, number).
std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}
std::uint64_t seedOf(std::uint64_t seed, const ProblemSetEntry& set, int number) {
  return mix(mix(mix(seed) + static_cast<std::uint64_t>(set.family)) + static_cast<std::uint64_t>(number));
}

Vector3d randomDirection(std::mt19937_64& random, bool planar) {
  Vector3d v;
  do {
    for (double& x : v) x = 2.0 * uniform01(random) - 1.0;
    if (planar) v.z() = 0.0;
  } while (v.norm() > 1.0 || v.norm() < 1e-3);
  return v.normalized();
}

int dofsAbove(const Skeleton& skeleton, int joint) {
  int count = 0;
  for (; joint >= 0; joint = skeleton.parent(joint)) count += skeleton.vCount(joint);
  return count;
}

Goal goalAt(const LabModel& model, int effector, const Frames& frames) {
  Goal goal{.kind = model.pose ? GoalKind::Pose : GoalKind::Position,
            .name = model.skeleton->joint(effector).name,
            .joint = effector,
            .target = frames[effector].translation()};
  if (model.pose) goal.orientation = Eigen::Quaterniond(frames[effector].linear()).normalized();
  return goal;
}

std::vector<Goal> goalsAt(const LabModel& model, const Skeleton& skeleton, const VectorXd& q) {
  const Frames frames = forwardKinematics(skeleton, q);
  std::vector<Goal> goals;
  for (int effector : model.effectors) goals.push_back(goalAt(model, effector, frames));
  for (Goal goal : model.goals) {
    goalType(goal.kind).capture(goal, {skeleton, q, frames});
    goals.push_back(std::move(goal));
  }
  return goals;
}

/// Singular values of the goals' Jacobian at q, falling.
struct Singular {
  VectorXd sigma;
  MatrixXd U, V;
};
Singular singularAt(CountedEvaluator& at, const VectorXd& q) {
  at.moveTo(q);
  const Eigen::JacobiSVD<MatrixXd> svd(at.jacobian(), Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {svd.singularValues(), svd.matrixU(), svd.matrixV()};
}

/// The largest rank that J has anywhere: a planar arm never moves along z.
int structuralRank(const Skeleton& skeleton, const std::vector<Goal>& goals) {
  std::mt19937_64 random(1);
  IkProblem problem{.skeleton = &skeleton, .goals = goals};
  CountedEvaluator at(problem);
  int rank = 1;
  for (int i = 0; i < 8; ++i) {
    const VectorXd sigma = singularAt(at, randomWithinLimits(skeleton, random)).sigma;
    rank = std::max(rank, static_cast<int>((sigma.array() > 1e-9 * sigma[0]).count()));
  }
  return rank;
}

double sigmaMinAt(const Skeleton& skeleton, const std::vector<Goal>& goals, const VectorXd& q) {
  IkProblem problem{.skeleton = &skeleton, .goals = goals};
  CountedEvaluator at(problem);
  return singularAt(at, q).sigma[structuralRank(skeleton, goals) - 1];
}

/// A configuration whose smallest structural singular value is `wanted`: Newton on sigma(q) = wanted with
/// d sigma = u^T dJ v, from random places.
VectorXd nearSingular(const LabModel& model, double wanted, std::mt19937_64& random) {
  const Skeleton& skeleton = *model.skeleton;
  IkProblem problem{.skeleton = &skeleton, .goals = goalsAt(model, skeleton, neutral(skeleton))};
  const int last = structuralRank(skeleton, problem.goals) - 1;
  CountedEvaluator at(problem);
  VectorXd best;
  double bestMiss = 0.0;
  for (int draw = 0; draw < 30; ++draw) {
    VectorXd q = randomWithinLimits(skeleton, random);
    for (int i = 0; i < 40; ++i) {
      const Singular s = singularAt(at, q);
      const double miss = s.sigma[last] - wanted;
      if (best.size() == 0 || std::abs(miss) < bestMiss) {
        best = q;
        bestMiss = std::abs(miss);
      }
      if (bestMiss <= 1e-3 * wanted + 1e-10) return best;
      VectorXd slope(skeleton.nv());
      MatrixXd dJ;
      for (int k = 0; k < skeleton.nv(); ++k) {
        at.jacobianDerivative(VectorXd::Unit(skeleton.nv(), k), dJ);
        slope[k] = s.U.col(last).dot(dJ * s.V.col(last));
      }
      VectorXd step = -miss / std::max(slope.squaredNorm(), 1e-12) * slope;
      const double largest = step.lpNorm<Eigen::Infinity>();
      if (largest > 0.3) step *= 0.3 / largest;
      q = projectToLimits(skeleton, integrate(skeleton, q, step));
    }
  }
  return best;
}

/// The model with its free root (translations, ball) held at rest: reach has no meaning for what can travel.
std::shared_ptr<const Skeleton> standing(const std::shared_ptr<const Skeleton>& skeleton) {
  bool travels = false;
  for (const AxisDof& dof : skeleton->joint(0).axes)
    travels |= dof.kind == AxisDof::Kind::Translation && !std::isfinite(dof.upper - dof.lower);
  if (!travels) return skeleton;
  std::vector<Joint> joints = skeleton->joints();
  joints[0].parentFromZero = restFrames(*skeleton)[0];
  joints[0].axes.clear();
  joints[0].ball = false;
  joints[0].ballLimit.reset();
  const int gone = skeleton->qCount(0);
  return std::make_shared<Skeleton>(joints, skeleton->rest().tail(skeleton->nq() - gone));
}

/// Where an effector's chain begins to move.
Vector3d baseOf(const Skeleton& skeleton, int effector) {
  int first = effector;
  for (int joint = effector; joint >= 0; joint = skeleton.parent(joint))
    if (skeleton.vCount(joint) > 0) first = joint;
  return restFrames(skeleton)[first].translation();
}

/// The configuration that comes nearest to a far point in that direction, the best of three starts: the reach
/// is a property of the direction, because of limits and because the second axis seldom meets the first at
/// the base.
VectorXd farthest(const Skeleton& skeleton, int effector, const Vector3d& base, const Vector3d& direction,
                  std::mt19937_64& random) {
  IkProblem problem{.skeleton = &skeleton};
  problem.goals = {
      {.joint = effector, .target = base + 20.0 * (chainLength(skeleton, effector) + 0.1) * direction}};
  const auto solver = makeExactHessian();
  IkReport best;
  for (int i = 0; i < 3; ++i) {
    problem.start = randomWithinLimits(skeleton, random);
    IkReport report = solver->solve(problem, {.maxIterations = 300, .maxSeconds = 1e9}, TraceLevel::Off);
    if (i == 0 || report.residual < best.residual) best = std::move(report);
  }
  return best.q;
}

/// A configuration whose effector is `share` of the way that the farthest one is from the base: on the
/// geodesic from the farthest one to a random one, halved down.
VectorXd atReach(const Skeleton& skeleton, int effector, double share, bool planar, std::mt19937_64& random) {
  const Vector3d base = baseOf(skeleton, effector);
  const VectorXd far = farthest(skeleton, effector, base, randomDirection(random, planar), random);
  const auto along = [&](const VectorXd& step, double t) {
    return projectToLimits(skeleton, integrate(skeleton, far, t * step));
  };
  const auto distance = [&](const VectorXd& q) {
    return (forwardKinematics(skeleton, q)[effector].translation() - base).norm();
  };
  const double wanted = share * distance(far);
  VectorXd step;
  do step = difference(skeleton, far, randomWithinLimits(skeleton, random));
  while (distance(along(step, 1.0)) >= wanted);
  double low = 0.0, high = 1.0;  // distance(low) >= wanted > distance(high)
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (distance(along(step, middle)) < wanted ? high : low) = middle;
  }
  return along(step, high);
}

std::shared_ptr<const Skeleton> shrunk(const Skeleton& skeleton, double share) {
  std::vector<Joint> joints = skeleton.joints();
  for (Joint& joint : joints) {
    for (AxisDof& dof : joint.axes) {
      if (joint.coupling) {  // its range is in its source's already
        dof.lower = -unlimited, dof.upper = unlimited;
        continue;
      }
      const double reach = dof.kind == AxisDof::Kind::Rotation ? M_PI : 1.0;
      const double lower = std::isfinite(dof.lower) ? dof.lower : -reach,
                   upper = std::isfinite(dof.upper) ? dof.upper : reach;
      dof.lower = 0.5 * (lower + upper) - 0.5 * share * (upper - lower);
      dof.upper = 0.5 * (lower + upper) + 0.5 * share * (upper - lower);
    }
    if (!joint.ball || !joint.ballLimit) continue;
    BallLimit& limit = *joint.ballLimit;
    const double lower = std::max(limit.twistLower, -M_PI), upper = std::min(limit.twistUpper, M_PI);
    limit.swingRadii *= share;
    limit.twistLower = 0.5 * (lower + upper) - 0.5 * share * (upper - lower);
    limit.twistUpper = 0.5 * (lower + upper) + 0.5 * share * (upper - lower);
  }
  return std::make_shared<Skeleton>(joints, skeleton.rest());
}

/// A chain's second effector: the joint half way whose position still has two degrees of freedom.
int halfWay(const Skeleton& skeleton, int effector) {
  const int wanted = std::max(2, (dofsAbove(skeleton, effector) + 1) / 2);
  int found = -1;
  for (int joint = skeleton.parent(effector); joint >= 0; joint = skeleton.parent(joint))
    if (dofsAbove(skeleton, joint) > wanted) found = joint;
  return found;
}

constexpr std::array sigmaLevels{0.0, 1e-3, 1e-2};
constexpr std::array boundaryLevels{0.95, 0.99, 0.999, 0.9999};
constexpr std::array unreachableLevels{1.05, 1.3, 3.0};
constexpr std::array dragLevels{0.005, 0.02, 0.1};
constexpr std::array limitLevels{0.5, 0.25, 0.1};

/// Makes problems of one set; holds what all of them share.
class ProblemMaker {
 public:
  ProblemMaker(const ProblemSetEntry& set, const LabModel& model, double tolerance)
      : set_(set), model_(model), tolerance_(tolerance), skeleton_(model.skeleton) {
    if (model.effectors.empty() &&
        (set.family == ProblemFamily::ReachBoundary || set.family == ProblemFamily::Unreachable ||
         set.family == ProblemFamily::Conflict))
      throw std::invalid_argument(std::string(set.name) + " needs an effector that gets a target");
    if (set.family == ProblemFamily::Solutions) {
      if (model.effectors.size() != 1 || !model.goals.empty())
        throw std::invalid_argument("D8 needs one effector and nothing asked for besides");
      complete_ = std::make_shared<CompleteSet>(
          *skeleton_, model.effectors[0],
          CompleteSetTask{.task = model.pose ? TipTask::Pose : TipTask::Position});
    }
    if (set.family == ProblemFamily::TightLimits)
      for (double share : limitLevels) shrunk_.push_back(shrunk(*skeleton_, share));
    if (set.family == ProblemFamily::ReachBoundary || set.family == ProblemFamily::Unreachable) {
      skeleton_ = standing(skeleton_);
      for (int effector : model.effectors)
        if (dofsAbove(*skeleton_, effector) == 0)
          throw std::invalid_argument("the effector '" + skeleton_->joint(effector).name +
                                      "' cannot move while the root stands");
    }
  }

  LabProblem make(int number, std::mt19937_64& random) const {
    constexpr int mostDraws = 1000;
    for (int i = 0; i < mostDraws; ++i)
      if (LabProblem one = draw(number, random); isMetByReference(one)) return one;
    throw std::invalid_argument(std::string(set_.name) + ": none of " + std::to_string(mostDraws) +
                                " random poses meets the goals that are asked for besides");
  }

 private:
  /// Goals that are regions, such as a balance over a given polygon, cannot be moved to where a pose is.
  bool isMetByReference(const LabProblem& one) const {
    if (!set_.meetable || model_.goals.empty()) return true;
    for (const GoalError& error : judge(one.problem, one.reference).goals)
      if (error.position > tolerance_ || error.orientation > tolerance_) return false;
    return true;
  }

  LabProblem draw(int number, std::mt19937_64& random) const {
    LabProblem one{.index = number, .sequence = number, .skeleton = skeleton_};
    switch (set_.family) {
      case ProblemFamily::Reachable: return meetable(one, randomWithinLimits(*one.skeleton, random), random);
      case ProblemFamily::NearSingular:
        one.level = sigmaLevels[number % sigmaLevels.size()];
        return meetable(one, nearSingular(model_, one.level, random), random);
      case ProblemFamily::ReachBoundary: {
        one.level = boundaryLevels[number % boundaryLevels.size()];
        const std::size_t which = number % model_.effectors.size();
        return meetable(one, atReach(*skeleton_, model_.effectors[which], one.level, isPlanar(), random),
                        random);
      }
      case ProblemFamily::TightLimits:
        one.level = limitLevels[number % limitLevels.size()];
        one.skeleton = shrunk_[number % limitLevels.size()];
        return meetable(one, randomWithinLimits(*one.skeleton, random), random);
      case ProblemFamily::Unreachable: {
        one.level = unreachableLevels[number % unreachableLevels.size()];
        meetable(one, randomWithinLimits(*skeleton_, random), random);
        for (std::size_t i = 0; i < model_.effectors.size(); ++i) {
          const int effector = model_.effectors[i];
          const Vector3d base = baseOf(*skeleton_, effector);
          const VectorXd far =
              farthest(*skeleton_, effector, base, randomDirection(random, isPlanar()), random);
          one.problem.goals[i].target =
              base + one.level * (forwardKinematics(*skeleton_, far)[effector].translation() - base);
        }
        return one;
      }
      case ProblemFamily::Conflict: return conflict(one, random);
      case ProblemFamily::Solutions: return bySolutions(one, number % 10, random);
      case ProblemFamily::Drag: break;
    }
    throw std::logic_error("drags are made as sequences");
  }

 public:
  /// A path towards one random configuration after another, no coordinate faster than the level.
  void appendDrag(int number, int frames, std::mt19937_64& random, std::vector<LabProblem>& out) const {
    const Skeleton& skeleton = *skeleton_;
    const double rate = dragLevels[number % dragLevels.size()];
    VectorXd q = randomWithinLimits(skeleton, random), waypoint = randomWithinLimits(skeleton, random);
    for (int frame = 0; frame < frames; ++frame) {
      LabProblem one{.index = static_cast<int>(out.size()),
                     .sequence = number,
                     .frame = frame,
                     .level = rate,
                     .skeleton = skeleton_};
      one.problem = {.skeleton = one.skeleton.get(), .start = q};
      VectorXd step = difference(skeleton, q, waypoint);
      const double largest = step.lpNorm<Eigen::Infinity>();
      if (largest > rate)
        step *= rate / largest;
      else
        waypoint = randomWithinLimits(skeleton, random);
      q = projectToLimits(skeleton, integrate(skeleton, q, step));
      finish(one, q);
      if (!isMetByReference(one))
        throw std::invalid_argument(std::string(set_.name) +
                                    ": a drag leaves the region of a goal that is asked for besides; give "
                                    "goals that can be met along any path");
      out.push_back(std::move(one));
    }
  }

 private:
  bool isPlanar() const {  // every axis along z: targets stay in the plane
    for (const Joint& joint : model_.skeleton->joints()) {
      if (joint.ball) return false;
      for (const AxisDof& dof : joint.axes)
        if (dof.kind != AxisDof::Kind::Rotation || std::abs(dof.axis.z()) < 1.0 ||
            std::abs(joint.parentFromZero.linear()(2, 2)) < 1.0)
          return false;
    }
    return true;
  }

  void finish(LabProblem& one, const VectorXd& reference) const {
    one.reference = reference;
    one.problem.goals = goalsAt(model_, *one.skeleton, reference);
    one.problem.positionTolerance = one.problem.orientationTolerance = tolerance_;
  }

  LabProblem& meetable(LabProblem& one, const VectorXd& reference, std::mt19937_64& random) const {
    one.problem = {.skeleton = one.skeleton.get(), .start = randomWithinLimits(*one.skeleton, random)};
    finish(one, reference);
    return one;
  }

  LabProblem conflict(LabProblem& one, std::mt19937_64& random) const {
    meetable(one, randomWithinLimits(*skeleton_, random), random);
    for (std::size_t i = 1; i < model_.effectors.size(); ++i)
      one.problem.goals[i] = goalAt(model_, model_.effectors[i],
                                    forwardKinematics(*skeleton_, randomWithinLimits(*skeleton_, random)));
    if (model_.effectors.size() > 1) return one;
    const int elbow = halfWay(*skeleton_, model_.effectors[0]);
    if (elbow < 0)
      throw std::invalid_argument(
          "D7 needs a chain with at least three degrees of freedom before its effector");
    const Frames frames = forwardKinematics(*skeleton_, randomWithinLimits(*skeleton_, random));
    one.problem.goals.push_back(
        {.name = skeleton_->joint(elbow).name, .joint = elbow, .target = frames[elbow].translation()});
    return one;
  }

  /// Solutions of a goal, limits left out; a set that is not known to be complete counts as none.
  int solutionsOf(const Goal& goal) const {
    ArmSolutions found;
    complete_->solve(Eigen::Translation3d(goal.target) * goal.orientation, Vector6d::Zero(), found);
    return found.complete ? found.count : 0;
  }

  /// kind 0 to 7: 2, 4, ..., 16 solutions, or the number nearest to it that some random poses have; 8: at a
  /// singularity; 9: moved straight on to just past the last place where there is any.
  LabProblem bySolutions(LabProblem one, int kind, std::mt19937_64& random) const {
    if (kind == 8) {
      one.level = 1.0;
      return meetable(one, nearSingular(model_, 0.0, random), random);
    }
    if (kind < 8) {
      constexpr int draws = 400;  // sixteen are rare
      const int wanted = 2 * (kind + 1);
      VectorXd best;
      for (int i = 0; i < draws && one.level != wanted; ++i) {
        const VectorXd q = randomWithinLimits(*skeleton_, random);
        const int count = solutionsOf(goalsAt(model_, *skeleton_, q)[0]);
        if (count > 0 && (best.size() == 0 || std::abs(count - wanted) < std::abs(one.level - wanted)))
          best = q, one.level = count;
      }
      if (best.size() == 0)
        throw std::invalid_argument("D8: no random pose of the arm has a finite number of solutions");
      return meetable(one, best, random);
    }
    meetable(one, randomWithinLimits(*skeleton_, random), random);
    one.level = 0.0;
    Goal& goal = one.problem.goals[0];
    const double reach = chainLength(*skeleton_, model_.effectors[0]);
    const Vector3d from = goal.target, way = 2.0 * reach * randomDirection(random, isPlanar());
    const auto reached = [&](double share) {
      goal.target = from + share * way;
      return solutionsOf(goal) > 0;
    };
    constexpr int steps = 64;
    int last = 0;
    for (int i = 1; i <= steps; ++i)
      if (reached(static_cast<double>(i) / steps)) last = i;
    double low = static_cast<double>(last) / steps, high = static_cast<double>(last + 1) / steps;
    for (int i = 0; i < 40; ++i) (reached(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
    goal.target = from + high * way + 1e-4 * way.normalized() * reach;
    return one;
  }

  const ProblemSetEntry& set_;
  const LabModel& model_;
  double tolerance_;
  std::shared_ptr<const Skeleton> skeleton_;
  std::vector<std::shared_ptr<const Skeleton>> shrunk_;
  std::shared_ptr<const CompleteSet> complete_;
};

/// Distance to the nearest limit: 1 in the middle of every range, 0 at the end of one.
double limitMarginAt(const Skeleton& skeleton, const VectorXd& q) {
  double margin = 1.0;
  const auto box = [&](double value, double lower, double upper) {
    if (std::isfinite(lower))
      margin =
          std::min(margin, std::isfinite(upper) ? 2.0 * (value - lower) / (upper - lower) : value - lower);
    if (std::isfinite(upper))
      margin =
          std::min(margin, std::isfinite(lower) ? 2.0 * (upper - value) / (upper - lower) : upper - value);
  };
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    for (std::size_t k = 0; k < joint.axes.size(); ++k)
      if (!joint.axes[k].isFullTurn())
        box(q[skeleton.qIndex(i) + k], joint.axes[k].lower, joint.axes[k].upper);
    if (!joint.ball || !joint.ballLimit) continue;
    const BallLimit& limit = *joint.ballLimit;
    const Vector3d c = swingTwistCoordinates(ballRotation(skeleton, q, i));
    margin = std::min(margin, 1.0 - (c.head<2>() - limit.swingCentre).cwiseQuotient(limit.swingRadii).norm());
    box(c.z(), limit.twistLower, limit.twistUpper);
  }
  return std::max(margin, 0.0);
}

void findBestPoint(LabProblem& one) {
  one.bestResidual = std::numeric_limits<double>::infinity();
  std::mt19937_64 random(mix(static_cast<std::uint64_t>(one.index)));
  const std::array solvers{makeExactHessian(), makeLmGainRatio()};
  IkProblem problem = one.problem;
  for (int i = 0; i < 12; ++i) {
    problem.start = i < 2 ? one.problem.start : randomWithinLimits(*one.skeleton, random);
    const IkReport report =
        solvers[i % 2]->solve(problem, {.maxIterations = 300, .maxSeconds = 1e9}, TraceLevel::Off);
    if (!(report.residual < one.bestResidual)) continue;
    one.bestResidual = report.residual;
    one.reference = report.q;
  }
}

}  // namespace

LabModel labModel(std::string name, const Skeleton& skeleton, const std::vector<std::string>& effectors) {
  LabModel model{.name = std::move(name), .skeleton = std::make_shared<Skeleton>(skeleton)};
  for (const std::string& effector : effectors) model.effectors.push_back(skeleton.jointIndex(effector));
  if (effectors.empty())
    for (int i = 0; i < skeleton.jointCount(); ++i)
      if (skeleton.children(i).empty() && dofsAbove(skeleton, i) > 0) model.effectors.push_back(i);
  if (model.effectors.empty())
    throw std::invalid_argument("the model '" + model.name + "' has no joint that moves");
  model.pose = model.effectors.size() == 1 && dofsAbove(skeleton, model.effectors[0]) >= 6;
  return model;
}

std::span<const ProblemSetEntry> problemSetCatalogue() { return sets; }

const ProblemSetEntry& problemSet(std::string_view name) {
  std::string known;
  for (const ProblemSetEntry& entry : sets) {
    if (entry.name == name) return entry;
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  }
  throw std::invalid_argument("no problem set is called '" + std::string(name) + "'; there are: " + known);
}

std::vector<LabProblem> makeProblems(const ProblemSetEntry& set, const LabModel& model, int count,
                                     std::uint64_t seed, double tolerance) {
  if (count < 1)
    throw std::invalid_argument("a problem set needs at least one problem, not " + std::to_string(count));
  const ProblemMaker maker(set, model, tolerance);
  std::vector<LabProblem> problems;
  problems.reserve(count);
  for (int number = 0; static_cast<int>(problems.size()) < count; ++number) {
    std::mt19937_64 random(seedOf(seed, set, number));
    if (set.family == ProblemFamily::Drag)
      maker.appendDrag(number, std::min(dragLength, count - static_cast<int>(problems.size())), random,
                       problems);
    else
      problems.push_back(maker.make(number, random));
  }
  return problems;
}

std::uint64_t checksum(const std::vector<LabProblem>& problems) {
  std::uint64_t hash = 0xcbf29ce484222325ull;
  const auto add = [&](double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    for (int k = 0; k < 8; ++k) hash = (hash ^ ((bits >> (8 * k)) & 0xff)) * 0x100000001b3ull;
  };
  for (const LabProblem& one : problems) {
    for (double x : one.problem.start) add(x);
    for (const Goal& goal : one.problem.goals) {
      add(goal.joint);
      for (double x : goal.target) add(x);
      for (double x : goal.orientation.coeffs()) add(x);
      if (goal.kind == GoalKind::Position || goal.kind == GoalKind::Pose) continue;
      for (const char c : goalToText(goal, *one.skeleton)) add(c);
    }
  }
  return hash;
}

void annotate(const ProblemSetEntry& set, LabProblem& one) {
  if (!set.meetable) findBestPoint(one);
  one.sigmaMin = sigmaMinAt(*one.skeleton, one.problem.goals, one.reference);
  one.limitMargin = limitMarginAt(*one.skeleton, one.reference);
  one.shortest = std::numeric_limits<double>::quiet_NaN();
  if (!set.meetable || set.family == ProblemFamily::Drag) return;
  IkProblem problem = one.problem;
  problem.positionTolerance = problem.orientationTolerance = std::max(1e-6, problem.positionTolerance);
  const IkReport path =
      makeMinimalChangePath()->solve(problem, {.maxIterations = 3000, .maxSeconds = 1e9}, TraceLevel::Off);
  if (path.why == Stop::Converged) one.shortest = difference(*one.skeleton, problem.start, path.q).norm();
}

}  // namespace gelenk
