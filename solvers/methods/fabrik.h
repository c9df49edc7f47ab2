#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

struct FabrikParameters {
  double bend = 0.01;

  static constexpr auto fields() {
    using P = FabrikParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::bend, "bend", 1e-6, 1.0, "1", "ours",
          "A straight chain in line with its target is first bent by this share of its first bone."}});
  }
};

/// Forward and backward reaching on bare points (no rotations, no limits): points[0] stays, the distances
/// between neighbours stay, the last point comes within `tolerance` of the target where it can. Target out of
/// reach: the straight chain towards it. A straight chain in line with its target is bent a little first.
/// Returns the iterations done. Aristidou, Lasenby 2011.
struct FabrikResult {
  int iterations = 0;
  double distance = 0.0;  ///< of the last point from the target, metres
};
FabrikResult fabrikPoints(std::span<Eigen::Vector3d> points, const Eigen::Vector3d& target, double tolerance,
                          int maxIterations, const FabrikParameters& parameters = {});

/// FABRIK on a skeleton: one position goal. The backward pass moves points alone; the forward pass turns each
/// joint on the path, root first, towards the points that the backward pass asks for, within its limits
/// (swing cone, twist range, hinge range), and goes on from where the joint really ends. A ball takes the
/// smallest rotation that brings the next place onto its line (no twist is added); a hinge in a plane does
/// the same by its angle; a hinge of a spatial chain takes the angle that brings all places below it closest
/// to where they are wanted, in the sum of squares, since the next one alone says nothing about a twist. So
/// the pose is a pose of the skeleton after every iteration, twist included. Translations on the path are
/// held. Chains of unlimited balls run on bare points and recover their rotations once.
///
/// With limits nothing guarantees progress; an answer that stalls says so.
std::unique_ptr<IkSolver> makeFabrik(const FabrikParameters& parameters = {});

}  // namespace gelenk
