#pragma once

#include <span>
#include <vector>

#include "solvers/serial/serial_chain.h"
#include "solvers/solutions/closed_loop.h"

namespace gelenk {

using Vector7d = Eigen::Matrix<double, 7, 1>;

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

  /// All solutions with the held joint at `angle`, each polished to 1e-12. No allocation.
  void slice(const Eigen::Isometry3d& worldFromTip, double angle, const Vector7d& reference,
             SliceSolutions& out) const;

  /// Every component of the self-motion, walked along the null space from the slices until it closes.
  std::vector<SelfMotionCurve> selfMotion(const Eigen::Isometry3d& worldFromTip,
                                          const SelfMotionOptions& options = {}) const;

  /// The solution within limits nearest to `near`: of every piece of the self-motion the points that are
  /// nearer than their neighbours, each improved by a projected Newton on the distance. False where no
  /// solution lies within the limits.
  bool nearest(const Eigen::Isometry3d& worldFromTip, const Vector7d& near, Vector7d& best,
               const SelfMotionOptions& options = {}) const;

  /// Slides a solution along its self-motion, by at most `most` radians and within limits, to where it is
  /// nearest to `wanted` by the tangent there; returns how far it went.
  double slideTowards(const Eigen::Isometry3d& worldFromTip, const Vector7d& wanted, double most,
                      Vector7d& q) const;

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
  double descend(const Eigen::Isometry3d& goal, const Vector7d& near, Vector7d& q) const;
  Eigen::Isometry3d lastFrame(const Eigen::Isometry3d& worldFromTip) const;

  SerialChain chain_;
  std::array<Eigen::Isometry3d, 7> fixed_;  ///< lengths over scale_
  double scale_ = 1.0;
  int held_ = 6;
  Decomposition decomposition_;
  Cut generalCut_;
};

}  // namespace gelenk
