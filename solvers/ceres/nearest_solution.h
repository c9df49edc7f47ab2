#pragma once

#include <Eigen/Core>
#include <string_view>

#include "kinematics/notation/planar_chain.h"

namespace gelenk {

/// The lecture's problem taken at its word (10.1.4, general inverse kinematics):
///     ||phi_new - phi_old|| = min { ||phi - phi_old|| : f(phi) = X }.
struct NearestSolution {
  Eigen::VectorXd phi;
  double distance = 0.0;   ///< ||phi - phi_old||, radians
  double violation = 0.0;  ///< |f(phi) - X|, unit of the lengths
  int iterations = 0;      ///< of the method, all starts together
};
/// The method of this build in words: Ceres is not everywhere (apps/web).
extern const std::string_view nearestSolutionMethod;

/// Augmented Lagrangian on Ceres' Levenberg-Marquardt, from phi_old, from `hint`, and from 16 seeded starts
/// around them; the best that fulfils the constraint to 1e-10 of the chain's length. X must be reachable, or
/// the violation tells by how much it is not.
NearestSolution nearestSolution(const PlanarChain& chain, const Eigen::VectorXd& phiOld,
                                const Eigen::Vector2d& X, const Eigen::VectorXd& hint);

}  // namespace gelenk
