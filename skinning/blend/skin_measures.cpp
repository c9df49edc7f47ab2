#include "skinning/blend/skin_measures.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

namespace gelenk {
namespace {

using Eigen::Vector3d;
using Edge = std::pair<int, int>;

Vector3d pointAt(const SkinSection::Point& p, const std::vector<Vector3d>& positions) {
  return (1.0 - p.share) * positions[p.a] + p.share * positions[p.b];
}

double loopArea(const std::vector<SkinSection::Point>& loop, const std::vector<Vector3d>& positions) {
  const Vector3d origin = pointAt(loop[0], positions);
  Vector3d sum = Vector3d::Zero(), before = Vector3d::Zero();
  for (std::size_t i = 1; i < loop.size(); ++i) {
    const Vector3d now = pointAt(loop[i], positions) - origin;
    sum += before.cross(now);
    before = now;
  }
  return 0.5 * sum.norm();
}

/// The closed curves of a plane through the mesh. height: of every vertex above it, never 0.
std::vector<std::vector<SkinSection::Point>> cutLoops(const Mesh& mesh, const std::vector<double>& height) {
  std::map<Edge, Edge> next;  // from the edge where a triangle is entered to the one where it is left
  for (const auto& t : mesh.triangles) {
    Edge in{-1, -1}, out{-1, -1};
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      if ((height[a] > 0.0) == (height[b] > 0.0)) continue;
      (height[a] > 0.0 ? out : in) = {std::min(a, b), std::max(a, b)};
    }
    if (in.first >= 0) next[in] = out;
  }
  std::vector<std::vector<SkinSection::Point>> loops;
  while (!next.empty()) {
    const Edge start = next.begin()->first;
    std::vector<SkinSection::Point> loop;
    Edge at = start;
    for (auto found = next.find(at); found != next.end(); found = next.find(at)) {
      loop.push_back({at.first, at.second, height[at.first] / (height[at.first] - height[at.second])});
      at = found->second;
      next.erase(found);
    }
    if (at == start && loop.size() > 2) loops.push_back(std::move(loop));
  }
  return loops;
}

std::vector<std::array<int, 3>> trianglesWithin(const Mesh& mesh, const Vector3d& centre, double radius) {
  const auto isInside = [&](int v) { return (mesh.positions[v] - centre).norm() < radius; };
  std::vector<std::array<int, 3>> triangles;
  std::ranges::copy_if(mesh.triangles, std::back_inserter(triangles),
                       [&](const auto& t) { return std::ranges::all_of(t, isInside); });
  return triangles;
}

}  // namespace

std::vector<SkinSection> sectionsAlong(const Mesh& mesh, const Vector3d& head, const Vector3d& end,
                                       int count) {
  std::vector<SkinSection> sections;
  const double length = (end - head).norm();
  if (!(length > 0.0)) return sections;
  const Vector3d axis = (end - head) / length;
  std::vector<double> height(mesh.positions.size());
  for (int i = 1; i <= count; ++i) {
    const Vector3d at = head + (end - head) * i / (count + 1);
    for (std::size_t v = 0; v < height.size(); ++v) {
      height[v] = axis.dot(mesh.positions[v] - at);
      if (height[v] == 0.0) height[v] = 1e-12 * length;
    }
    double nearest = 0.5 * length;
    SkinSection best;
    for (auto& loop : cutLoops(mesh, height)) {
      Vector3d middle = Vector3d::Zero();
      double farthest = 0.0;
      for (const SkinSection::Point& p : loop) {
        const Vector3d x = pointAt(p, mesh.positions);
        middle += x / static_cast<double>(loop.size());
        farthest = std::max(farthest, (x - at).norm());
      }
      if (farthest > 0.5 * length || (middle - at).norm() >= nearest) continue;
      nearest = (middle - at).norm();
      best.points = std::move(loop);
    }
    if (best.points.empty()) continue;
    best.restArea = loopArea(best.points, mesh.positions);
    if (best.restArea > 0.0) sections.push_back(std::move(best));
  }
  return sections;
}

double smallestSection(const std::vector<SkinSection>& sections, const std::vector<Vector3d>& positions) {
  double least = sections.empty() ? 1.0 : 1e300;
  for (const SkinSection& section : sections)
    least = std::min(least, loopArea(section.points, positions) / section.restArea);
  return least;
}

PartVolume::PartVolume(const Mesh& mesh, const Vector3d& centre, double radius)
    : PartVolume(trianglesWithin(mesh, centre, radius)) {}

PartVolume::PartVolume(const std::vector<std::array<int, 3>>& triangles) {
  std::map<int, std::vector<int>> next;  // border edges turned round
  std::map<Edge, int> open;
  for (const auto& t : triangles) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    triangles_.push_back(t);
    for (int k = 0; k < 3; ++k) {
      const Edge edge{t[k], t[(k + 1) % 3]}, back{edge.second, edge.first};
      if (const auto found = open.find(back); found != open.end())
        open.erase(found);
      else
        open[edge] = 1;
    }
  }
  for (const auto& [edge, one] : open) next[edge.second].push_back(edge.first);
  while (!next.empty()) {
    std::vector<int> loop;
    int at = next.begin()->first;
    for (auto found = next.find(at); found != next.end(); found = next.find(at)) {
      loop.push_back(at);
      at = found->second.back();
      found->second.pop_back();
      if (found->second.empty()) next.erase(found);
    }
    openings_.push_back(std::move(loop));
  }
}

double PartVolume::volume(const std::vector<Vector3d>& positions) const {
  if (triangles_.empty()) return 0.0;
  const Vector3d origin = positions[triangles_[0][0]];
  const auto six = [&](const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    return (a - origin).dot((b - origin).cross(c - origin));
  };
  double sum = 0.0;
  for (const auto& [a, b, c] : triangles_) sum += six(positions[a], positions[b], positions[c]);
  for (const std::vector<int>& loop : openings_) {
    Vector3d hub = Vector3d::Zero();
    for (const int v : loop) hub += positions[v] / static_cast<double>(loop.size());
    for (std::size_t i = 0; i < loop.size(); ++i)
      sum += six(hub, positions[loop[i]], positions[loop[(i + 1) % loop.size()]]);
  }
  return sum / 6.0;
}

MeshEdges innerEdges(const Mesh& mesh) {
  std::map<Edge, int> opposite;  // directed edge -> third corner
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) opposite[{t[k], t[(k + 1) % 3]}] = t[(k + 2) % 3];
  MeshEdges edges;
  for (const auto& [edge, c] : opposite) {
    if (edge.first > edge.second) continue;
    if (const auto back = opposite.find({edge.second, edge.first}); back != opposite.end())
      edges.corners.push_back({edge.first, edge.second, c, back->second});
  }
  return edges;
}

std::vector<double> edgeAngles(const MeshEdges& edges, const std::vector<Vector3d>& positions) {
  std::vector<double> angles;
  angles.reserve(edges.corners.size());
  for (const auto& [a, b, c, d] : edges.corners) {
    const Vector3d along = positions[b] - positions[a];
    const Vector3d left = along.cross(positions[c] - positions[a]),
                   right = (positions[d] - positions[a]).cross(along);
    const double length = along.norm();
    angles.push_back(length > 0.0 ? std::atan2(left.cross(right).dot(along) / length, left.dot(right)) : 0.0);
  }
  return angles;
}

double crease(const std::vector<double>& rest, const std::vector<double>& now) {
  std::vector<double> growth(rest.size());
  for (std::size_t i = 0; i < rest.size(); ++i) growth[i] = std::abs(now[i]) - std::abs(rest[i]);
  const std::size_t count = std::min<std::size_t>(50, growth.size());
  if (count == 0) return 0.0;
  std::partial_sort(growth.begin(), growth.begin() + static_cast<std::ptrdiff_t>(count), growth.end(),
                    std::greater<>());
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) sum += growth[i];
  return sum / static_cast<double>(count);
}

SurfaceDistance::SurfaceDistance(const Mesh& mesh) : round_(mesh.positions.size()) {
  for (const auto& t : mesh.triangles)
    for (const int v : t) round_[v].push_back(t);
}

double SurfaceDistance::of(const Vector3d& point, int vertex, const std::vector<Vector3d>& positions) const {
  double least = (positions[vertex] - point).squaredNorm();
  for (bool nearer = true; nearer;) {
    nearer = false;
    for (const auto& t : round_[vertex])
      for (const int v : t)
        if (const double d = (positions[v] - point).squaredNorm(); d < least)
          least = d, vertex = v, nearer = true;
  }
  for (const auto& [i, j, k] : round_[vertex])
    for (const auto& [a, b, c] : {std::array{i, j, k}, std::array{j, k, i}, std::array{k, i, j}}) {
      const Vector3d along = positions[b] - positions[a], other = positions[c] - positions[a],
                     to = point - positions[a], normal = along.cross(other);
      const double s = std::clamp(to.dot(along) / std::max(along.squaredNorm(), 1e-300), 0.0, 1.0);
      least = std::min(least, (to - s * along).squaredNorm());  // the edge; below, the inside
      const double square = normal.squaredNorm();
      if (!(square > 0.0)) continue;
      const double v = along.cross(to).dot(normal) / square, u = to.cross(other).dot(normal) / square;
      if (u >= 0.0 && v >= 0.0 && u + v <= 1.0) least = std::min(least, std::pow(to.dot(normal), 2) / square);
    }
  return std::sqrt(least);
}

std::vector<double> normalErrors(const Mesh& mesh, const std::vector<Vector3d>& positions,
                                 const std::vector<Vector3d>& normals) {
  Mesh posed{.positions = positions, .triangles = mesh.triangles, .normals = {}};
  computeNormals(posed);
  std::vector<double> errors(normals.size());
  for (std::size_t v = 0; v < normals.size(); ++v)
    errors[v] = std::atan2(normals[v].cross(posed.normals[v]).norm(), normals[v].dot(posed.normals[v]));
  return errors;
}

}  // namespace gelenk
