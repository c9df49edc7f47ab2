#pragma once

#include <vector>

#include "apps/document/theme.h"
#include "apps/render/overlay.h"
#include "kinematics/forward_kinematics.h"
#include "skinning/muscles/muscle_layer.h"

namespace gelenk {

// Signs of an articulated model, made from its frames. size: a typical length of the scene (the body's
// diagonal).

/// Slim octahedral bones from each joint to its children; joints without a child end in a point; a freely
/// moving root is left out. selected: drawn in the accent colour with the bones that it carries; -1 for none.
void addBones(Overlay& overlay, const Skeleton& skeleton, const Frames& worldFromJoint, double size,
              const Colour& colour, int selected = -1);
/// Red, green and blue axes of every joint.
void addJointFrames(Overlay& overlay, const Frames& worldFromJoint, double size);
/// The axis of every rotation and translation as a dashed line through its joint. q: nq.
void addJointAxes(Overlay& overlay, const Skeleton& skeleton, const Eigen::VectorXd& q,
                  const Frames& worldFromJoint, double size, const Colour& colour);
/// Colours that mean the same in the picture, in panels and in plots.
struct MarkColours {
  Colour dim, accent;               ///< words beside; what is chosen, the workspace
  Colour held, pinned, pole, free;  ///< goals by their state
  Colour good, warning, bad;
};
const MarkColours& markColours(Theme theme);
/// good at a millimetre, over warning to bad at 20 cm, by the logarithm.
Colour distanceColour(const MarkColours& colours, double metres);

inline constexpr Colour boneColour = {0.33f, 0.46f, 0.60f};
inline constexpr Colour accentColour = {0.99f, 0.62f, 0.18f};

inline constexpr Colour connectingPlaneColour = {0.05f, 0.48f, 0.47f};
inline constexpr Colour innerPlaneColour = {0.85f, 0.50f, 0.05f};

/// How the lattice of a limb with muscle layers is drawn. Planes are counted along the limb: 6 link + (0 ...
/// 6).
struct LatticeLook {
  Colour connecting = connectingPlaneColour, inner = innerPlaneColour;
  float opacity = 0.75f, between = 0.3f;       ///< of the planes, and of the lines from plane to plane
  int selectedPlane = -1, selectedPoint = -1;  ///< drawn stronger; -1: none
};
inline bool isInnerPlane(int plane) { return plane % 6 >= 2 && plane % 6 <= 4; }
/// The control planes of a limb, 4 x 4 points each.
void addLattice(Overlay& overlay, const LimbPose& limb, const LatticeLook& look = {});

}  // namespace gelenk
