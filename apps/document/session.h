#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/document/model.h"
#include "apps/document/scene.h"
#include "kinematics/forward_kinematics.h"
#include "skinning/blend/linear_blend.h"
#include "solvers/problem/ik_solver.h"

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
};

/// Names that makeFrameSolver knows: "drag" (the drag solver, the default) and every entry of
/// solverCatalogue().
std::vector<std::string> frameSolverNames();
/// Throws std::invalid_argument that lists the names there are.
std::unique_ptr<FrameSolver> makeFrameSolver(const std::string& name, const Skeleton& skeleton);

/// What the last solved frame did; all facts are recomputed by forward kinematics outside the solver.
struct FrameSolve {
  bool ran = false;  ///< false: nothing was held, nothing to solve
  Stop why = Stop::Converged;
  int iterations = 0;
  double seconds = 0.0;      ///< of the solver's call; not part of the status file
  double error = 0.0;        ///< largest position error of the goals in the solve, metres
  double jointMotion = 0.0;  ///< largest change of a rotation (radians) or translation (metres) this frame
  std::vector<double> residuals;  ///< weighted residual norm before each iteration, then after the last
  std::string unsupported;        ///< why the solver does not do this problem; empty where it does
};

/// The state of dragging a model, without window or OpenGL: pose, goals, pins, history, solver, and the step
/// of a frame.
///
/// A drag: begin (a handle, a joint, a point of the skin) -> move the target, frame by frame -> end. A handle
/// that is let go stays held at its target; other points let go entirely unless they are pinned. Every edit
/// can be undone.
class Session {
 public:
  explicit Session(Model model);
  ~Session();
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;

  const Model& model() const { return *model_; }
  const Skeleton& skeleton() const { return model_->skeleton; }
  /// Binds the model's skin anew, one row a vertex: what was model() is replaced. Throws
  /// std::invalid_argument for a model without a skin or another number of rows.
  void setInfluences(std::vector<Influences> influences);

  // --- pose
  const Eigen::VectorXd& q() const { return q_; }
  const Frames& frames() const { return frames_; }
  /// Poses the model directly (sliders, keyframes, playback). Held goals and pins go along: their targets
  /// become the points reached. q: nq; projected to the limits. Throws std::invalid_argument on a wrong
  /// length or values that are not finite.
  void setPose(const Eigen::VectorXd& q);
  void resetPose();  ///< rest pose, only the handles pinned at the beginning are pinned
  /// Left and right change places, see kinematics/symmetry.h. Throws std::invalid_argument where the model is
  /// not symmetric.
  void mirrorPose();

  // --- goals
  const std::vector<SceneGoal>& goals() const { return goals_; }
  /// Index of the goal of that name.
  std::optional<int> findGoal(const std::string& name) const;
  /// Where the goal's point is now, metres, world. Points of the skin by their blend.
  Eigen::Vector3d reached(int goal) const;
  /// Position: |target - reached|; metres. 0 for a free handle.
  double error(int goal) const;
  /// A goal at a joint's origin / at a point of the skin, held at its present place; the index of an existing
  /// one where there is.
  int addJointGoal(int joint);
  int addSurfaceGoal(const SurfacePoint& point);
  /// Any goal (Position, Pose, Pole, Aim), held. A repeated name gets a number.
  int addGoal(Goal goal);
  void setTarget(int goal, const Eigen::Vector3d& target);  ///< metres, world; a free goal becomes held
  void setOrientation(int goal, const Eigen::Quaterniond& orientation);  ///< makes it a pose goal
  void clearOrientation(int goal);
  void setState(int goal, GoalState state);
  void togglePin(int goal);
  /// Handles become free, others vanish. Indices above the goal's move down by one if it vanishes.
  void removeGoal(int goal);
  void removeAllGoals();

  // --- dragging
  void beginDrag(int goal);
  void moveDrag(const Eigen::Vector3d& target);
  void rotateDrag(const Eigen::Quaterniond& worldRotation);  ///< turns the wanted orientation
  void endDrag();
  std::optional<int> dragged() const { return dragged_; }

  // --- history: every edit begins with remember(); the mutators above that start an edit do so themselves
  void remember();
  bool undo();
  bool redo();
  bool canUndo() const;
  bool canRedo() const;

  // --- solver
  const std::string& solver() const { return solverName_; }
  void setSolver(const std::string& name);  ///< throws std::invalid_argument that lists the names
  void nextSolver(int direction = 1);

  /// One frame: solve towards the goals, warm from the present pose.
  const FrameSolve& step();
  const FrameSolve& lastSolve() const { return lastSolve_; }
  /// The problem that step() solves: the goals that take part, with their weights.
  IkProblem problem() const;

  /// Radians (or metres for translations) from the nearest limit below which a joint counts as being at it.
  static constexpr double limitMargin = 1e-3;
  /// For each joint whether it lies at one of its limits.
  std::vector<bool> jointsAtLimit() const;

  /// The scene's part that belongs here: q, goals, solver.
  void store(Scene& scene) const;
  void restore(const Scene& scene);

 private:
  struct Snapshot {
    Eigen::VectorXd q;
    std::vector<SceneGoal> goals;
  };
  void apply(const Snapshot& snapshot);
  void makeHandles();
  void followPose();
  void anchorSurfaceGoals();
  void place(const Eigen::VectorXd& q);
  Eigen::Vector3d blendedPoint(const SurfacePoint& point) const;
  std::string makeUnsupportedReason(const IkProblem& problem) const;

  std::shared_ptr<const Model> model_;  // shared: panels and ghosts may outlive an opened model for a frame
  Eigen::VectorXd q_;
  Frames frames_;
  std::vector<SceneGoal> goals_;
  std::optional<int> dragged_;
  GoalState afterDrag_ = GoalState::Held;
  bool dragMoved_ = false;  ///< a press without a move is no edit
  std::vector<Snapshot> past_, future_;
  std::string solverName_;
  std::unique_ptr<FrameSolver> solver_;
  FrameSolve lastSolve_;
};

}  // namespace gelenk
