#include "apps/document/pick.h"

#include <algorithm>
#include <cmath>

#include "skinning/blend/linear_blend.h"

namespace gelenk {

std::optional<SurfaceHit> pickSurface(const std::vector<std::array<int, 3>>& triangles,
                                      const std::vector<Eigen::Vector3d>& positions, const Ray& ray) {
  std::optional<SurfaceHit> nearest;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Eigen::Vector3d& a = positions[triangles[t][0]];
    const Eigen::Vector3d ab = positions[triangles[t][1]] - a, ac = positions[triangles[t][2]] - a;
    const Eigen::Vector3d p = ray.direction.cross(ac);
    const double determinant = ab.dot(p);  // > 0 for triangles that face the viewer
    if (!(determinant > 0.0)) continue;
    const Eigen::Vector3d s = ray.origin - a;
    const double u = s.dot(p);
    if (u < 0.0 || u > determinant) continue;
    const Eigen::Vector3d q = s.cross(ab);
    const double v = ray.direction.dot(q);
    if (v < 0.0 || u + v > determinant) continue;
    const double depth = ac.dot(q) / determinant;
    if (depth < 0.0 || (nearest && depth >= nearest->depth)) continue;
    const Eigen::Vector3d weights((determinant - u - v) / determinant, u / determinant, v / determinant);
    nearest = {.point = {.triangle = static_cast<int>(t), .barycentric = weights},
               .position = ray.at(depth),
               .depth = depth};
  }
  return nearest;
}

int dominantJoint(const Skin& skin, const SurfacePoint& point) {
  std::vector<double> share(skin.jointFromRestWorld.size(), 0.0);
  for (int corner = 0; corner < 3; ++corner) {
    const Influences& influences = skin.influences[skin.mesh.triangles[point.triangle][corner]];
    for (int k = 0; k < 4; ++k)
      share[influences.joints[k]] += point.barycentric[corner] * influences.weights[k];
  }
  return static_cast<int>(std::ranges::max_element(share) - share.begin());
}

Eigen::Vector3d linearBlendPoint(const Skin& skin, const Frames& worldFromJoint, const SurfacePoint& point) {
  Skin three{.mesh = {}, .influences = {}, .jointFromRestWorld = skin.jointFromRestWorld};
  for (const int v : skin.mesh.triangles[point.triangle]) {
    three.mesh.positions.push_back(skin.mesh.positions[v]);
    three.mesh.normals.push_back(skin.mesh.normals[v]);
    three.influences.push_back(skin.influences[v]);
  }
  const SkinnedVertices at = linearBlendSkin(three, worldFromJoint);
  return point.barycentric[0] * at.positions[0] + point.barycentric[1] * at.positions[1] +
         point.barycentric[2] * at.positions[2];
}

namespace {

double distanceToSegment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d ab = b - a;
  const double t = ab.squaredNorm() > 0.0 ? std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0) : 0.0;
  return (a + t * ab - p).norm();
}

}  // namespace

std::optional<LatticePoint> pickLattice(const LimbPose& limb, const Camera& camera, const Viewport& viewport,
                                        const Eigen::Vector2d& pixel, double reach) {
  std::optional<LatticePoint> nearest;
  double smallest = reach, depth = 0.0;
  for (int plane = 0; plane < static_cast<int>(limb.planes.size()); ++plane) {
    std::array<Projected, 16> at;
    std::ranges::transform(limb.controlPoints(plane), at.begin(),
                           [&](const Eigen::Vector3d& p) { return project(camera, viewport, p); });
    if (std::ranges::any_of(at, [](const Projected& p) { return p.depth <= 0.0; })) continue;
    double distance = reach;
    for (int c = 0; c < 16; ++c) {
      if (c % 4 > 0) distance = std::min(distance, distanceToSegment(pixel, at[c - 1].pixel, at[c].pixel));
      if (c >= 4) distance = std::min(distance, distanceToSegment(pixel, at[c - 4].pixel, at[c].pixel));
    }
    const auto point =
        std::ranges::min_element(at, {}, [&](const Projected& p) { return (p.pixel - pixel).norm(); });
    const bool nearer =
        distance < smallest - 0.5 || (distance < smallest + 0.5 && nearest && point->depth < depth);
    if (distance >= reach || !(nearer || !nearest)) continue;
    smallest = distance;
    depth = point->depth;
    nearest = {.plane = plane, .point = static_cast<int>(point - at.begin())};
  }
  return nearest;
}

std::optional<Eigen::Vector3d> dragTarget(const Camera& camera, const Viewport& viewport,
                                          const Eigen::Vector2d& pixel, const Eigen::Vector3d& start,
                                          DragConstraint constraint) {
  constexpr double steepest = 0.05;  // sine of the smallest angle between ray and plane, about 3 degrees
  const Ray ray = rayThroughPixel(camera, viewport, pixel);
  if (constraint == DragConstraint::ViewPlane || constraint == DragConstraint::GroundPlane) {
    const Eigen::Vector3d normal =
        constraint == DragConstraint::ViewPlane ? Eigen::Vector3d(camera.axes().col(2)) : camera.up;
    const double along = ray.direction.dot(normal);
    if (std::abs(along) < steepest) return std::nullopt;
    const double t = (start - ray.origin).dot(normal) / along;
    if (t < 0.0 && !camera.orthographic) return std::nullopt;
    return ray.at(t);
  }
  const int axis = static_cast<int>(constraint) - static_cast<int>(DragConstraint::AxisX);
  const Eigen::Vector3d direction = Eigen::Vector3d::Unit(axis);
  // Nearest points of two lines: start + s direction, origin + t ray.
  const double cosine = direction.dot(ray.direction), sine2 = 1.0 - cosine * cosine;
  if (sine2 < steepest * steepest) return std::nullopt;
  const Eigen::Vector3d w = start - ray.origin;
  const double s = (cosine * ray.direction.dot(w) - direction.dot(w)) / sine2;
  return start + s * direction;
}

}  // namespace gelenk
