#pragma once

#include <array>
#include <vector>

#include "solvers/problem/goal_type.h"
#include "solvers/tree/goal_tree.h"
#include "solvers/tree/tree_matrix.h"

namespace gelenk {

/// Which second derivatives a step was made with.
enum class StepKind : unsigned char { GaussNewton, ExactHessian };

/// What one iteration did.
struct StepOutcome {
  StepKind kind = StepKind::GaussNewton;
  bool moved = false;        ///< a descent was found and taken
  bool budgetSpent = false;  ///< the step was cut short by the rotation budget
  double step = 0.0;         ///< largest entry of the step taken (radians, units)
  double damping = 0.0;      ///< mu of the step
  int factorisations = 0;
  int placements = 0;  ///< forward kinematics
};

/// A smooth cost of sums of carried points, weight phi(y - correction): a goal whose type gives the drag
/// solver DragForm::model. Beyond `cut` metres, sqrt(2 phi), it goes on with the same slope, as a point does.
struct TreeBlock {
  const Goal* goal = nullptr;
  const GoalType* type = nullptr;
  double weight = 0.0;
  double cut = unlimited;
  int firstSum = 0;
  std::array<Eigen::Vector3d, DragModel::mostVectors> correction = {};  ///< metres; directions: none
};

/// Minimises, on the dofs between the goals and the root and within the joints' limits,
///     f = 1/2 sum_points w |t - x|^2 + sum_blocks w phi(y) + 1/2 lambda sum_i s_i (c_i - posture_i)^2 + 1/2
///     kappa |c - c_anchor|^2
/// by damped Newton steps that take the exact Hessian far from a solution and Gauss-Newton near one. Free
/// balls measure c - posture by the rotation vector. The state between steps (mu of both kinds, what the last
/// step was worth) persists, so that a drag goes on where the frame before ended. Lengths are units of the
/// tree.
///
/// A block's y may hang on every joint: its curvature is a few rows U beside the tree's matrix H, and
/// (H + U^T S U) d = -g, S = diag(+-1), is solved by H and the small matrix S + U H^-1 U^T (Woodbury). Where
/// its pivots have not the signs of S, the whole is not positive definite (Haynsworth 1968).
///
/// A dof that follows another one, d_f = multiplier d_s, is such a row with 0 in S: the step of least model
/// cost among those that keep it.
///
/// Limits inside the step: a box dof at its bound with outward gradient is locked; a swing on its cone with
/// outward gradient is left the one dof along the ellipse; dofs that the step would carry across their limit
/// are put on it and the others solved again (at most three times); the step is applied with projection.
class DragDescent {
 public:
  struct Settings {
    double lambda = 0.0;            ///< weight of the posture
    double kappa = 0.0;             ///< weight of the change since anchor()
    double largestStep = 0.5;       ///< radians or units a dof and step
    double smallestStep = 1e-6;     ///< steps below are not taken
    double rotationBudget = 1e300;  ///< radians a joint since anchor()
    bool exact = true;              ///< false: Gauss-Newton alone
    bool passing = false;           ///< true: a Gauss-Newton step that leaves no trace in what persists

    // When the exact Hessian is taken. docs/solvers/drag.md tells what they were tried on.
    double near = 0.03;         ///< sqrt(sum w e^2) below which Gauss-Newton is as good, units
    double goodGain = 0.75;     ///< actual over predicted fall of a Gauss-Newton step that earns another ...
    double goodDamping = 0.01;  ///< ... unless it was only short: damped by more than this
    double poorGain = 0.25;     ///< below it, where the exact Hessian was not definite ...
    int raisedSteps = 8;        ///< ... so many steps with it, damped until it is
  };

  DragDescent(const Skeleton& skeleton, double unit, std::vector<double> stiffness,
              const Eigen::VectorXd& rest);

  GoalTree& tree() { return tree_; }
  const GoalTree& tree() const { return tree_; }
  std::vector<TreePoint>& points() { return points_; }
  const std::vector<TreePoint>& points() const { return points_; }
  const TreePose& pose() const { return pose_; }
  std::vector<TreeBlock>& blocks() { return blocks_; }
  const std::vector<TreeBlock>& blocks() const { return blocks_; }
  std::vector<TreeSum>& sums() { return sums_; }
  std::vector<TreeShare>& shares() { return shares_; }
  const std::vector<TreeShare>& shares() const { return shares_; }
  /// Metres that stand for a radian in blocks.
  void setArm(double metres) { arm_ = metres; }
  /// The block's model at the pose, with or without its correction.
  void look(const TreeBlock& block, bool corrected, bool exact, DragModel& model) const {
    look(block, pose_, corrected, exact, model);
  }

  /// What the posture term pulls towards, nq.
  void setPosture(const Eigen::VectorXd& q);
  /// New structure; forgets what earlier steps were worth. Points must be set anew.
  void build(std::span<const int> joints, const Eigen::Vector3d& origin);
  /// Takes the tree's joints from q, moved into the limits.
  void load(const Eigen::VectorXd& q);
  /// The current pose becomes the one from which change and rotation are measured.
  void anchor() { anchor_ = pose_, anchorChange(); }
  /// Back to the anchor.
  void returnToAnchor() { pose_ = anchor_, anchorChange(); }
  /// The current pose becomes the one from which change alone is measured.
  void anchorChange() { changeAnchor_ = pose_.coordinates; }
  void forget();

  StepOutcome step(const Settings& settings);

  /// sqrt(sum w |t - x|^2) at the pose.
  double residual() const;
  /// Largest rotation of a joint since anchor(), radians.
  double rotationSinceAnchor() const { return largestRotation(pose_); }

  /// The whole objective and its derivatives at the current pose, for tests.
  double objective(const Settings& settings) const { return objective(settings, pose_); }
  void derivatives(const Settings& settings, double beta, double* gradient, TreeMatrix& H);
  /// Rows beside H after derivatives().
  int rowCount() const { return rows_; }
  double rowEntry(int r, int k) const { return U_[(r / 4) * 4 * tree_.dofCount() + 4 * k + r % 4]; }
  double rowSign(int r) const { return sign_[r]; }
  /// The pose moved by d (dofCount() entries) without limits, for tests.
  void moveFreely(const double* d);

 private:
  enum class DofState : unsigned char { Free, Fixed, AlongCone, ConePartner };

  double objective(const Settings& settings, const TreePose& pose) const;
  void look(const TreeBlock& block, const TreePose& pose, bool corrected, bool exact, DragModel& model) const;
  /// Of the touching quadratic beyond the cut: the factor of force and curvature.
  static double pullOf(const TreeBlock& block, const DragModel& model);
  double costOfBlocks(const TreePose& pose) const;
  double goalCost(const TreePose& pose) const { return tree_.cost(pose, points_) + costOfBlocks(pose); }
  void gather();
  void collectRows(StepKind kind);
  bool factorRows();
  void solveSystem(double* x);
  double modelSlope(int k, double mu = 0.0) const;
  double* addRow(double sign);
  double regulariser(const Settings& settings, const TreePose& pose) const;
  void addRegulariser(const Settings& settings);
  void assemble(const Settings& settings, StepKind kind);
  void chooseActiveSet();
  void rememberActiveSet();
  void setConeTangent(const TreeNode& node, const double* coordinates);
  bool solve(double mu, double reach, StepOutcome& outcome);
  bool factorWithActiveSet(double mu);
  bool fixCrossing(double reach);
  void apply(double alpha);
  double largestRotation(const TreePose& pose) const;
  bool descend(const Settings& settings, double& mu, StepOutcome& outcome);
  double startingDamping() const;

  GoalTree tree_;
  std::vector<double> stiffnessOfDof_;  ///< of the skeleton's tangent
  Eigen::VectorXd posture_;
  std::vector<TreePoint> points_;
  std::vector<TreeBlock> blocks_;
  std::vector<TreeSum> sums_;
  std::vector<TreeShare> shares_;
  double arm_ = 0.3;
  TreePose pose_, trial_, anchor_;
  std::vector<double> changeAnchor_;

  std::vector<double> s_, postureCoordinates_;  ///< by dof; by coordinate
  TreeMatrix H_, W_;
  std::vector<double> g_, d_, x_, value_;
  std::vector<DofState> state_;
  std::vector<char> stays_;  ///< by dof: stay on the limit at the next step
  std::vector<Eigen::Vector2d>
      tangent_;  ///< by dof: unit tangent of the ellipse where the state is AlongCone
  std::vector<double> tangentLength_;
  bool anyFixedMoves_ = false;

  int rows_ = 0;                   ///< of U: couplings (sign 0), those of sign +1, then those of sign -1
  std::vector<double> U_, V_, Y_;  ///< four rows at a time, side by side for each dof
  std::vector<double> sign_, S_, Ud_, z_;
  std::vector<double> held_;             ///< by row: what dofs fixed at a value leave of a coupling
  std::vector<Eigen::Vector3d> slopes_;  ///< dy / d(dof) of a block's sums, one after the other

  double cost_ = 0.0, slope_ = 0.0, curvature_ = 0.0;
  double muGaussNewton_ = 0.0, muExact_ = 0.0;
  double lastGaussNewtonGain_ = 1.0, gain_ = 0.0;
  int forcedExact_ = 0;
};

}  // namespace gelenk
