#include "apps/document/limb.h"

namespace gelenk {

std::optional<int> limbMiddle(const Skeleton& skeleton, int joint) {
  int j = skeleton.parent(joint);
  for (int steps = 0; j > 0 && steps < 3; ++steps, j = skeleton.parent(j)) {
    const Joint& middle = skeleton.joint(j);
    const Joint& above = skeleton.joint(middle.parent);
    const bool hinge = !middle.ball && (middle.axes.size() == 1 || middle.axes.size() == 2) &&
                       middle.axes[0].kind == AxisDof::Kind::Rotation &&
                       middle.axes[0].upper - middle.axes[0].lower > 1.5;
    if (hinge && (above.ball || above.axes.size() >= 2)) return j;
    if (middle.ball) return std::nullopt;
  }
  return std::nullopt;
}

Eigen::Vector3d polePoint(const Skeleton& skeleton, const Frames& frames, int middle) {
  const Eigen::Vector3d a = frames[skeleton.parent(middle)].translation();
  const Eigen::Vector3d b = frames[middle].translation();
  const Eigen::Vector3d c =
      skeleton.children(middle).empty() ? b : frames[skeleton.children(middle).front()].translation();
  const double length = (b - a).norm() + (c - b).norm();
  Eigen::Vector3d side = b - a;
  if (const Eigen::Vector3d u = c - a; u.norm() > 0.0) side -= u * u.dot(b - a) / u.squaredNorm();
  if (side.norm() < 1e-6 * length) side = frames[middle].linear().col(1);
  return b + 0.5 * length * side.normalized();
}

}  // namespace gelenk
