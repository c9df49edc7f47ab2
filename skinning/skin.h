#pragma once

#include <array>
#include <string>
#include <vector>

#include "kinematics/forward_kinematics.h"
#include "skinning/mesh.h"

namespace gelenk {

/// Up to four joints that carry a vertex; unused entries have weight 0. Weights are >= 0, descending, and sum
/// to 1.
struct Influences {
  std::array<int, 4> joints{0, 0, 0, 0};
  std::array<double, 4> weights{1.0, 0.0, 0.0, 0.0};
};

/// A mesh bound to a skeleton: v_anim = sum_i w_i T_anim,i T_rest,i^-1 v_rest (exercise sheet, linear blend
/// skinning). T_rest^-1 = jointFromRestWorld is constant and computed once. "Bone i" of a skin is whatever is
/// rigidly carried by joint i.
struct Skin {
  Mesh mesh;                                          ///< in the rest pose, world coordinates, with normals
  std::vector<Influences> influences;                 ///< one a vertex
  std::vector<Eigen::Isometry3d> jointFromRestWorld;  ///< one a joint

  int jointCount() const { return static_cast<int>(jointFromRestWorld.size()); }
};

/// A full weight matrix, row by row: weights[v] lists (joint, weight) in any number and order.
using SparseWeights = std::vector<std::vector<std::pair<int, double>>>;

/// What keeping only the four largest weights loses: per vertex 1 - (sum of the four largest) / (sum of all).
struct WeightLoss {
  double mean = 0.0, max = 0.0;
  int verticesOverFour = 0;
};

/// The four largest weights of each vertex, renormalised. Throws std::invalid_argument for a vertex whose
/// weights are negative, not finite or all zero, and for joint indices out of range.
std::vector<Influences> fourLargest(const SparseWeights& weights, int jointCount, WeightLoss* loss = nullptr);

/// Binds a mesh to the skeleton's rest pose. The mesh gets normals where it has none.
Skin bindSkin(Mesh mesh, const Frames& restFrames, std::vector<Influences> influences);

/// T_skin,i = T_anim,i T_rest,i^-1 for every joint: what the vertex shader needs.
std::vector<Eigen::Isometry3d> skinningMatrices(const Skin& skin, const Frames& worldFromJoint);

}  // namespace gelenk
