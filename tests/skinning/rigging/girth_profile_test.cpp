#include "skinning/rigging/fit/girth_profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace gelenk {
namespace {

using Eigen::Vector3d;

/// Rings around y, height 1, whose radius follows `radius`; fed edge by edge.
void addRings(GirthProfile& profile, const std::function<double(double)>& radius) {
  constexpr int n = 32, rings = 50;
  const auto at = [&](int i, int k) {
    const double y = static_cast<double>(i) / rings, a = 2.0 * M_PI * k / n;
    return Vector3d(radius(y) * std::cos(a), y, radius(y) * std::sin(a));
  };
  for (int i = 0; i < rings; ++i)
    for (int k = 0; k < n; ++k) {
      profile.add(at(i, k), at(i, k + 1));
      profile.add(at(i, k), at(i + 1, k));
    }
}

const Vector3d bottom(0, 0, 0), top(0, 1, 0);

TEST(GirthProfile, IsTheLengthOfATapeAroundTheLimb) {
  GirthProfile profile(bottom, top, 21);
  addRings(profile, [](double y) { return 0.1 + 0.1 * y; });
  addRings(profile, [](double) { return 0.05; });  // an inner layer
  // The polygon of 32 corners is 0.16 % shorter than the circle, eight directions see 0.3 % of its width.
  for (int cut = 0; cut <= 20; ++cut)
    EXPECT_NEAR(profile.girth(cut), 2.0 * M_PI * (0.1 + 0.005 * cut), 0.005 * profile.girth(cut));
}

TEST(GirthProfile, TheWaistLiesBetweenTwoThickerParts) {
  const auto waist = [](const std::function<double(double)>& radius) {
    GirthProfile profile(bottom, top, 61);
    addRings(profile, radius);
    return profile.waist();
  };
  const auto hourglass = waist([](double y) { return 0.1 + 0.3 * std::abs(y - 0.6); });
  ASSERT_TRUE(hourglass);
  EXPECT_NEAR(*hourglass, 0.6, 0.02);  // two cuts
  const auto cuff = waist([](double y) { return y < 0.5 ? 0.1 : 0.06 + 0.1 * std::abs(y - 0.6); });
  ASSERT_TRUE(cuff);
  EXPECT_NEAR(*cuff, 0.6, 0.02);
  EXPECT_FALSE(waist([](double) { return 0.1; }));
  EXPECT_FALSE(waist([](double y) { return 0.2 - 0.1 * y; })) << "thicker on one side only";
  EXPECT_FALSE(GirthProfile(bottom, top, 5).waist()) << "nothing there";
}

}  // namespace
}  // namespace gelenk
