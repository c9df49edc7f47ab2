#include "skinning/rigging/short_edges.h"

#include <algorithm>
#include <cstdint>
#include <unordered_map>

namespace gelenk {

namespace {

/// Cuts a triangle at the middles of its long edges; middle[k] lies between corners k and k + 1, or is -1.
void cut(const std::array<int, 3>& corner, const std::array<int, 3>& middle,
         std::vector<std::array<int, 3>>& out) {
  const auto split = std::count_if(middle.begin(), middle.end(), [](int m) { return m >= 0; });
  if (split == 0) return out.push_back(corner);
  if (split == 3) {
    for (int k = 0; k < 3; ++k) out.push_back({corner[k], middle[k], middle[(k + 2) % 3]});
    return out.push_back(middle);
  }
  // Turned so that the first edge is long and, of two, the second one, too.
  int k = 0;
  while (middle[k] < 0 || (split == 2 && middle[(k + 1) % 3] < 0)) ++k;
  const int a = corner[k], b = corner[(k + 1) % 3], c = corner[(k + 2) % 3], ab = middle[k],
            bc = middle[(k + 1) % 3];
  out.push_back({a, ab, c});
  if (split == 1) return out.push_back({ab, b, c});
  out.back() = {ab, b, bc};
  out.push_back({ab, bc, c});
  out.push_back({a, ab, c});
}

}  // namespace

Mesh withShortEdges(const Mesh& mesh, double longest, std::size_t enough) {
  Mesh out{.positions = mesh.positions, .triangles = mesh.triangles, .normals = {}};
  for (bool again = true; again && out.triangles.size() < enough;) {
    again = false;
    std::unordered_map<std::uint64_t, int> middles;
    const auto middle = [&](int a, int b) {
      const Eigen::Vector3d p = out.positions[a], q = out.positions[b];
      if (!((p - q).norm() > longest)) return -1;
      const auto [low, high] = std::minmax(a, b);
      const std::uint64_t key = static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint64_t>(high);
      const auto [at, fresh] = middles.emplace(key, static_cast<int>(out.positions.size()));
      if (fresh) out.positions.push_back(0.5 * (p + q));
      again = true;
      return at->second;
    };
    std::vector<std::array<int, 3>> triangles;
    for (const auto& t : out.triangles)
      cut(t, {middle(t[0], t[1]), middle(t[1], t[2]), middle(t[2], t[0])}, triangles);
    out.triangles = std::move(triangles);
  }
  return out;
}

}  // namespace gelenk
