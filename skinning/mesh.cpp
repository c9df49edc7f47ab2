#include "skinning/mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <stdexcept>
#include <unordered_map>

namespace gelenk {

using Eigen::Vector3d;

void validate(const Mesh& mesh) {
  if (mesh.positions.empty()) throw std::invalid_argument("the mesh has no vertex");
  if (mesh.triangles.empty()) throw std::invalid_argument("the mesh has no triangle");
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    if (!mesh.positions[v].allFinite())
      throw std::invalid_argument("vertex " + std::to_string(v) + " has a coordinate that is not finite");
  const int count = static_cast<int>(mesh.positions.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const int corner : mesh.triangles[t])
      if (corner < 0 || corner >= count)
        throw std::invalid_argument("triangle " + std::to_string(t) + " refers to vertex " +
                                    std::to_string(corner) + ", the mesh has " + std::to_string(count));
}

void computeNormals(Mesh& mesh) {
  mesh.normals.assign(mesh.positions.size(), Vector3d::Zero());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3d doubleArea =
        (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]);
    for (const int corner : {a, b, c}) mesh.normals[corner] += doubleArea;
  }
  for (Vector3d& n : mesh.normals) n = n.norm() > 0.0 ? Vector3d(n.normalized()) : Vector3d::UnitZ();
}

namespace {

struct DisjointSets {
  std::vector<int> parent;
  explicit DisjointSets(int n) : parent(n) { std::iota(parent.begin(), parent.end(), 0); }
  int find(int a) {
    while (parent[a] != a) a = parent[a] = parent[parent[a]];
    return a;
  }
  void unite(int a, int b) { parent[find(a)] = find(b); }
};

}  // namespace

MeshTopology topology(const Mesh& mesh) {
  MeshTopology facts;
  facts.vertices = static_cast<int>(mesh.positions.size());
  facts.triangles = static_cast<int>(mesh.triangles.size());

  struct Edge {
    int forward = 0, backward = 0;  // how many triangles run along it from the smaller index, and against
    int corners[2] = {-1, -1};      // one corner (3 triangle + k) of the first two triangles
  };
  std::unordered_map<std::uint64_t, Edge> edges;
  edges.reserve(mesh.triangles.size() * 2);
  std::vector<char> referenced(mesh.positions.size(), 0);
  DisjointSets bodies(facts.vertices);

  // Fans: the corners at one vertex, joined across shared edges. More than one set at a vertex: not manifold
  // there.
  DisjointSets fans(3 * facts.triangles);
  for (int t = 0; t < facts.triangles; ++t) {
    const auto& triangle = mesh.triangles[t];
    const Vector3d doubleArea = (mesh.positions[triangle[1]] - mesh.positions[triangle[0]])
                                    .cross(mesh.positions[triangle[2]] - mesh.positions[triangle[0]]);
    if (!(doubleArea.norm() > 0.0)) ++facts.degenerateTriangles;
    for (int k = 0; k < 3; ++k) {
      const int a = triangle[k], b = triangle[(k + 1) % 3];
      referenced[a] = 1;
      if (a == b) continue;
      bodies.unite(a, b);
      Edge& edge = edges[(static_cast<std::uint64_t>(std::min(a, b)) << 32) |
                         static_cast<std::uint32_t>(std::max(a, b))];
      const int use = edge.forward + edge.backward;
      (a < b ? edge.forward : edge.backward) += 1;
      const int cornerOfSmaller = a < b ? 3 * t + k : 3 * t + (k + 1) % 3;
      const int cornerOfLarger = a < b ? 3 * t + (k + 1) % 3 : 3 * t + k;
      if (use == 0) {
        edge.corners[0] = cornerOfSmaller;
        edge.corners[1] = cornerOfLarger;
      } else {
        fans.unite(edge.corners[0], cornerOfSmaller);
        fans.unite(edge.corners[1], cornerOfLarger);
      }
    }
  }
  facts.edges = static_cast<int>(edges.size());
  for (const auto& [key, edge] : edges) {
    const int uses = edge.forward + edge.backward;
    if (uses == 1) ++facts.boundaryEdges;
    if (uses > 2 || edge.forward > 1 || edge.backward > 1) ++facts.nonManifoldEdges;
  }

  std::vector<int> fanOfVertex(mesh.positions.size(), -1);
  std::vector<char> counted(mesh.positions.size(), 0);
  for (int corner = 0; corner < 3 * facts.triangles; ++corner) {
    const int v = mesh.triangles[corner / 3][corner % 3];
    const int fan = fans.find(corner);
    if (fanOfVertex[v] < 0) fanOfVertex[v] = fan;
    if (fanOfVertex[v] != fan && !counted[v]) {
      counted[v] = 1;
      ++facts.nonManifoldVertices;
    }
  }
  for (int v = 0; v < facts.vertices; ++v) {
    if (!referenced[v])
      ++facts.unreferencedVertices;
    else if (bodies.find(v) == v)
      ++facts.components;
  }
  return facts;
}

double enclosedVolume(const Mesh& mesh) {
  double sixfold = 0.0;
  for (const auto& [a, b, c] : mesh.triangles)
    sixfold += mesh.positions[a].dot(mesh.positions[b].cross(mesh.positions[c]));
  return sixfold / 6.0;
}

double bodySize(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : mesh.positions) box.extend(p);
  return box.isEmpty() ? 0.0 : box.diagonal().norm();
}

}  // namespace gelenk
