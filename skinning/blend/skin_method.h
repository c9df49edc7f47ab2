#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "skinning/blend/linear_blend.h"
#include "skinning/blend/twist_spread.h"
#include "skinning/skin.h"

/// Every skinning method there is. A new one: a line here, a file blend/NAME.cpp that defines its SkinMethod,
/// and, where the vertex shader shall have it, a part of skinning/gpu/shaders (docs/skinning/README.md).
#define GELENK_SKIN_METHODS(ROW) \
  ROW(Lbs, lbsMethod)            \
  ROW(Dqs, dqsMethod)            \
  ROW(Cor, corMethod)            \
  ROW(Ddm0, ddm0Method)          \
  ROW(Ddm2, ddm2Method)          \
  ROW(DeltaMush, deltaMushMethod)

namespace gelenk {

#define GELENK_ENUMERATOR(Kind, method) Kind,
enum class SkinMethodKind { GELENK_SKIN_METHODS(GELENK_ENUMERATOR) };
#undef GELENK_ENUMERATOR

/// Derivatives of a vertex's four weights along the two tangents of its rest surface (surfaceTangents), 1/m;
/// each column sums to 0.
using WeightSlopes = Eigen::Matrix<double, 4, 2>;
/// Derivatives of a point along the two tangents.
using PointSlopes = Eigen::Matrix<double, 3, 2>;

/// What a method alone prepares and reads.
struct MethodData {
  virtual ~MethodData() = default;
};

struct SkinMethod;

/// A skin with what its method needs beyond it: made once for a body (prepareSkin).
struct PreparedSkin {
  Skin skin;
  const SkinMethod* method = nullptr;
  TwistSpread spread = {};                    ///< empty: twist is not spread
  std::vector<WeightSlopes> slopes = {};      ///< one a vertex
  std::vector<Eigen::Vector3d> centres = {};  ///< centres of rotation; empty where the method has none
  std::vector<PointSlopes> centreSlopes = {};
  std::shared_ptr<const MethodData> own = {};
};

/// A pose as the methods read it.
struct PosedBones {
  std::vector<Eigen::Isometry3d> worldFromRest;  ///< T_j = T_anim,j T_rest,j^-1
  std::vector<BoneTwist> twists;                 ///< one a bone of the spread
};
/// q: see boneTwists. Throws std::invalid_argument where the pose has another number of joints.
PosedBones poseBones(const PreparedSkin& prepared, const Frames& worldFromJoint,
                     const Eigen::VectorXd* q = nullptr);

enum class SkinNormals {
  Gradients,  ///< tangents with the derivatives of the weights: exact to first order (Tarini et al. 2014)
  Cheap,      ///< cofactors of the blended matrix (lbs), the blended rotation (others)
};

/// A way of blending the motions of a vertex's bones.
struct SkinMethod {
  SkinMethodKind kind = SkinMethodKind::Lbs;
  std::string_view name;       ///< for programs: "lbs"
  std::string_view title;      ///< for people
  std::string_view reference;  ///< where it comes from
  /// Adds what the method needs to a PreparedSkin that has skin and slopes; null: nothing.
  void (*prepare)(PreparedSkin&) = nullptr;
  /// Positions and unit normals of all vertices (world, metres), in double precision: the reference for the
  /// shader. out has the right sizes.
  void (*blend)(const PreparedSkin&, const PosedBones&, SkinNormals, SkinnedVertices& out) = nullptr;
  std::string_view shader = {};  ///< word of its part of the vertex shader; empty: on the processor only
  bool twists = true;            ///< its twist can be spread along bones
  int bytesAVertex = 0;          ///< beyond linear blending's, normals apart; floats
};
const SkinMethod& skinMethod(SkinMethodKind kind);
std::span<const SkinMethod* const> skinMethods();
/// Throws std::invalid_argument that lists the names there are.
const SkinMethod& skinMethodNamed(std::string_view name);

PreparedSkin prepareSkin(Skin skin, const SkinMethod& method, TwistSpread spread = {});
/// Some vertices of it alone, without triangles: for a few points of a large skin. Not of methods that keep
/// data of their own.
PreparedSkin verticesOf(const PreparedSkin& prepared, std::span<const int> vertices);

/// Positions and unit normals in world coordinates.
void blendSkin(const PreparedSkin& prepared, const PosedBones& bones, SkinnedVertices& out,
               SkinNormals normals = SkinNormals::Gradients);
SkinnedVertices blendSkin(const PreparedSkin& prepared, const Frames& worldFromJoint,
                          const Eigen::VectorXd* q = nullptr, SkinNormals normals = SkinNormals::Gradients);

}  // namespace gelenk
