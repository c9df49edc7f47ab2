#include "apps/document/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "apps/document/chosen_skin.h"
#include "apps/document/limb.h"
#include "apps/document/pick.h"
#include "kinematics/configuration.h"
#include "kinematics/rotation.h"
#include "kinematics/symmetry.h"
#include "skinning/io/skin_cache.h"
#include "solvers/iteration/attempt.h"
#include "solvers/problem/goal_text.h"
#include "solvers/problem/support.h"

namespace gelenk {
namespace {

constexpr double pinnedWithin = 3e-4;  // metres: a pin that is missed by more is put where its point is

bool has(const Goal& goal, GoalField::Meaning meaning) {
  return std::ranges::any_of(goalType(goal.kind).fields,
                             [&](const GoalField& field) { return field.meaning == meaning; });
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

/// The skeleton's ends that something moves: a frame of a robot's base is nothing to drag. All of them where
/// nothing moves.
std::vector<int> endEffectors(const Skeleton& skeleton) {
  std::vector<bool> moves(skeleton.jointCount(), false);
  std::vector<int> ends, moved;
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const int parent = skeleton.parent(i);
    moves[i] = skeleton.vCount(i) > 0 || skeleton.joint(i).coupling || (parent >= 0 && moves[parent]);
    if (!skeleton.children(i).empty()) continue;
    ends.push_back(i);
    if (moves[i]) moved.push_back(i);
  }
  return moved.empty() ? ends : moved;
}

}  // namespace

struct Session::DrawnSkin {
  SkinChoice choice;
  int version;  ///< of the weights
  std::shared_ptr<const MuscleSettings> settings;
  ChosenSkin skin;
};

Session::Session(Model model) : Session(std::make_shared<const Model>(std::move(model)), ModelReference{}) {
  document_.model.nameOrFile = model_->name;
}

Session::Session(std::shared_ptr<const Model> model, const ModelReference& reference)
    : Session(model, newDocument(*model, reference)) {
  resetPose();
  history_.clear();
}

Session::Session(std::shared_ptr<const Model> model, Document document)
    : model_(std::move(model)), document_(std::move(document)) {
  if (model_->skin) {
    skin_ = std::make_unique<Skin>(*model_->skin);
    for (int v = 0; v < edits().weights.size(); ++v) skin_->influences[v] = edits().weights[v];
  }
  double reach = 1.0;
  for (int i = 0; i < skeleton().jointCount(); ++i) reach = std::max(reach, chainLength(skeleton(), i));
  reachedWithin_ = 1e-3 * reach;
  posture_ = skeleton().rest();
  setSolver(document_.solver.name);
  for (const SceneGoal& goal : goals()) lastId_ = std::max(lastId_, static_cast<int>(goal.id));
  if (goals().empty()) makeHandles();
  place(Eigen::VectorXd(q()));
  asOpened_ = true;
}
Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

// --- weights

void Session::changeWeights(const WeightChange& change) {
  for (const auto& [vertex, influences] : change)
    if (vertex < 0 || vertex >= document_.edits.weights.size())
      throw std::invalid_argument(fmt::format("weights of vertex {} for a skin of {} vertices", vertex,
                                              document_.edits.weights.size()));
  for (const auto& [vertex, influences] : change) {
    document_.edits.weights.set(vertex, influences);
    skin_->influences[vertex] = influences;
  }
  ++weightsVersion_;
  asOpened_ = false;
  anchorSurfaceGoals();
}

// --- pose

void Session::place(const Eigen::VectorXd& q) {
  asOpened_ = false;
  document_.edits.q = q;
  skeleton().couple(document_.edits.q);
  forwardKinematics(skeleton(), document_.edits.q, frames_);
  anchorSurfaceGoals();
}

/// The goal asks for what is now.
void Session::holdHere(SceneGoal& goal) const { goalType(goal.goal.kind).capture(goal.goal, here()); }

/// After the pose was set directly: targets, orientations and anchors become what they are now.
void Session::followPose() {
  for (SceneGoal& goal : document_.edits.goals) {
    if (goalType(goal.goal.kind).movesWithPose) holdHere(goal);
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

void Session::setPosture(const Eigen::VectorXd& q) {
  solver_->setPosture(q);
  posture_ = q;
}

void Session::resetPose() {
  endDrag();
  remember();
  std::erase_if(document_.edits.goals, [](const SceneGoal& goal) { return !goal.handle; });
  for (SceneGoal& goal : document_.edits.goals) {
    goal.state = GoalState::Free;
    if (goal.goal.kind == GoalKind::Pose) goal.goal.kind = GoalKind::Position;
  }
  place(skeleton().rest());
  setPosture(skeleton().rest());
  followPose();
  for (const SceneGoal& goal : document_.edits.goals)
    if (std::ranges::count(model_->pins, goal.goal.name) > 0) setState(goal.id, GoalState::Pinned);
  lastSolve_ = {};
}

void Session::mirrorPose() {
  endDrag();
  const Eigen::VectorXd mirrored = gelenk::mirrorPose(skeleton(), q());
  const Frames before = frames_;
  remember();
  place(projectToLimits(skeleton(), mirrored));
  mirrorGoals(before);
  solver_->reset();
}

namespace {

bool mirrors(const SceneGoal& goal) {
  return goal.goal.kind == GoalKind::Position || goal.goal.kind == GoalKind::Pose ||
         goal.goal.kind == GoalKind::Orientation || goal.goal.kind == GoalKind::Pole;
}

/// The handle at the partner of this one's joint; the end where it is no handle or there is none.
std::vector<SceneGoal>::const_iterator handleOfOtherSide(const std::vector<SceneGoal>& goals,
                                                         const SceneGoal& goal,
                                                         const std::vector<int>& partners) {
  if (!goal.handle) return goals.end();
  return std::ranges::find_if(goals, [&](const SceneGoal& other) {
    return other.handle && mirrors(other) && other.goal.joint == partners[goal.goal.joint] &&
           (other.goal.kind == GoalKind::Pole) == (goal.goal.kind == GoalKind::Pole);
  });
}

}  // namespace

GoalId Session::mirrored(GoalId id) const {
  const SceneGoal& goal = this->goal(id);
  const auto partner = handleOfOtherSide(goals(), goal, mirrorPartners(skeleton()));
  return mirrors(goal) && partner != goals().end() ? partner->id : id;
}

/// What a goal asked of one side it asks of the other. The frames of two partners are no reflections of each
/// other; those of the body before and after are: an orientation keeps its turn from the one reached.
void Session::mirrorGoals(const Frames& before) {
  const std::vector<int> partners = mirrorPartners(skeleton());
  const auto reflected = [](const Eigen::Vector3d& p) { return Eigen::Vector3d(-p.x(), p.y(), p.z()); };
  const std::vector<SceneGoal> old = document_.edits.goals;
  for (SceneGoal& goal : document_.edits.goals) {
    if (!mirrors(goal)) {
      if (goalType(goal.goal.kind).movesWithPose) holdHere(goal);
      continue;
    }
    // A handle takes over from the handle of the other side, another goal goes there itself.
    const auto partner = handleOfOtherSide(old, goal, partners);
    const SceneGoal& from = partner != old.end() ? *partner : old[&goal - document_.edits.goals.data()];
    const int joint = goal.handle ? goal.goal.joint : partners[goal.goal.joint];
    goal.state = from.state;
    goal.weight = from.weight;
    goal.goal.kind = from.goal.kind;
    goal.goal.pointInJoint =
        frames_[joint].inverse() * reflected(before[from.goal.joint] * from.goal.pointInJoint);
    if (goal.handle && partner == old.end()) continue;  // no handle there: it stays what it was
    goal.goal.joint = joint;
    goal.surface = {};  // which triangle is the other side's is not known
    goal.goal.target = reflected(from.goal.target);
    const Eigen::AngleAxisd turn(from.goal.orientation *
                                 Eigen::Quaterniond(before[from.goal.joint].linear()).conjugate());
    const Eigen::AngleAxisd turned(-turn.angle(), reflected(turn.axis()));
    goal.goal.orientation = Eigen::Quaterniond(turned * frames_[joint].linear()).normalized();
  }
  anchorSurfaceGoals();
}

// --- goals

GoalId Session::addSceneGoal(SceneGoal goal) {
  asOpened_ = false;
  goal.id = GoalId{++lastId_};
  document_.edits.goals.push_back(std::move(goal));
  return document_.edits.goals.back().id;
}

void Session::makeHandles() {
  std::vector<int> joints;
  for (const std::string& name : model_->handles) joints.push_back(skeleton().jointIndex(name));
  if (joints.empty()) joints = endEffectors(skeleton());
  for (const int joint : joints)
    addSceneGoal({.goal = {.name = skeleton().joint(joint).name, .joint = joint}, .handle = true});
  for (const int joint : joints)
    if (const auto middle = limbMiddle(skeleton(), joint))
      if (const std::string name = skeleton().joint(*middle).name + "_pole"; !findGoal(name))
        addSceneGoal({.goal = {.kind = GoalKind::Pole, .name = name, .joint = *middle}, .handle = true});
}

bool Session::hasGoal(GoalId id) const {
  return std::ranges::any_of(goals(), [&](const SceneGoal& goal) { return goal.id == id; });
}

const SceneGoal& Session::goal(GoalId id) const {
  const auto found = std::ranges::find(goals(), id, &SceneGoal::id);
  if (found == goals().end())
    throw std::invalid_argument(fmt::format("there is no goal {} any more", static_cast<int>(id)));
  return *found;
}
SceneGoal& Session::at(GoalId id) {
  asOpened_ = false;
  return const_cast<SceneGoal&>(std::as_const(*this).goal(id));
}

std::optional<GoalId> Session::findGoal(const std::string& name) const {
  for (const SceneGoal& goal : goals())
    if (goal.goal.name == name) return goal.id;
  return std::nullopt;
}

const ChosenSkin& Session::drawnSkin() const {
  SkinChoice choice = chosenSkin(document_);
  const auto& settings = edits().muscles;
  if (drawn_ && drawn_->choice == choice && drawn_->version == weightsVersion_) {
    if (drawn_->settings == settings) return drawn_->skin;
    if (choice.layers == SkinLayers::None || sameProportions(*drawn_->settings, *settings)) {
      drawn_->settings = settings;
      if (settings) drawn_->skin.setControls(*settings);
      return drawn_->skin;
    }
  }
  const std::string cache = weightsVersion_ == 0 ? cacheFolder() : "";
  const auto make = [&](const SkinChoice& made) {
    return ChosenSkin(*model_, *skin_, made, settings.get(), cache);
  };
  try {
    drawn_ = std::make_unique<DrawnSkin>(DrawnSkin{choice, weightsVersion_, settings, make(choice)});
  } catch (const std::invalid_argument&) {  // planes that cross: the picture shows no layers either
    SkinChoice without = choice;
    without.layers = SkinLayers::None;
    drawn_ = std::make_unique<DrawnSkin>(DrawnSkin{choice, weightsVersion_, settings, make(without)});
  }
  return drawn_->skin;
}

Eigen::Vector3d Session::skinPoint(const SurfacePoint& point) const {
  if (painting_) return linearBlendPoint(*skin_, frames_, point);
  SkinnedVertices at;
  drawnSkin().verticesOf(skin_->mesh.triangles[point.triangle]).pose(frames_, &q(), at, SkinNormals::Cheap);
  return point.barycentric[0] * at.positions[0] + point.barycentric[1] * at.positions[1] +
         point.barycentric[2] * at.positions[2];
}

/// The skin's point moves in its joint's frame as the pose changes; solver and judge need it as a point
/// fixed to that joint.
void Session::anchorSurfaceGoals() {
  for (SceneGoal& goal : document_.edits.goals)
    if (goal.surface.triangle >= 0)
      goal.goal.pointInJoint = frames_[goal.goal.joint].inverse() * skinPoint(goal.surface);
}

Eigen::Vector3d Session::reached(const SceneGoal& goal) const {
  if (goal.surface.triangle >= 0) return skinPoint(goal.surface);
  const GoalType& type = goalType(goal.goal.kind);
  return type.handleAtTarget ? goal.goal.target : type.reached(goal.goal, here());
}
Eigen::Vector3d Session::reached(GoalId id) const { return reached(goal(id)); }

GoalError Session::judged(GoalId id) const {
  const SceneGoal& goal = this->goal(id);
  if (!isEffective(goal)) return {};
  const IkProblem alone{.skeleton = &skeleton(), .start = q(), .goals = {goal.goal}};
  const Judgement verdict = judge(alone, q());
  return verdict.goals.empty() ? GoalError{} : verdict.goals.front();
}

GoalId Session::addGoal(Goal goal) {
  const std::string base = goal.name.empty() ? skeleton().joint(goal.joint).name : goal.name;
  goal.name = base;
  for (int n = 2; findGoal(goal.name); ++n) goal.name = fmt::format("{} {}", base, n);
  return addSceneGoal({.goal = std::move(goal), .state = GoalState::Held});
}

GoalId Session::addGoalOf(GoalKind kind, int joint, int otherJoint) {
  const GoalType& type = goalType(kind);
  Goal goal{.kind = kind,
            .name = std::string(type.title),
            .joint = joint,
            .otherJoint = otherJoint,
            .direction = model_->up,
            .masses = model_->masses};
  if (const std::string why = whyMisplaced(goal, skeleton()); !why.empty()) throw std::invalid_argument(why);
  if (kind == GoalKind::Balance)
    for (const FootPoint& sole : model_->soles) goal.polygon.push_back(frames_[sole.joint] * sole.inJoint);
  goal.target = type.reached(goal, here());
  type.capture(goal, here());
  if (const std::string why = whyInvalid(goal, skeleton()); !why.empty()) throw std::invalid_argument(why);
  return addGoal(std::move(goal));
}

void Session::changeGoal(GoalId id, const Goal& asked) {
  SceneGoal& goal = at(id);
  Goal changed = asked;
  changed.kind = goal.goal.kind;
  changed.name = goal.goal.name;
  changed.masses = model_->masses;
  if (const std::string why = whyInvalid(changed, skeleton()); !why.empty()) throw std::invalid_argument(why);
  normaliseDirections(changed);
  goal.goal = std::move(changed);
  if (goal.state == GoalState::Free) goal.state = GoalState::Held;
}

GoalMark Session::mark(GoalId id) const {
  GoalMark mark;
  const Goal& goal = this->goal(id).goal;
  goalType(goal.kind).mark(goal, here(), mark);
  return mark;
}

GoalId Session::addJointGoal(int joint) {
  for (const SceneGoal& goal : goals())
    if (goal.goal.joint == joint && goal.goal.pointInJoint.isZero() &&
        (goal.goal.kind == GoalKind::Position || goal.goal.kind == GoalKind::Pose))
      return goal.id;
  const GoalId id = addGoal({.joint = joint});
  holdHere(at(id));
  return id;
}

GoalId Session::addSurfaceGoal(const SurfacePoint& point) {
  const int joint = dominantJoint(*skin_, point);
  const GoalId id = addGoal({.name = skeleton().joint(joint).name + " skin", .joint = joint});
  at(id).surface = point;
  anchorSurfaceGoals();
  holdHere(at(id));
  return id;
}

GoalId Session::goalOf(const Grip& grip) {
  if (const GoalId* id = std::get_if<GoalId>(&grip)) return goal(*id).id;
  if (const JointGrip* joint = std::get_if<JointGrip>(&grip)) return addJointGoal(joint->joint);
  return addSurfaceGoal(std::get<SurfacePoint>(grip));
}

void Session::setTarget(GoalId id, const Eigen::Vector3d& target) {
  SceneGoal& goal = at(id);
  goal.goal.target = target;
  if (goal.state == GoalState::Free) goal.state = GoalState::Held;
}

void Session::setOrientation(GoalId id, const Eigen::Quaterniond& orientation) {
  Goal& goal = at(id).goal;
  if (goal.kind == GoalKind::Position) goal.kind = GoalKind::Pose;
  goal.orientation = orientation.normalized();
}

void Session::clearOrientation(GoalId id) {
  Goal& goal = at(id).goal;
  if (goal.kind == GoalKind::Pose) goal.kind = GoalKind::Position;
}

void Session::setState(GoalId id, GoalState state) {
  SceneGoal& g = at(id);
  const bool wasFree = g.state == GoalState::Free;
  g.state = state;
  if (wasFree && goalType(g.goal.kind).movesWithPose) holdHere(g);
  // A pinned foot keeps its sole on the ground: handles other than the root's are pinned with their
  // orientation, where there are joints enough for it.
  if (g.goal.kind == GoalKind::Position && state == GoalState::Pinned && g.handle &&
      skeleton().parent(g.goal.joint) >= 0 && !model_->planar && skeleton().nv() >= 12) {
    g.goal.kind = GoalKind::Pose;
    g.goal.orientation = Eigen::Quaterniond(frames_[g.goal.joint].linear()).normalized();
  }
  if (state == GoalState::Free && g.goal.kind == GoalKind::Pose) g.goal.kind = GoalKind::Position;
}

GoalId Session::togglePin(const Grip& grip) {
  if (drag_ && std::get_if<GoalId>(&grip) && std::get<GoalId>(grip) == drag_->goal) {
    drag_->moved = true;
    drag_->after = drag_->after == GoalState::Pinned ? GoalState::Held : GoalState::Pinned;
    return drag_->goal;
  }
  remember();
  const GoalId id = goalOf(grip);
  if (goal(id).state != GoalState::Pinned)
    pinHere(id);
  else
    removeGoal(id);
  return id;
}

void Session::pinHere(GoalId id) {
  setState(id, GoalState::Pinned);
  SceneGoal& goal = at(id);
  if (judged(id).position > pinnedWithin && goalType(goal.goal.kind).movesWithPose) holdHere(goal);
}

void Session::freePins() {
  endDrag();
  remember();
  const std::vector<SceneGoal> all = goals();
  for (const SceneGoal& goal : all)
    if (goal.state == GoalState::Pinned) removeGoal(goal.id);
}

void Session::setWeight(GoalId id, double weight) {
  if (!(weight > 0.0 && weight <= 1e6))
    throw std::invalid_argument(fmt::format("a goal's weight is above 0 and at most 1e6, not {}", weight));
  at(id).weight = weight;
}

void Session::removeGoal(GoalId id) {
  if (dragged() == id) drag_.reset();
  SceneGoal& goal = at(id);
  if (goal.handle) {
    setState(id, GoalState::Free);
    goal.goal.target = reached(goal);
  } else {
    std::erase_if(document_.edits.goals, [&](const SceneGoal& other) { return other.id == id; });
  }
}

void Session::removeAllGoals() {
  endDrag();
  remember();
  std::erase_if(document_.edits.goals, [](const SceneGoal& goal) { return !goal.handle; });
  for (const SceneGoal& goal : document_.edits.goals) removeGoal(goal.id);
}

// --- dragging

GoalId Session::beginDrag(const Grip& grip) {
  endDrag();
  Drag drag{.goal = {}, .before = document_.edits};
  drag.goal = goalOf(grip);
  if (const Goal& asked = goal(drag.goal).goal;
      !has(asked, GoalField::Meaning::Target) && asked.kind != GoalKind::Orientation) {
    // Nothing of it can be moved: take the point that it holds.
    const bool whole = !has(asked, GoalField::Meaning::Joint);
    drag.goal =
        addGoal({.joint = whole ? 0 : asked.joint,
                 .pointInJoint = whole ? frames_[0].inverse() * reached(drag.goal) : asked.pointInJoint});
  }
  SceneGoal& g = at(drag.goal);
  // Points made for this drag go with it; what was pinned stays pinned; handles stay where they are put.
  drag.after = g.state == GoalState::Pinned ? GoalState::Pinned
               : g.handle                   ? GoalState::Held
                                            : GoalState::Free;
  if (g.state == GoalState::Free || (goalType(g.goal.kind).movesWithPose && g.goal.kind != GoalKind::Pole))
    g.goal.target = reached(g);
  if (g.goal.kind == GoalKind::Pose)
    g.goal.orientation = Eigen::Quaterniond(frames_[g.goal.joint].linear()).normalized();
  g.state = GoalState::Dragged;
  drag_ = std::move(drag);
  return drag_->goal;
}

void Session::moveDrag(const Eigen::Vector3d& target) {
  if (!drag_ || !target.allFinite()) return;
  Goal& goal = at(drag_->goal).goal;
  // A pixel's ray gives the start back only to rounding.
  drag_->moved = drag_->moved || (target - goal.target).norm() > 1e-9 * (1.0 + target.norm());
  goal.target = target;
}

void Session::rotateDrag(const Eigen::Quaterniond& worldRotation) {
  if (!drag_) return;
  const Goal& asked = goal(drag_->goal).goal;
  if (!has(asked, GoalField::Meaning::Rotation) && asked.kind != GoalKind::Position) return;
  Goal& goal = at(drag_->goal).goal;
  drag_->moved = true;
  if (!has(goal, GoalField::Meaning::Rotation))
    goal.orientation = Eigen::Quaterniond(frames_[goal.joint].linear()).normalized();
  setOrientation(drag_->goal, worldRotation * goal.orientation);
}

void Session::endDrag() {
  if (!drag_) return;
  if (!drag_->moved) return cancelDrag();
  Drag drag = std::move(*drag_);
  drag_.reset();
  history_.remember(std::move(drag.before));
  if (drag.after == GoalState::Free)
    removeGoal(drag.goal);
  else if (drag.after == GoalState::Pinned)
    pinHere(drag.goal);
  else
    setState(drag.goal, drag.after);
}

void Session::cancelDrag() {
  if (!drag_) return;
  const Drag drag = std::move(*drag_);
  drag_.reset();
  if (drag.moved)
    apply(drag.before);
  else
    document_.edits.goals = drag.before.goals;  // the pose may have settled meanwhile
}

// --- history

void Session::apply(const Edits& edits) {
  drag_.reset();
  if (skin_) {
    bool changed = false;
    edits.weights.forUnshared(document_.edits.weights, [&](int vertex, const Influences& influences) {
      skin_->influences[vertex] = influences;
      changed = true;
    });
    weightsVersion_ += changed;
  }
  document_.edits = edits;
  for (SceneGoal& goal : document_.edits.goals) {
    if (goal.state == GoalState::Dragged) goal.state = GoalState::Held;
    lastId_ = std::max(lastId_, static_cast<int>(goal.id));
  }
  place(Eigen::VectorXd(edits.q));
  solver_->reset();
  lastSolve_ = {};
  ++jumps_;
}

bool Session::undo() {
  endDrag();
  const std::optional<Edits> before = history_.undo(document_.edits);
  if (before) apply(*before);
  return before.has_value();
}

bool Session::redo() {
  endDrag();
  const std::optional<Edits> after = history_.redo(document_.edits);
  if (after) apply(*after);
  return after.has_value();
}

// --- solver

void Session::setSolver(const std::string& text) {
  SolverSpec spec = solverSpec(text);
  const std::string name = spec.name;
  if (const auto kept = document_.solver.parameters.find(name); kept != document_.solver.parameters.end())
    for (const auto& [parameter, value] : kept->second)
      if (!spec.values.count(parameter)) spec = withParameter(spec, parameter, value);
  solver_ = makeFrameSolver(toText(spec), sharedSkeleton());
  solver_->setPosture(posture_);
  asOpened_ = false;
  document_.solver.name = name;
  document_.solver.parameters.erase(name);
  if (!spec.values.empty()) document_.solver.parameters[name] = spec.values;
}

ParameterValues Session::parameters() const {
  const auto found = document_.solver.parameters.find(document_.solver.name);
  return found == document_.solver.parameters.end() ? ParameterValues() : found->second;
}

void Session::setParameters(const ParameterValues& values) {
  solverEntry(document_.solver.name).make(values);  // throws before anything is changed
  document_.solver.parameters[document_.solver.name] = values;
  setSolver(std::string(document_.solver.name));
}

void Session::nextSolver(int direction) {
  const std::vector<std::string> names = frameSolverNames();
  const int count = static_cast<int>(names.size());
  const int at = static_cast<int>(std::ranges::find(names, document_.solver.name) - names.begin());
  for (int step = 1; step <= count; ++step)
    if (const std::string& name = names[((at + step * direction) % count + count) % count];
        whyUnsupported(name).empty())
      return setSolver(name);
}

std::string Session::whyUnsupported(const std::string& solver, Pins pins) const {
  IkProblem asked = problem();
  if (pins == Pins::Freed)
    std::erase_if(asked.goals,
                  [](const Goal& goal) { return goal.role == Role::Pin && goal.kind != GoalKind::Balance; });
  return asked.goals.empty() ? std::string() : makeSolver(solver)->whyUnsupported(asked);
}

IkProblem Session::problem() const {
  IkProblem problem{.skeleton = &skeleton(), .start = q()};
  for (const SceneGoal& goal : goals()) {
    if (!isEffective(goal)) continue;
    Goal g = goal.goal;
    const bool pinned = goal.state == GoalState::Pinned;
    g.weight = (pinned ? pinWeight : goalType(g.kind).preference) * goal.weight;
    g.role = pinned ? Role::Pin : goal.state == GoalState::Dragged ? Role::Drag : Role::Hold;
    problem.goals.push_back(std::move(g));
  }
  if (auto standing = balanceGoal()) problem.goals.push_back(*std::move(standing));
  return problem;
}

std::optional<Goal> Session::balanceGoal() const {
  if (!balance() || support_.size() < 3) return std::nullopt;
  return Goal{.kind = GoalKind::Balance,
              .name = "balance",
              .direction = model_->up,
              .polygon = support_,
              .masses = model_->masses,
              .weight = pinWeight,
              .role = Role::Pin};
}

void Session::setBalance(bool balance) {
  asOpened_ = false;
  document_.solver.balance = balance;
}

/// The hull of the soles that stand, 1 cm inwards. Feet that stay keep it, to the last bit.
void Session::updateSupport() {
  if (!balance()) return;
  constexpr double margin = 0.01, standing = 0.03, still = 1e-4;  // metres, as DragOptions::balance has them
  std::vector<Eigen::Vector3d> soles;
  double lowest = std::numeric_limits<double>::infinity();
  for (const FootPoint& sole : model_->soles) {
    soles.push_back(frames_[sole.joint] * sole.inJoint);
    lowest = std::min(lowest, soles.back().dot(model_->up));
  }
  std::erase_if(soles, [&](const Eigen::Vector3d& p) { return p.dot(model_->up) > lowest + standing; });
  bool same = soles.size() == standing_.size();
  for (std::size_t i = 0; same && i < soles.size(); ++i) same = (soles[i] - standing_[i]).norm() < still;
  if (same) return;
  standing_ = std::move(soles);
  support_ = SupportPolygon::hull(standing_, model_->up).inset(margin).corners;
}

const FrameSolve& Session::step() {
  const auto freeFollow = [this] {
    for (SceneGoal& goal : document_.edits.goals)
      if (goal.state == GoalState::Free) goal.goal.target = reached(goal);
  };
  anchorSurfaceGoals();
  freeFollow();
  updateSupport();
  lastSolve_ = {};
  const IkProblem problem = this->problem();
  if (problem.goals.empty()) return lastSolve_;
  if (asOpened_) {
    lastSolve_.ran = true;
    judgeFrame();
    return lastSolve_;
  }

  const IkReport report = solver_->frame(problem);
  lastSolve_.ran = true;
  lastSolve_.why = report.why;
  lastSolve_.iterations = report.counters.iterations;
  lastSolve_.seconds = report.seconds;
  for (const IterationRecord& record : report.trace) lastSolve_.residuals.push_back(record.residual);
  lastSolve_.residuals.push_back(report.residual);
  if (report.why == Stop::Unsupported)
    lastSolve_.unsupported = makeSolver(document_.solver.name)->whyUnsupported(problem);
  if (report.q.size() == q().size() && report.q.allFinite()) {
    lastSolve_.jointMotion = largestMotion(skeleton(), q(), report.q);
    place(report.q);
  } else {
    lastSolve_.why = Stop::Failure;
  }
  freeFollow();
  judgeFrame();
  lastSolve_.outOfReach = restsOutOfReach(problem);
  return lastSolve_;
}

namespace {

double largestError(const IkProblem& problem, const Eigen::VectorXd& q) {
  double error = 0.0;
  for (const GoalError& goal : judge(problem, q).goals) error = std::max(error, goal.position);
  return error;
}

/// A pose that creeps its last micrometres: whether twenty steps of Newton's method from there come closer by
/// less than 0.5 % of the distance.
bool endsAtRestHere(IkProblem problem, const Eigen::VectorXd& q) {
  problem.start = q;
  const auto solver = makeSolver("exact-hessian");
  solver->prepare(*problem.skeleton);
  const IkReport end = solver->solve(problem, {.maxIterations = 20, .maxSeconds = 3600.0}, TraceLevel::Off);
  if (end.why != Stop::Stationary && end.why != Stop::Budget) return false;
  const double here = largestError(problem, q);
  return std::abs(largestError(problem, end.q) - here) < 5e-3 * here;
}

}  // namespace

/// Asked once of a pose that stays.
bool Session::restsOutOfReach(const IkProblem& problem) {
  constexpr double still = 1e-4;  // radians or metres a frame
  if (lastSolve_.reached || lastSolve_.why == Stop::Unsupported || lastSolve_.why == Stop::Failure ||
      lastSolve_.jointMotion > still)
    return false;
  if (lastSolve_.why == Stop::Stationary) return true;
  constexpr double creeping = 1e-5;  // of which is said that it rests
  if (restedAt_.size() != q().size() || restedAt_ != q()) {
    const Stop why = whyAtRest(problem, q());
    restedOutOfReach_ =
        why == Stop::Stationary ||
        (why == Stop::Stalled && lastSolve_.jointMotion < creeping && endsAtRestHere(problem, q()));
  }
  restedAt_ = q();
  return restedOutOfReach_;
}

void Session::judgeFrame() {
  for (const GoalError& goal : judge(problem(), q()).goals) {
    lastSolve_.error = std::max(lastSolve_.error, goal.position);
    lastSolve_.orientationError = std::max(lastSolve_.orientationError, goal.orientation);
  }
  lastSolve_.reached = lastSolve_.error < reachedWithin_ && lastSolve_.orientationError < reachedAngle;
}

std::vector<bool> Session::jointsAtLimit() const {
  std::vector<bool> at(skeleton().jointCount(), false);
  for (int i = 0; i < skeleton().jointCount(); ++i) {
    const Joint& joint = skeleton().joint(i);
    for (std::size_t k = 0; k < joint.axes.size(); ++k)
      at[i] = at[i] || axisAtLimit(joint.axes[k], q()[skeleton().qIndex(i) + static_cast<int>(k)]);
    if (joint.ballLimit) at[i] = at[i] || ballAtLimit(*joint.ballLimit, ballRotation(skeleton(), q(), i));
  }
  return at;
}

Document Session::saved() const {
  Document document = document_;
  for (SceneGoal& goal : document.edits.goals)
    if (dragged() == goal.id) goal.state = drag_->after == GoalState::Free ? GoalState::Held : drag_->after;
  return document;
}

}  // namespace gelenk
