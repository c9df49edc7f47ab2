#include "solvers/tree/drag_solver.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/rotation.h"

namespace gelenk {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

int pointsOf(GoalKind kind) {
  switch (kind) {
    case GoalKind::Orientation: return 3;
    case GoalKind::Pose: return 4;
    case GoalKind::Posture: return 0;
    default: return 1;
  }
}

Vector3d clipped(const Vector3d& v, double length) {
  const double norm = v.norm();
  return norm > length ? Vector3d(v * (length / norm)) : v;
}

bool usable(const Goal& goal) {
  if (goal.kind == GoalKind::Posture) return goal.posture.allFinite();
  return goal.target.allFinite() && goal.pointInJoint.allFinite() && goal.orientation.coeffs().allFinite() &&
         goal.axisInJoint.allFinite() && std::isfinite(goal.weight) && goal.weight >= 0.0;
}

}  // namespace

std::vector<double> postureStiffness(const Skeleton& skeleton) {
  std::vector<double> s(skeleton.nv(), 0.3);
  const auto byRange = [](double halfRange) {
    return std::isfinite(halfRange) ? std::clamp(0.36 / std::max(halfRange * halfRange, 1e-12), 0.3, 2.0)
                                    : 0.3;
  };
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    int k = skeleton.vIndex(i);
    for (const AxisDof& dof : joint.axes)
      s[k++] = dof.kind == AxisDof::Kind::Translation ? 0.5 : byRange(0.5 * (dof.upper - dof.lower));
    if (!joint.ball) continue;
    double stiffness = i == 0 ? 0.7 : 0.3;
    if (joint.ballLimit) stiffness = byRange(std::sqrt(joint.ballLimit->swingRadii.prod()));
    for (int j = 0; j < 3; ++j) s[k + j] = stiffness;
  }
  return s;
}

double characteristicLength(const Skeleton& skeleton) {
  constexpr double figure = 2.331;  // of the built-in figure: Root to the tip of the middle finger, metres
  double longest = 0.0;
  for (int i = 0; i < skeleton.jointCount(); ++i) longest = std::max(longest, chainLength(skeleton, i));
  return longest > 0.0 ? longest / figure : 1.0;
}

DragSolver::DragSolver(const Skeleton& skeleton, DragOptions options)
    : options_(std::move(options)),
      descent_(skeleton, options_.unit > 0.0 ? options_.unit : characteristicLength(skeleton),
               options_.stiffness.empty() ? postureStiffness(skeleton) : options_.stiffness,
               skeleton.rest()) {
  if (!options_.stiffness.empty() && static_cast<int>(options_.stiffness.size()) != skeleton.nv())
    throw std::invalid_argument("the drag solver needs nv = " + std::to_string(skeleton.nv()) +
                                " stiffnesses, found " + std::to_string(options_.stiffness.size()));
  reset(skeleton.rest());
}

void DragSolver::reset(const VectorXd& q) {
  if (q.size() != skeleton().nq())
    throw std::invalid_argument("the drag solver needs nq = " + std::to_string(skeleton().nq()) +
                                " values, found " + std::to_string(q.size()));
  report_.q = projectToLimits(skeleton(), q);
  fresh_ = true;
  memory_.clear();
}

bool DragSolver::sameStructure(std::span<const DragGoal> goals) const {
  if (fresh_ || goals.size() != memory_.size()) return false;
  for (std::size_t i = 0; i < goals.size(); ++i)
    if (goals[i].goal.joint != memory_[i].joint || goals[i].goal.kind != memory_[i].kind ||
        goals[i].role != memory_[i].role)
      return false;
  return true;
}

void DragSolver::rebuild(std::span<const DragGoal> goals) {
  std::swap(memory_, previous_);
  memory_.clear();
  joints_.clear();
  int points = 0;
  for (const DragGoal& goal : goals) {
    const int joint = goal.goal.joint;
    if (joint < 0 || joint >= skeleton().jointCount())
      throw std::invalid_argument("a drag goal names joint " + std::to_string(joint) + "; the skeleton has " +
                                  std::to_string(skeleton().jointCount()));
    if (goal.goal.kind == GoalKind::Pole &&
        (skeleton().parent(joint) < 0 || skeleton().children(joint).empty()))
      throw std::invalid_argument("a pole goal needs a joint with a parent and a child; '" +
                                  skeleton().joint(joint).name + "' has not both");
    Memory memory{.joint = joint,
                  .kind = goal.goal.kind,
                  .role = goal.role,
                  .firstPoint = points,
                  .pointCount = pointsOf(goal.goal.kind),
                  .bias = {},
                  .a = {},
                  .b = {},
                  .c = {}};
    for (Vector3d& bias : memory.bias) bias.setZero();
    for (Memory& old : previous_)
      if (old.joint == joint && old.kind == memory.kind && old.role == memory.role) {
        std::copy(old.bias, old.bias + 4, memory.bias);
        old.joint = -1;  // taken
        break;
      }
    points += memory.pointCount;
    if (goal.goal.kind != GoalKind::Posture) joints_.push_back(joint);
    memory_.push_back(memory);
  }
  // The origin of the inner frame lies near the body: far from the world's origin nothing is lost to
  // rounding.
  Vector3d origin = skeleton().joint(0).parentFromZero.translation();
  descent_.build(joints_, origin);
  descent_.points().resize(points);
  wanted_.resize(points);
  reportWeight_.resize(points);
  descent_.load(report_.q);
  fresh_ = strained_ = spent_ = false;
  framesHeld_ = 0;
  budgetShare_ = 1.0;
}

void DragSolver::setTargets(std::span<const DragGoal> goals) {
  const GoalTree& tree = descent_.tree();
  bool moved = false;
  for (std::size_t i = 0; i < goals.size(); ++i) {
    const Goal& goal = goals[i].goal;
    Memory& memory = memory_[i];
    const double weight = usable(goal) ? goal.weight * (goals[i].role == GoalRole::Pin ? options_.pinWeight
                                                                                       : options_.dragWeight)
                                       : 0.0;
    const double reported = usable(goal) ? goal.weight : 0.0;
    const int carrier = tree.carrier(goal.joint);
    int at = memory.firstPoint;
    const auto put = [&](bool direction, double share, const Vector3d& local, const Vector3d& target) {
      TreePoint& point = descent_.points()[at];
      moved = moved || wanted_[at] != target;
      point = {.node = carrier,
               .direction = direction,
               .weight = share * weight,
               .local = local,
               .target = target};
      wanted_[at] = target;
      reportWeight_[at] = share * reported;
      if (!direction) point.cut = options_.cut;
      if (weight == 0.0) {  // nothing that is not finite may reach the sums
        point.local.setZero();
        point.target.setZero();
        wanted_[at].setZero();
      }
      ++at;
    };
    if (goal.kind == GoalKind::Position || goal.kind == GoalKind::Pose)
      put(false, 1.0, tree.toCarrier(goal.joint, goal.pointInJoint), tree.toTree(goal.target));
    if (goal.kind == GoalKind::Orientation || goal.kind == GoalKind::Pose) {
      const Matrix3d wanted = goal.orientation.normalized().toRotationMatrix(),
                     local = tree.carrierFromJoint(goal.joint);
      for (int k = 0; k < 3; ++k)
        put(true, 1.0 / 3.0, options_.poseArm * local.col(k), options_.poseArm * wanted.col(k));
    }
    if (goal.kind == GoalKind::Aim)
      put(true, 1.0, options_.poseArm * (tree.carrierFromJoint(goal.joint) * goal.axisInJoint),
          tree.toTree(goal.target));
    if (goal.kind == GoalKind::Pole) {
      const int parent = skeleton().parent(goal.joint), child = skeleton().children(goal.joint).front();
      memory.a = {.node = tree.carrier(parent), .local = tree.toCarrier(parent, Vector3d::Zero())};
      memory.b = {.node = carrier, .local = tree.toCarrier(goal.joint, Vector3d::Zero())};
      memory.c = {.node = carrier,
                  .local = tree.toCarrier(goal.joint, skeleton().joint(child).parentFromZero.translation())};
      put(false, 1.0, memory.b.local, tree.toTree(goal.target));
    }
  }
  framesHeld_ = moved ? 0 : framesHeld_ + 1;
  updateMovingTargets(goals);
  restoreTargets();
}

/// Targets that depend on the pose: the direction of an aim, the place of the elbow on its circle. Held
/// during one iteration.
void DragSolver::updateMovingTargets(std::span<const DragGoal> goals) {
  const GoalTree& tree = descent_.tree();
  for (std::size_t i = 0; i < goals.size(); ++i) {
    const Memory& memory = memory_[i];
    if (memory.kind != GoalKind::Aim && memory.kind != GoalKind::Pole) continue;
    TreePoint& point = descent_.points()[memory.firstPoint];
    if (point.weight == 0.0) continue;
    const Vector3d goal = tree.toTree(goals[i].goal.target);
    if (memory.kind == GoalKind::Aim) {
      const TreePoint origin{.node = point.node, .local = tree.toCarrier(memory.joint, Vector3d::Zero())};
      const Vector3d wanted = goal - tree.at(descent_.pose(), origin);
      const double length = wanted.norm();
      point.target =
          length > 1e-9 ? Vector3d(options_.poseArm / length * wanted) : tree.at(descent_.pose(), point);
    } else {
      const Vector3d a = tree.at(descent_.pose(), memory.a), b = tree.at(descent_.pose(), memory.b),
                     c = tree.at(descent_.pose(), memory.c);
      const double length = (c - a).norm();
      const Vector3d u = (c - a) / std::max(length, 1e-12), s = goal - a, side = s - u * u.dot(s);
      const Vector3d foot = a + u * u.dot(b - a);
      const double width = side.norm(), radius = (b - foot).norm();
      point.target = length > 1e-9 && width > 1e-9 ? Vector3d(foot + radius / width * side) : b;
    }
    wanted_[memory.firstPoint] = point.target;
  }
}

/// Method of multipliers, bounded: what the posture's pull leaves of the error is added to the target.
void DragSolver::updateBiases() {
  for (Memory& memory : memory_) {
    if (memory.kind == GoalKind::Aim || memory.kind == GoalKind::Pole) continue;
    for (int k = 0; k < memory.pointCount; ++k) {
      const TreePoint& point = descent_.points()[memory.firstPoint + k];
      if (point.weight == 0.0) continue;
      const double bound = point.direction                ? options_.poseBias
                           : memory.role == GoalRole::Pin ? options_.pinBias
                                                          : options_.dragBias;
      const Vector3d error = wanted_[memory.firstPoint + k] - descent_.tree().at(descent_.pose(), point);
      memory.bias[k] = clipped(memory.bias[k] + error, bound);
    }
  }
}

void DragSolver::holdDragsWhereTheyAre() {
  for (const Memory& memory : memory_)
    if (memory.role == GoalRole::Drag)
      for (int k = 0; k < memory.pointCount; ++k) {
        TreePoint& point = descent_.points()[memory.firstPoint + k];
        point.target = descent_.tree().at(descent_.pose(), point);
      }
}

void DragSolver::restoreTargets() {
  for (const Memory& memory : memory_)
    for (int k = 0; k < memory.pointCount; ++k)
      descent_.points()[memory.firstPoint + k].target = wanted_[memory.firstPoint + k] + memory.bias[k];
}

double DragSolver::largestError(GoalRole role) const {
  double largest = 0.0;
  for (const Memory& memory : memory_)
    if (memory.role == role && memory.kind != GoalKind::Pole && memory.kind != GoalKind::Aim)
      for (int k = memory.firstPoint; k < memory.firstPoint + memory.pointCount; ++k)
        if (descent_.points()[k].weight > 0.0)
          largest = std::max(largest,
                             (wanted_[k] - descent_.tree().at(descent_.pose(), descent_.points()[k])).norm());
  return largest;
}

double DragSolver::residual() const {
  double sum = 0.0;
  for (std::size_t k = 0; k < wanted_.size(); ++k)
    sum += reportWeight_[k] *
           (wanted_[k] - descent_.tree().at(descent_.pose(), descent_.points()[k])).squaredNorm();
  return unit() * std::sqrt(sum);
}

void DragSolver::record(TraceLevel trace, const StepOutcome& outcome, double before, double seconds) {
  report_.trace.push_back({.q = {},
                           .residual = before,
                           .stepNorm = outcome.step,
                           .damping = outcome.damping,
                           .seconds = seconds});
  if (trace != TraceLevel::Full) return;
  report_.trace.back().q = report_.q;
  descent_.tree().store(descent_.pose(), report_.trace.back().q);
}

/// Up to `iterations` steps, and the repair of the pins where the rotation budget is spent. True where the
/// pose settled.
bool DragSolver::descend(std::span<const DragGoal> goals, double budget, int iterations, TraceLevel trace,
                         Clock::time_point begin) {
  HybridDescent::Settings settings;
  settings.lambda = options_.posture;
  settings.kappa =
      options_.change * std::max(options_.heldChange, std::pow(0.7, std::max(0, framesHeld_ - 2)));
  settings.rotationBudget = budget;
  spent_ = false;
  for (int done = 0; iterations > 0; --iterations, ++done) {
    const double before = trace == TraceLevel::Off ? 0.0 : residual();
    if (done > 0 && !spent_) updateMovingTargets(goals);
    const StepOutcome outcome = descent_.step(settings);
    ++report_.counters.iterations;
    report_.counters.forwardKinematics += outcome.placements;
    report_.counters.factorisations += outcome.factorisations;
    ++(outcome.kind == StepKind::ExactHessian ? report_.counters.hessians : report_.counters.jacobians);
    if (trace != TraceLevel::Off)
      record(trace, outcome, before, std::chrono::duration<double>(Clock::now() - begin).count());
    if (outcome.budgetSpent && !spent_) {
      spent_ = true;
      iterations = options_.repairs + 1;
      settings.lambda = 0.0;
      settings.passing = true;
      settings.rotationBudget = 1.2 * budget;
      descent_.anchorChange();
      holdDragsWhereTheyAre();
    } else if (!outcome.moved || outcome.step < options_.settled) {
      return !spent_ && (outcome.moved || outcome.step < settings.smallestStep);
    }
  }
  return false;
}

const IkReport& DragSolver::frame(std::span<const DragGoal> goals, TraceLevel trace) {
  const auto begin = Clock::now();
  if (!sameStructure(goals)) rebuild(goals);
  report_.trace.clear();
  report_.counters = {};
  descent_.anchor();
  setTargets(goals);
  const double pinsBefore = largestError(GoalRole::Pin);
  const int iterations = strained_ ? options_.strainedIterations : options_.iterations;
  const HybridDescent::Settings goalsAndPosture{.lambda = options_.posture, .kappa = 0.0};
  const double costBefore = descent_.objective(goalsAndPosture);
  if (framesHeld_ == 0) budgetShare_ = 1.0;
  double budget = budgetShare_ * options_.rotationBudget;
  bool settled = descend(goals, budget, iterations, trace, begin);
  // A long step may leave the pins too far off for the repair: take a shorter one instead.
  for (int again = 0; again < 2 && largestError(GoalRole::Pin) > std::max(options_.pinTolerance, pinsBefore);
       ++again) {
    descent_.returnToAnchor();
    setTargets(goals);
    budget *= 0.4;
    settled = descend(goals, budget, iterations, trace, begin);
  }
  // Cut steps and repairs can go round in a circle between two poses when the targets stand still: tighten
  // the budget.
  if (spent_) {
    for (Memory& memory : memory_)  // corrections found at rest are stale in a glide
      if (memory.role == GoalRole::Pin)
        for (Vector3d& bias : memory.bias) bias *= 0.5;
    restoreTargets();
    const bool better = descent_.objective(goalsAndPosture) < (1.0 - 1e-4) * costBefore;
    budgetShare_ = better ? std::min(1.0, 1.2 * budgetShare_) : 0.5 * budgetShare_;
  } else {
    budgetShare_ = std::min(1.0, 1.2 * budgetShare_);
  }
  if (settled) updateBiases();
  strained_ = largestError(GoalRole::Drag) > options_.strain;
  descent_.tree().store(descent_.pose(), report_.q);
  report_.residual = residual();
  report_.why = !settled                            ? Stop::Budget
                : report_.residual <= 1e-4 * unit() ? Stop::Converged
                                                    : Stop::Stationary;
  report_.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return report_;
}

/// Every goal within its tolerance, by the points that stand for it.
bool DragSolver::met(double positionTolerance, double orientationTolerance) const {
  for (const Memory& memory : memory_) {
    double chord = 0.0;  // squared, over the points that turn
    int directions = 0;
    for (int k = memory.firstPoint; k < memory.firstPoint + memory.pointCount; ++k) {
      const TreePoint& point = descent_.points()[k];
      const double squared = (wanted_[k] - descent_.tree().at(descent_.pose(), point)).squaredNorm();
      if (point.direction) {
        chord += squared;
        ++directions;
      } else if (!(unit() * std::sqrt(squared) <= positionTolerance)) {
        return false;
      }
    }
    // Turned by the angle a, one unit direction moves by at most 2 sin(a / 2), three orthogonal ones by
    // sqrt(8) sin(a / 2).
    const double sine = std::sqrt(chord) / options_.poseArm / (directions == 3 ? std::sqrt(8.0) : 2.0);
    if (directions > 0 && !(2.0 * std::asin(std::min(1.0, sine)) <= orientationTolerance)) return false;
  }
  return true;
}

IkReport DragSolver::solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) {
  const auto begin = Clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  constexpr double rounding = 0.999;  // what the judge's own arithmetic may add
  std::vector<DragGoal> goals;
  for (const Goal& goal : problem.goals) goals.push_back({.goal = goal});
  const DragOptions given = options_;
  options_.cut = unlimited;
  options_.dragWeight = 1.0;
  reset(problem.start);
  report_.counters = {};
  report_.trace.clear();

  std::mt19937_64 random(budget.seed);
  VectorXd best = report_.q;
  double bestResidual = std::numeric_limits<double>::infinity();
  Stop why = Stop::Budget;
  for (int attempt = 0; attempt <= budget.restarts && why != Stop::Converged; ++attempt) {
    rebuild(goals);
    if (attempt > 0) {  // the tree's joints alone: the others stay
      descent_.load(randomWithinLimits(skeleton(), random));
      ++report_.counters.restarts;
    }
    setTargets(goals);
    HybridDescent::Settings settings{
        .lambda = options_.posture, .kappa = 0.0, .smallestStep = 1e-14, .leastDamping = 1e-8};
    int stuck = 0;
    for (;; settings.lambda = settings.lambda > 1e-10 ? 0.1 * settings.lambda : 0.0) {
      updateMovingTargets(goals);
      why = met(rounding * problem.positionTolerance, rounding * problem.orientationTolerance)
                ? Stop::Converged
                : Stop::Budget;
      if (why == Stop::Converged || report_.counters.iterations >= budget.maxIterations ||
          seconds() > budget.maxSeconds)
        break;
      const double before = trace == TraceLevel::Off ? 0.0 : residual();
      const StepOutcome outcome = descent_.step(settings);
      ++report_.counters.iterations;
      report_.counters.forwardKinematics += outcome.placements;
      report_.counters.factorisations += outcome.factorisations;
      ++(outcome.kind == StepKind::ExactHessian ? report_.counters.hessians : report_.counters.jacobians);
      if (trace != TraceLevel::Off) record(trace, outcome, before, seconds());
      stuck = outcome.moved ? 0 : stuck + 1;
      if (settings.lambda == 0.0 && (outcome.step < 1e-9 || stuck > 3)) {
        why = Stop::Stationary;
        break;
      }
    }
    if (why == Stop::Converged || residual() < bestResidual) {
      bestResidual = residual();
      best = report_.q;
      descent_.tree().store(descent_.pose(), best);
    }
  }
  options_ = given;
  fresh_ = true;
  IkReport report = std::move(report_);
  report.q = best;
  report.why = why;
  report.seconds = seconds();
  report_ = {};
  report_.q = std::move(best);
  return report;
}

}  // namespace gelenk
