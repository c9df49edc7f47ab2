#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "skinning/mesh.h"
#include "skinning/rigging/fit/surface_samples.h"

namespace gelenk {

/// A mesh as voxels: those that the surface touches, those that the outside air reaches, and the rest, which
/// lies inside. Needs no closed, welded or oriented surface; through a hole wider than a voxel the air gets
/// in.
class VoxelBody {
 public:
  /// resolution: voxels along the longest side of the box.
  VoxelBody(const Mesh& mesh, int resolution);

  double voxelSize() const { return size_; }
  /// Points beyond the box are outside.
  bool isOutside(const Eigen::Vector3d& p) const { return at(p) == Outside; }

  /// Voxels by number.
  int voxelCount() const { return static_cast<int>(state_.size()); }
  bool isOutside(int voxel) const { return state_[voxel] == Outside; }
  Eigen::Vector3d middle(int voxel) const {
    const Eigen::Vector3i at(voxel % count_.x(), voxel / count_.x() % count_.y(),
                             voxel / (count_.x() * count_.y()));
    return origin_ + size_ * (at.cast<double>().array() + 0.5).matrix();
  }
  /// The up to 26 voxels around one, with the distances of their middles in voxels: visit(voxel, distance).
  template <class Visit>
  void eachNeighbour(int voxel, Visit visit) const {
    const Eigen::Vector3i at(voxel % count_.x(), voxel / count_.x() % count_.y(),
                             voxel / (count_.x() * count_.y()));
    for (int k = 0; k < 27; ++k) {
      const Eigen::Vector3i step(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1), to = at + step;
      if (k != 13 && within(to))
        visit(static_cast<int>(indexOf(to)), std::sqrt(static_cast<float>(step.squaredNorm())));
    }
  }

 private:
  enum State : char { Outside, Surface, Inside };
  State at(const Eigen::Vector3d& p) const;
  std::size_t indexOf(const Eigen::Vector3i& v) const {
    return v.x() + static_cast<std::size_t>(count_.x()) *
                       (v.y() + static_cast<std::size_t>(count_.y()) * static_cast<std::size_t>(v.z()));
  }
  bool within(const Eigen::Vector3i& v) const {
    return (v.array() >= 0).all() && (v.array() < count_.array()).all();
  }
  Eigen::Vector3i voxelOf(const Eigen::Vector3d& p) const {
    return ((p - origin_) / size_).array().floor().cast<int>();
  }

  double size_ = 1.0;
  Eigen::Vector3d origin_;
  Eigen::Vector3i count_;
  std::vector<State> state_;
};

/// What the air says about the samples of a surface.
struct SurfaceAir {
  double flipped = 0.0;  ///< share that faced inwards and was turned; 0 below 0.5 %, nothing is turned then
  double hidden = 0.0;   ///< share that no air touches, inner layers: left out; 0 below 5 %
};

/// Turns the samples' normals outwards and drops those inside the body.
SurfaceAir faceOutwards(SurfaceSamples& samples, const VoxelBody& body);

}  // namespace gelenk
