#pragma once

#include <Eigen/Core>
#include <optional>

#include "skinning/muscles/muscle_skin.h"

namespace gelenk {

/// How far the joint between a limb's first two links (elbow, knee) bends by the hinge that bends it most.
/// Bends as JointBend has them: radians, straight = 0.
struct LimbBend {
  int coordinate = -1;             ///< of q
  double straightest = 0.0;        ///< its value at the least bend within the limits, radians
  double fullest = 0.0;            ///< and at the greatest; the bend grows all the way between the two
  double least = 0.0, most = 0.0;  ///< bends at both
};

/// limb: bound to the skeleton. nullopt for a limb of one link and where no hinge bends the joint.
std::optional<LimbBend> limbBend(const Skeleton& skeleton, const Limb& limb, const Eigen::VectorXd& q);

/// q with that one coordinate moved so that the joint bends by so much, at most within the range.
Eigen::VectorXd bentBy(const Skeleton& skeleton, const Limb& limb, const LimbBend& range, Eigen::VectorXd q,
                       double bend);

}  // namespace gelenk
