#include "skinning/creases.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace gelenk {

using Eigen::Vector3d;

Mesh withCreases(const Mesh& mesh, double angle, std::vector<int>* from) {
  struct Corner {
    int vertex, triangle, place;
    int next, previous;  // the triangle's other two vertices
    int own;             // as the mesh has it; the others are the first in their place
  };
  std::map<std::array<double, 3>, int> firstAt;
  std::vector<int> same;
  for (const Vector3d& p : mesh.positions)
    same.push_back(firstAt.try_emplace({p.x(), p.y(), p.z()}, static_cast<int>(same.size())).first->second);
  std::vector<Corner> corners;
  std::vector<Vector3d> area;  // twice the triangle's, along its normal
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& v = mesh.triangles[t];
    area.push_back(
        (mesh.positions[v[1]] - mesh.positions[v[0]]).cross(mesh.positions[v[2]] - mesh.positions[v[0]]));
    for (int k = 0; k < 3; ++k)
      corners.push_back(
          {same[v[k]], static_cast<int>(t), k, same[v[(k + 1) % 3]], same[v[(k + 2) % 3]], v[k]});
  }
  std::ranges::stable_sort(corners, {}, &Corner::vertex);
  const double most = std::cos(angle);
  const auto smooth = [&](const Corner& a, const Corner& b) {
    const bool adjacent =
        a.next == b.previous || a.previous == b.next || a.next == b.next || a.previous == b.previous;
    const double product = area[a.triangle].norm() * area[b.triangle].norm();
    // One without an area has no direction: it must not part its neighbours.
    return adjacent && (product <= 0.0 || area[a.triangle].dot(area[b.triangle]) >= most * product);
  };
  Mesh out{.positions = {}, .triangles = mesh.triangles, .normals = {}};
  if (from) from->clear();
  std::vector<int> piece;
  std::vector<std::pair<int, int>> made;  // of a piece: the vertex that was, and the one that is
  for (std::size_t begin = 0, end; begin < corners.size(); begin = end) {
    end = begin;
    while (end < corners.size() && corners[end].vertex == corners[begin].vertex) ++end;
    piece.resize(end - begin);
    std::iota(piece.begin(), piece.end(), 0);
    const auto root = [&](int i) {
      while (piece[i] != i) i = piece[i] = piece[piece[i]];
      return i;
    };
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t j = begin; j < i; ++j)
        if (smooth(corners[i], corners[j]))
          piece[root(static_cast<int>(i - begin))] = root(static_cast<int>(j - begin));
    const Vector3d at = mesh.positions[corners[begin].vertex];
    for (std::size_t first = begin; first < end; ++first) {
      if (root(static_cast<int>(first - begin)) != static_cast<int>(first - begin)) continue;
      Vector3d normal = Vector3d::Zero();
      made.clear();
      for (std::size_t i = begin; i < end; ++i) {
        const Corner& corner = corners[i];
        if (root(static_cast<int>(i - begin)) != static_cast<int>(first - begin)) continue;
        auto known = std::ranges::find(made, corner.own, &std::pair<int, int>::first);
        if (known == made.end()) {
          made.emplace_back(corner.own, static_cast<int>(out.positions.size()));
          known = made.end() - 1;
          out.positions.push_back(at);
          if (from) from->push_back(corner.own);
        }
        out.triangles[corner.triangle][corner.place] = known->second;
        const Vector3d a = mesh.positions[corner.next] - at, b = mesh.positions[corner.previous] - at;
        normal += std::atan2(a.cross(b).norm(), a.dot(b)) * area[corner.triangle];
      }
      out.normals.resize(out.positions.size(),
                         normal.norm() > 0.0 ? normal.stableNormalized() : Vector3d(Vector3d::UnitZ()));
    }
  }
  return out;
}

}  // namespace gelenk
