#include "apps/render/signs.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace gelenk {

using Eigen::Vector3d;

namespace {

constexpr Colour rgb(unsigned hex) {
  return {static_cast<float>(hex >> 16 & 0xff) / 255.0f, static_cast<float>(hex >> 8 & 0xff) / 255.0f,
          static_cast<float>(hex & 0xff) / 255.0f};
}
Colour between(const Colour& a, const Colour& b, float t) {
  return {a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b), a.a + t * (b.a - a.a)};
}

}  // namespace

const MarkColours& markColours(Theme theme) {
  static constexpr MarkColours light{.dim = rgb(0x62666d),
                                     .accent = rgb(0x1f66b0),
                                     .held = rgb(0xd9790b),
                                     .pinned = rgb(0x0b7f73),
                                     .pole = rgb(0x8d5fb0),
                                     .free = rgb(0x4a5058),
                                     .good = rgb(0x1d8348),
                                     .warning = rgb(0xb7791f),
                                     .bad = rgb(0xc0392b)};
  static constexpr MarkColours dark{.dim = rgb(0xa3a8b0),
                                    .accent = rgb(0x4c9be8),
                                    .held = rgb(0xf5a33b),
                                    .pinned = rgb(0x35c4b3),
                                    .pole = rgb(0xbf93e0),
                                    .free = rgb(0xcdd2d9),
                                    .good = rgb(0x5cc98a),
                                    .warning = rgb(0xe3b341),
                                    .bad = rgb(0xff6b5e)};
  return theme == Theme::Light ? light : dark;
}

Colour distanceColour(const MarkColours& colours, double metres) {
  const float t =
      static_cast<float>(std::clamp(std::log10(std::max(metres, 1e-9) / 1e-3) / std::log10(200.0), 0.0, 1.0));
  return t < 0.5f ? between(colours.good, colours.warning, 2.0f * t)
                  : between(colours.warning, colours.bad, 2.0f * t - 1.0f);
}

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
