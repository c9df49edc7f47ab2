#pragma once

#include <optional>
#include <vector>

#include "solvers/serial/serial_chain.h"
#include "solvers/solutions/loop.h"

namespace gelenk {

using Vector7d = Eigen::Matrix<double, 7, 1>;

/// Closed form of the self-motion of seven-joint arms whose axes 1, 2 and 3 meet in a point S, the shoulder,
/// and whose axes 5 and 6 meet in a point W: S-R-S arms, and those whose last axis is offset (Panda, xArm 7).
/// With the last joint held, W and axis 6 stand still. Then |SW| gives joint 4 (two elbows), the angles of
/// axis 5 with SW and with axis 6 give joint 6 (two sides), the direction of SW gives joint 5, and what is
/// left is a rotation of the shoulder (two triples of angles): eight branches over the last joint's angle t.
/// A branch ends where a square root vanishes, and goes on there as the one with the other sign. An interval
/// of t from end to end is walked as t = middle - half cos(s), s in [0, pi]: the joints are smooth in s, ends
/// included.
class ShoulderFamily {
 public:
  /// None where the axes do not meet so to 1e-5 of a third of the chain's length.
  static std::optional<ShoulderFamily> of(const SerialChain& chain);

  double misfit() const { return misfit_; }  ///< by how much the axes miss, in that length

  /// The solution nearest to `near`, of its images q + 2 pi k the nearest within limits; false where there is
  /// none. Of two neighbouring samples a, b of a branch, what lies between is no nearer than
  /// (|a - near| + |b - near| - 1.5 |a - b|) / 2 unless the way between them is more than half as long again
  /// as the chord; what that does not rule out is halved until it is short, and the root of the distance's
  /// derivative, or where a joint comes to its limit, is found there. No allocation.
  bool nearest(const Eigen::Isometry3d& worldFromTip, const Vector7d& near, bool limits,
               Vector7d& best) const;

  /// Solutions along every branch within limits, neighbours at most about `step` apart.
  void sample(const Eigen::Isometry3d& worldFromTip, double step, std::vector<Vector7d>& out) const;

  /// Lengths over a third of the chain's.
  struct Shape {
    double a[7], d[7], cosAlpha[7], sinAlpha[7], theta[7];  ///< L_i = Rx(alpha) T(a, 0, d) Rz(theta + q)
    double wrist[3];                                        ///< W before the last joint turns
    double shoulder[3];                                     ///< S before joint 4 turns
    double forearm[3];                                      ///< W in the frame of joint 4
    double rise, pull;                                      ///< |SW|^2 = rise - pull cos(opening)
    double foldedCos, foldedSin;  ///< joint 4 where the opening is 0; it is theta_4 + q_4 = folded +- opening
  };

 private:
  struct Search;
  ShoulderFamily() = default;

  SerialChain chain_;
  Shape shape_;
  double scale_ = 1.0, misfit_ = 0.0;
  Vector7d lower_, upper_;  ///< +-1e6 where there is no limit
};

}  // namespace gelenk
