#include "apps/commands/solver_colour.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "solvers/problem/ik_solver.h"

namespace gelenk {
namespace {

/// Ottosson 2020, "A perceptual color space for image processing".
Eigen::Vector3f oklab(const Eigen::Vector3f& srgb) {
  const Eigen::Vector3f linear = srgb.unaryExpr(
      [](float v) { return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f); });
  Eigen::Matrix3f cones, opponents;
  cones << 0.4122214708f, 0.5363325363f, 0.0514459929f, 0.2119034982f, 0.6806995451f, 0.1073969566f,
      0.0883024619f, 0.2817188376f, 0.6299787005f;
  opponents << 0.2104542553f, 0.7936177850f, -0.0040720468f, 1.9779984951f, -2.4285922050f, 0.4505937099f,
      0.0259040371f, 0.7827717662f, -0.8086757660f;
  return opponents * Eigen::Vector3f((cones * linear).unaryExpr([](float v) { return std::cbrt(v); }));
}

TEST(SolverColour, EighteenColoursAreToldApart) {
  std::vector<Eigen::Vector3f> seen;
  for (const SolverEntry& entry : solverCatalogue()) {
    const Eigen::Vector3f colour = solverColour(entry.name);
    bool known = false;
    for (const Eigen::Vector3f& other : seen) known = known || other == colour;
    if (!known) seen.push_back(colour);
  }
  ASSERT_EQ(seen.size(), 18u);
  for (std::size_t i = 0; i < seen.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      EXPECT_GE((oklab(seen[i]) - oklab(seen[k])).norm(), 0.1f)
          << i << " and " << k;  // five times a just noticeable difference
}

}  // namespace
}  // namespace gelenk
