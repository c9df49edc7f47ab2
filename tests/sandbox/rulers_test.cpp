#include "apps/render/rulers.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gelenk {
namespace {

const Viewport viewport{800, 600};
Camera fromAbove() {
  Camera camera{
      .target = {3.0, -1.0, 0.0}, .up = Eigen::Vector3d::UnitZ(), .distance = 20.0, .orthographic = true};
  return lookFrom(camera, StandardView::Top);
}

/// Ticks stand on multiples of one step, to the pixel, at every zoom.
TEST(Rulers, TicksStandOnTheCoordinatesThatTheyName) {
  for (const double distance : {0.3, 20.0, 900.0}) {
    Camera camera = fromAbove();
    camera.distance = distance;
    Overlay overlay;
    addRulers(overlay, camera, viewport, 1.0f, 0.0, {});
    const double pixel = 2.0 * camera.halfHeight() / viewport.height, step = niceStep(80.0 * pixel);
    int ticks = 0;
    for (const Overlay::Line& line : overlay.lines) {
      const Eigen::Vector3d a(line.a.position[0], line.a.position[1], 0),
          b(line.b.position[0], line.b.position[1], 0);
      if (std::abs(project(camera, viewport, a).pixel.y() - 600.0) > 0.01 ||
          std::abs((a - b).norm() - 5.0 * pixel) > 0.02 * pixel)
        continue;
      EXPECT_NEAR(a.x() / step, std::round(a.x() / step), 0.6 * pixel / step);
      ++ticks;
    }
    EXPECT_GE(ticks, 4);
    EXPECT_LE(ticks, 12);
  }
}

TEST(Rulers, AreForThePlaneSeenFromAbove) {
  Overlay overlay;
  Camera camera = fromAbove();
  camera.elevation = 1.0;
  addRulers(overlay, camera, viewport, 1.0f, 0.0, {});
  EXPECT_TRUE(overlay.empty());
}

TEST(Rulers, StepsAreOneTwoOrFiveTimesAPowerOfTen) {
  EXPECT_DOUBLE_EQ(niceStep(0.7), 1.0);
  EXPECT_DOUBLE_EQ(niceStep(1.3), 2.0);
  EXPECT_DOUBLE_EQ(niceStep(41.0), 50.0);
  EXPECT_DOUBLE_EQ(niceStep(0.0051), 0.01);
}

}  // namespace
}  // namespace gelenk
