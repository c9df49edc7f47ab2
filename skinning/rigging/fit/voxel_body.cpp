#include "skinning/rigging/fit/voxel_body.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

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
  insideCount_ = static_cast<std::size_t>(std::count(state_.begin(), state_.end(), Inside));
}

VoxelBody::State VoxelBody::at(const Vector3d& p) const {
  if (!(((p - origin_) / size_).array() >= 0.0).all() ||
      !(((p - origin_) / size_).array() < count_.cast<double>().array()).all())
    return Outside;
  return state_[indexOf(voxelOf(p))];
}

Vector3d VoxelBody::nearestInside(const Vector3d& p, double reach) const {
  if (at(p) == Inside) return p;
  const int radius = static_cast<int>(std::ceil(reach / size_));
  const Vector3i centre = voxelOf(p);
  double nearest = reach;
  Vector3d found = p;
  for (int z = -radius; z <= radius; ++z)
    for (int y = -radius; y <= radius; ++y)
      for (int x = -radius; x <= radius; ++x) {
        const Vector3i v = centre + Vector3i(x, y, z);
        if (!within(v) || state_[indexOf(v)] != Inside) continue;
        const Vector3d c = origin_ + size_ * (v.cast<double>().array() + 0.5).matrix();
        if (const double d = (c - p).norm(); d < nearest) nearest = d, found = c;
      }
  return found;
}

SurfaceAir faceOutwards(SurfaceSamples& samples, const VoxelBody& body) {
  SurfaceAir air;
  if (samples.points.empty()) return air;
  SurfaceSamples kept;
  const double step = 1.6 * body.voxelSize();
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    const Vector3d& p = samples.points[i];
    Vector3d n = samples.normals[i];
    const bool before = body.isOutside(p + step * n), behind = body.isOutside(p - step * n);
    if (!before && !behind) {
      ++air.hidden;
      continue;
    }
    if (behind && !before) n = -n, ++air.flipped;
    kept.points.push_back(p);
    kept.normals.push_back(n);
  }
  const auto all = static_cast<double>(samples.points.size());
  air.flipped /= all, air.hidden /= all;
  if (!kept.points.empty()) samples = std::move(kept);
  return air;
}

}  // namespace gelenk
