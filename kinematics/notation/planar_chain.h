#pragma once

#include <Eigen/Geometry>
#include <numeric>
#include <vector>

#include "kinematics/skeleton.h"

namespace gelenk {

/// An unbranched chain of n links in the plane (lecture 10.1, description of skeletons in 2D):
///
///           P_3 ---l_3--- X = P_4
///      l_2 /  phi_3
///    P_2 -'
/// l_1 /  phi_2           phi_1 is measured from the x axis, every other angle from the link before.
///  P_1  phi_1
struct PlanarChain {
  Eigen::Vector2d base = Eigen::Vector2d::Zero();  ///< P_1
  std::vector<double> lengths;                     ///< l_1 ... l_n

  int linkCount() const { return static_cast<int>(lengths.size()); }
  double reach() const { return std::accumulate(lengths.begin(), lengths.end(), 0.0); }  ///< l_1 + ... + l_n
};

/// The lecture's chain (10.1.4, example): P_1 = (50, 400), l = 150, 200, 100.
PlanarChain lecturePlanarChain();

/// n + 2: the two coordinates of P_1 and n angles. Lecture 10.1.
int degreesOfFreedom(const PlanarChain& chain);

/// P_1 ... P_{n+1}: P_{i+1} = P_i + l_i (cos, sin)(phi_1 + ... + phi_i). phi: n angles, radians.
/// Lecture 10.1. Throws std::invalid_argument when phi has another length.
std::vector<Eigen::Vector2d> linkPoints(const PlanarChain& chain, const Eigen::VectorXd& phi);

/// X = f(phi) = P_{n+1}. Lecture 10.1, forward kinematics.
Eigen::Vector2d endEffector(const PlanarChain& chain, const Eigen::VectorXd& phi);

/// The Jacobian matrix D_f, 2 x n: column i is X - P_i turned by +90 degrees. Lecture 10.1.4.
Eigen::Matrix2Xd jacobian(const PlanarChain& chain, const Eigen::VectorXd& phi);

/// Hierarchical coordinate systems K_1 ... K_n and, last, the frame at X with K_n's axes:
/// K_1 = T(P_1) R(phi_1), K_{i+1} = K_i T(l_i, 0) R(phi_{i+1}). Lecture 10.1.1.
std::vector<Eigen::Isometry2d> hierarchicalFrames(const PlanarChain& chain, const Eigen::VectorXd& phi);

/// The same chain as a skeleton in the x-y plane: hinges "joint1" ... "jointN" about z, then the fixed frame
/// "end-effector". q = phi. Angles are unlimited. Throws std::invalid_argument for a chain without links.
Skeleton toSkeleton(const PlanarChain& chain);

}  // namespace gelenk
