#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <vector>

#include "solvers/problem/ik_solver.h"
#include "solvers/serial/serial_chain.h"

namespace gelenk {

/// Families of six-joint arms whose pose equation has a closed form here.
enum class ArmFamily {
  None,
  SphericalWrist,  ///< axes 4, 5, 6 meet in a point; axes 2 and 3 are parallel and not parallel to 1 (PUMA,
                   ///< most industrial arms)
  ThreeParallelAxes,  ///< axes 2, 3, 4 are parallel; 4 meets 5 and 5 meets 6 (UR)
};

/// One branch of the closed form.
struct ArmBranch {
  Eigen::Matrix<double, 6, 1> q;  ///< radians, brought within limits by whole turns where that is possible
  bool exact = false;  ///< false: a part was out of reach and the nearest point of that part was taken
  bool withinLimits = false;
};

/// The family of the chain, and, for None, the reason in words.
ArmFamily armFamily(const SerialChain& chain, std::string* whyNot = nullptr);

/// All branches (at most eight: two of the shoulder, the elbow and the wrist each) for a pose of the tip;
/// none for other families. At a singular wrist (axes 4 and 6 in line; UR: axis 6 along the parallel ones)
/// only a sum of angles is determined: the free one is taken from `reference` (6). Where the shoulder is
/// undetermined (the wrist on axis 1) so is q_1. Pieper 1968; for three parallel axes Hawkins 2013.
std::vector<ArmBranch> armBranches(
    const SerialChain& chain, const Eigen::Isometry3d& worldFromTip,
    const Eigen::Matrix<double, 6, 1>& reference = Eigen::Matrix<double, 6, 1>::Zero());

/// Solver around armBranches(): of the exact branches within limits the one nearest to the start; otherwise
/// the branch with the smallest error after its angles are clamped to the limits, with Stop::Stalled: it is
/// not a least-squares solution.
std::unique_ptr<IkSolver> makeSphericalWrist();

}  // namespace gelenk
