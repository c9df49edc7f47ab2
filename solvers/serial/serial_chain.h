#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "kinematics/skeleton.h"
#include "solvers/serial/serial_kernel.h"

namespace gelenk {

/// The path from the root to a tip joint as a bare chain of one-dof joints in modified Denavit-Hartenberg
/// form, whatever notation the skeleton came from:
///     worldFromTip(q) = worldFromBase * L_1(q_1) * ... * L_n(q_n) * lastFromTip
///     L_i(q) = Rx(alpha_i) T(a_i, 0, d_i) Rz(theta_i + q)   (revolute; a prismatic joint adds q to d_i)
/// with alpha_1 = a_1 = d_1 = theta_1 = 0, which the base absorbs. The origin of frame n lies on the last
/// axis where the common normal from the axis before meets it: for a spherical wrist that is the wrist's
/// centre.
struct SerialChain {
  int n = 0;
  ChainConstants constants;      ///< metres, radians; limits as they are: see wraps
  std::vector<int> qIndex;       ///< where dof i stands in the skeleton's q, n entries
  std::vector<char> wraps;       ///< 1: a rotation whose range holds a full turn (it has no wall), n entries
  Eigen::VectorXd lower, upper;  ///< limits as in the skeleton, n
  Eigen::Isometry3d worldFromBase = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d lastFromTip = Eigen::Isometry3d::Identity();
  bool hasPrismatic = false;
  double length = 1.0;  ///< sum of the links' lengths, metres; never 0
};

/// A chain, or the reason why there is none (in words for a person; empty: there is one): ball joints on the
/// path, more than 8 dofs or none, axes so nearly parallel that Denavit-Hartenberg parameters lose precision.
struct SerialChainResult {
  SerialChain chain;
  std::string whyNot;
};

/// Throws std::invalid_argument where tipJoint is no joint of the skeleton.
SerialChainResult extractSerialChain(const Skeleton& skeleton, int tipJoint);

/// The tip's frame at the chain's coordinates (n), by the chain's own parameters.
Eigen::Isometry3d tipFrame(const SerialChain& chain, const Eigen::VectorXd& q);

}  // namespace gelenk
