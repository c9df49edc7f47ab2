#include "apps/document/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "apps/document/limb.h"
#include "kinematics/configuration.h"
#include "kinematics/rotation.h"
#include "kinematics/symmetry.h"
#include "solvers/iteration/evaluator.h"
#include "solvers/problem/judge.h"

namespace gelenk {
namespace {

constexpr double heldWeight = 1.0;
constexpr double pinWeight =
    300.0;  // on the squared error: a pin yields 300 times less than the hand that pulls
constexpr double poleWeight = 0.1;
constexpr std::size_t longestHistory = 200;

bool hasOrientation(const Goal& goal) {
  return goal.kind == GoalKind::Pose || goal.kind == GoalKind::Orientation;
}

bool isEffective(const SceneGoal& goal) { return goal.state != GoalState::Free; }

/// Largest change of one tangent entry; balls count as their angle.
double largestMotion(const Skeleton& skeleton, const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  const Eigen::VectorXd dq = difference(skeleton, from, to);
  double largest = 0.0;
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const int at = skeleton.vIndex(i), axes = static_cast<int>(skeleton.joint(i).axes.size());
    for (int k = 0; k < axes; ++k) largest = std::max(largest, std::abs(dq[at + k]));
    if (skeleton.joint(i).ball) largest = std::max(largest, dq.segment<3>(at + axes).norm());
  }
  return largest;
}

bool axisAtLimit(const AxisDof& axis, double value) {
  if (!(axis.upper - axis.lower > 4.0 * Session::limitMargin)) return false;  // locked, or nearly
  return value <= axis.lower + Session::limitMargin || value >= axis.upper - Session::limitMargin;
}

bool ballAtLimit(const BallLimit& limit, const Eigen::Quaterniond& rotation) {
  const Eigen::Vector3d c = swingTwistCoordinates(rotation);
  const Eigen::Vector2d scaled = (c.head<2>() - limit.swingCentre).cwiseQuotient(limit.swingRadii);
  if (scaled.norm() >= 1.0 - Session::limitMargin) return true;
  return limit.twistUpper - limit.twistLower > 4.0 * Session::limitMargin &&
         (c.z() <= limit.twistLower + Session::limitMargin ||
          c.z() >= limit.twistUpper - Session::limitMargin);
}

std::vector<int> endEffectors(const Skeleton& skeleton) {
  std::vector<int> ends;
  for (int i = 0; i < skeleton.jointCount(); ++i)
    if (skeleton.children(i).empty()) ends.push_back(i);
  return ends;
}

}  // namespace

Session::Session(Model model) : model_(std::make_shared<const Model>(std::move(model))) {
  const std::vector<std::string> known = frameSolverNames();
  solverName_ = known.front();
  solver_ = makeFrameSolver(solverName_, skeleton());
  makeHandles();
  place(skeleton().rest());
  resetPose();
  past_.clear();
}
Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

// --- pose

void Session::place(const Eigen::VectorXd& q) {
  q_ = q;
  forwardKinematics(skeleton(), q_, frames_);
}

/// After the pose was set directly: targets, orientations and anchors become what they are now.
void Session::followPose() {
  anchorSurfaceGoals();
  for (int i = 0; i < static_cast<int>(goals_.size()); ++i) {
    Goal& goal = goals_[i].goal;
    if (goal.kind == GoalKind::Posture) goal.posture = q_;
    if (goal.kind == GoalKind::Aim) continue;
    goal.target = reached(i);
    goal.orientation = Eigen::Quaterniond(frames_[goal.joint].linear()).normalized();
  }
  solver_->reset();
}

void Session::setPose(const Eigen::VectorXd& q) {
  if (q.size() != skeleton().nq())
    throw std::invalid_argument(
        fmt::format("a pose of this model has {} values, not {}", skeleton().nq(), q.size()));
  if (!q.allFinite()) throw std::invalid_argument("a pose needs finite values");
  place(projectToLimits(skeleton(), q));
  followPose();
}

void Session::resetPose() {
  remember();
  dragged_.reset();
  std::erase_if(goals_, [](const SceneGoal& goal) { return !goal.handle; });
  for (SceneGoal& goal : goals_) {
    goal.state = GoalState::Free;
    if (goal.goal.kind == GoalKind::Pose) goal.goal.kind = GoalKind::Position;
  }
  place(skeleton().rest());
  followPose();
  for (int i = 0; i < static_cast<int>(goals_.size()); ++i)
    if (std::ranges::count(model_->pins, goals_[i].goal.name) > 0) setState(i, GoalState::Pinned);
  lastSolve_ = {};
}

void Session::mirrorPose() {
  const Eigen::VectorXd mirrored = gelenk::mirrorPose(skeleton(), q_);
  remember();
  place(projectToLimits(skeleton(), mirrored));
  followPose();
}

// --- goals

void Session::makeHandles() {
  std::vector<int> joints;
  for (const std::string& name : model_->handles) joints.push_back(skeleton().jointIndex(name));
  if (joints.empty()) joints = endEffectors(skeleton());
  for (const int joint : joints)
    goals_.push_back({.goal = {.name = skeleton().joint(joint).name, .joint = joint}, .handle = true});
  for (const int joint : joints)
    if (const auto middle = limbMiddle(skeleton(), joint))
      if (const std::string name = skeleton().joint(*middle).name + "_pole"; !findGoal(name))
        goals_.push_back({.goal = {.kind = GoalKind::Pole, .name = name, .joint = *middle}, .handle = true});
}

void Session::setInfluences(std::vector<Influences> influences) {
  if (!model_->skin || influences.size() != model_->skin->influences.size())
    throw std::invalid_argument(fmt::format("{} rows of weights for a skin of {} vertices", influences.size(),
                                            model_->skin ? model_->skin->influences.size() : 0));
  Model bound = *model_;
  bound.skin->influences = std::move(influences);
  model_ = std::make_shared<const Model>(std::move(bound));
  anchorSurfaceGoals();
}

std::optional<int> Session::findGoal(const std::string& name) const {
  for (std::size_t i = 0; i < goals_.size(); ++i)
    if (goals_[i].goal.name == name) return static_cast<int>(i);
  return std::nullopt;
}

Eigen::Vector3d Session::blendedPoint(const SurfacePoint& point) const {
  const Skin& skin = *model_->skin;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (int corner = 0; corner < 3; ++corner) {
    const int v = skin.mesh.triangles[point.triangle][corner];
    const Influences& influences = skin.influences[v];
    for (int k = 0; k < 4; ++k)
      if (influences.weights[k] > 0.0)
        p += point.barycentric[corner] * influences.weights[k] *
             (frames_[influences.joints[k]] *
              (skin.jointFromRestWorld[influences.joints[k]] * skin.mesh.positions[v]));
  }
  return p;
}

/// The blended point moves in its joint's frame as the pose changes; a solver needs it as a point fixed to
/// that joint.
void Session::anchorSurfaceGoals() {
  for (SceneGoal& goal : goals_)
    if (goal.surface.triangle >= 0)
      goal.goal.pointInJoint = frames_[goal.goal.joint].inverse() * blendedPoint(goal.surface);
}

Eigen::Vector3d Session::reached(int index) const {
  const SceneGoal& goal = goals_[index];
  if (goal.goal.kind == GoalKind::Pole) return polePoint(skeleton(), frames_, goal.goal.joint);
  if (goal.surface.triangle >= 0) return blendedPoint(goal.surface);
  return frames_[goal.goal.joint] * goal.goal.pointInJoint;
}

double Session::error(int index) const {
  const SceneGoal& goal = goals_[index];
  if (goal.state == GoalState::Free || goal.goal.kind == GoalKind::Posture) return 0.0;
  if (goal.goal.kind == GoalKind::Pole) {
    Eigen::VectorXd r(1);
    goalResidual(goal.goal, skeleton(), q_, frames_, r);
    return std::abs(r[0]);
  }
  if (goal.goal.kind == GoalKind::Orientation || goal.goal.kind == GoalKind::Aim) return 0.0;
  return (goal.goal.target - reached(index)).norm();
}

int Session::addGoal(Goal goal) {
  const std::string base = goal.name.empty() ? skeleton().joint(goal.joint).name : goal.name;
  goal.name = base;
  for (int n = 2; findGoal(goal.name); ++n) goal.name = fmt::format("{} {}", base, n);
  goals_.push_back({.goal = std::move(goal), .state = GoalState::Held});
  return static_cast<int>(goals_.size()) - 1;
}

int Session::addJointGoal(int joint) {
  for (int i = 0; i < static_cast<int>(goals_.size()); ++i)
    if (goals_[i].goal.joint == joint && goals_[i].goal.pointInJoint.isZero() &&
        goals_[i].goal.kind != GoalKind::Pole)
      return i;
  return addGoal({.joint = joint,
                  .target = frames_[joint].translation(),
                  .orientation = Eigen::Quaterniond(frames_[joint].linear()).normalized()});
}

int Session::addSurfaceGoal(const SurfacePoint& point) {
  const Skin& skin = *model_->skin;
  std::vector<double> share(skeleton().jointCount(), 0.0);
  for (int corner = 0; corner < 3; ++corner) {
    const Influences& influences = skin.influences[skin.mesh.triangles[point.triangle][corner]];
    for (int k = 0; k < 4; ++k)
      share[influences.joints[k]] += point.barycentric[corner] * influences.weights[k];
  }
  const int joint = static_cast<int>(std::ranges::max_element(share) - share.begin());
  const int goal = addGoal({.name = skeleton().joint(joint).name + " skin", .joint = joint});
  goals_[goal].surface = point;
  anchorSurfaceGoals();
  goals_[goal].goal.target = reached(goal);
  goals_[goal].goal.orientation = Eigen::Quaterniond(frames_[joint].linear()).normalized();
  return goal;
}

void Session::setTarget(int goal, const Eigen::Vector3d& target) {
  goals_[goal].goal.target = target;
  if (goals_[goal].state == GoalState::Free) goals_[goal].state = GoalState::Held;
}

void Session::setOrientation(int goal, const Eigen::Quaterniond& orientation) {
  Goal& g = goals_[goal].goal;
  if (g.kind == GoalKind::Position) g.kind = GoalKind::Pose;
  g.orientation = orientation.normalized();
}

void Session::clearOrientation(int goal) {
  if (goals_[goal].goal.kind == GoalKind::Pose) goals_[goal].goal.kind = GoalKind::Position;
}

void Session::setState(int goal, GoalState state) {
  SceneGoal& g = goals_[goal];
  const bool wasFree = g.state == GoalState::Free;
  g.state = state;
  if (wasFree && g.goal.kind != GoalKind::Aim) {
    g.goal.target = reached(goal);
    g.goal.orientation = Eigen::Quaterniond(frames_[g.goal.joint].linear()).normalized();
  }
  // A pinned foot keeps its sole on the ground: handles other than the root's are pinned with their
  // orientation, where there are joints enough for it.
  if (g.goal.kind == GoalKind::Position && state == GoalState::Pinned && g.handle &&
      skeleton().parent(g.goal.joint) >= 0 && !model_->planar && skeleton().nv() >= 12) {
    g.goal.kind = GoalKind::Pose;
    g.goal.orientation = Eigen::Quaterniond(frames_[g.goal.joint].linear()).normalized();
  }
  if (state == GoalState::Free && g.goal.kind == GoalKind::Pose) g.goal.kind = GoalKind::Position;
}

void Session::togglePin(int goal) {
  if (dragged_ != goal) remember();
  const bool pin =
      goals_[goal].state != GoalState::Pinned && !(dragged_ == goal && afterDrag_ == GoalState::Pinned);
  if (dragged_ == goal) {
    dragMoved_ = true;
    afterDrag_ = pin ? GoalState::Pinned : GoalState::Held;
  } else if (pin) {
    setState(goal, GoalState::Pinned);
  } else {
    removeGoal(goal);
  }
}

void Session::removeGoal(int goal) {
  if (dragged_ == goal) dragged_.reset();
  if (goals_[goal].handle) {
    setState(goal, GoalState::Free);
    goals_[goal].goal.target = reached(goal);
    return;
  }
  goals_.erase(goals_.begin() + goal);
  if (dragged_ && *dragged_ > goal) --*dragged_;
}

void Session::removeAllGoals() {
  remember();
  for (int i = static_cast<int>(goals_.size()) - 1; i >= 0; --i) removeGoal(i);
}

// --- dragging

void Session::beginDrag(int goal) {
  if (dragged_) endDrag();
  remember();
  SceneGoal& g = goals_[goal];
  // Points made for this drag go with it; what was pinned stays pinned; handles stay where they are put.
  afterDrag_ = g.state == GoalState::Pinned ? GoalState::Pinned
               : g.handle                   ? GoalState::Held
                                            : GoalState::Free;
  if (g.state == GoalState::Free || g.goal.kind == GoalKind::Position || g.goal.kind == GoalKind::Pose)
    g.goal.target = reached(goal);
  if (g.goal.kind == GoalKind::Pose)
    g.goal.orientation = Eigen::Quaterniond(frames_[g.goal.joint].linear()).normalized();
  g.state = GoalState::Dragged;
  dragged_ = goal;
  dragMoved_ = false;
}

void Session::moveDrag(const Eigen::Vector3d& target) {
  if (!dragged_ || !target.allFinite()) return;
  // A pixel's ray gives the start back only to rounding.
  dragMoved_ = dragMoved_ || (target - goals_[*dragged_].goal.target).norm() > 1e-9 * (1.0 + target.norm());
  goals_[*dragged_].goal.target = target;
}

void Session::rotateDrag(const Eigen::Quaterniond& worldRotation) {
  if (!dragged_ || goals_[*dragged_].goal.kind == GoalKind::Pole) return;
  Goal& goal = goals_[*dragged_].goal;
  dragMoved_ = true;
  if (!hasOrientation(goal)) goal.orientation = Eigen::Quaterniond(frames_[goal.joint].linear()).normalized();
  setOrientation(*dragged_, worldRotation * goal.orientation);
}

void Session::endDrag() {
  if (!dragged_) return;
  const int goal = *dragged_;
  dragged_.reset();
  if (!dragMoved_ && goals_[goal].handle && !past_.empty()) {
    goals_[goal] = past_.back().goals[goal];
    past_.pop_back();
    return;
  }
  if (afterDrag_ == GoalState::Free)
    removeGoal(goal);
  else
    setState(goal, afterDrag_);
}

// --- history

void Session::remember() {
  past_.push_back({q_, goals_});
  if (past_.size() > longestHistory) past_.erase(past_.begin());
  future_.clear();
}

void Session::apply(const Snapshot& snapshot) {
  dragged_.reset();
  goals_ = snapshot.goals;
  for (SceneGoal& goal : goals_)
    if (goal.state == GoalState::Dragged) goal.state = GoalState::Held;
  place(snapshot.q);
  solver_->reset();
  lastSolve_ = {};
}

bool Session::undo() {
  if (past_.empty()) return false;
  endDrag();
  future_.push_back({q_, goals_});
  const Snapshot snapshot = std::move(past_.back());
  past_.pop_back();
  apply(snapshot);
  return true;
}

bool Session::redo() {
  if (future_.empty()) return false;
  endDrag();
  past_.push_back({q_, goals_});
  const Snapshot snapshot = std::move(future_.back());
  future_.pop_back();
  apply(snapshot);
  return true;
}

bool Session::canUndo() const { return !past_.empty(); }
bool Session::canRedo() const { return !future_.empty(); }

// --- solver

void Session::setSolver(const std::string& name) {
  solver_ = makeFrameSolver(name, skeleton());
  solverName_ = name == "hybrid" ? "drag" : name;  // as older files call it
}

void Session::nextSolver(int direction) {
  const std::vector<std::string> names = frameSolverNames();
  const int count = static_cast<int>(names.size());
  const int at = static_cast<int>(std::ranges::find(names, solverName_) - names.begin());
  setSolver(names[((at + direction) % count + count) % count]);
}

IkProblem Session::problem() const {
  IkProblem problem{.skeleton = &skeleton(), .start = q_};
  for (const SceneGoal& goal : goals_) {
    if (!isEffective(goal)) continue;
    Goal g = goal.goal;
    const bool pinned = goal.state == GoalState::Pinned;
    g.weight = pinned ? pinWeight : g.kind == GoalKind::Pole ? poleWeight : heldWeight;
    g.role = pinned ? Role::Pin : goal.state == GoalState::Dragged ? Role::Drag : Role::Hold;
    problem.goals.push_back(std::move(g));
  }
  return problem;
}

const FrameSolve& Session::step() {
  anchorSurfaceGoals();
  for (int i = 0; i < static_cast<int>(goals_.size()); ++i)
    if (goals_[i].state == GoalState::Free) goals_[i].goal.target = reached(i);
  const IkProblem problem = this->problem();
  lastSolve_ = {};
  if (problem.goals.empty()) return lastSolve_;

  const IkReport report = solver_->frame(problem);
  lastSolve_.ran = true;
  lastSolve_.why = report.why;
  lastSolve_.iterations = report.counters.iterations;
  lastSolve_.seconds = report.seconds;
  for (const IterationRecord& record : report.trace) lastSolve_.residuals.push_back(record.residual);
  lastSolve_.residuals.push_back(report.residual);
  if (report.why == Stop::Unsupported) lastSolve_.unsupported = makeUnsupportedReason(problem);
  if (report.q.size() == q_.size() && report.q.allFinite()) {
    lastSolve_.jointMotion = largestMotion(skeleton(), q_, report.q);
    place(report.q);
  } else {
    lastSolve_.why = Stop::Failure;
  }
  for (int i = 0; i < static_cast<int>(goals_.size()); ++i) {
    if (isEffective(goals_[i])) lastSolve_.error = std::max(lastSolve_.error, error(i));
    if (goals_[i].state == GoalState::Free) goals_[i].goal.target = reached(i);
  }
  return lastSolve_;
}

std::string Session::makeUnsupportedReason(const IkProblem& problem) const {
  return solverName_ == "drag" ? std::string() : makeSolver(solverName_)->whyUnsupported(problem);
}

std::vector<bool> Session::jointsAtLimit() const {
  std::vector<bool> at(skeleton().jointCount(), false);
  for (int i = 0; i < skeleton().jointCount(); ++i) {
    const Joint& joint = skeleton().joint(i);
    for (std::size_t k = 0; k < joint.axes.size(); ++k)
      at[i] = at[i] || axisAtLimit(joint.axes[k], q_[skeleton().qIndex(i) + static_cast<int>(k)]);
    if (joint.ballLimit) at[i] = at[i] || ballAtLimit(*joint.ballLimit, ballRotation(skeleton(), q_, i));
  }
  return at;
}

// --- scene

void Session::store(Scene& scene) const {
  scene.q = q_;
  scene.goals = goals_;
  if (dragged_) scene.goals[*dragged_].state = afterDrag_ == GoalState::Free ? GoalState::Held : afterDrag_;
  scene.solver = solverName_;
}

void Session::restore(const Scene& scene) {
  for (const SceneGoal& goal : scene.goals)
    if (goal.surface.triangle >= 0 &&
        (!model_->skin || goal.surface.triangle >= static_cast<int>(model_->skin->mesh.triangles.size())))
      throw std::invalid_argument(
          fmt::format("goal {}: the model's skin has no triangle {}", goal.goal.name, goal.surface.triangle));
  setSolver(scene.solver);
  remember();
  apply({scene.q, scene.goals});
}

}  // namespace gelenk
