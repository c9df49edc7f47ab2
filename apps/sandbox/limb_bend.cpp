#include "apps/sandbox/limb_bend.h"

#include <algorithm>
#include <cmath>

#include "kinematics/forward_kinematics.h"

namespace gelenk {
namespace {

double bendAt(const Skeleton& skeleton, const Limb& limb, Eigen::VectorXd q, int coordinate, double value) {
  q[coordinate] = value;
  return jointBend(limbFrames(limb, forwardKinematics(skeleton, q)), 1).bend;
}

}  // namespace

std::optional<LimbBend> limbBend(const Skeleton& skeleton, const Limb& limb, const Eigen::VectorXd& q) {
  if (limb.joints.size() < 3) return std::nullopt;
  const Joint& joint = skeleton.joint(limb.joints[1]);
  if (joint.coupling) return std::nullopt;
  std::optional<LimbBend> best;
  for (std::size_t k = 0; k < joint.axes.size(); ++k) {
    const AxisDof& axis = joint.axes[k];
    if (axis.kind != AxisDof::Kind::Rotation) continue;
    constexpr int steps = 24;
    const double lower = std::max(axis.lower, -M_PI), upper = std::min(axis.upper, M_PI);
    const int coordinate = skeleton.qIndex(limb.joints[1]) + static_cast<int>(k);
    LimbBend range{.coordinate = coordinate, .least = 2.0 * M_PI, .most = -1.0};
    for (int i = 0; i <= steps; ++i) {
      const double value = lower + (upper - lower) * i / steps;
      const double bend = bendAt(skeleton, limb, q, coordinate, value);
      if (bend < range.least) range.least = bend, range.straightest = value;
      if (bend > range.most) range.most = bend, range.fullest = value;
    }
    if (!best || range.most - range.least > best->most - best->least) best = range;
  }
  constexpr double bends = 0.1;  // radians: a twist about the bone bends by rounding and by tilted axes alone
  return best && best->most - best->least > bends ? best : std::nullopt;
}

Eigen::VectorXd bentBy(const Skeleton& skeleton, const Limb& limb, const LimbBend& range, Eigen::VectorXd q,
                       double bend) {
  double low = range.straightest, high = range.fullest;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (bendAt(skeleton, limb, q, range.coordinate, middle) < bend ? low : high) = middle;
  }
  q[range.coordinate] = 0.5 * (low + high);
  return q;
}

}  // namespace gelenk
