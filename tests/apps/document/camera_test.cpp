#include "apps/document/camera.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "kinematics/configuration.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

const Viewport wide{1280, 800};

Camera randomCamera(std::mt19937_64& random, bool orthographic) {
  const auto number = [&random] { return 2.0 * uniform01(random) - 1.0; };
  Camera camera{.target = {number(), number(), number()},
                .up = uniform01(random) < 0.5 ? Vector3d::UnitY() : Vector3d::UnitZ(),
                .distance = 1.0 + 5.0 * uniform01(random),
                .azimuth = pi * number(),
                .elevation = 0.49 * pi * number(),
                .orthographic = orthographic};
  return camera;
}

TEST(Camera, FrontViewHasXToTheRightAndTheViewerWhereTheBodyLooks) {
  EXPECT_TRUE(Camera{}.axes().isApprox(Eigen::Matrix3d::Identity(), 1e-15));
  const Eigen::Matrix3d axes = Camera{.up = Vector3d::UnitZ()}.axes();
  EXPECT_LE((axes.col(0) - Vector3d::UnitX()).norm(), 1e-15);
  EXPECT_LE((axes.col(1) - Vector3d::UnitZ()).norm(), 1e-15);
  EXPECT_LE((axes.col(2) + Vector3d::UnitY()).norm(), 1e-15);
}

TEST(Camera, FromAboveAPlanarSceneXIsRightAndYIsUp) {
  const Eigen::Matrix3d axes = lookFrom({.up = Vector3d::UnitZ()}, StandardView::Top).axes();
  EXPECT_TRUE(axes.isApprox(Eigen::Matrix3d::Identity(), 1e-15)) << axes;
}

TEST(Camera, APixelsRayPassesThroughThePointThatProjectsToIt) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Camera camera = randomCamera(random, trial % 2 == 0);
    const Vector3d point =
        camera.target + 0.4 * Vector3d(uniform01(random), uniform01(random), uniform01(random));
    const Projected at = project(camera, wide, point);
    const Ray ray = rayThroughPixel(camera, wide, at.pixel);
    const double along = ray.direction.dot(point - ray.origin);
    EXPECT_GT(along, 0.0);
    EXPECT_LE((ray.at(along) - point).norm(), 1e-12) << "seed 1, trial " << trial;
  }
}

TEST(Camera, MatricesAndProjectionAgree) {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 200; ++trial) {
    const Camera camera = randomCamera(random, trial % 2 == 0);
    const Eigen::AlignedBox3d box(Vector3d(camera.target.array() - 1.0),
                                  Vector3d(camera.target.array() + 1.0));
    const DepthRange range = depthRange(camera, box, 5.0);
    const Vector3d point =
        camera.target + 0.3 * Vector3d(uniform01(random), uniform01(random), uniform01(random));
    const Eigen::Vector4d clip =
        clipFromView(camera, wide, range) * viewFromWorld(camera) * point.homogeneous();
    const Vector2d pixel(0.5 * wide.width * (1.0 + clip.x() / clip.w()),
                         0.5 * wide.height * (1.0 - clip.y() / clip.w()));
    EXPECT_LE((pixel - project(camera, wide, point).pixel).norm(), 1e-9) << "seed 2, trial " << trial;
    EXPECT_LE(std::abs(clip.z() / clip.w()), 1.0) << "the box lies within the depth range";
  }
}

TEST(Camera, ZoomKeepsWhatLiesUnderThePixelInPlace) {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 100; ++trial) {
    const Camera camera = randomCamera(random, trial % 2 == 0);
    const Vector2d pixel(1280 * uniform01(random), 800 * uniform01(random));
    const Vector3d normal = camera.axes().col(2);
    const Ray ray = rayThroughPixel(camera, wide, pixel);
    const Vector3d point = ray.at(normal.dot(camera.target - ray.origin) / normal.dot(ray.direction));
    const Camera nearer = zoomTo(camera, wide, pixel, 0.7);
    EXPECT_LE((project(nearer, wide, point).pixel - pixel).norm(), 1e-8);
    EXPECT_NEAR(nearer.distance, 0.7 * camera.distance, 1e-12);
  }
}

TEST(Camera, PanMovesTheTargetsPictureWithTheMouse) {
  std::mt19937_64 random(4);
  for (int trial = 0; trial < 100; ++trial) {
    const Camera camera = randomCamera(random, trial % 2 == 0);
    const Vector2d before = project(camera, wide, camera.target).pixel;
    const Vector2d after = project(pan(camera, wide, {30.0, -12.0}), wide, camera.target).pixel;
    EXPECT_LE((after - before - Vector2d(30.0, -12.0)).norm(), 1e-8);
  }
}

TEST(Camera, OrbitKeepsTheTargetAndStopsAtThePoles) {
  const Camera start{.target = {1, 2, 3}};
  Camera camera = orbit(start, wide, {200.0, 10000.0});
  EXPECT_DOUBLE_EQ(camera.elevation, 0.5 * pi);
  EXPECT_EQ(camera.target, start.target);
  camera = orbit(camera, wide, {0.0, -20000.0});
  EXPECT_DOUBLE_EQ(camera.elevation, -0.5 * pi);
  EXPECT_NEAR(camera.axes().determinant(), 1.0, 1e-14);
}

TEST(Camera, AFramedBoxIsWhollyInThePictureAndTouchesItsMargin) {
  std::mt19937_64 random(5);
  for (int trial = 0; trial < 200; ++trial) {
    Camera camera = randomCamera(random, trial % 2 == 0);
    Eigen::AlignedBox3d box;
    for (int i = 0; i < 2; ++i)
      box.extend(500.0 * Vector3d(uniform01(random), uniform01(random), uniform01(random)));
    camera = frameBox(camera, wide, box, 0.1);
    double used = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      const Projected at =
          project(camera, wide, box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
      EXPECT_GT(at.depth, 0.0);
      used = std::max({used, std::abs(at.pixel.x() - 640.0) / 640.0, std::abs(at.pixel.y() - 400.0) / 400.0});
    }
    EXPECT_LE(used, 0.8 + 1e-9) << "seed 5, trial " << trial;
    if (!camera.orthographic) {
      EXPECT_GE(used, 0.8 - 1e-9) << "seed 5, trial " << trial;
    }
  }
}

}  // namespace
}  // namespace gelenk
