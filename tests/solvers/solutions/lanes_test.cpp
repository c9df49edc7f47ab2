#include "solvers/solutions/lanes.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#pragma GCC diagnostic ignored "-Wpsabi"  // everything that takes vectors is inlined

namespace gelenk::lanes {
namespace {

/// Reduced to tan(pi / 8), a polynomial good to 1.2e-17, and at most four roundings of numbers below pi.
TEST(Lanes, AnglesAreThoseOfTheLibraryToRounding) {
  std::mt19937_64 random(81);
  std::uniform_real_distribution<double> unit(-1.0, 1.0), exponent(-12.0, 3.0);
  double worst = 0.0;
  const auto compare = [&](const double(&y)[4], const double(&x)[4]) {
    double angle[4];
    store(angle, angleOf(load(y), load(x)));
    for (int l = 0; l < 4; ++l) worst = std::max(worst, std::abs(angle[l] - std::atan2(y[l], x[l])));
  };
  for (int k = 0; k < 200000; ++k) {
    double y[4], x[4];
    for (int l = 0; l < 4; ++l) {
      y[l] = unit(random) * std::pow(10.0, exponent(random));
      x[l] = unit(random) * std::pow(10.0, exponent(random));
    }
    compare(y, x);
  }
  compare({0.0, 1.0, 0.0, -1.0}, {1.0, 0.0, -1.0, 0.0});
  compare({1.0, 1.0, -1.0, -1.0}, {1.0, -1.0, 1.0, -1.0});
  compare({1e-300, -1e-16, 1e-9, 0.41421356237309503}, {-1.0, -1.0, 1e-9, 1.0});
  EXPECT_LT(worst, 1e-15);
}

TEST(Lanes, TheNearestImageWithinLimitsIsThatOfASearch) {
  std::mt19937_64 random(82);
  std::uniform_real_distribution<double> angle(-20.0, 20.0);
  int without = 0;
  for (int k = 0; k < 20000; ++k) {
    const bool open = k % 5 == 0;
    double lower = angle(random), upper = lower + std::abs(angle(random));
    if (open) lower = -std::numeric_limits<double>::infinity();
    const double reference = angle(random);
    double from[4], moved[4];
    for (double& x : from) x = angle(random);
    Lanes lanes = load(from);
    const Mask within = toNearestImage(lanes, lower, upper, reference);
    store(moved, lanes);
    for (int l = 0; l < 4; ++l) {
      double best = std::numeric_limits<double>::infinity();
      for (int turns = -12; turns <= 12; ++turns)
        if (const double image = from[l] + turns * turn; image >= lower && image <= upper)
          best = std::min(best, std::abs(image - reference));
      EXPECT_EQ(within[l] != 0, std::isfinite(best)) << lower << " " << upper << " " << from[l];
      if (std::isfinite(best)) {
        EXPECT_NEAR(std::abs(moved[l] - reference), best, 1e-8);
        EXPECT_TRUE(moved[l] >= lower && moved[l] <= upper);
      } else {
        EXPECT_LE(std::abs(moved[l] - reference), M_PI + 1e-12);
        ++without;
      }
      EXPECT_NEAR(std::remainder(moved[l] - from[l], turn), 0.0, 1e-8);
      double alone = from[l];
      EXPECT_EQ(toNearestImage(alone, lower, upper, reference) != 0, within[l] != 0);
      EXPECT_EQ(alone, moved[l]);
    }
  }
  EXPECT_GT(without, 1000);
}

}  // namespace
}  // namespace gelenk::lanes
