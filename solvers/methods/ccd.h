#pragma once

#include <memory>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

struct CcdParameters {
  double arm = 1.0;

  static constexpr auto fields() {
    using P = CcdParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::arm, "arm", 1e-3, 1e3, "m", "ours",
          "A radian of a pose's orientation weighs like this way of its point."}});
  }
};
/// Cyclic coordinate descent: one dof after the other, from the effector to the root, takes the value that
/// alone minimises
///     |t - p|^2 + 1/2 arm^2 sum_k |R e_k - T e_k|^2      (the parts that the goal asks for; the sum is about
///     twice the squared angle)
/// which is an atan2 for a rotation and a projection for a translation. A ball takes the smallest rotation
/// that turns the effector towards the target (position goals) or turns about three axes in sequence; it is
/// then brought back within its swing cone and twist range. One position, orientation or pose goal. Wang,
/// Chen 1991.
///
/// Needs no Jacobian and no singular pose stops it, but the joints near the effector do most of the work, and
/// progress is linear.
std::unique_ptr<IkSolver> makeCcd(const CcdParameters& parameters = {});

}  // namespace gelenk
