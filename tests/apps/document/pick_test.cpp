#include "apps/document/pick.h"

#include <gtest/gtest.h>

namespace gelenk {
namespace {

using Eigen::Vector3d;

TEST(Pick, TheNearestTriangleThatFacesTheRayIsHit) {
  const std::vector<Vector3d> positions{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0},
                                        {-1, -1, 1}, {1, -1, 1}, {0, 1, 1}};
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

/// A straight limb of two links along x, seen from the front.
LimbPose limbAlongX() {
  LimbFrames frames{.joints = {{-0.3, 0, 0}, {0, 0, 0}, {0.3, 0, 0}}, .rotations = {}};
  Eigen::Matrix3d R;
  R << 0, 0, 1, 0, 1, 0, -1, 0, 0;  // z of the link is x of the world
  frames.rotations = {R, R};
  return poseLimb(defaultLimbShape({0.3, 0.3}), frames);
}

TEST(PickLattice, EveryControlPointOfEveryPlaneIsPickedByItsPixel) {
  const LimbPose limb = limbAlongX();
  const Camera camera{.distance = 1.5, .azimuth = 0.5, .elevation = 0.35};  // no two points on one pixel
  const Viewport viewport{1600, 1000};
  for (int plane = 0; plane < 13; ++plane)
    for (int c = 0; c < 16; ++c) {
      const Projected at = project(camera, viewport, limb.controlPoints(plane)[c]);
      const auto hit = pickLattice(limb, camera, viewport, at.pixel, 1.0);
      ASSERT_TRUE(hit) << plane << " " << c;
      if (hit->plane != plane) {  // another plane's line crosses here, nearer to the eye
        EXPECT_LT(project(camera, viewport, limb.controlPoints(hit->plane)[hit->point]).depth, at.depth)
            << plane << " " << c;
        continue;
      }
      EXPECT_EQ(hit->point, c);
    }
}

TEST(PickLattice, LinesCountAndTheVoidDoesNot) {
  const LimbPose limb = limbAlongX();
  const Camera camera{.distance = 1.5, .orthographic = true};  // planes are seen edge on
  const Viewport viewport{1600, 1000};
  const auto points = limb.controlPoints(9);  // plane 3 of the second link
  const auto between = project(camera, viewport, 0.5 * (points[5] + points[6]));
  const auto hit = pickLattice(limb, camera, viewport, between.pixel + Eigen::Vector2d(3.0, 0.0));
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->plane, 9);
  EXPECT_FALSE(pickLattice(limb, camera, viewport, between.pixel + Eigen::Vector2d(12.0, 0.0)));
  EXPECT_FALSE(pickLattice(limb, camera, viewport, {5.0, 5.0}));
  Camera away = camera;
  away.orthographic = false;
  away.target.z() = -5.0;  // the limb lies behind the eye
  EXPECT_FALSE(pickLattice(limb, away, viewport, {800.0, 500.0}, 1e6));
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
  // The locked point is the one of its line that is nearest to the pixel's ray: moving along the line either
  // way is farther.
  const Ray ray = rayThroughPixel(camera, viewport, {500.0, 400.0});
  const auto distance = [&](const Vector3d& p) { return (p - ray.origin).cross(ray.direction).norm(); };
  EXPECT_LT(distance(*along), distance(*along + Vector3d(1e-3, 0, 0)));
  EXPECT_LT(distance(*along), distance(*along - Vector3d(1e-3, 0, 0)));
}

TEST(DragTarget, RefusesAPlaneSeenEdgeOn) {
  const Camera camera{.target = {0.0, 1.0, 0.0},
                      .distance = 3.0};  // level: the ground plane at eye height is a line
  EXPECT_FALSE(dragTarget(camera, {960, 600}, {480.0, 300.0}, {0.0, 1.0, 0.0}, DragConstraint::GroundPlane));
  EXPECT_FALSE(dragTarget(camera, {960, 600}, {480.0, 300.0}, {0.0, 1.0, 0.0}, DragConstraint::AxisZ));
}

}  // namespace
}  // namespace gelenk
