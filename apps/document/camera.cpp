#include "apps/document/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kinematics/rotation.h"

namespace gelenk {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

/// World axes of the front view: right, up, towards the viewer. For up = y: x, y, z; for up = z: x, z, -y.
Matrix3d frontAxes(const Vector3d& up) { return rotationBetween(Vector3d::UnitY(), up).toRotationMatrix(); }

/// The point of the target's plane (facing the viewer) that lies under the pixel.
Vector3d onTargetPlane(const Camera& camera, const Viewport& viewport, const Vector2d& pixel) {
  const Ray ray = rayThroughPixel(camera, viewport, pixel);
  const Vector3d normal = camera.axes().col(2);
  return ray.at(normal.dot(camera.target - ray.origin) / normal.dot(ray.direction));
}

}  // namespace

Matrix3d Camera::axes() const {
  const Matrix3d turned = Eigen::AngleAxisd(azimuth, up).toRotationMatrix() * frontAxes(up);
  return Eigen::AngleAxisd(-elevation, turned.col(0)).toRotationMatrix() * turned;
}

double Camera::halfHeight() const { return distance * std::tan(0.5 * verticalFieldOfView); }

DepthRange depthRange(const Camera& camera, const Eigen::AlignedBox3d& box, double extent) {
  const double radius = (box.isEmpty() ? 1.0 : 0.5 * box.diagonal().norm()) + 1e-9;
  const Vector3d centre = box.isEmpty() ? camera.target : box.center();
  const double middle = camera.axes().col(2).dot(camera.eye() - centre);
  DepthRange range{.near = middle - 1.2 * radius, .far = middle + std::max(1.2 * radius, extent)};
  if (camera.orthographic) {
    range.near =
        std::min(range.near, middle - extent);  // the eye's plane may cut the scene: negative depths are fine
    range.far = std::max(range.far, range.near + 1e-3 * radius);
  } else {
    range.near = std::max({range.near, 1e-2 * camera.distance, 1e-3 * radius});
    range.far = std::max(range.far, 2.0 * range.near);
  }
  return range;
}

Matrix4d viewFromWorld(const Camera& camera) {
  const Matrix3d axes = camera.axes();
  Matrix4d view = Matrix4d::Identity();
  view.topLeftCorner<3, 3>() = axes.transpose();
  view.topRightCorner<3, 1>() = -axes.transpose() * camera.eye();
  return view;
}

Matrix4d clipFromView(const Camera& camera, const Viewport& viewport, const DepthRange& range) {
  const double depth = range.far - range.near;
  Matrix4d clip = Matrix4d::Zero();
  if (camera.orthographic) {
    const double half = camera.halfHeight();
    clip(0, 0) = 1.0 / (half * viewport.aspect());
    clip(1, 1) = 1.0 / half;
    clip(2, 2) = -2.0 / depth;
    clip(2, 3) = -(range.far + range.near) / depth;
    clip(3, 3) = 1.0;
  } else {
    const double slope = std::tan(0.5 * camera.verticalFieldOfView);
    clip(0, 0) = 1.0 / (slope * viewport.aspect());
    clip(1, 1) = 1.0 / slope;
    clip(2, 2) = -(range.far + range.near) / depth;
    clip(2, 3) = -2.0 * range.far * range.near / depth;
    clip(3, 2) = -1.0;
  }
  return clip;
}

Projected project(const Camera& camera, const Viewport& viewport, const Vector3d& pointInWorld) {
  const Vector3d inView = camera.axes().transpose() * (pointInWorld - camera.eye());
  const double depth = -inView.z();
  const double half =
      camera.orthographic ? camera.halfHeight() : std::tan(0.5 * camera.verticalFieldOfView) * depth;
  const double perPixel = 2.0 * half / viewport.height;
  return {
      .pixel = {0.5 * viewport.width + inView.x() / perPixel, 0.5 * viewport.height - inView.y() / perPixel},
      .depth = depth};
}

Ray rayThroughPixel(const Camera& camera, const Viewport& viewport, const Vector2d& pixel) {
  const Matrix3d axes = camera.axes();
  const double perPixel = 2.0 * camera.halfHeight() / viewport.height;  // at the target's depth
  const Vector3d sideways = axes.col(0) * (pixel.x() - 0.5 * viewport.width) * perPixel -
                            axes.col(1) * (pixel.y() - 0.5 * viewport.height) * perPixel;
  if (camera.orthographic) return {.origin = camera.eye() + sideways, .direction = -axes.col(2)};
  return {.origin = camera.eye(), .direction = (sideways - camera.distance * axes.col(2)).normalized()};
}

double pixelSize(const Camera& camera, const Viewport& viewport, const Vector3d& pointInWorld) {
  const double atTarget = 2.0 * camera.halfHeight() / viewport.height;
  if (camera.orthographic) return atTarget;
  const double depth = camera.axes().col(2).dot(camera.eye() - pointInWorld);
  return atTarget * std::max(depth, 0.0) / camera.distance;
}

Camera orbit(Camera camera, const Viewport& viewport, const Vector2d& pixels) {
  const double radians = pi / viewport.height;
  camera.azimuth = std::remainder(camera.azimuth - pixels.x() * radians, 2.0 * pi);
  camera.elevation = std::clamp(camera.elevation + pixels.y() * radians, -0.5 * pi, 0.5 * pi);
  return camera;
}

Camera pan(Camera camera, const Viewport& viewport, const Vector2d& pixels) {
  const double perPixel = 2.0 * camera.halfHeight() / viewport.height;
  const Matrix3d axes = camera.axes();
  camera.target += perPixel * (pixels.y() * axes.col(1) - pixels.x() * axes.col(0));
  return camera;
}

Camera zoomTo(Camera camera, const Viewport& viewport, const Vector2d& pixel, double factor) {
  const Vector3d fixed = onTargetPlane(camera, viewport, pixel);
  camera.distance *= factor;
  camera.target = fixed + factor * (camera.target - fixed);
  return camera;
}

Camera lookFrom(Camera camera, StandardView view) {
  switch (view) {
    case StandardView::Front: camera.azimuth = 0.0, camera.elevation = 0.0; break;
    case StandardView::Side: camera.azimuth = 0.5 * pi, camera.elevation = 0.0; break;
    case StandardView::Top: camera.azimuth = 0.0, camera.elevation = 0.5 * pi; break;
    case StandardView::ThreeQuarter: camera.azimuth = 0.6, camera.elevation = 0.2; break;
  }
  return camera;
}

Camera frameBox(Camera camera, const Viewport& viewport, const Eigen::AlignedBox3d& box, double margin) {
  if (box.isEmpty()) {
    camera.target.setZero();
    return camera;
  }
  camera.target = box.center();
  const Matrix3d axes = camera.axes();
  const double slope = std::tan(0.5 * camera.verticalFieldOfView), room = 1.0 - 2.0 * margin;
  double needed = 1e-9;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d c =
        axes.transpose() * (box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)) - camera.target);
    const double half = std::max(std::abs(c.y()), std::abs(c.x()) / viewport.aspect()) / room;
    needed =
        std::max(needed, camera.orthographic ? std::max(half / slope, 1.01 * c.z()) : half / slope + c.z());
  }
  camera.distance = needed;
  return camera;
}

}  // namespace gelenk
