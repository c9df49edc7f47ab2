#pragma once

#include "kinematics/notation/planar_chain.h"
#include "solvers/methods/newton.h"

namespace gelenk {

/// Newton's method on a planar chain from phi towards X. Lecture 10.1.4, n = m and n > m.
NewtonRun planarNewton(const PlanarChain& chain, const Eigen::VectorXd& phi, const Eigen::Vector2d& X,
                       double tolerance = 1e-12, int maxSteps = 50);

/// The slide's example: the lecture's chain from phi^alt = (0.6, 1.0, -0.7) to X^neu = (350, 700), to |g| <=
/// 1e-12 of the chain's length.
const NewtonRun& lectureNewtonRun();

/// The one-link arm of the one-dimensional example: f(phi) = l sin phi, the height of the end-effector; l
/// = 10.
double oneLinkHeight(double phi);
inline constexpr double oneLinkTarget = 5.0;  ///< reached at phi = 30 degrees

}  // namespace gelenk
