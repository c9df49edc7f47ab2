#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

namespace gelenk {

/// A triangle mesh. positions in metres; triangles counter-clockwise seen from outside; normals (unit, one a
/// vertex) may be empty until computeNormals.
struct Mesh {
  std::vector<Eigen::Vector3d> positions;
  std::vector<std::array<int, 3>> triangles;
  std::vector<Eigen::Vector3d> normals;
};

/// Throws std::invalid_argument: an index out of range, a position that is not finite, no vertex or no
/// triangle.
void validate(const Mesh& mesh);

/// Unit vertex normals: the mean of the adjacent faces' normals weighted by area (vertices without a face get
/// +z).
void computeNormals(Mesh& mesh);

/// Facts about the surface, for `gelenk info` and for tests.
struct MeshTopology {
  int vertices = 0, triangles = 0, edges = 0;
  int components = 0;           ///< connected by edges; unreferenced vertices not counted
  int boundaryEdges = 0;        ///< edges of one triangle
  int nonManifoldEdges = 0;     ///< edges of more than two triangles, or of two that disagree on orientation
  int nonManifoldVertices = 0;  ///< vertices whose triangles form more than one fan
  int unreferencedVertices = 0;
  int degenerateTriangles = 0;  ///< a repeated corner, or zero area
  bool closed() const { return boundaryEdges == 0; }
  bool manifold() const { return nonManifoldEdges == 0 && nonManifoldVertices == 0; }
  int eulerCharacteristic() const { return vertices - unreferencedVertices - edges + triangles; }
};
MeshTopology topology(const Mesh& mesh);

/// Signed volume by the divergence theorem (positive when the triangles face outwards). Cubic metres; needs a
/// closed mesh.
double enclosedVolume(const Mesh& mesh);
/// Diagonal of the bounding box, metres.
double bodySize(const Mesh& mesh);

}  // namespace gelenk
