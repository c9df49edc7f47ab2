#pragma once

#include <string>
#include <vector>

#include "kinematics/skeleton.h"
#include "skinning/blend/linear_blend.h"
#include "skinning/blend/twist_spread.h"
#include "skinning/muscles/muscle_layer.h"

namespace gelenk {

/// A limb of a skeleton that carries a muscle layer: joints[i] carries link i and joints[i + 1] is its child
/// at the link's end. The last joint is the tip (wrist, ankle): its turn about the last bone is spread along
/// that bone.
struct Limb {
  std::string name;
  std::vector<int> joints;  ///< one more than links
  LimbShape shape;
  std::vector<Eigen::Matrix3d>
      jointFromLink;  ///< rotation: z along the bone, y the bend axis, x the inside of the bend
  bool spreadNearTwist =
      true;  ///< undo the first joint's own axial twist at plane 0, so that it spreads along the first link
  int parent = -1;  ///< of the first joint
  Eigen::Matrix3d parentFromFirstLinkAtRest = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d lastLinkFromTipAtRest = Eigen::Matrix3d::Identity();
  std::vector<double> bendAtRest;  ///< of each joint between links, radians
  std::vector<double> twistAtRest;
  /// Of every joint, about the bone that it turns (the tip: about the last one).
  std::vector<TwistCoordinate> twistCoordinates;
};

/// Builds a limb from the rest pose. The bend axis of all links is that of the first joint between links that
/// has a rotation axis (turned so that the larger part of its range is positive); for ball joints the rest
/// pose's own bend; for straight ones bendAxisInWorld. Throws std::invalid_argument naming the joint: not
/// consecutive, a zero-length link, no bend axis known.
Limb makeLimb(const Skeleton& skeleton, const Frames& restFrames, std::string name, std::vector<int> joints,
              const Eigen::Vector3d& bendAxisInWorld = Eigen::Vector3d::Zero());

/// q: the configuration that the frames come from, where it is known; without it a twist beyond half a turn
/// jumps by a whole one.
LimbFrames limbFrames(const Limb& limb, const Frames& worldFromJoint, const Eigen::VectorXd* q = nullptr);

/// A vertex of the body on a limb: F(uvw) of its volume replaces the rigid motions of the limb's bones in the
/// skinning sum.
struct LimbVertex {
  static constexpr int beyondNear = -1, beyondFar = -2;
  int limb = -1;  ///< -1: not on any limb, plain linear blend skinning
  int volume =
      0;  ///< or beyondNear / beyondFar: carried rigidly by the end frame, uvw are its coordinates there
  Eigen::Vector3d uvw = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< m = J_rest^T n_rest (end frames: n in that frame)
  double weight = 0.0;                               ///< W: sum of the vertex's weights on the limb's bones
};

/// A skin with muscle layers. x' = sum over bones outside limbs w_b T_b x + W F(x): the limb acts as one
/// "super-bone". A vertex with weights on two limbs belongs to the heavier one; the bones of the other stay
/// linear.
struct MuscleSkin {
  Skin skin;
  std::vector<Limb> limbs;
  std::vector<LimbVertex> vertices;  ///< one a vertex of the skin
  std::vector<Influences> outside;   ///< what remains of skin.influences, not renormalised: sums to 1 - W
  int unbound = 0;  ///< vertices with limb weights for which the rest lattice has no parameters; left linear
};

/// Binds each vertex by solving the rest lattice (built by the same seam rule from the rest frames) for its
/// parameters, so that the rest pose is reproduced exactly however the rig rests. Fits each limb's section
/// rectangle to the vertices that are mainly on the limb. Throws std::invalid_argument for a limb whose
/// planes would cross.
MuscleSkin bindMuscles(Skin skin, std::vector<Limb> limbs, const Frames& restFrames);

/// Pose of every limb without muscles. q: see limbFrames.
std::vector<LimbPose> poseLimbs(const MuscleSkin& body, const Frames& worldFromJoint,
                                const Eigen::VectorXd* q = nullptr);

/// Positions and unit normals on the CPU in double precision: the reference for the shader.
void skinWithMuscles(const MuscleSkin& body, const Frames& worldFromJoint, const std::vector<LimbPose>& limbs,
                     SkinnedVertices& out);

/// F alone: the position of a bound vertex, and with its unit normal.
Eigen::Vector3d deformLimbPoint(const LimbPose& pose, const LimbVertex& vertex);
std::pair<Eigen::Vector3d, Eigen::Vector3d> deformLimbVertex(const LimbPose& pose, const LimbVertex& vertex);

}  // namespace gelenk
