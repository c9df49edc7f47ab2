#pragma once

#include <Eigen/Core>
#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "solvers/problem/ik_problem.h"
#include "solvers/problem/ik_report.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/tree/drag_descent.h"

namespace gelenk {

/// Keeps a body from tipping over: its centre of mass stays over the hull of those of its points that stand
/// on the ground.
struct BalanceOptions {
  std::shared_ptr<const Masses> masses = {};
  struct Support {
    int joint;
    Eigen::Vector3d inJoint;  ///< metres
  };
  std::vector<Support> supports = {};  ///< heels, balls of the feet, toes
  Eigen::Vector3d up = Eigen::Vector3d::UnitY();
  double margin = 0.01;    ///< metres inside the hull
  double standing = 0.03;  ///< a support at most so high above the lowest one stands, metres
};

/// Constants of the drag solver. Lengths are in units of DragSolver::unit(), about a metre for a figure of
/// human size, so that the same constants serve an arm of hundreds of metres. Defaults:
/// docs/solvers/drag.md.
struct DragOptions {
  double posture = 1e-3;     ///< lambda: pull towards the rest pose, the soft reach
  double change = 5e-3;      ///< kappa: cost of the change within a frame
  double heldChange = 0.01;  ///< share of it that is left when the targets have stood still for a while
  double dragWeight = 1.0;   ///< on the squared distance, times Goal::weight
  double pinWeight = gelenk::pinWeight;
  double poseArm = 0.3;          ///< orientations count as three points on arms of this length, units
  double dragBias = 0.01;        ///< largest correction of a drag's target against the posture's pull, units
  double pinBias = 0.002;        ///< likewise of a pin's
  double poseBias = 0.03;        ///< likewise of the orientation part, at the arm's end
  double cut = 0.6;              ///< a target farther away pulls as if it were this far, units
  double rotationBudget = 0.18;  ///< radians a joint and frame; the repair of the pins may add a fifth
  int iterations = 4;            ///< a frame
  int strainedIterations = 6;    ///< a frame after one that left a drag farther than `strain` from its target
  double strain = 0.02;          ///< units
  int repairs = 3;               ///< further iterations that restore the pins when the budget is spent
  double pinTolerance =
      7e-4;  ///< a frame that would leave a pin farther off is taken again with a smaller budget, units
  double settled = 1e-3;     ///< a frame ends with the first step below, radians or units
  double unit = 0.0;         ///< metres a unit; 0: from the skeleton's size
  double roundings = 0.999;  ///< of the tolerances in solve(): what the judge's own arithmetic may add
  std::optional<BalanceOptions> balance = {};
  std::vector<double> stiffness =
      {};  ///< s of every tangent dimension, nv; empty: postureStiffness(skeleton)
};

/// s_i of the posture term for each tangent dimension, by the range of motion: a joint of half range r
/// (radians) gets (0.6 / r)^2 within [0.3, 2], so that a spine is stiff and a shoulder gives. Translations
/// and free root balls 0.5 and 0.7.
std::vector<double> postureStiffness(const Skeleton& skeleton);

/// Metres that stand for one unit: the longest chain of bones from the root, divided by that of the figure.
double characteristicLength(const Skeleton& skeleton);

/// Drags a skeleton frame by frame: a few damped Newton steps a frame, exact Hessian far from a solution and
/// Gauss-Newton near one, on the joints between goals and root. The others stay as they are. Damping, target
/// corrections and the structure persist from frame to frame; after the first frame with the same goals
/// nothing allocates (traces aside).
///
/// Goals may come, go and change joint, point, kind and role between frames. Every type with a DragForm is
/// served (a Pole wants a small weight: it is a preference); Posture goals are ignored: the posture term
/// pulls towards the skeleton's rest pose, or what setPosture() says. Drags and holds are drawn, pins stand
/// by their weight. Targets that are not finite are left out. Throws std::invalid_argument for a goal that
/// makes no sense on the skeleton (whyMisplaced).
class DragSolver {
 public:
  /// skeleton must outlive the solver.
  explicit DragSolver(const Skeleton& skeleton, DragOptions options = {});

  /// Begins anew at q (nq), moved into the limits.
  void reset(const Eigen::VectorXd& q);
  /// What the posture term pulls towards from now on (nq); the skeleton's rest pose at the beginning.
  void setPosture(const Eigen::VectorXd& q);
  /// One frame. The report is valid until the next call: q, why (Converged: goals met within 1e-4 units;
  /// Stationary: at rest short of them; Budget: still moving), the goals' residual (weighted root of summed
  /// squares, metres; orientation by its arm; pins by their Goal::weight), work done and, on demand, a record
  /// an iteration.
  const IkReport& frame(std::span<const Goal> goals, TraceLevel trace = TraceLevel::Off);
  /// From problem.start (nq) to a solution at once: no target corrections, cut, rotation budget or cost of
  /// change, and a posture term that fades. Reset before the next frame().
  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace = TraceLevel::Off);

  const Eigen::VectorXd& q() const { return report_.q; }

  const Skeleton& skeleton() const { return descent_.tree().skeleton(); }
  const DragOptions& options() const { return options_; }
  double unit() const { return descent_.tree().unit(); }

 private:
  using Clock = std::chrono::steady_clock;

  /// What is kept of a goal between frames.
  struct Memory {
    int joint = -1, otherJoint = -1;
    GoalKind kind = GoalKind::Position;
    Role role = Role::Drag;
    const GoalType* type = nullptr;
    int firstPoint = 0, pointCount = 0;
    Eigen::Vector3d bias[4];             ///< of each of its points
    std::array<TreePoint, 3> reference;  ///< DragForm::references
    int block = -1;
    Goal last = {};       ///< of blocks: as it was asked in the frame before
    double weight = 0.0;  ///< of blocks, also while they rest
  };
  /// How hard goals pull: a frame of a drag, or a cold solve, where all stand by their own weights.
  struct Pull {
    double drag, pin, cut;
  };

  const Goal& goalAt(std::span<const Goal> goals, std::size_t i) const {
    return i < goals.size() ? goals[i] : balance_;
  }
  std::size_t countOf(std::span<const Goal> goals) const { return goals.size() + (options_.balance ? 1 : 0); }
  bool sameStructure(std::span<const Goal> goals) const;
  bool met(std::span<const Goal> goals, double positionTolerance, double orientationTolerance);
  void rebuild(std::span<const Goal> goals);
  void compile(const Goal& goal, const Memory& memory);
  void setTargets(std::span<const Goal> goals, const Pull& pull);
  bool setPoints(const Goal& goal, Memory& memory, double weight, double reported, double cut);
  bool setBlock(const Goal& goal, Memory& memory, double weight, double cut);
  void updateMovingTargets(std::span<const Goal> goals);
  void restoreTargets();
  void updateBiases();
  void updateSupport();
  void holdDragsWhereTheyAre();
  double errorOf(const Memory& memory) const;
  double largestError(bool pins) const;
  bool descend(std::span<const Goal> goals, double budget, int iterations, TraceLevel trace,
               Clock::time_point begin);
  double residual() const;
  void record(TraceLevel trace, const StepOutcome& outcome, double before, double seconds);
  void count(const StepOutcome& outcome);
  Pull dragging() const { return {options_.dragWeight, options_.pinWeight, options_.cut}; }
  Eigen::Vector3d worldOf(const TreePoint& point) const;

  DragOptions options_;
  DragDescent descent_;
  std::vector<Memory> memory_, previous_;
  std::vector<int> joints_;
  std::vector<Eigen::Vector3d> wanted_;  ///< of each point: the target without cut and bias
  std::vector<double> reportWeight_;     ///< of each point: its share of the residual reported
  std::vector<Carried> carried_;
  Goal balance_;                     ///< where options_.balance is given
  std::vector<TreePoint> supports_;  ///< of it
  std::vector<Eigen::Vector3d> standing_, standingBefore_;
  Frames frames_;
  bool fresh_ = true, strained_ = false, spent_ = false;
  double budgetShare_ = 1.0;
  int framesHeld_ = 0;  ///< with the same targets
  IkReport report_;
};

struct DragParameters {
  double posture = 1e-3, poseArm = 0.3;

  static constexpr auto fields() {
    using P = DragParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::posture, "posture", 0.0, 1.0, "1", "ours",
          "Pull towards the rest pose in the first step; it fades tenfold a step."},
         {&P::poseArm, "pose-arm", 1e-3, 10.0, "unit", "ours",
          "Orientations count as three points on arms of this length, in body units."}});
  }
};
/// The drag solver's steps as a cold solve of the catalogue: DragSolver::solve. docs/solvers/drag.md.
std::unique_ptr<IkSolver> makeDrag(const DragParameters& parameters = {});

}  // namespace gelenk
