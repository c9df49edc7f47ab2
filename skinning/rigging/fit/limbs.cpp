#include "skinning/rigging/fit/limbs.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <queue>

namespace gelenk {

namespace {

/// Distances inside the body in voxels, from all sources at once; unreached: -1.
std::vector<float> distancesInside(const VoxelBody& body, const std::vector<int>& sources) {
  std::vector<float> distance(body.voxelCount(), -1.0f);
  using Entry = std::pair<float, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  for (const int v : sources) open.push({distance[v] = 0.0f, v});
  while (!open.empty()) {
    const float d = open.top().first;
    const int from = open.top().second;
    open.pop();
    if (d > distance[from]) continue;
    body.eachNeighbour(from, [&, d = d](int to, float step) {
      if (body.isOutside(to) || (distance[to] >= 0.0f && distance[to] <= d + step)) return;
      open.push({distance[to] = d + step, to});
    });
  }
  return distance;
}

/// A connected piece of what is further from the middle than the present level.
struct Branch {
  float tip = 0.0f, thickness = 0.0f;
  int limbs = 0;
};

}  // namespace

int countLimbs(const VoxelBody& body) {
  std::vector<int> inside, skin;
  for (int v = 0; v < body.voxelCount(); ++v) {
    if (body.isOutside(v)) continue;
    inside.push_back(v);
    bool atAir = false;
    body.eachNeighbour(v, [&](int to, float) { atAir = atAir || body.isOutside(to); });
    if (atAir) skin.push_back(v);
  }
  if (inside.empty()) return 0;
  const std::vector<float> depth = distancesInside(body, skin);
  const auto deepest =
      std::max_element(inside.begin(), inside.end(), [&](int a, int b) { return depth[a] < depth[b]; });
  const std::vector<float> reach = distancesInside(body, {*deepest});
  std::erase_if(inside, [&](int v) { return reach[v] < 0.0f; });  // other pieces
  std::stable_sort(inside.begin(), inside.end(), [&](int a, int b) { return reach[a] > reach[b]; });
  const float least = 0.2f * reach[inside.front()];

  std::vector<int> parent(body.voxelCount(), -1);
  std::vector<Branch> branches(body.voxelCount());
  const auto rootOf = [&](int v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const int v : inside) {
    parent[v] = v;
    branches[v] = {reach[v], 2.0f * depth[v] + 2.0f, 0};
    body.eachNeighbour(v, [&](int to, float) {
      if (parent[to] < 0) return;
      int a = rootOf(v), b = rootOf(to);
      if (a == b) return;
      for (const int side : {a, b}) {
        Branch& branch = branches[side];
        const float length = branch.tip - reach[v];
        if (branch.limbs == 0 && length > least && length > 1.7f * branch.thickness) branch.limbs = 1;
      }
      if (branches[a].tip < branches[b].tip) std::swap(a, b);
      parent[b] = a;
      branches[a].thickness = std::max(branches[a].thickness, branches[b].thickness);
      branches[a].limbs += branches[b].limbs;
    });
  }
  return branches[rootOf(*deepest)].limbs;
}

int countLegs(const VoxelBody& body, const Eigen::Vector3d& up) {
  std::vector<double> height(body.voxelCount(), -1.0);  // of what is not outside, from 0 to 1
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (int v = 0; v < body.voxelCount(); ++v) {
    if (body.isOutside(v)) continue;
    low = std::min(low, up.dot(body.middle(v)));
    high = std::max(high, up.dot(body.middle(v)));
  }
  for (int v = 0; v < body.voxelCount(); ++v)
    if (!body.isOutside(v)) height[v] = (up.dot(body.middle(v)) - low) / (high - low);
  constexpr double from = 0.05, to = 0.15;
  const double edge = 1.8 * body.voxelSize() / (high - low);  // across a voxel that stands slanted
  int legs = 0;
  std::vector<char> seen(body.voxelCount(), 0);
  const auto isInCut = [&](int v) { return !seen[v] && height[v] >= from && height[v] <= to; };
  for (int first = 0; first < body.voxelCount(); ++first) {
    if (!isInCut(first)) continue;
    double least = 1.0, most = 0.0;
    std::vector<int> open{first};
    seen[first] = 1;
    while (!open.empty()) {
      const int v = open.back();
      open.pop_back();
      least = std::min(least, height[v]);
      most = std::max(most, height[v]);
      body.eachNeighbour(v, [&](int next, float) {
        if (isInCut(next)) seen[next] = 1, open.push_back(next);
      });
    }
    legs += least < from + edge && most > to - edge;
  }
  return legs;
}

}  // namespace gelenk
