#include "skinning/rigging/fit/mirror_plane.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "skinning/rigging/fit/kd_tree.h"

namespace gelenk {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

class MirrorFit {
 public:
  MirrorFit(const SurfaceSamples& samples, double size) : samples_(samples), size_(size), tree_(lift()) {}

  /// Gauss-Newton rounds on normal and offset with the distances across the surface; leaves the misfit.
  void refine(MirrorPlane& plane, int rounds, std::size_t count) const {
    const std::size_t stride = std::max<std::size_t>(1, samples_.points.size() / count);
    for (int round = 0; round <= rounds; ++round) {
      const double width = size_ * (round < rounds / 2 ? 0.04 : 0.01);
      Matrix3d N = Matrix3d::Zero();
      Vector3d b = Vector3d::Zero();
      const Vector3d n = plane.normal, u = n.unitOrthogonal(), v = n.cross(u);
      double misfit = 0.0;
      int used = 0;
      for (std::size_t i = 0; i < samples_.points.size(); i += stride, ++used) {
        const Vector3d& p = samples_.points[i];
        const double height = n.dot(p) - plane.offset;
        const Vector3d image = p - 2.0 * height * n;
        const Vector3d m = samples_.normals[i] - 2.0 * n.dot(samples_.normals[i]) * n;
        const int s = tree_.nearest(lifted(image, m));
        const Vector3d& q = samples_.points[s];
        const Vector3d& k = samples_.normals[s];
        const double across = k.dot(image - q);
        // The nearest sample is up to a grain away along the surface: only beyond that is it a distance.
        const double along = std::max(0.0, (image - q).norm() - grain_);
        const double d = std::hypot(across, along);
        misfit += std::min(d, 0.05 * size_);
        const double weight = 1.0 / ((1.0 + d * d / (width * width)) * (1.0 + d * d / (width * width)));
        const Vector3d J(-2.0 * (u.dot(p) * k.dot(n) + height * k.dot(u)),
                         -2.0 * (v.dot(p) * k.dot(n) + height * k.dot(v)), 2.0 * k.dot(n));
        N += weight * J * J.transpose();
        b -= weight * across * J;
      }
      plane.misfit = misfit / (used * size_);
      if (round == rounds) return;
      N.diagonal() += Vector3d(1e-9 * size_ * size_ * used, 1e-9 * size_ * size_ * used, 1e-9 * used);
      const Vector3d step = N.ldlt().solve(b);
      plane.normal = (n + step[0] * u + step[1] * v).normalized();
      plane.offset += step[2];
    }
  }

 private:
  KdTree<6>::Point lifted(const Vector3d& p, const Vector3d& n) const {
    KdTree<6>::Point out;
    out << p, 0.05 * size_ * n;
    return out;
  }
  std::vector<KdTree<6>::Point> lift() {
    std::vector<KdTree<6>::Point> out;
    for (std::size_t i = 0; i < samples_.points.size(); ++i)
      out.push_back(lifted(samples_.points[i], samples_.normals[i]));
    grain_ = 0.02 * size_;
    return out;
  }

  const SurfaceSamples& samples_;
  double size_, grain_ = 0.0;
  KdTree<6> tree_;
};

}  // namespace

std::vector<MirrorPlane> mirrorPlanes(const SurfaceSamples& samples, double size) {
  Vector3d centre = Vector3d::Zero();
  for (const Vector3d& p : samples.points) centre += p;
  centre /= static_cast<double>(samples.points.size());
  Matrix3d spread = Matrix3d::Zero();
  for (const Vector3d& p : samples.points) spread += (p - centre) * (p - centre).transpose();
  const Matrix3d axes = Eigen::SelfAdjointEigenSolver<Matrix3d>(spread).eigenvectors();

  std::vector<Vector3d> starts;
  for (int i = 0; i < 3; ++i) starts.push_back(axes.col(i));
  for (int i = 0; i < 3; ++i)
    for (const double sign : {1.0, -1.0})
      starts.push_back((axes.col(i) + sign * axes.col((i + 1) % 3)).normalized());
  const MirrorFit fit(samples, size);
  std::vector<MirrorPlane> planes;
  for (const Vector3d& n : starts) {
    planes.push_back({n, n.dot(centre)});
    fit.refine(planes.back(), 8, 400);
  }
  const auto better = [](const MirrorPlane& a, const MirrorPlane& b) { return a.misfit < b.misfit; };
  std::stable_sort(planes.begin(), planes.end(), better);
  std::vector<MirrorPlane> kept;
  for (const MirrorPlane& plane : planes) {
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const MirrorPlane& k) {
      return std::abs(k.normal.dot(plane.normal)) > std::cos(5.0 * M_PI / 180.0);
    });
    if (!known && kept.size() < 3) kept.push_back(plane);
  }
  for (MirrorPlane& plane : kept) fit.refine(plane, 10, 1500);
  std::stable_sort(kept.begin(), kept.end(), better);
  return kept;
}

}  // namespace gelenk
