// libFuzzer target: the parts of automatic rigging that walk over a mesh (voxels, branches, fingers, girths,
// cut edges, heat), coarse enough for many runs a second; rig_fuzz runs the whole. Every row of weights sums
// to 1, everything stays finite.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "skinning/rigging/bone_heat.h"
#include "skinning/rigging/fit/fingers.h"
#include "skinning/rigging/fit/girth_profile.h"
#include "skinning/rigging/fit/limbs.h"
#include "skinning/rigging/fit/nearest_skin.h"
#include "skinning/rigging/fit/surface_samples.h"
#include "skinning/rigging/fit/voxel_body.h"
#include "skinning/rigging/short_edges.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gelenk;
  using Eigen::Vector3d;
  if (size < 3) return 0;
  const std::size_t vertices = 3 + data[0] % 40;
  const double scale = std::pow(10.0, static_cast<std::int8_t>(data[1]) / 4);  // from 1e-32 to 1e31
  const bool onGrid = data[2] % 2;
  data += 3, size -= 3;
  const auto next = [&]() -> int {
    if (size == 0) return 0;
    return --size, *data++;
  };
  const auto coordinate = [&] { return scale * (onGrid ? next() % 8 : next() - 128); };
  const auto point = [&] {
    const double x = coordinate(), y = coordinate(), z = coordinate();
    return Vector3d(x, y, z);
  };
  Mesh mesh;
  for (std::size_t v = 0; v < vertices; ++v) mesh.positions.push_back(point());
  const Vector3d a = point(), b = point(), c = point(), d = point();
  const auto corner = [&] { return next() % static_cast<int>(vertices); };
  do {
    const int i = corner(), j = corner(), k = corner();
    mesh.triangles.push_back({i, j, k});
  } while (size >= 3 && mesh.triangles.size() < 120);

  const VoxelBody voxels(mesh, 12);
  SurfaceSamples samples = sampleSurface(mesh, 60);
  faceOutwards(samples, voxels);
  for (const Vector3d& p : samples.points)
    if (!p.allFinite()) __builtin_trap();
  if (countLimbs(voxels) < 0 || countLegs(voxels, Vector3d::UnitY()) < 0) __builtin_trap();
  if (!nearestSkin(mesh, a).allFinite()) __builtin_trap();
  if (withShortEdges(mesh, 0.02 * scale, 500).triangles.size() > 2000) __builtin_trap();
  if (a != b) {
    GirthProfile girths(a, b, 20);
    for (const auto& t : mesh.triangles)
      for (int k = 0; k < 3; ++k) girths.add(mesh.positions[t[k]], mesh.positions[t[(k + 1) % 3]]);
    if (const auto waist = girths.waist(); waist && !(*waist >= 0.0)) __builtin_trap();
  }
  findFingers(mesh, {.elbow = a, .wrist = b, .knuckles = c});
  const std::vector<Bone> bones{{0, a, b}, {1, b, c}, {2, c, d}};
  const SparseWeights weights = boneHeatWeights(mesh, bones, {.voxels = 10, .longestEdge = 0.3});
  if (weights.size() != vertices) __builtin_trap();
  for (const auto& row : weights) {
    double sum = 0.0;
    for (const auto& [joint, w] : row) sum += w >= 0.0 ? w : NAN;
    if (!(std::abs(sum - 1.0) < 1e-5)) __builtin_trap();
  }
  return 0;
}
