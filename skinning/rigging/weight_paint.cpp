#include "skinning/rigging/weight_paint.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>

namespace gelenk {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double unit = 0x1p-30;  // sums of multiples of it up to 1 are exact in double precision

using JointWeights = std::vector<std::pair<int, double>>;

void add(JointWeights& sum, const Influences& influences, double factor) {
  for (int k = 0; k < 4; ++k)
    if (influences.weights[k] > 0.0) sum.emplace_back(influences.joints[k], factor * influences.weights[k]);
}

/// Equal weights on equal joints, whatever their order; the joint of a weight 0 does not count.
bool sameWeights(const Influences& a, const Influences& b) {
  for (int k = 0; k < 4; ++k)
    if (a.weights[k] != b.weights[k] || (a.weights[k] > 0.0 && a.joints[k] != b.joints[k])) return false;
  return true;
}

/// Adds the change only where something changes.
void record(WeightChange& change, int vertex, const Influences& before, const Influences& after) {
  if (!sameWeights(before, after)) change.emplace_back(vertex, after);
}

int nearestJoint(const PaintTarget& target, const Vector3d& p) {
  const auto nearest =
      std::min_element(target.bones.begin(), target.bones.end(),
                       [&](const Bone& a, const Bone& b) { return distanceTo(a, p) < distanceTo(b, p); });
  return nearest == target.bones.end() ? target.joints.front() : nearest->joint;
}

}  // namespace

bool operator==(const Influences& a, const Influences& b) { return sameWeights(a, b); }

Influences exactInfluences(JointWeights weights) {
  std::sort(weights.begin(), weights.end());
  JointWeights merged;
  for (const auto& [joint, weight] : weights) {
    if (!std::isfinite(weight))
      throw std::invalid_argument("the weight of joint " + std::to_string(joint) + " is not finite");
    if (weight <= 0.0) continue;
    if (!merged.empty() && merged.back().first == joint)
      merged.back().second += weight;
    else
      merged.emplace_back(joint, weight);
  }
  if (merged.empty()) throw std::invalid_argument("no weight is positive");
  std::stable_sort(merged.begin(), merged.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  if (merged.size() > 4) {  // a pair of equal weights, left and right, goes or stays together
    std::size_t kept = 4;
    while (kept > 0 && merged[kept - 1].second == merged[4].second) --kept;
    merged.resize(kept > 0 ? kept : 4);
  }
  double sum = 0.0;
  for (const auto& entry : merged) sum += entry.second;
  Influences result;
  double rest = 1.0;
  for (std::size_t k = 1; k < merged.size(); ++k) {
    result.weights[k] = 2.0 * unit * std::round(merged[k].second / sum / (2.0 * unit));
    if (result.weights[k] > 0.0) result.joints[k] = merged[k].first;
    rest -= result.weights[k];
  }
  result.joints[0] = merged[0].first;
  result.weights[0] = rest;
  if (merged.size() > 1 && merged[0].second == merged[1].second)
    result.weights[0] = result.weights[1] = 0.5 * (result.weights[0] + result.weights[1]);
  for (std::size_t k = 1; k < 4 && result.weights[k] > result.weights[k - 1];
       ++k) {  // rounding may reverse equal weights
    std::swap(result.weights[k], result.weights[k - 1]);
    std::swap(result.joints[k], result.joints[k - 1]);
  }
  return result;
}

VertexNeighbours vertexNeighbours(const Mesh& mesh) {
  std::vector<std::pair<int, int>> edges;
  edges.reserve(6 * mesh.triangles.size());
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      edges.emplace_back(t[k], t[(k + 1) % 3]);
      edges.emplace_back(t[(k + 1) % 3], t[k]);
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  VertexNeighbours result{.first = std::vector<int>(mesh.positions.size() + 1, 0), .neighbours = {}};
  for (const auto& [from, to] : edges) {
    if (from == to) continue;
    ++result.first[from + 1];
    result.neighbours.push_back(to);
  }
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) result.first[v + 1] += result.first[v];
  return result;
}

double Brush::share(double distance) const {
  const double t = distance / radius;
  return t < 1.0 ? strength * (1.0 - t * t) * (1.0 - t * t) : 0.0;
}

VertexSelection underBrush(const Brush& brush, const Vector3d& centre, const std::array<int, 3>& triangle,
                           const std::vector<Vector3d>& positions, const VertexNeighbours& neighbours) {
  VertexSelection selection;
  std::vector<char> seen(positions.size(), 0);
  std::vector<int> open;
  for (const int v : triangle) {  // the corners always lead on, even from a triangle larger than the brush
    seen[v] = 1;
    open.push_back(v);
  }
  while (!open.empty()) {
    const int v = open.back();
    open.pop_back();
    const double share = brush.share((positions[v] - centre).norm());
    if (share > 0.0) selection.push_back({v, share});
    if (share <= 0.0 && std::find(triangle.begin(), triangle.end(), v) == triangle.end()) continue;
    for (const int n : neighbours.of(v))
      if (!seen[n]) {
        seen[n] = 1;
        open.push_back(n);
      }
  }
  std::sort(selection.begin(), selection.end(),
            [](const auto& a, const auto& b) { return a.vertex < b.vertex; });
  return selection;
}

bool insideLasso(const std::vector<Vector2d>& polygon, const Vector2d& point) {
  bool inside = false;
  for (std::size_t i = 0, before = polygon.size() - 1; i < polygon.size(); before = i++) {
    const Vector2d &a = polygon[before], &b = polygon[i];
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    if (point.x() < a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
  }
  return inside;
}

bool PaintTarget::contains(int joint) const {
  return std::find(joints.begin(), joints.end(), joint) != joints.end();
}

double weightOn(const Influences& influences, const PaintTarget& target) {
  double sum = 0.0;
  for (int k = 0; k < 4; ++k)
    if (target.contains(influences.joints[k])) sum += influences.weights[k];
  return sum;
}

std::vector<float> weightsOn(const std::vector<Influences>& weights, const PaintTarget& target) {
  std::vector<float> values;
  values.reserve(weights.size());
  for (const Influences& influences : weights)
    values.push_back(static_cast<float>(weightOn(influences, target)));
  return values;
}

WeightChange painted(const std::vector<Influences>& weights, const VertexSelection& selection,
                     const PaintTarget& target, const std::vector<Vector3d>& restPositions) {
  if (target.joints.empty()) throw std::invalid_argument("a target to paint needs at least one joint");
  WeightChange change;
  for (const auto& [v, share] : selection) {
    const Influences& before = weights[v];
    const double present = weightOn(before, target);
    JointWeights sum;
    add(sum, before, 1.0 - share);
    if (present > 0.0) {
      for (int k = 0; k < 4; ++k)
        if (target.contains(before.joints[k]))
          sum.emplace_back(before.joints[k], share * before.weights[k] / present);
    } else {
      sum.emplace_back(nearestJoint(target, restPositions[v]), share);
    }
    record(change, v, before, exactInfluences(std::move(sum)));
  }
  return change;
}

WeightChange erased(const std::vector<Influences>& weights, const VertexSelection& selection,
                    const PaintTarget& target) {
  WeightChange change;
  for (const auto& [v, share] : selection) {
    const Influences& before = weights[v];
    const double present = weightOn(before, target);
    if (present <= 0.0 || present >= 1.0 - unit) continue;
    JointWeights sum;
    for (int k = 0; k < 4; ++k)
      sum.emplace_back(before.joints[k],
                       before.weights[k] * (target.contains(before.joints[k]) ? 1.0 - share : 1.0));
    record(change, v, before, exactInfluences(std::move(sum)));
  }
  return change;
}

WeightChange smoothed(const std::vector<Influences>& weights, const VertexSelection& selection,
                      const VertexNeighbours& neighbours) {
  WeightChange change;
  for (const auto& [v, share] : selection) {
    const auto around = neighbours.of(v);
    if (around.empty()) continue;
    JointWeights sum;
    add(sum, weights[v], 1.0 - share);
    for (const int n : around) add(sum, weights[n], share / static_cast<double>(around.size()));
    record(change, v, weights[v], exactInfluences(std::move(sum)));
  }
  return change;
}

std::vector<int> mirrorVertices(const std::vector<Vector3d>& rest, double tolerance) {
  if (!(tolerance > 0.0)) throw std::invalid_argument("the tolerance of mirror images must be positive");
  using Cell = std::tuple<long, long, long>;
  const auto cellOf = [&](const Vector3d& p) {
    return Cell{std::lround(p.x() / tolerance), std::lround(p.y() / tolerance),
                std::lround(p.z() / tolerance)};
  };
  std::map<Cell, std::vector<int>> cells;
  for (std::size_t v = 0; v < rest.size(); ++v) cells[cellOf(rest[v])].push_back(static_cast<int>(v));
  std::vector<int> partner(rest.size(), -1);
  for (std::size_t v = 0; v < rest.size(); ++v) {
    const Vector3d image(-rest[v].x(), rest[v].y(), rest[v].z());
    const auto [x, y, z] = cellOf(image);
    double nearest = tolerance;
    for (long dx = -1; dx <= 1; ++dx)
      for (long dy = -1; dy <= 1; ++dy)
        for (long dz = -1; dz <= 1; ++dz) {
          const auto cell = cells.find({x + dx, y + dy, z + dz});
          if (cell == cells.end()) continue;
          for (const int other : cell->second)
            if (const double d = (rest[other] - image).norm();
                d <= nearest && (partner[v] < 0 || d < nearest)) {
              nearest = d;
              partner[v] = other;
            }
        }
  }
  return partner;
}

WeightChange mirrored(const std::vector<Influences>& weights, const std::vector<Vector3d>& rest,
                      const std::vector<int>& partnerVertex, const std::vector<int>& partnerJoint,
                      MirrorFrom from) {
  const double side = from == MirrorFrom::PositiveX ? 1.0 : -1.0;
  WeightChange change;
  for (int v = 0; v < static_cast<int>(weights.size()); ++v) {
    const int source = partnerVertex[v];
    if (source < 0 || (source != v && side * rest[v].x() >= 0.0)) continue;
    JointWeights sum;
    for (int k = 0; k < 4; ++k) {
      sum.emplace_back(partnerJoint[weights[source].joints[k]], weights[source].weights[k]);
      if (source == v) sum.emplace_back(weights[v].joints[k], weights[v].weights[k]);
    }
    record(change, v, weights[v], exactInfluences(std::move(sum)));
  }
  return change;
}

WeightChange difference(const std::vector<Influences>& from, const std::vector<Influences>& to) {
  WeightChange change;
  for (std::size_t v = 0; v < to.size(); ++v) record(change, static_cast<int>(v), from.at(v), to[v]);
  return change;
}

}  // namespace gelenk
