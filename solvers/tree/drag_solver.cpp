#include "solvers/tree/drag_solver.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "solvers/iteration/attempt.h"
#include "solvers/iteration/moving_joints.h"
#include "solvers/problem/judge.h"
#include "solvers/problem/support.h"

namespace gelenk {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

Vector3d clipped(const Vector3d& v, double length) {
  const double norm = v.norm();
  return norm > length ? Vector3d(v * (length / norm)) : v;
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
    if (joint.coupling) continue;  // its source's posture is its own
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
  if (options_.balance) {
    const BalanceOptions& balance = *options_.balance;
    if (!balance.masses) throw std::invalid_argument("a balance needs masses");
    balance.masses->check(skeleton);
    if (balance.supports.empty()) throw std::invalid_argument("a balance needs supports");
    balance_ = {.kind = GoalKind::Balance,
                .name = "balance",
                .direction = balance.up.normalized(),
                .masses = balance.masses,
                .role = Role::Pin};
  }
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

void DragSolver::setPosture(const VectorXd& q) {
  if (q.size() != skeleton().nq())
    throw std::invalid_argument("the drag solver needs a posture of nq = " + std::to_string(skeleton().nq()) +
                                " values, found " + std::to_string(q.size()));
  descent_.setPosture(q);
}

bool DragSolver::sameStructure(std::span<const Goal> goals) const {
  if (fresh_ || countOf(goals) != memory_.size()) return false;
  for (std::size_t i = 0; i < memory_.size(); ++i) {
    const Goal& goal = goalAt(goals, i);
    const Memory& memory = memory_[i];
    if (goal.joint != memory.joint || goal.kind != memory.kind || goal.role != memory.role ||
        goal.otherJoint != memory.otherJoint)
      return false;
    if (memory.type->needsMasses && goal.masses != memory.last.masses) return false;
  }
  return true;
}

void DragSolver::rebuild(std::span<const Goal> goals) {
  for (const Goal& goal : goals)
    if (const std::string why = whyMisplaced(goal, skeleton()); !why.empty())
      throw std::invalid_argument(why);
  std::swap(memory_, previous_);
  memory_.clear();
  joints_.clear();
  int points = 0, blocks = 0, sums = 0;
  bool wholeBody = false;
  for (std::size_t i = 0; i < countOf(goals); ++i) {
    const Goal& goal = goalAt(goals, i);
    Memory memory{.joint = goal.joint,
                  .otherJoint = goal.otherJoint,
                  .kind = goal.kind,
                  .role = goal.role,
                  .type = &goalType(goal.kind),
                  .firstPoint = points,
                  .pointCount = 0,
                  .bias = {},
                  .reference = {},
                  .block = -1};
    const DragForm& form = memory.type->drag;
    for (Vector3d& bias : memory.bias) bias.setZero();
    for (Memory& old : previous_)
      if (old.joint == memory.joint && old.kind == memory.kind && old.role == memory.role &&
          old.otherJoint == memory.otherJoint) {
        std::copy(old.bias, old.bias + 4, memory.bias);
        old.joint = -1;  // taken
        break;
      }
    if (memory.type->joints) memory.type->joints(goal, skeleton(), joints_);
    if (form.points) {
      DragPoints list;
      form.points(goal, skeleton(), list);
      memory.pointCount = list.count;
    }
    if (form.model) {
      memory.block = blocks++;
      memory.last = goal;
    }
    wholeBody = wholeBody || memory.type->needsMasses;
    points += memory.pointCount;
    sums += form.sums;
    memory_.push_back(std::move(memory));
  }
  if (options_.balance)
    for (const BalanceOptions::Support& support : options_.balance->supports)
      joints_.push_back(support.joint);
  // The origin of the inner frame lies near the body: far from the world's origin nothing is lost to
  // rounding.
  descent_.build(joints_, skeleton().joint(0).parentFromZero.translation());
  descent_.setArm(options_.poseArm * unit());
  descent_.points().resize(points);
  descent_.blocks().resize(blocks);
  descent_.sums().resize(sums);
  wanted_.resize(points);
  reportWeight_.resize(points);
  descent_.load(report_.q);
  if (wholeBody) forwardKinematics(skeleton(), report_.q, frames_);
  int sum = 0;
  for (std::size_t i = 0; i < memory_.size(); ++i) {
    Memory& memory = memory_[i];
    if (memory.block < 0) continue;
    TreeBlock& block = descent_.blocks()[memory.block];
    block = {.type = memory.type, .firstSum = sum};
    sum += memory.type->drag.sums;
    for (int j = 0; j < memory.type->drag.sums; ++j) block.correction[j].setZero();
    compile(goalAt(goals, i), memory);
  }
  supports_.clear();
  standingBefore_.clear();
  if (options_.balance)
    for (const BalanceOptions::Support& support : options_.balance->supports)
      supports_.push_back({.node = descent_.tree().carrier(support.joint),
                           .local = descent_.tree().toCarrier(support.joint, support.inJoint)});
  fresh_ = strained_ = spent_ = false;
  framesHeld_ = 0;
  budgetShare_ = 1.0;
}

/// The block's sums as shares of nodes. Joints beside the tree move with the nearest one on it, where they
/// were when it was built.
void DragSolver::compile(const Goal& goal, const Memory& memory) {
  const GoalTree& tree = descent_.tree();
  const TreeBlock& block = descent_.blocks()[memory.block];
  for (int j = 0; j < memory.type->drag.sums; ++j) {
    carried_.clear();
    memory.type->drag.carried(goal, skeleton(), j, carried_);
    TreeSum& sum = descent_.sums()[block.firstSum + j];
    std::vector<TreeShare>& shares = descent_.shares();
    const bool direction = carried_.front().direction;
    const bool again = sum.count > 0;  // the same nodes as before
    int at = again ? sum.first : static_cast<int>(shares.size());
    if (!again) sum.first = at;
    sum.constant.setZero();
    sum.direction = direction;
    sum.scale = direction ? 1.0 : unit();
    double total = 0.0;
    for (const Carried& part : carried_) {
      int joint = part.joint;
      Vector3d inJoint = part.inJoint;
      if (!tree.holds(joint)) {
        joint = tree.holderOf(joint);
        if (joint >= 0) inJoint = frames_[joint].inverse() * (frames_[part.joint] * inJoint);
      }
      const int node = joint >= 0 ? tree.carrier(joint) : -1;
      Vector3d local;
      if (joint < 0)
        local = tree.toTree(frames_[part.joint] * inJoint);
      else if (part.direction)
        local = tree.carrierFromJoint(joint) * inJoint;
      else
        local = tree.toCarrier(joint, inJoint);
      if (!part.direction) total += part.share;
      if (node < 0) {
        sum.constant += part.share * local;
        continue;
      }
      TreeShare* same = nullptr;  // points of one node are one point
      for (int k = sum.first; !again && !direction && k < at; ++k)
        if (shares[k].node == node && shares[k].share * part.share > 0.0) same = &shares[k];
      if (same) {
        const double both = same->share + part.share;
        same->local = (same->share * same->local + part.share * local) / both;
        same->share = both;
        continue;
      }
      if (!again) shares.emplace_back();
      shares[at++] = {.node = node, .direction = part.direction, .share = part.share, .local = local};
    }
    if (!again) sum.count = at - sum.first;
    sum.shift = direction ? Vector3d(Vector3d::Zero()) : Vector3d(total * tree.origin());
  }
}

/// True where the target has moved.
bool DragSolver::setPoints(const Goal& goal, Memory& memory, double weight, double reported, double cut) {
  const GoalTree& tree = descent_.tree();
  DragPoints list;
  memory.type->drag.points(goal, skeleton(), list);
  bool moved = false;
  for (int k = 0; k < list.count; ++k) {
    const auto& [at, target] = list.points[k];
    const int index = memory.firstPoint + k;
    TreePoint& point = descent_.points()[index];
    const Vector3d wanted = at.direction ? Vector3d(options_.poseArm * target) : tree.toTree(target);
    moved = moved || wanted_[index] != wanted;
    point = {.node = tree.carrier(at.joint),
             .direction = at.direction,
             .weight = at.share * weight,
             .local = at.direction
                          ? Vector3d(options_.poseArm * (tree.carrierFromJoint(at.joint) * at.inJoint))
                          : tree.toCarrier(at.joint, at.inJoint),
             .target = wanted};
    wanted_[index] = wanted;
    reportWeight_[index] = at.share * reported;
    if (!at.direction) point.cut = cut;
    if (weight == 0.0) {  // nothing that is not finite may reach the sums
      point.local.setZero();
      point.target.setZero();
      wanted_[index].setZero();
    }
  }
  if (memory.type->drag.references) {
    std::array<Carried, 3> references;
    memory.type->drag.references(goal, skeleton(), references);
    for (int k = 0; k < 3; ++k)
      memory.reference[k] = {.node = tree.carrier(references[k].joint),
                             .local = tree.toCarrier(references[k].joint, references[k].inJoint)};
  }
  return moved;
}

/// Likewise.
bool DragSolver::setBlock(const Goal& goal, Memory& memory, double weight, double cut) {
  TreeBlock& block = descent_.blocks()[memory.block];
  block.goal = &goal;
  block.weight = memory.weight = weight;
  block.cut = cut * unit();
  for (int j = 0; j < memory.type->drag.sums; ++j) block.correction[j] = memory.bias[j];
  if (weight == 0.0 || asksTheSame(goal, memory.last)) return false;
  memory.last = goal;
  if (!memory.type->needsMasses) compile(goal, memory);  // a body's masses do not change between frames
  return true;
}

void DragSolver::setTargets(std::span<const Goal> goals, const Pull& pull) {
  if (options_.balance) updateSupport();
  bool moved = false;
  for (std::size_t i = 0; i < memory_.size(); ++i) {
    const Goal& goal = goalAt(goals, i);
    Memory& memory = memory_[i];
    const double asked = isFinite(goal) ? goal.weight : 0.0;
    const double weight = asked * (goal.role == Role::Pin ? pull.pin : pull.drag);
    if (memory.pointCount > 0) moved = setPoints(goal, memory, weight, asked, pull.cut) || moved;
    if (memory.block >= 0) moved = setBlock(goal, memory, weight, pull.cut) || moved;
  }
  framesHeld_ = moved ? 0 : framesHeld_ + 1;
  updateMovingTargets(goals);
  restoreTargets();
}

Vector3d DragSolver::worldOf(const TreePoint& point) const {
  return unit() * descent_.tree().at(descent_.pose(), point) + descent_.tree().origin();
}

/// The polygon of those supports that stand, at the pose where the frame begins.
void DragSolver::updateSupport() {
  const BalanceOptions& balance = *options_.balance;
  const Vector3d& up = balance_.direction;
  double lowest = std::numeric_limits<double>::infinity();
  standing_.clear();
  for (const TreePoint& support : supports_) {
    standing_.push_back(worldOf(support));
    lowest = std::min(lowest, standing_.back().dot(up));
  }
  std::erase_if(standing_, [&](const Vector3d& p) { return p.dot(up) > lowest + balance.standing; });
  bool same = standing_.size() == standingBefore_.size();
  constexpr double still = 1e-4;  // metres: pinned feet keep their polygon
  for (std::size_t k = 0; same && k < standing_.size(); ++k)
    same = (standing_[k] - standingBefore_[k]).squaredNorm() < still * still;
  if (same) return;
  standingBefore_ = standing_;
  balance_.polygon = SupportPolygon::hull(standing_, up).inset(balance.margin).corners;
}

/// Targets that depend on the pose: the place of the elbow on its circle. Held during one iteration.
void DragSolver::updateMovingTargets(std::span<const Goal> goals) {
  for (std::size_t i = 0; i < goals.size(); ++i) {
    const Memory& memory = memory_[i];
    if (!memory.type->drag.follow) continue;
    TreePoint& point = descent_.points()[memory.firstPoint];
    if (point.weight == 0.0) continue;
    std::array<Vector3d, 3> at;
    for (int k = 0; k < 3; ++k) at[k] = worldOf(memory.reference[k]);
    point.target = descent_.tree().toTree(memory.type->drag.follow(goals[i], at));
    wanted_[memory.firstPoint] = point.target;
  }
}

/// Method of multipliers, bounded: what the posture's pull leaves of the error is added to the target. For
/// blocks u <- clip(force(y - u) / stiffness), which lets go by itself where a one-sided goal is not touched.
void DragSolver::updateBiases() {
  for (Memory& memory : memory_) {
    if (!memory.type->drag.measured) continue;
    const bool pin = memory.role == Role::Pin;
    for (int k = 0; k < memory.pointCount; ++k) {
      const TreePoint& point = descent_.points()[memory.firstPoint + k];
      if (point.weight == 0.0) continue;
      const double bound = point.direction ? options_.poseBias : pin ? options_.pinBias : options_.dragBias;
      const Vector3d error = wanted_[memory.firstPoint + k] - descent_.tree().at(descent_.pose(), point);
      memory.bias[k] = clipped(memory.bias[k] + error, bound);
    }
    if (memory.block < 0) continue;
    const TreeBlock& block = descent_.blocks()[memory.block];
    if (block.weight == 0.0) continue;
    DragModel model;
    descent_.look(block, true, false, model);
    for (int j = 0; j < memory.type->drag.sums; ++j) {
      if (model.stiffness[j] == 0.0) continue;
      const double bound = descent_.sums()[block.firstSum + j].direction
                               ? options_.poseBias / options_.poseArm
                               : unit() * (pin ? options_.pinBias : options_.dragBias);
      memory.bias[j] = clipped(model.force[j] / model.stiffness[j], bound);
    }
  }
}

void DragSolver::holdDragsWhereTheyAre() {
  for (const Memory& memory : memory_) {
    if (memory.role == Role::Pin) continue;
    for (int k = 0; k < memory.pointCount; ++k) {
      TreePoint& point = descent_.points()[memory.firstPoint + k];
      point.target = descent_.tree().at(descent_.pose(), point);
    }
    if (memory.block >= 0) descent_.blocks()[memory.block].weight = 0.0;
  }
}

void DragSolver::restoreTargets() {
  for (const Memory& memory : memory_) {
    for (int k = 0; k < memory.pointCount; ++k)
      descent_.points()[memory.firstPoint + k].target = wanted_[memory.firstPoint + k] + memory.bias[k];
    if (memory.block < 0) continue;
    TreeBlock& block = descent_.blocks()[memory.block];
    block.weight = memory.weight;
    for (int j = 0; j < memory.type->drag.sums; ++j) block.correction[j] = memory.bias[j];
  }
}

/// How far a goal is from being met, units; directions by their arm.
double DragSolver::errorOf(const Memory& memory) const {
  double largest = 0.0;
  for (int k = memory.firstPoint; k < memory.firstPoint + memory.pointCount; ++k)
    if (descent_.points()[k].weight > 0.0)
      largest =
          std::max(largest, (wanted_[k] - descent_.tree().at(descent_.pose(), descent_.points()[k])).norm());
  if (memory.block >= 0 && memory.weight > 0.0) {
    DragModel model;
    descent_.look(descent_.blocks()[memory.block], false, false, model);
    largest = std::max(largest, std::sqrt(2.0 * model.cost) / unit());
  }
  return largest;
}

double DragSolver::largestError(bool pins) const {
  double largest = 0.0;
  for (const Memory& memory : memory_)
    if ((memory.role == Role::Pin) == pins && memory.type->drag.measured)
      largest = std::max(largest, errorOf(memory));
  return largest;
}

double DragSolver::residual() const {
  double sum = 0.0;
  for (std::size_t k = 0; k < wanted_.size(); ++k)
    sum += reportWeight_[k] *
           (wanted_[k] - descent_.tree().at(descent_.pose(), descent_.points()[k])).squaredNorm();
  sum *= unit() * unit();
  for (const Memory& memory : memory_) {
    if (memory.block < 0 || memory.weight == 0.0) continue;
    DragModel model;
    descent_.look(descent_.blocks()[memory.block], false, false, model);
    sum += descent_.blocks()[memory.block].goal->weight * 2.0 * model.cost;
  }
  return std::sqrt(sum);
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

void DragSolver::count(const StepOutcome& outcome) {
  ++report_.counters.iterations;
  report_.counters.forwardKinematics += outcome.placements;
  report_.counters.factorisations += outcome.factorisations;
  ++(outcome.kind == StepKind::ExactHessian ? report_.counters.hessians : report_.counters.jacobians);
}

/// Up to `iterations` steps, and the repair of the pins where the rotation budget is spent. True where the
/// pose settled.
bool DragSolver::descend(std::span<const Goal> goals, double budget, int iterations, TraceLevel trace,
                         Clock::time_point begin) {
  DragDescent::Settings settings;
  settings.lambda = options_.posture;
  settings.kappa =
      options_.change * std::max(options_.heldChange, std::pow(0.7, std::max(0, framesHeld_ - 2)));
  settings.rotationBudget = budget;
  spent_ = false;
  for (int done = 0; iterations > 0; --iterations, ++done) {
    const double before = trace == TraceLevel::Off ? 0.0 : residual();
    if (done > 0 && !spent_) updateMovingTargets(goals);
    const StepOutcome outcome = descent_.step(settings);
    count(outcome);
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

const IkReport& DragSolver::frame(std::span<const Goal> goals, TraceLevel trace) {
  const auto begin = Clock::now();
  if (!sameStructure(goals)) rebuild(goals);
  report_.trace.clear();
  report_.counters = {};
  descent_.anchor();
  setTargets(goals, dragging());
  const double pinsBefore = largestError(true);
  const int iterations = strained_ ? options_.strainedIterations : options_.iterations;
  const DragDescent::Settings goalsAndPosture{.lambda = options_.posture, .kappa = 0.0};
  const double costBefore = descent_.objective(goalsAndPosture);
  if (framesHeld_ == 0) budgetShare_ = 1.0;
  double budget = budgetShare_ * options_.rotationBudget;
  bool settled = descend(goals, budget, iterations, trace, begin);
  // A long step may leave the pins too far off for the repair: take a shorter one instead.
  for (int again = 0; again < 2 && largestError(true) > std::max(options_.pinTolerance, pinsBefore);
       ++again) {
    descent_.returnToAnchor();
    setTargets(goals, dragging());
    budget *= 0.4;
    settled = descend(goals, budget, iterations, trace, begin);
  }
  // Cut steps and repairs can go round in a circle between two poses when the targets stand still: tighten
  // the budget.
  if (spent_) {
    for (Memory& memory : memory_)  // corrections found at rest are stale in a glide
      if (memory.role == Role::Pin)
        for (Vector3d& bias : memory.bias) bias *= 0.5;
    restoreTargets();
    const bool better = descent_.objective(goalsAndPosture) < (1.0 - 1e-4) * costBefore;
    budgetShare_ = better ? std::min(1.0, 1.2 * budgetShare_) : 0.5 * budgetShare_;
  } else {
    budgetShare_ = std::min(1.0, 1.2 * budgetShare_);
  }
  if (settled) updateBiases();
  strained_ = largestError(false) > options_.strain;
  descent_.tree().store(descent_.pose(), report_.q);
  report_.residual = residual();
  report_.why = !settled                            ? Stop::Budget
                : report_.residual <= 1e-4 * unit() ? Stop::Converged
                                                    : Stop::Stationary;
  report_.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return report_;
}

/// Every goal within its tolerance: by the points that stand for it, or, where there are blocks, by forward
/// kinematics.
bool DragSolver::met(std::span<const Goal> goals, double positionTolerance, double orientationTolerance) {
  if (!descent_.blocks().empty()) {
    VectorXd& q = report_.q;
    descent_.tree().store(descent_.pose(), q);
    forwardKinematics(skeleton(), q, frames_);
    VectorXd r;
    for (const Goal& goal : goals) {
      const GoalType& type = goalType(goal.kind);
      if (!type.judged || goal.weight == 0.0 || !isFinite(goal)) continue;
      r.resize(type.rows(skeleton()));
      type.residual(goal, {skeleton(), q, frames_}, r);
      const GoalError error = type.error(r);
      if (!(error.position <= positionTolerance && error.orientation <= orientationTolerance)) return false;
    }
    return true;
  }
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
    // Turned by the angle a, one unit direction moves by 2 sin(a / 2), three orthogonal ones by sqrt(8) sin(a
    // / 2).
    const double sine = std::sqrt(chord / (directions == 1 ? 4.0 : 8.0)) / options_.poseArm;
    if (directions > 0 && !(2.0 * std::asin(std::min(1.0, sine)) <= orientationTolerance)) return false;
  }
  return true;
}

IkReport DragSolver::solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) {
  const auto begin = Clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  const std::span<const Goal> goals = problem.goals;
  constexpr Pull byOwnWeight{.drag = 1.0, .pin = 1.0, .cut = unlimited};
  constexpr double fade = 0.1, lastPosture = 1e-10;  // of the posture's pull, a step
  constexpr double smallestStep = 1e-9;              // without posture: at rest
  constexpr int mostStuck = 3;
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
    setTargets(goals, byOwnWeight);
    const int mostIterations = report_.counters.iterations + budget.maxIterations;
    DragDescent::Settings settings{.lambda = options_.posture, .smallestStep = 1e-14};
    int stuck = 0;
    for (;; settings.lambda = settings.lambda > lastPosture ? fade * settings.lambda : 0.0) {
      updateMovingTargets(goals);
      why = met(goals, options_.roundings * problem.positionTolerance,
                options_.roundings * problem.orientationTolerance)
                ? Stop::Converged
                : Stop::Budget;
      if (why == Stop::Converged || report_.counters.iterations >= mostIterations ||
          seconds() > budget.maxSeconds)
        break;
      const double before = trace == TraceLevel::Off ? 0.0 : residual();
      const StepOutcome outcome = descent_.step(settings);
      count(outcome);
      if (trace != TraceLevel::Off) record(trace, outcome, before, seconds());
      stuck = outcome.moved ? 0 : stuck + 1;
      if (settings.lambda == 0.0 && (outcome.step < smallestStep || stuck > mostStuck)) {
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
  fresh_ = true;
  IkReport report = std::move(report_);
  report.q = best;
  report.why = why;
  report.seconds = seconds();
  report_ = {};
  report_.q = std::move(best);
  return report;
}

namespace {

class ColdDrag final : public IkSolver {
 public:
  explicit ColdDrag(const DragParameters& parameters) : p_(parameters) {}
  std::string whyUnsupported(const IkProblem& problem) const override {
    for (const Goal& goal : problem.goals)
      if (const std::string why = whyMisplaced(goal, *problem.skeleton); !why.empty()) return why;
    return {};
  }

  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const override {
    if (!whyUnsupported(problem).empty())
      return {.q = problem.start, .why = Stop::Unsupported, .counters = {}, .trace = {}};
    DragSolver solver(*problem.skeleton, {.posture = p_.posture, .poseArm = p_.poseArm});
    IkReport report = solver.solve(problem, budget, trace);
    // Its own objective holds posture too, and may rest on a place that meets the goals or on a saddle of
    // them.
    IkProblem below = problem;
    Budget rest = budget;
    rest.restarts = 0;
    while (report.counters.iterations < budget.maxIterations * (1 + budget.restarts)) {
      if (report.why != Stop::Stationary || judge(problem, report.q).solved) break;
      VectorXd lower;
      report.why = whyAtRest(problem, report.q, &lower);
      if (lower.size() == 0) break;
      below.start = lower;
      IkReport next = solver.solve(below, rest, trace);
      next.counters += report.counters;
      next.seconds += report.seconds;
      next.trace.insert(next.trace.begin(), report.trace.begin(), report.trace.end());
      report = std::move(next);
    }
    MovingJoints(problem).restore(report.q);
    const VectorXd& q = report.q;
    const Frames frames = forwardKinematics(*problem.skeleton, q);
    double squared = 0.0;
    VectorXd r;
    for (const Goal& goal : problem.goals) {
      r.resize(residualRows(goal, *problem.skeleton));
      goalResidual(goal, *problem.skeleton, q, frames, r);
      squared += goal.weight * r.squaredNorm();
    }
    report.residual = std::sqrt(squared);
    if (judge(problem, q).solved) report.why = Stop::Converged;
    return report;
  }

 private:
  DragParameters p_;
};

}  // namespace

std::unique_ptr<IkSolver> makeDrag(const DragParameters& parameters) {
  return std::make_unique<ColdDrag>(parameters);
}

}  // namespace gelenk
