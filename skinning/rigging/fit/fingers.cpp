#include "skinning/rigging/fit/fingers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>

namespace gelenk {

using Eigen::Vector3d;

namespace {

/// The surface beyond the wrist as a graph of welded vertices, with their distances from the wrist along it.
struct HandGraph {
  std::vector<Vector3d> points;
  std::vector<std::vector<int>> neighbours;
  std::vector<double> distance;  ///< infinite where it hangs together with no wrist
};

HandGraph handGraph(const Mesh& mesh, const HandPlace& hand, double length) {
  const Vector3d along = (hand.wrist - hand.elbow).normalized();
  const auto height = [&](const Vector3d& p) { return along.dot(p - hand.wrist); };
  const double grain = 1e-5 * length;
  HandGraph graph;
  std::map<std::array<long long, 3>, int> at;
  std::vector<int> of(mesh.positions.size(), -1);
  for (std::size_t v = 0; v < of.size(); ++v) {
    const Vector3d& p = mesh.positions[v];
    if (height(p) < -0.15 * length || (p - hand.wrist).norm() > 1.8 * length) continue;
    std::array<long long, 3> cell;
    for (int d = 0; d < 3; ++d) cell[d] = std::llround((p[d] - hand.wrist[d]) / grain);
    const auto [found, fresh] = at.emplace(cell, static_cast<int>(graph.points.size()));
    if (fresh) graph.points.push_back(p);
    of[v] = found->second;
  }
  graph.neighbours.resize(graph.points.size());
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = of[t[k]], b = of[t[(k + 1) % 3]];
      if (a < 0 || b < 0 || a == b) continue;
      graph.neighbours[a].push_back(b);
      graph.neighbours[b].push_back(a);
    }
  for (auto& list : graph.neighbours) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }

  // The cuff begins at the vertex nearest to the wrist: a thigh beside the hand is none of it.
  graph.distance.assign(graph.points.size(), std::numeric_limits<double>::infinity());
  std::vector<int> cuff;
  for (int v = 0; v < static_cast<int>(graph.points.size()); ++v)
    if (height(graph.points[v]) < 0.0 && !graph.neighbours[v].empty() &&
        (cuff.empty() || (graph.points[v] - hand.wrist).norm() < (graph.points[cuff[0]] - hand.wrist).norm()))
      cuff = {v};
  if (cuff.empty()) return graph;
  graph.distance[cuff[0]] = 0.0;
  for (std::size_t k = 0; k < cuff.size(); ++k)
    for (const int to : graph.neighbours[cuff[k]])
      if (height(graph.points[to]) < 0.0 && graph.distance[to] != 0.0)
        graph.distance[to] = 0.0, cuff.push_back(to);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  for (const int v : cuff) open.push({0.0, v});
  while (!open.empty()) {
    const auto [d, from] = open.top();
    open.pop();
    if (d > graph.distance[from]) continue;
    for (const int to : graph.neighbours[from])
      if (const double further = d + (graph.points[to] - graph.points[from]).norm();
          further < graph.distance[to])
        open.push({graph.distance[to] = further, to});
  }
  return graph;
}

/// A part of the hand that hangs together beyond the present distance.
struct Branch {
  double tip = 0.0;
  std::vector<int> members = {};
  bool palm = false;  ///< several fingers have met in it
};
struct FingerBranch {
  double tip, web;  ///< distances of its end and of the place where it meets the next one
  std::vector<int> members;
};

/// Branches longer than `least`, by sweeping from the far end to the wrist.
std::vector<FingerBranch> longBranches(const HandGraph& graph, double least) {
  std::vector<int> order;
  for (int v = 0; v < static_cast<int>(graph.points.size()); ++v)
    if (std::isfinite(graph.distance[v])) order.push_back(v);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return graph.distance[a] > graph.distance[b]; });
  std::vector<int> parent(graph.points.size(), -1);
  std::vector<Branch> branches(graph.points.size());
  const auto rootOf = [&](int v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  std::vector<FingerBranch> out;
  for (const int v : order) {
    const double level = graph.distance[v];
    parent[v] = v;
    branches[v] = {level, {v}};
    for (const int to : graph.neighbours[v]) {
      if (parent[to] < 0) continue;
      int a = rootOf(v), b = rootOf(to);
      if (a == b) continue;
      if (branches[a].tip < branches[b].tip) std::swap(a, b);
      Branch &tall = branches[a], &small = branches[b];
      const auto counts = [&](const Branch& branch) { return branch.palm || branch.tip - level > least; };
      if (counts(tall) && counts(small)) {
        for (Branch* branch : {&tall, &small})
          if (!branch->palm) out.push_back({branch->tip, level, std::move(branch->members)});
        tall.palm = true;
        tall.members.clear();
      } else if (small.palm) {
        tall.palm = true;
        tall.members.clear();
      } else if (!tall.palm) {
        tall.members.insert(tall.members.end(), small.members.begin(), small.members.end());
      }
      parent[b] = a;
    }
  }
  return out;
}

/// From the tip to the web, the middles of the cuts at even distances.
std::vector<Vector3d> middleLine(const HandGraph& graph, const FingerBranch& finger) {
  std::vector<Vector3d> line{
      graph.points[*std::max_element(finger.members.begin(), finger.members.end(),
                                     [&](int a, int b) { return graph.distance[a] < graph.distance[b]; })]};
  constexpr int cuts = 10;
  for (int k = 1; k <= cuts; ++k) {
    const double level = finger.tip - (finger.tip - finger.web) * k / cuts;
    Vector3d sum = Vector3d::Zero();
    int crossings = 0;
    for (const int v : finger.members) {
      if (graph.distance[v] <= level) continue;
      for (const int to : graph.neighbours[v]) {
        if (graph.distance[to] > level) continue;
        const double share = (graph.distance[v] - level) / (graph.distance[v] - graph.distance[to]);
        sum += graph.points[v] + share * (graph.points[to] - graph.points[v]);
        ++crossings;
      }
    }
    if (crossings > 2) line.push_back(sum / crossings);
  }
  return line;
}

/// The point a way along a line of points, past its end straight on.
Vector3d pointAlong(const std::vector<Vector3d>& line, double way) {
  for (std::size_t k = 1; k < line.size(); ++k) {
    const double step = (line[k] - line[k - 1]).norm();
    if (way <= step && step > 0.0) return line[k - 1] + way / step * (line[k] - line[k - 1]);
    way -= step;
  }
  const Vector3d& last = line.back();
  return last + way * (last - line[line.size() > 4 ? line.size() - 4 : 0]).normalized();
}

double lengthOf(const std::vector<Vector3d>& line) {
  double length = 0.0;
  for (std::size_t k = 1; k < line.size(); ++k) length += (line[k] - line[k - 1]).norm();
  return length;
}

}  // namespace

std::vector<FingerJoints> findFingers(const Mesh& mesh, const HandPlace& hand) {
  // From the tip, in lengths of the part that stands free: where the joints lie in the bodies of MakeHuman.
  constexpr double places[5][3] = {
      {2.0, 1.41, 0.64}, {1.14, 0.76, 0.42}, {1.15, 0.71, 0.35}, {1.21, 0.78, 0.40}, {1.31, 0.78, 0.45}};
  const double length = 2.0 * (hand.knuckles - hand.wrist).norm();
  if (!(length > 0.0) || !((hand.wrist - hand.elbow).norm() > 0.0)) return {};
  const HandGraph graph = handGraph(mesh, hand, length);
  // Little fingers stand free over 0.16 to 0.25 of that length, bumps of a hand over less than 0.05.
  std::vector<FingerBranch> branches = longBranches(graph, 0.1 * length);
  if (branches.size() < 4 || branches.size() > 5) return {};
  std::vector<std::vector<Vector3d>> lines;
  for (const FingerBranch& branch : branches) {
    lines.push_back(middleLine(graph, branch));
    if (lines.back().size() < 6) return {};
  }
  // The thumb parts from the hand nearest to the wrist; the others follow by how far they are from it.
  std::vector<int> order(branches.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<int>(k);
  const int thumb = *std::min_element(order.begin(), order.end(),
                                      [&](int a, int b) { return branches[a].web < branches[b].web; });
  const auto fromThumb = [&](int k) { return (lines[k].back() - lines[thumb].back()).norm(); };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return fromThumb(a) < fromThumb(b); });
  std::vector<FingerJoints> out;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::vector<Vector3d>& line = lines[order[k]];
    const double free = lengthOf(line);
    FingerJoints joints;
    for (int j = 0; j < 3; ++j) joints[j] = pointAlong(line, places[k][j] * free);
    joints[3] = pointAlong(line, 0.04 * free);
    out.push_back(joints);
  }
  return out;
}

}  // namespace gelenk
