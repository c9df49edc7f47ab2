#include "skinning/rigging/fit/voxel_body.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace gelenk {

using Eigen::Vector3d;
using Eigen::Vector3i;

VoxelBody::VoxelBody(const Mesh& mesh, int resolution) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : mesh.positions) box.extend(p);
  size_ = std::max(box.sizes().maxCoeff() / resolution, 1e-300);
  origin_ = box.min().array() - 1.5 * size_;
  for (int d = 0; d < 3; ++d) count_[d] = static_cast<int>(std::ceil(box.sizes()[d] / size_)) + 4;
  state_.assign(static_cast<std::size_t>(count_.x()) * count_.y() * count_.z(), Inside);
  for (const auto& t : mesh.triangles) {
    const Vector3d a = mesh.positions[t[0]], u = mesh.positions[t[1]] - a, v = mesh.positions[t[2]] - a;
    const double longest = std::max({u.norm(), v.norm(), (u - v).norm()});
    const int steps = static_cast<int>(std::ceil(longest / (0.45 * size_))) + 1;
    for (int i = 0; i <= steps; ++i)
      for (int j = 0; i + j <= steps; ++j) state_[indexOf(voxelOf(a + (i * u + j * v) / steps))] = Surface;
  }
  std::vector<Vector3i> open{Vector3i::Zero()};
  state_[0] = Outside;
  while (!open.empty()) {
    const Vector3i from = open.back();
    open.pop_back();
    for (int d = 0; d < 6; ++d) {
      Vector3i next = from;
      next[d / 2] += d % 2 ? 1 : -1;
      if (!within(next) || state_[indexOf(next)] != Inside) continue;
      state_[indexOf(next)] = Outside;
      open.push_back(next);
    }
  }
}

VoxelBody::State VoxelBody::at(const Vector3d& p) const {
  if (!(((p - origin_) / size_).array() >= 0.0).all() ||
      !(((p - origin_) / size_).array() < count_.cast<double>().array()).all())
    return Outside;
  return state_[indexOf(voxelOf(p))];
}

SurfaceAir faceOutwards(SurfaceSamples& samples, const VoxelBody& body) {
  // Where two limbs nearly touch no air is found between them, and thin parts have air on both sides: a few
  // such samples in a sound surface are left as they are.
  constexpr double flippedOnPurpose = 0.005, layered = 0.05;
  SurfaceAir air;
  if (samples.points.empty()) return air;
  SurfaceSamples turned = samples, kept;
  const double step = 1.6 * body.voxelSize();
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    const Vector3d &p = samples.points[i], &n = samples.normals[i];
    const bool before = body.isOutside(p + step * n), behind = body.isOutside(p - step * n);
    if (behind && !before) turned.normals[i] = -n, ++air.flipped;
    if (!before && !behind) {
      ++air.hidden;
      continue;
    }
    kept.points.push_back(p);
    kept.normals.push_back(turned.normals[i]);
  }
  const auto all = static_cast<double>(samples.points.size());
  air.flipped = air.flipped / all > flippedOnPurpose ? air.flipped / all : 0.0;
  air.hidden = air.hidden / all > layered ? air.hidden / all : 0.0;
  if (air.hidden > 0.0 && air.hidden < 0.9)
    samples = std::move(kept);
  else if (air.flipped > 0.0)
    samples = std::move(turned);
  return air;
}

}  // namespace gelenk
