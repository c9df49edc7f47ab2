#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

#include "apps/lecture/leg_animation.h"
#include "kinematics/notation/dh_table.h"
#include "kinematics/notation/planar_chain.h"
#include "solvers/ceres/nearest_solution.h"
#include "solvers/methods/newton.h"

namespace gelenk {

// The slides' derivations with any values: LectureTopic::steps gives them the slide's, a scene those of the
// arm that is being dragged. Plain text in the notation that mathematics.h sets: phi_1, D_f^+, rows of a
// matrix in brackets. Lengths as the model has them, angles of the arguments in radians.

/// Lecture 10.1.2: the points P_1 ... P_(n+1) by sums, by the hierarchy and by the skeleton. phi: a value a
/// link.
std::string forwardDerivation(const PlanarChain& chain, const Eigen::VectorXd& phi);

/// Lecture 10.1.3: both solutions of an arm of two links, the arctangent's candidates and which of them hold.
std::string twoLinkDerivation(const PlanarChain& arm, const Eigen::Vector2d& X);

/// Lecture 10.1.4 in one dimension: f(phi) = l sin phi towards height X from phi^0 = start, difference
/// quotient over delta.
std::string oneDimensionDerivation(double start, double X, double delta);

/// Lecture 10.1.4 for a planar chain, n = m (the inverse) or n > m (the pseudo-inverse): step i of the run in
/// full, then the whole run. i < run.steps.size().
std::string newtonDerivation(const PlanarChain& chain, const Eigen::Vector2d& X, const NewtonRun& run,
                             std::size_t i);

/// Lecture 10.1.4, the claim of the shortest way: where Newton ended beside the true minimum.
std::string shortestDerivation(const PlanarChain& chain, const Eigen::VectorXd& start,
                               const Eigen::VectorXd& newtonEnd, const NearestSolution& best);

/// Lecture 10.2: three ball joints at the ends of links along x; angles (phi^x, phi^y, phi^z) of each.
std::string rotationsDerivation(const std::array<Eigen::Vector3d, 3>& angles);

/// Lecture 10.2, Denavit-Hartenberg: every frame of the table at q (nq), and the tool's as a matrix.
std::string dhDerivation(const DhTable& table, const Eigen::VectorXd& q);

/// Lecture 10.1.1: one frame of the walk, keyed or pinned: angles of the left leg, and what both soles do.
std::string legDerivation(const LegAnimation& shown, const std::array<FootMeasure, 2>& feet, int frame);

}  // namespace gelenk
