#pragma once

#include <memory>
#include <span>
#include <vector>

#include "solvers/problem/ik_solver.h"
#include "solvers/serial/seed_table.h"
#include "solvers/serial/serial_chain.h"

namespace gelenk {

/// Coordinates of a chain; lives on the stack.
using ChainVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, maxChainDofs, 1>;
using ChainJacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, maxChainDofs>;

/// What is wanted of the tip: a place for a point of it, an orientation, or both (GoalKind::Position,
/// Orientation, Pose).
struct TipGoal {
  GoalKind kind = GoalKind::Pose;
  Eigen::Vector3d pointInTip = Eigen::Vector3d::Zero();
  Eigen::Vector3d target = Eigen::Vector3d::Zero();           ///< of the point, world
  Eigen::Matrix3d orientation = Eigen::Matrix3d::Identity();  ///< worldFromTip wanted; a rotation
};

/// Constants of the method.
struct SerialPoseParameters {
  int attemptIterations = 15;
  double farJump = 0.5, nudge = 0.3;

  static constexpr auto fields() {
    using P = SerialPoseParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::attemptIterations, "attempt-iterations", 1, 1000, "1", "ours",
          "A start of the race that has not converged by then is given up."},
         {&P::farJump, "far-jump", 0.0, 100.0, "rad, chain lengths", "ours",
          "Where the start's own descent moves a joint farther, starts close by are tried as well."},
         {&P::nudge, "nudge", 0.0, 6.3, "rad, chain lengths", "ours",
          "How far off those starts are at most."}});
  }
};

struct SerialPoseOptions {
  double positionTolerance = 1e-6;     ///< metres
  double orientationTolerance = 1e-6;  ///< radians
  int restarts = 4000;                 ///< starts beyond the first
  int maxIterations = 200;             ///< of the first descent and of the search for the closest pose
  double maxSeconds = 1.0;
  std::uint64_t seed = 1;
  bool closestPose = true;  ///< false: an unsolved answer may be any pose, which saves time where such
                            ///< answers are thrown away
  SerialPoseParameters method = {};
};

struct SerialPoseAnswer {
  ChainVector q;     ///< within limits
  ChainVector from;  ///< the start of the descent that led to q
  Stop why = Stop::Failure;
  double positionError = 0.0;     ///< metres; 0 where the goal has no position part
  double orientationError = 0.0;  ///< radians
  Counters counters;
};

/// The default solver of serial chains: box-limited Levenberg-Marquardt on the Denavit-Hartenberg form of the
/// chain, restarts sixteen at a time in the lanes of the processor, and an exact Newton method for the
/// closest pose where there is no solution.
///
/// 1. A descent from the start, when the start is near the goal or no restart is allowed; where it fails or a
/// joint goes more than half a
///    radian, sixteen starts close by, and the nearer answer of the two.
/// 2. The race: sixteen starts side by side (of the seed table where there is one, then random) in single
/// precision; the first to come
///    close is finished in double precision and wins.
/// 3. No solution: Newton with the exact Hessian from the start and from the best pose met, on the judge's
/// own error; the
///    start's answer is kept unless the other is better by a hundredth, so that a dragged goal out of reach
///    does not jitter.
///
/// Rotations whose range holds a full turn have no wall; their angle is returned within limits, nearest to
/// the start. The same goal, start, options and kernel give the same answer. Kernels: serial_kernel.h. All
/// methods are const and may be called from several threads.
class SerialPoseSolver {
 public:
  /// Throws std::invalid_argument where the instruction set is not available.
  explicit SerialPoseSolver(SerialChain chain, InstructionSet set = bestInstructionSet());

  /// Fills the table of starts (0.2 to 0.4 s; see seed_table.h). False where the chain has none: it goes on
  /// without.
  bool buildSeedTable(const SeedTableOptions& options = {});
  const SeedTable* seedTable() const { return table_ ? &*table_ : nullptr; }

  const SerialChain& chain() const { return chain_; }

  /// start: n entries, clamped to the limits. Throws std::invalid_argument for a start or goal that is not
  /// finite.
  SerialPoseAnswer solve(const TipGoal& goal, const ChainVector& start,
                         const SerialPoseOptions& options = {}) const;

  /// Newton with the exact Hessian from start, alone: the closest pose nearby.
  SerialPoseAnswer closest(const TipGoal& goal, const ChainVector& start,
                           const SerialPoseOptions& options) const;

  /// World frame of the tip; J (6 x n, resized): rows 0-2 the velocity of the tip's origin, 3-5 the angular
  /// velocity, world axes.
  Eigen::Isometry3d frameAndJacobian(const ChainVector& q, ChainJacobian& J) const;

  /// Many poses of the tip (GoalKind::Pose, the tip's origin) at once, one a lane; see solveBatch.
  void solveBatch(std::span<const Eigen::Isometry3d> worldFromTip, std::span<const double> starts,
                  std::span<KernelAnswer> answers, const SerialPoseOptions& options = {}) const;

 private:
  struct Prepared;
  struct Search;
  Prepared prepare(const TipGoal& goal, const SerialPoseOptions& options) const;
  KernelTarget kernelTarget(const TipGoal& goal) const;
  double jump(const double* start, const KernelAnswer& found) const;
  void nudge(const double* start, double most, std::uint64_t seed, LaneStarts& starts) const;
  void toLimits(double* q, const double* start) const;
  void reportErrors(const TipGoal& goal, const Prepared& prepared, const KernelAnswer& found,
                    SerialPoseAnswer& answer) const;

  SerialChain chain_;
  ChainConstants scaled_;  ///< lengths in units of chain_.length
  const SerialKernel* kernel_;
  std::optional<SeedTable> table_;
};

/// "serial-pose": the default. Budget::restarts are its random starts.
std::unique_ptr<IkSolver> makeSerialPose(const SerialPoseParameters& parameters = {});
/// The same with a seed table, built by prepare().
std::unique_ptr<IkSolver> makeSerialPoseTable(const SerialPoseParameters& parameters = {});

}  // namespace gelenk
