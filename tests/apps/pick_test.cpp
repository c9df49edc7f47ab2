#include "apps/pick.h"

#include <gtest/gtest.h>

namespace gelenk {
namespace {

using Eigen::Vector3d;

TEST(Pick, TheNearestTriangleThatFacesTheRayIsHit) {
  const std::vector<Vector3d> positions{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}, {-1, -1, 1}, {1, -1, 1}, {0, 1, 1}};
  const std::vector<std::array<int, 3>> triangles{{0, 1, 2}, {3, 4, 5}, {5, 4, 3}};  // the last faces away
  const Ray ray{{0.1, -0.2, 5.0}, {0, 0, -1}};
  const auto hit = pickSurface(triangles, positions, ray);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->point.triangle, 1);
  EXPECT_DOUBLE_EQ(hit->depth, 4.0);
  Vector3d blended = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) blended += hit->point.barycentric[k] * positions[triangles[1][k]];
  EXPECT_LT((blended - hit->position).norm(), 1e-15);
  EXPECT_FALSE(pickSurface(triangles, positions, {{3.0, 0.0, 5.0}, {0, 0, -1}}));
  EXPECT_FALSE(pickSurface(triangles, positions, {{0.1, -0.2, -5.0}, {0, 0, -1}}));
}

TEST(DragTarget, LiesUnderThePixelAndInThePlaneThatFacesTheViewer) {
  const Camera camera{.target = {0.1, 1.0, 0.0}, .distance = 3.0, .azimuth = 0.6, .elevation = 0.3};
  const Viewport viewport{960, 600};
  const Vector3d start(0.3, 1.2, -0.1);
  const auto target = dragTarget(camera, viewport, {700.0, 180.0}, start, DragConstraint::ViewPlane);
  ASSERT_TRUE(target);
  EXPECT_LT((project(camera, viewport, *target).pixel - Eigen::Vector2d(700.0, 180.0)).norm(), 1e-9);
  EXPECT_NEAR((*target - start).dot(camera.axes().col(2)), 0.0, 1e-12);
}

TEST(DragTarget, KeepsToTheGroundPlaneAndToALockedAxis) {
  const Camera camera{.target = {0.0, 1.0, 0.0}, .distance = 3.0, .azimuth = 0.6, .elevation = 0.4};
  const Viewport viewport{960, 600};
  const Vector3d start(0.3, 1.2, -0.1);
  const auto ground = dragTarget(camera, viewport, {500.0, 400.0}, start, DragConstraint::GroundPlane);
  ASSERT_TRUE(ground);
  EXPECT_NEAR(ground->y(), start.y(), 1e-12);
  const auto along = dragTarget(camera, viewport, {500.0, 400.0}, start, DragConstraint::AxisX);
  ASSERT_TRUE(along);
  EXPECT_EQ(along->y(), start.y());
  EXPECT_EQ(along->z(), start.z());
  // The locked point is the one of its line that is nearest to the pixel's ray: moving along the line either way is farther.
  const Ray ray = rayThroughPixel(camera, viewport, {500.0, 400.0});
  const auto distance = [&](const Vector3d& p) { return (p - ray.origin).cross(ray.direction).norm(); };
  EXPECT_LT(distance(*along), distance(*along + Vector3d(1e-3, 0, 0)));
  EXPECT_LT(distance(*along), distance(*along - Vector3d(1e-3, 0, 0)));
}

TEST(DragTarget, RefusesAPlaneSeenEdgeOn) {
  const Camera camera{.target = {0.0, 1.0, 0.0}, .distance = 3.0};  // level: the ground plane at eye height is a line
  EXPECT_FALSE(dragTarget(camera, {960, 600}, {480.0, 300.0}, {0.0, 1.0, 0.0}, DragConstraint::GroundPlane));
  EXPECT_FALSE(dragTarget(camera, {960, 600}, {480.0, 300.0}, {0.0, 1.0, 0.0}, DragConstraint::AxisZ));
}

}  // namespace
}  // namespace gelenk
