#include "skinning/blend/surface_slopes.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

namespace gelenk {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

/// (A^T A)^-1 A^T of the steps from a vertex to its neighbours in its tangent plane: takes differences to
/// derivatives. Rows of zeros where the steps span no plane.
Eigen::Matrix2Xd differencesToSlopes(const Mesh& mesh, int vertex, const std::vector<int>& neighbours) {
  const Eigen::Matrix<double, 3, 2> tangents = surfaceTangents(mesh.normals[vertex]);
  Eigen::Matrix2Xd steps(2, static_cast<Eigen::Index>(neighbours.size()));
  for (std::size_t i = 0; i < neighbours.size(); ++i)
    steps.col(static_cast<Eigen::Index>(i)) =
        tangents.transpose() * (mesh.positions[neighbours[i]] - mesh.positions[vertex]);
  const Eigen::Matrix2d square = steps * steps.transpose();
  const double trace = square.trace();
  if (!(square.determinant() > 1e-8 * trace * trace)) return Eigen::Matrix2Xd::Zero(2, steps.cols());
  return square.inverse() * steps;
}

}  // namespace

Eigen::Matrix<double, 3, 2> surfaceTangents(const Vector3d& n) {
  const double side = static_cast<float>(n.z()) >= 0.0f ? 1.0 : -1.0;
  const double a = -1.0 / (side + n.z()), b = n.x() * n.y() * a;
  Eigen::Matrix<double, 3, 2> tangents;
  tangents << 1.0 + side * n.x() * n.x() * a, b, side * b, side + n.y() * n.y() * a, -side * n.x(), -n.y();
  return tangents;
}

std::vector<std::vector<int>> surfaceRings(const Mesh& mesh) {
  const int count = static_cast<int>(mesh.positions.size());
  std::map<std::array<double, 3>, int> firstAt;
  std::vector<int> same(count);
  std::vector<std::vector<int>> ring(count);
  for (int v = 0; v < count; ++v) {
    const Vector3d& p = mesh.positions[v];
    same[v] = firstAt.try_emplace({p.x(), p.y(), p.z()}, v).first->second;
  }
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = same[t[k]], b = same[t[(k + 1) % 3]];
      if (a == b) continue;
      ring[a].push_back(b);
      ring[b].push_back(a);
    }
  for (int v = 0; v < count; ++v) {
    if (same[v] != v) continue;
    std::sort(ring[v].begin(), ring[v].end());
    ring[v].erase(std::unique(ring[v].begin(), ring[v].end()), ring[v].end());
  }
  for (int v = 0; v < count; ++v)
    if (same[v] != v) ring[v] = ring[same[v]];
  return ring;
}

std::vector<Eigen::Matrix<double, 4, 2>> weightSlopes(const Skin& skin) {
  const auto ring = surfaceRings(skin.mesh);
  std::vector<Eigen::Matrix<double, 4, 2>> slopes(ring.size(), Eigen::Matrix<double, 4, 2>::Zero());
  for (std::size_t v = 0; v < ring.size(); ++v) {
    const Influences& own = skin.influences[v];
    const Eigen::Matrix2Xd inverse = differencesToSlopes(skin.mesh, static_cast<int>(v), ring[v]);
    for (std::size_t i = 0; i < ring[v].size(); ++i) {
      const Influences& other = skin.influences[ring[v][i]];
      for (int k = 0; k < 4 && own.weights[k] > 0.0; ++k) {
        double weight = 0.0;
        for (int j = 0; j < 4; ++j)
          if (other.joints[j] == own.joints[k]) weight += other.weights[j];
        slopes[v].row(k) += (weight - own.weights[k]) * inverse.col(static_cast<Eigen::Index>(i)).transpose();
      }
    }
    const Eigen::RowVector2d sum = slopes[v].colwise().sum();
    for (int k = 0; k < 4; ++k) slopes[v].row(k) -= own.weights[k] * sum;
  }
  return slopes;
}

std::vector<Eigen::Matrix<double, 3, 2>> pointSlopes(const Mesh& mesh, const std::vector<Vector3d>& points,
                                                     const std::vector<bool>& defined) {
  auto ring = surfaceRings(mesh);
  std::vector<Eigen::Matrix<double, 3, 2>> slopes(ring.size(), Eigen::Matrix<double, 3, 2>::Zero());
  for (std::size_t v = 0; v < ring.size(); ++v) {
    if (!defined[v]) continue;
    std::erase_if(ring[v], [&](int u) { return !defined[u]; });
    const Eigen::Matrix2Xd inverse = differencesToSlopes(mesh, static_cast<int>(v), ring[v]);
    for (std::size_t i = 0; i < ring[v].size(); ++i)
      slopes[v] += (points[ring[v][i]] - points[v]) * inverse.col(static_cast<Eigen::Index>(i)).transpose();
  }
  return slopes;
}

}  // namespace gelenk
