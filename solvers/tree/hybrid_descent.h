#pragma once

#include <vector>

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

/// Minimises, on the dofs between the goals and the root and within the joints' limits,
///     f = 1/2 sum_points w |t - x|^2 + 1/2 lambda sum_i s_i (c_i - rest_i)^2 + 1/2 kappa |c - c_anchor|^2
/// by damped Newton steps that take the exact Hessian far from a solution and Gauss-Newton near one. Free
/// balls measure c - rest by the rotation vector. The state between steps (mu of both kinds, what the last
/// step was worth) persists, so that a drag goes on where the frame before ended. Lengths are units of the
/// tree.
///
/// Limits inside the step: a box dof at its bound with outward gradient is locked; a swing on its cone with
/// outward gradient is left the one dof along the ellipse; dofs that the step would carry across their limit
/// are put on it and the others solved again (at most three times); the step is applied with projection.
class HybridDescent {
 public:
  struct Settings {
    double lambda = 3e-3;           ///< weight of the posture
    double kappa = 3e-3;            ///< weight of the change since anchor()
    double largestStep = 0.5;       ///< radians or units a dof and step
    double smallestStep = 1e-6;     ///< steps below are not taken
    double rotationBudget = 1e300;  ///< radians a joint since anchor()
    double leastDamping = 0.0;  ///< of Gauss-Newton steps; > 0 where nothing else makes their matrix definite
    bool exact = true;          ///< false: Gauss-Newton alone
    bool passing = false;       ///< true: a Gauss-Newton step that leaves no trace in what persists
  };

  HybridDescent(const Skeleton& skeleton, double unit, std::vector<double> stiffness,
                const Eigen::VectorXd& rest);

  GoalTree& tree() { return tree_; }
  const GoalTree& tree() const { return tree_; }
  std::vector<TreePoint>& points() { return points_; }
  const std::vector<TreePoint>& points() const { return points_; }
  const TreePose& pose() const { return pose_; }

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
  /// The pose moved by d (dofCount() entries) without limits, for tests.
  void moveFreely(const double* d);

 private:
  enum class DofState : unsigned char { Free, Fixed, AlongCone, ConePartner };

  double objective(const Settings& settings, const TreePose& pose) const;
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
  Eigen::VectorXd rest_;
  std::vector<TreePoint> points_;
  TreePose pose_, trial_, anchor_;
  std::vector<double> changeAnchor_;

  std::vector<double> s_, restCoordinates_;  ///< by dof; by coordinate
  TreeMatrix H_, W_;
  std::vector<double> g_, d_, x_, value_;
  std::vector<DofState> state_;
  std::vector<char> stays_;  ///< by dof: stay on the limit at the next step
  std::vector<Eigen::Vector2d>
      tangent_;  ///< by dof: unit tangent of the ellipse where the state is AlongCone
  std::vector<double> tangentLength_;
  bool anyFixedMoves_ = false;

  double cost_ = 0.0, slope_ = 0.0, curvature_ = 0.0;
  double muGaussNewton_ = 0.0, muExact_ = 0.0;
  double lastGaussNewtonGain_ = 1.0, gain_ = 0.0;
  int forcedExact_ = 0;
};

}  // namespace gelenk
