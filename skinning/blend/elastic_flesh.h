#pragma once

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <array>
#include <vector>

#include "skinning/mesh.h"

namespace gelenk {

/// What is rigid in a body: a segment that a joint carries. Metres, rest pose.
struct FleshBone {
  int joint = 0;
  Eigen::Vector3d head, end;
};

/// The flesh round a joint as an elastic continuum, a reference that knows no skin weights: cubes of the part
/// of the body inside a ball, five tetrahedra each, under
///
///     sum_t V_t (|F - R|^2 + 3 |F - P|^2),   F the deformation gradient, R its nearest rotation,
///                                            P the nearest matrix of determinant 1
///
/// by local and global steps in turn (Bouaziz et al. 2014, projective dynamics, without inertia). Nodes near
/// a bone go with it. There is no contact: a result counts only where the surface does not run through
/// itself.
class ElasticFlesh {
 public:
  /// rest: a closed body. cell: edge of a cube, metres; nodes within `rigid` of a bone are the bone's.
  ElasticFlesh(const Mesh& rest, const std::vector<FleshBone>& bones, const Eigen::Vector3d& centre,
               double radius, double cell = 0.014, double rigid = 0.016);

  void reset() { now_ = rest_; }
  /// Towards the equilibrium where every joint has moved by worldFromRest since rest. In small steps from
  /// rest: what it finds is the equilibrium near the last one.
  void follow(const std::vector<Eigen::Isometry3d>& worldFromRest, int iterations);
  /// Puts the vertices of the mesh that lie in the ball where the flesh carries them.
  void carry(std::vector<Eigen::Vector3d>& positions) const;
  std::size_t cellCount() const { return cells_.size(); }

 private:
  struct Tetrahedron {
    std::array<int, 4> nodes;
    Eigen::Matrix<double, 4, 3> gradients;  ///< of the nodes' hat functions, 1/m
    double volume;
  };
  struct Anchor {
    int vertex, cell;
    Eigen::Vector3d share;  ///< of the cube's edges
  };
  using Places = Eigen::Matrix<double, Eigen::Dynamic, 3>;

  std::vector<std::array<int, 8>> cells_;  ///< nodes; bit 0, 1, 2 of the corner: x, y, z
  std::vector<Tetrahedron> tetrahedra_;
  std::vector<Anchor> anchors_;
  std::vector<int> joint_;    ///< of each node; -1: free
  std::vector<int> unknown_;  ///< of each free node; -1: fixed
  Places rest_, now_;
  Eigen::SparseMatrix<double> freeFromFixed_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver_;
};

}  // namespace gelenk
