#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "skinning/rigging/bone.h"
#include "skinning/skin.h"

namespace gelenk {

// Binding by hand, the lecture's answer to ambiguous assignments (10.3): vertices are brushed or lassoed to a
// bone or a layer. Every operation is a function from weights to a change of some vertices. No graphics.

/// Weights made here are multiples of 2^-30, so that the four of a vertex sum to exactly 1 in any order and
/// mirror exactly. Keeps the four largest of the weights (any number, repeated joints are added up),
/// renormalised, descending; where the fifth is as large as the fourth both go, so that what is symmetric
/// stays so. Throws std::invalid_argument where none is positive or one is not finite.
Influences exactInfluences(std::vector<std::pair<int, double>> weights);

/// Vertices that an operation works on, and how strongly, (0, 1].
struct VertexShare {
  int vertex = 0;
  double share = 1.0;
};
using VertexSelection = std::vector<VertexShare>;

/// For each vertex those that share an edge with it: neighbours[first[v]] ... neighbours[first[v + 1] - 1],
/// ascending.
struct VertexNeighbours {
  std::vector<int> first, neighbours;
  std::span<const int> of(int vertex) const {
    return {neighbours.data() + first[vertex], static_cast<std::size_t>(first[vertex + 1] - first[vertex])};
  }
};
VertexNeighbours vertexNeighbours(const Mesh& mesh);

struct Brush {
  double radius = 0.05;   ///< metres
  double strength = 0.5;  ///< share at the centre, (0, 1]
  /// strength (1 - (d / radius)^2)^2, 0 from the radius on: smooth at both ends.
  double share(double distance) const;
};

/// What lies under the brush: vertices nearer than the radius that are connected with the triangle under the
/// mouse through such vertices, so that a hand beside the hip is left alone. positions: of the surface as it
/// is posed, one a vertex.
VertexSelection underBrush(const Brush& brush, const Eigen::Vector3d& centre,
                           const std::array<int, 3>& triangle, const std::vector<Eigen::Vector3d>& positions,
                           const VertexNeighbours& neighbours);

/// Whether the point lies inside the closed polygon (even-odd rule). Any plane coordinates, such as pixels.
bool insideLasso(const std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& point);

/// What vertices are bound to: one joint, or a layer, that is all joints that carry a limb.
struct PaintTarget {
  std::vector<int> joints;
  std::vector<Bone> bones =
      {};  ///< of these joints in the rest pose: where a vertex begins that the layer did not carry yet
  bool contains(int joint) const;
};

/// Sum of a vertex's weights on the target: the W of a layer.
double weightOn(const Influences& influences, const PaintTarget& target);
std::vector<float> weightsOn(const std::vector<Influences>& weights, const PaintTarget& target);

/// New influences of some vertices.
using WeightChange = std::vector<std::pair<int, Influences>>;

/// Towards the target, w' = (1 - a) w + a t. t is the vertex's present weights on the target, summing to 1;
/// where it has none, the joint of the target whose bone is nearest to restPositions[v] (the first joint
/// without bones).
WeightChange painted(const std::vector<Influences>& weights, const VertexSelection& selection,
                     const PaintTarget& target, const std::vector<Eigen::Vector3d>& restPositions);

/// Away from the target: its weights shrink by 1 - a, the others take their share. A vertex that only the
/// target carries stays as it is, for nothing says who should take it.
WeightChange erased(const std::vector<Influences>& weights, const VertexSelection& selection,
                    const PaintTarget& target);

/// Towards the mean of the neighbours along mesh edges, all from the weights as they were: w' = (1 - a) w + a
/// mean.
WeightChange smoothed(const std::vector<Influences>& weights, const VertexSelection& selection,
                      const VertexNeighbours& neighbours);

/// For each vertex the one that lies at its mirror image in the plane x = 0, within the tolerance (metres);
/// -1 where none does. Positions in the rest pose.
std::vector<int> mirrorVertices(const std::vector<Eigen::Vector3d>& restPositions, double tolerance);

/// Copies one side's weights to the other, joints to their partners (kinematics/symmetry.h). A vertex that is
/// its own mirror image takes the mean of its weights and their mirror image. Vertices without a partner
/// stay.
enum class MirrorFrom { PositiveX, NegativeX };
WeightChange mirrored(const std::vector<Influences>& weights,
                      const std::vector<Eigen::Vector3d>& restPositions,
                      const std::vector<int>& partnerVertex, const std::vector<int>& partnerJoint,
                      MirrorFrom from);

/// What leads from one list of weights to another of the same length.
WeightChange difference(const std::vector<Influences>& from, const std::vector<Influences>& to);

bool operator==(const Influences& a, const Influences& b);

}  // namespace gelenk
