#pragma once

#include "skinning/blend/skin_method.h"
#include "skinning/muscles/muscle_skin.h"

namespace gelenk {

// Muscle layers beside any skinning method, in displacement form:
//
//     x' = S(x; bones outside the limb, E with the weight W) + W (F(x) - E x)
//
// S a method, F the limb's volumes, W the vertex's weight on the limb and E the rigid frame of the limb's
// near end (its first link) or far end (its last): beside the limb the body keeps what the method gives,
// inside it (W = 1) all of S is E x and F alone remains. With S linear it is the sum of MuscleSkin.

/// A skin with muscle layers, made ready for a method.
struct LayeredSkin {
  /// The skin whose limb bones are merged into the limbs' ends: behind the skeleton's joints follow two for
  /// each limb, near and far.
  PreparedSkin outside;
  std::vector<int> endJoint;         ///< E of each vertex, among the joints of `outside`; -1: on no limb
  std::vector<LimbVertex> vertices;  ///< MuscleSkin's
};

/// bound: frames of the bind pose. Twist is spread along bones outside limbs only; the layers have their own.
LayeredSkin prepareLayers(const MuscleSkin& body, const SkinMethod& method, const Frames& bound,
                          TwistSpread spread = {});

/// Some vertices of it alone, see verticesOf(PreparedSkin); `outside` of the MuscleSkin is not filled.
LayeredSkin verticesOf(const LayeredSkin& layered, std::span<const int> vertices);

/// The pose of `outside`: the joints' frames and the ends of the posed limbs.
Frames withEnds(const Frames& worldFromJoint, const std::vector<LimbPose>& limbs);

/// Positions and unit normals in double precision: the reference for the shader. The normal is that of S and
/// of F, mixed by W.
void skinWithMuscles(const LayeredSkin& layered, const Frames& worldFromJoint,
                     const std::vector<LimbPose>& limbs, SkinnedVertices& out,
                     const Eigen::VectorXd* q = nullptr, SkinNormals normals = SkinNormals::Gradients);

}  // namespace gelenk
