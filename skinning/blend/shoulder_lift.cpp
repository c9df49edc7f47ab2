#include "skinning/blend/shoulder_lift.h"

#include <algorithm>

#include "skinning/blend/surface_slopes.h"

namespace gelenk {

using Eigen::Vector3d;

void liftShoulderCentres(PreparedSkin& prepared, const Skeleton& skeleton, const Frames& bound,
                         const std::vector<LimbChain>& limbs, double lift) {
  if (prepared.centres.empty() || limbs.size() != 4) return;
  Vector3d up = Vector3d::Zero();
  for (const LimbChain& limb : limbs)
    up += (limb.arm ? 0.5 : -0.5) * bound[limb.joints.front()].translation();
  if (!(up.norm() > 0.0)) return;
  up.normalize();
  const std::vector<Vector3d>& rest = prepared.skin.mesh.positions;
  std::vector<bool> blended(rest.size());
  for (std::size_t v = 0; v < rest.size(); ++v)
    blended[v] = prepared.skin.influences[v].weights[1] > 0.0 && prepared.centres[v] != rest[v];
  for (const LimbChain& limb : limbs) {
    if (!limb.arm) continue;
    const int shoulder = limb.joints.front();
    for (std::size_t v = 0; v < rest.size(); ++v) {
      const Influences& in = prepared.skin.influences[v];
      double onArm = 0.0, squares = 0.0;
      for (int k = 0; k < 4; ++k) {
        squares += in.weights[k] * in.weights[k];
        if (in.joints[k] == shoulder || skeleton.isAncestor(shoulder, in.joints[k])) onArm += in.weights[k];
      }
      const double pairs = 0.5 * (1.0 - squares), across = onArm * (1.0 - onArm);
      if (!(pairs > 1e-9) || !(across > 0.0)) continue;
      const double share = lift * std::min(1.0, across / pairs);
      prepared.centres[v] += share * up.dot(rest[v] - prepared.centres[v]) * up;
    }
  }
  prepared.centreSlopes = pointSlopes(prepared.skin.mesh, prepared.centres, blended);
}

}  // namespace gelenk
