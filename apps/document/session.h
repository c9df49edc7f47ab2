#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "apps/document/document.h"
#include "apps/document/history.h"
#include "apps/document/model.h"
#include "kinematics/forward_kinematics.h"
#include "skinning/blend/linear_blend.h"
#include "skinning/rigging/weight_paint.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/problem/judge.h"

namespace gelenk {

/// One method of following goals from frame to frame: the stateful drag solver, or a catalogue solver started
/// warm.
class FrameSolver {
 public:
  virtual ~FrameSolver() = default;
  /// One frame: from problem.start towards the goals. trace: at least the residuals.
  virtual IkReport frame(const IkProblem& problem) = 0;
  /// The pose was changed by something else than frame(): forget what was carried over.
  virtual void reset() {}
  /// What the pose is pulled towards where the goals leave it free (nq), of solvers that pull; the rest pose
  /// at the beginning.
  virtual void setPosture(const Eigen::VectorXd& /*q*/) {}
};

/// Names that makeFrameSolver knows, with or without values of parameters in brackets (ik_solver.h): "drag"
/// (the drag solver, the default) and every entry of solverCatalogue().
std::vector<std::string> frameSolverNames();
/// The solver keeps the skeleton alive. Throws std::invalid_argument that lists the names there are.
std::unique_ptr<FrameSolver> makeFrameSolver(const std::string& name,
                                             std::shared_ptr<const Skeleton> skeleton);

/// What the last solved frame did; all facts are recomputed by forward kinematics outside the solver
/// (judge.h).
struct FrameSolve {
  bool ran = false;  ///< false: nothing was held, nothing to solve
  Stop why = Stop::Converged;
  int iterations = 0;
  double seconds = 0.0;           ///< of the solver's call; not part of the status file
  double error = 0.0;             ///< largest position error of the goals in the solve, metres
  double orientationError = 0.0;  ///< largest orientation or aim error, radians
  bool reached = false;           ///< every goal within Session::reachedWithin() and reachedAngle
  bool outOfReach = false;        ///< at rest short of the goals, and no pose nearby comes closer
  double jointMotion = 0.0;  ///< largest change of a rotation (radians) or translation (metres) this frame
  std::vector<double> residuals;  ///< weighted residual norm before each iteration, then after the last
  std::string unsupported;        ///< why the solver does not do this problem; empty where it does
};

struct JointGrip {
  int joint = 0;
};
class ChosenSkin;

/// What a press takes: a goal, a joint's origin or a point of the skin, for which a goal is made.
using Grip = std::variant<GoalId, JointGrip, SurfacePoint>;

/// A document being worked on, without window or OpenGL: model, document, history, solver, and the step of a
/// frame. The model and its skeleton stay what and where they are for the session's life.
///
/// A drag: begin (a handle, a joint, a point of the skin) -> move the target, frame by frame -> end. A handle
/// that is let go stays held at its target; other points let go entirely unless they are pinned. Every edit
/// can be undone.
class Session {
 public:
  /// A new document: rest pose, handles, those pinned that the model names.
  explicit Session(Model model);
  Session(std::shared_ptr<const Model> model, const ModelReference& reference);
  /// A document of the model, such as a scene's; without goals it gets the model's handles. Throws
  /// std::invalid_argument for a solver that is not there.
  Session(std::shared_ptr<const Model> model, Document document);
  ~Session();
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;

  // --- the document. What undo goes through (edits) is changed by the methods below, the rest directly.
  const Document& document() const { return document_; }
  const Edits& edits() const { return document_.edits; }
  View& view() { return document_.view; }
  SkinChoice& skinChoice() { return document_.skin; }
  void chooseSkin(const SkinChoice& choice) { gelenk::chooseSkin(document_, *model_, choice); }
  Theme& theme() { return document_.theme; }
  Playback& playback() { return document_.playback; }
  LabSettings& lab() { return document_.lab; }
  LectureState& lecture() { return document_.lecture; }
  /// To be written to a file: what is being dragged stands held.
  Document saved() const;
  std::optional<int> selectedJoint() const { return skeleton().findJoint(document_.view.selectedJoint); }
  void selectJoint(std::optional<int> joint) {
    document_.view.selectedJoint = joint ? skeleton().joint(*joint).name : std::string();
  }

  std::shared_ptr<const Model> sharedModel() const { return model_; }
  /// As it was opened; edits are not in it.
  const Model& model() const { return *model_; }
  const Skeleton& skeleton() const { return model_->skeleton; }
  /// For those who may outlive the session.
  std::shared_ptr<const Skeleton> sharedSkeleton() const { return {model_, &model_->skeleton}; }

  // --- weights
  /// The model's skin with the weights as they were edited; nullptr without a skin. Stays at its address.
  const Skin* skin() const { return skin_.get(); }
  /// Puts new weights of some vertices in effect. remember() comes first, once a stroke. Throws
  /// std::invalid_argument for a vertex that is not there.
  void changeWeights(const WeightChange& change);
  int weightsVersion() const { return weightsVersion_; }  ///< counts the changes
  /// While weights are being painted the skin is a plain linear blend, which needs the least of it.
  void setPainting(bool painting) { painting_ = painting; }

  // --- muscles and motion; remember() comes first, once a move of a slider
  void setMuscles(std::shared_ptr<const MuscleSettings> muscles) {
    document_.edits.muscles = std::move(muscles);
  }
  void setClip(std::shared_ptr<const ClipEdits> clip) { document_.edits.clip = std::move(clip); }
  double& playhead() { return document_.edits.seconds; }  ///< seconds; no edit of its own

  // --- pose
  const Eigen::VectorXd& q() const { return edits().q; }
  const Frames& frames() const { return frames_; }
  /// Poses the model directly (sliders, keyframes, playback). Held goals and pins go along: their targets
  /// become the points reached. q: nq; projected to the limits. Throws std::invalid_argument on a wrong
  /// length or values that are not finite.
  void setPose(const Eigen::VectorXd& q);
  /// What a solver that pulls (drag) pulls towards; the rest pose by default. No part of the document: who
  /// shows another pose, such as a clip's, says so.
  void setPosture(const Eigen::VectorXd& q);
  void resetPose();  ///< rest pose, only the handles pinned at the beginning are pinned
  /// Left and right change places, see kinematics/symmetry.h; goals of points, orientations and poles go
  /// along, others ask for what is then. Throws std::invalid_argument where the model is not symmetric.
  void mirrorPose();
  /// The goal that has, after mirrorPose(), what this one asked for: the other side's handle, else itself.
  GoalId mirrored(GoalId id) const;

  // --- goals: an id that no goal has any more throws std::invalid_argument
  const std::vector<SceneGoal>& goals() const { return edits().goals; }
  bool hasGoal(GoalId goal) const;
  const SceneGoal& goal(GoalId goal) const;
  std::optional<GoalId> findGoal(const std::string& name) const;
  /// Where the goal's point is now, metres, world. Points of the skin as the document's method and layers
  /// carry them.
  Eigen::Vector3d reached(GoalId goal) const;
  /// What the judge says of the goal in the present pose; zero for a free handle.
  GoalError judged(GoalId goal) const;
  double error(GoalId goal) const { return judged(goal).position; }  ///< metres
  /// A goal at a joint's origin / at a point of the skin, held at its present place; an existing one where
  /// there is.
  GoalId addJointGoal(int joint);
  GoalId addSurfaceGoal(const SurfacePoint& point);
  /// Any goal, held. A repeated name gets a number.
  GoalId addGoal(Goal goal);
  /// A goal of the kind on a joint (another one for goals between two), met where the model is. Throws
  /// std::invalid_argument where the model has none.
  GoalId addGoalOf(GoalKind kind, int joint, int otherJoint);
  /// What a goal asks for, as a whole; kind and name stay. Throws std::invalid_argument, changing nothing,
  /// where it cannot be asked of the model.
  void changeGoal(GoalId goal, const Goal& asked);
  /// What the goal looks like (GoalType::mark).
  GoalMark mark(GoalId goal) const;
  void setTarget(GoalId goal, const Eigen::Vector3d& target);  ///< metres, world; a free goal becomes held
  void setOrientation(GoalId goal, const Eigen::Quaterniond& orientation);  ///< makes it a pose goal
  void clearOrientation(GoalId goal);
  void setState(GoalId goal, GoalState state);
  /// A pin holds its point where it is, also where a goal was missed: another pin is then never pulled away.
  GoalId togglePin(const Grip& grip);
  void freePins();  ///< one edit
  /// On the squared error, above 0, beside what the state brings. remember() comes first, once a move of a
  /// slider. Throws std::invalid_argument.
  void setWeight(GoalId goal, double weight);
  /// Handles become free, others vanish.
  void removeGoal(GoalId goal);
  void removeAllGoals();

  // --- dragging
  GoalId beginDrag(const Grip& grip);
  void moveDrag(const Eigen::Vector3d& target);
  void rotateDrag(const Eigen::Quaterniond& worldRotation);  ///< turns the wanted orientation
  void endDrag();     ///< an edit if the target moved, as if nothing had happened otherwise
  void cancelDrag();  ///< back to how it was before the press
  std::optional<GoalId> dragged() const { return drag_ ? std::optional(drag_->goal) : std::nullopt; }

  // --- history: every edit begins with remember(); the mutators above that start an edit do so themselves
  void remember() { history_.remember(edits()); }
  /// Where the edit turned out to be one after it was made.
  void rememberAs(Edits before) { history_.remember(std::move(before)); }
  bool undo();
  bool redo();
  int editCount() const { return history_.steps(); }  ///< grows with every edit, undo and redo
  bool canUndo() const { return history_.canUndo() || (drag_ && drag_->moved); }
  bool canRedo() const { return history_.canRedo(); }
  int jumps() const { return jumps_; }  ///< counts undo, redo and cancelled drags

  // --- solver
  const std::string& solver() const { return document_.solver.name; }
  /// A name, or a name and values of its parameters in brackets, which it keeps from then on. Throws
  /// std::invalid_argument that lists what there is.
  void setSolver(const std::string& text);
  /// Those of the present solver that are away from their defaults, and others in their place. Throws
  /// likewise.
  ParameterValues parameters() const;
  void setParameters(const ParameterValues& values);
  void nextSolver(int direction = 1);  ///< the next one that can do the present goals
  enum class Pins { AsTheyAre, Freed };
  /// Why the solver cannot do the present goals; empty: it can.
  std::string whyUnsupported(const std::string& solver, Pins pins = Pins::AsTheyAre) const;
  /// Whether the model can keep its balance (masses and soles), and whether it shall.
  bool canBalance() const { return model_->masses && !model_->soles.empty(); }
  bool balance() const { return document_.solver.balance && canBalance(); }
  void setBalance(bool balance);
  /// What balance() adds to the problem, while it stands.
  std::optional<Goal> balanceGoal() const;

  /// One frame: solve towards the goals, warm from the present pose. A document that was opened stands as it
  /// was saved until something of its pose, goals, weights or solver is changed.
  const FrameSolve& step();
  const FrameSolve& lastSolve() const { return lastSolve_; }
  /// The problem that step() solves: the goals that take part, with their weights.
  IkProblem problem() const;
  /// A goal counts as reached within a thousandth of a metre, or of the model's reach where that is longer,
  /// and within reachedAngle.
  double reachedWithin() const { return reachedWithin_; }
  static constexpr double reachedAngle = 0.01;

  /// Radians (or metres for translations) from the nearest limit below which a joint counts as being at it.
  static constexpr double limitMargin = 1e-3;
  /// For each joint whether it lies at one of its limits.
  std::vector<bool> jointsAtLimit() const;

 private:
  struct Drag {
    GoalId goal;
    GoalState after = GoalState::Held;
    bool moved = false;
    Edits before;  ///< the press
  };
  void apply(const Edits& edits);
  void makeHandles();
  void followPose();
  void anchorSurfaceGoals();
  void judgeFrame();
  void place(const Eigen::VectorXd& q);
  SceneGoal& at(GoalId goal);
  GoalId goalOf(const Grip& grip);
  void pinHere(GoalId goal);
  GoalId addSceneGoal(SceneGoal goal);
  Eigen::Vector3d reached(const SceneGoal& goal) const;
  void holdHere(SceneGoal& goal) const;
  GoalPlace here() const { return {skeleton(), q(), frames_}; }
  void updateSupport();
  Eigen::Vector3d skinPoint(const SurfacePoint& point) const;
  const ChosenSkin& drawnSkin() const;
  void mirrorGoals(const Frames& before);
  bool restsOutOfReach(const IkProblem& problem);

  std::shared_ptr<const Model> model_;
  std::unique_ptr<Skin> skin_;
  int weightsVersion_ = 0, jumps_ = 0;
  bool painting_ = false;
  struct DrawnSkin;  ///< made when a point of the skin is first asked for
  mutable std::unique_ptr<DrawnSkin> drawn_;
  Document document_;
  History<Edits> history_;
  Frames frames_;
  int lastId_ = 0;
  std::optional<Drag> drag_;
  std::unique_ptr<FrameSolver> solver_;
  Eigen::VectorXd posture_;  ///< that it pulls towards
  FrameSolve lastSolve_;
  std::vector<Eigen::Vector3d> standing_, support_;  ///< soles on the ground; their hull, inset
  bool asOpened_ = false;
  Eigen::VectorXd restedAt_;  ///< where it was last asked whether a pose nearby comes closer
  bool restedOutOfReach_ = false;
  double reachedWithin_ = 1e-3;
};

}  // namespace gelenk
