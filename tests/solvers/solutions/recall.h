#pragma once

#include "solvers/solutions/complete_set.h"
#include "tests/solvers/solutions/example_arms.h"

namespace gelenk::testing {

/// Largest entry of the difference of the pose reached from the pose wanted.
inline double poseError(const SerialChain& chain, const Vector6d& q, const Eigen::Isometry3d& pose) {
  return (tipFrame(chain, q).matrix() - pose.matrix()).cwiseAbs().maxCoeff();
}

struct Recall {
  int targets = 0, missed = 0, missedSingular = 0, incomplete = 0;
  double worst = 0.0;  ///< pose error of any solution
  void operator+=(const Recall& o) {
    targets += o.targets, missed += o.missed, missedSingular += o.missedSingular, incomplete += o.incomplete;
    worst = std::max(worst, o.worst);
  }
};

/// Targets of random joints: the configuration that made one must be in its set, to 1e-5 rad. Singular:
/// within 1e-4 (smallest singular value of the Jacobian).
inline Recall recall(const SixJointArm& arm, int targets, std::uint64_t seed) {
  Recall r{.targets = targets};
  std::mt19937_64 random(seed);
  ArmSolutions found;
  for (int t = 0; t < targets; ++t) {
    const Vector6d q = randomAngles(random);
    const Eigen::Isometry3d pose = tipFrame(arm.chain(), q);
    arm.solve(pose, Vector6d::Zero(), found);
    r.incomplete += !found.complete;
    bool hit = false;
    for (const ArmSolution& s : found.all()) {
      r.worst = std::max(r.worst, poseError(arm.chain(), s.q, pose));
      hit |= apart(s.q, q) < 1e-5;
    }
    if (!hit) (singularity(arm.chain(), q).sigmaMin > 1e-4 ? r.missed : r.missedSingular) += 1;
  }
  return r;
}

}  // namespace gelenk::testing
