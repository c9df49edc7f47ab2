#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <span>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

struct BallChainParameters {
  double damping = 1e-3, largestTurn = 1.0;

  static constexpr auto fields() {
    using P = BallChainParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::damping, "damping", 0.0, 1e3, "1", "ours; form: Chan, Lawrence 1988",
          "Share of the squared error in lambda."},
         {&P::largestTurn, "largest-turn", 1e-3, 3.2, "rad", "ours", "No joint turns farther in one step."}});
  }
};

/// Levenberg-Marquardt for a chain of unlimited ball joints and one position goal, without ever forming J:
/// with r_i = effector - joint i the block of joint i in J is -[r_i]x, so that
///     J J^T = sum_i (r_i . r_i) I - r_i r_i^T,    dq_i = r_i x (J J^T + lambda I)^-1 e,    lambda = damping
///     c |e|^2
/// a 3 x 3 system whatever the number of joints. A step turns no joint by more than largest-turn; c is 1 and
/// grows by 8 whenever a step made the error larger.
///
/// points: joints, then the effector (n + 1); moved. rotations: n world rotations that the bones have turned
/// by, multiplied on the left; may be empty where they are not wanted. Stops at `tolerance` (metres) or when
/// the error has stopped falling.
struct BallChainResult {
  int iterations = 0;
  double distance = 0.0;  ///< metres
};
BallChainResult solveBallChain(std::span<Eigen::Vector3d> points, std::span<Eigen::Quaterniond> rotations,
                               const Eigen::Vector3d& target, double tolerance, int maxIterations,
                               const BallChainParameters& parameters = {});

/// The same behind the solver interface: one position goal, all joints on its path unlimited balls or fixed.
std::unique_ptr<IkSolver> makeBallChain(const BallChainParameters& parameters = {});

}  // namespace gelenk
