#pragma once

#include <Eigen/Geometry>
#include <string_view>
#include <vector>

namespace gelenk {

/// How ||q|| = 1 is kept while quaternions are optimised (lecture 10.2: "optimising quaternions forces the
/// condition ||q|| = 1").
enum class UnitConstraint {
  Manifold,  ///< steps stay on the sphere: three parameters a joint
  Penalty,   ///< weight (||q||^2 - 1) as one more residual a joint: four parameters
};

struct QuaternionChainFit {
  std::vector<Eigen::Quaterniond> q;  ///< as optimised, not normalised afterwards
  double constraintError = 0.0;       ///< largest | ||q|| - 1 |
  double claimedError = 0.0;          ///< distance to the target with q as it is, as the optimiser sees it
  double trueError = 0.0;             ///< distance with q normalised: what a rigid chain does
  int iterations = 0;
};
/// The method of this build in words: Ceres is not everywhere (apps/web).
extern const std::string_view quaternionChainMethod;

/// A chain of ball joints at the origin with links along x: end-effector = sum over i of R(q_1) ... R(q_i)
/// (l_i, 0, 0). Optimised by Ceres' Levenberg-Marquardt from `start` towards the target. lengths and start:
/// one a joint, exactly three. penaltyWeight is used by Penalty alone. Throws std::invalid_argument for
/// another number of joints.
QuaternionChainFit fitQuaternionChain(const std::vector<double>& lengths,
                                      const std::vector<Eigen::Quaterniond>& start,
                                      const Eigen::Vector3d& target, UnitConstraint constraint,
                                      double penaltyWeight = 1.0);

/// The chain's end-effector by normalised quaternions.
Eigen::Vector3d quaternionChainEnd(const std::vector<double>& lengths,
                                   const std::vector<Eigen::Quaterniond>& q);

}  // namespace gelenk
