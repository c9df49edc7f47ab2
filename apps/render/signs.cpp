#include "apps/render/signs.h"

#include <algorithm>
#include <array>

namespace gelenk {

using Eigen::Vector3d;

void addBones(Overlay& overlay, const Skeleton& skeleton, const Frames& worldFromJoint, double size,
              const Colour& colour, int selected) {
  // A root that moves freely is a place in the world and no part of the body: no bone leads from it.
  const auto& rootAxes = skeleton.joint(0).axes;
  const bool freeRoot = std::count_if(rootAxes.begin(), rootAxes.end(), [](const AxisDof& dof) {
                          return dof.kind == AxisDof::Kind::Translation;
                        }) == 3;
  for (int j = freeRoot ? 1 : 0; j < skeleton.jointCount(); ++j) {
    const Vector3d at = worldFromJoint[j].translation();
    const int parent = skeleton.parent(j);
    if (parent >= (freeRoot ? 1 : 0)) {
      const Vector3d from = worldFromJoint[parent].translation();
      const double length = (at - from).norm();
      const double thickness = std::clamp(0.07 * length, 0.002 * size, 0.009 * size);
      if (length > 1e-4 * size)
        overlay.bone(from, at, std::min(thickness, 0.25 * length),
                     parent == selected ? accentColour : colour);
    }
    const bool marked = j == selected;
    overlay.point(at, marked ? accentColour : colour, marked ? 9.0f : 5.0f);
  }
}

void addJointFrames(Overlay& overlay, const Frames& worldFromJoint, double size) {
  for (const Eigen::Isometry3d& frame : worldFromJoint) overlay.axes(frame, 0.03 * size);
}

void addJointAxes(Overlay& overlay, const Skeleton& skeleton, const Eigen::VectorXd& q,
                  const Frames& worldFromJoint, double size, const Colour& colour) {
  for (int j = 0; j < skeleton.jointCount(); ++j) {
    const Joint& joint = skeleton.joint(j);
    // The axes turn with the motions before them: walk them from the joint's zero frame.
    Eigen::Isometry3d frame = worldFromJoint[j] * jointMotion(skeleton, q, j).inverse(Eigen::Isometry);
    for (std::size_t k = 0; k < joint.axes.size(); ++k) {
      const Vector3d direction = frame.linear() * joint.axes[k].axis;
      const Vector3d at = frame.translation();
      overlay.dashedLine(at - 0.08 * size * direction, at + 0.08 * size * direction, 0.008 * size, colour);
      const double value = q[skeleton.qIndex(j) + static_cast<int>(k)];
      if (joint.axes[k].kind == AxisDof::Kind::Rotation)
        frame.rotate(Eigen::AngleAxisd(value, joint.axes[k].axis));
      else
        frame.translate(value * joint.axes[k].axis);
    }
  }
}

void addReach(Overlay& overlay, const Vector3d& reached, const Vector3d& target, double size,
              const Colour& colour, Overlay::Shape shape) {
  const double distance = (target - reached).norm();
  if (distance > 1e-3 * size) {
    overlay.line(reached, target, viridis(static_cast<float>(1.0 - distance / (0.5 * size))), 2.0f);
    overlay.point(reached, withAlpha(colour, 0.7f), 7.0f);
  }
  overlay.point(target, colour, 13.0f, shape);
}

void addLattice(Overlay& overlay, const LimbPose& limb, const LatticeLook& look) {
  std::array<Vector3d, 16> before{};
  for (int p = 0; p < static_cast<int>(limb.planes.size()); ++p) {
    const bool marked = p == look.selectedPlane;
    const Colour colour =
        withAlpha(isInnerPlane(p) ? look.inner : look.connecting, marked ? 1.0f : look.opacity);
    const float width = marked ? 2.6f : 1.4f;
    const std::array<Vector3d, 16> points = limb.controlPoints(p);
    for (int c = 0; c < 16; ++c) {
      const int i = c % 4, j = c / 4;
      const bool rim = i == 0 || j == 0 || i == 3 || j == 3;
      if (i > 0) overlay.line(points[c - 1], points[c], colour, j == 0 || j == 3 ? width : 0.5f * width);
      if (j > 0) overlay.line(points[c - 4], points[c], colour, i == 0 || i == 3 ? width : 0.5f * width);
      if (p > 0 && rim) overlay.line(before[c], points[c], withAlpha(colour, look.between), 0.8f);
      overlay.point(points[c], colour,
                    marked && c == look.selectedPoint ? 9.0f
                    : rim || marked                   ? 4.5f
                                                      : 3.0f);
    }
    before = points;
  }
}

}  // namespace gelenk
