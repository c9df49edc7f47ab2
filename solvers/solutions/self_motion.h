#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "solvers/serial/serial_chain.h"
#include "solvers/solutions/closed_loop.h"
#include "solvers/solutions/shoulder_family.h"

namespace gelenk {

/// Solutions of a pose with one joint of seven held.
struct SliceSolutions {
  static constexpr int most = LoopSolutions::most;
  int count = 0;
  std::array<Vector7d, most> q;  ///< radians; images as in ArmSolution
  std::array<bool, most> withinLimits{};
  std::span<const Vector7d> all() const { return {q.data(), static_cast<size_t>(count)}; }
};

/// A piece of the self-motion: how a seven-joint arm can move without moving its tip.
struct SelfMotionCurve {
  std::vector<Vector7d> q;        ///< a chain of poses, each as good a solution as the others
  std::vector<double> arcLength;  ///< radians, from 0
  bool closed = false;            ///< the last pose leads back to the first (angles by whole turns)
  double length() const { return arcLength.empty() ? 0.0 : arcLength.back(); }
};

struct SelfMotionOptions {
  bool limits = true;  ///< only the pieces within the joints' limits
  int slices = 64;     ///< values of the held joint at which all solutions are found; a component that lies
                       ///< between two of them is not seen
  double step = 0.04;  ///< radians of all joints together between neighbours of a chain
};

/// Arms of seven revolute joints. One joint is held, the other six are solved completely; the joint is chosen
/// so that these belong to a class with closed forms wherever it stands (S-R-S arms: the third; the Panda:
/// the last; else any joint and the general elimination). Const methods may be called from several threads.
class SevenJointArm {
 public:
  /// Throws std::invalid_argument for a chain of other than seven revolute joints.
  explicit SevenJointArm(const SerialChain& chain);

  const SerialChain& chain() const { return chain_; }
  int heldJoint() const { return held_; }
  LoopClass sliceClass() const { return decomposition_.kind; }
  std::string describe() const;  ///< "closed form over joint 7: axes 1, 2 and 3 meet, and axes 5 and 6"

  /// All solutions with the held joint at `angle`, each polished to 1e-12. No allocation.
  void slice(const Eigen::Isometry3d& worldFromTip, double angle, const Vector7d& reference,
             SliceSolutions& out) const;

  /// Every component of the self-motion, walked along the null space from the slices until it closes.
  std::vector<SelfMotionCurve> selfMotion(const Eigen::Isometry3d& worldFromTip,
                                          const SelfMotionOptions& options = {}) const;

  /// The closed form of the family, where the arm has one.
  const std::optional<ShoulderFamily>& family() const { return family_; }

  /// The solution within limits nearest to `near`; false where there is none. By the closed form of the
  /// family where there is one (then options.limits alone is read, and nothing is allocated), else of every
  /// piece of the self-motion the points that are nearer than their neighbours, each improved by a projected
  /// Newton on the distance.
  bool nearest(const Eigen::Isometry3d& worldFromTip, const Vector7d& near, Vector7d& best,
               const SelfMotionOptions& options = {}) const;

  /// The same by walking, whatever the arm: slower, and a second way to the closed form's answers.
  bool nearestByWalking(const Eigen::Isometry3d& worldFromTip, const Vector7d& near, Vector7d& best,
                        const SelfMotionOptions& options = {}) const;

  /// Unit tangent of the self-motion through a solution, in either sense.
  Vector7d tangent(const Vector7d& q) const;
  /// Moves a solution along its self-motion, by `step` on the tangent and back onto the curve. False, and
  /// nothing is changed, where that fails or leaves the limits.
  bool slide(const Eigen::Isometry3d& worldFromTip, const Vector7d& step, Vector7d& q) const;

 private:
  struct Frame;
  void place(const Eigen::Isometry3d& worldFromTip, double heldTurn, Loop& loop) const;
  void solveLoop(const Loop& loop, const Vector6d& reference, LoopSolutions& out) const;
  Frame frameAt(const Vector7d& q) const;
  bool correct(const Eigen::Isometry3d& goal, const Vector7d& tangent, Vector7d& q) const;
  Vector7d tangentAt(const Vector7d& q, const Vector7d& before) const;
  SelfMotionCurve walk(const Eigen::Isometry3d& goal, const Vector7d& from, double step) const;
  void cutByLimits(const Eigen::Isometry3d& goal, const SelfMotionCurve& whole,
                   std::vector<SelfMotionCurve>& pieces) const;
  bool toLimits(Vector7d& q, const Vector7d& reference) const;
  double descend(const Eigen::Isometry3d& goal, const Vector7d& near, bool limits, Vector7d& q) const;
  Eigen::Isometry3d lastFrame(const Eigen::Isometry3d& worldFromTip) const;

  SerialChain chain_;
  std::array<Eigen::Isometry3d, 7> fixed_;  ///< lengths over scale_
  double scale_ = 1.0;
  int held_ = 6;
  Decomposition decomposition_;
  Cut generalCut_;
  std::optional<ShoulderFamily> family_;
};

}  // namespace gelenk
