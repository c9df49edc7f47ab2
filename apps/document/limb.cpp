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

}  // namespace gelenk
