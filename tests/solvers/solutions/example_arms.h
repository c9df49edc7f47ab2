#pragma once

#include <random>
#include <string>
#include <vector>

#include "kinematics/configuration.h"
#include "kinematics/notation/dh_table.h"
#include "kinematics/notation/robots.h"
#include "solvers/serial/serial_chain.h"
#include "solvers/solutions/loop.h"

namespace gelenk::testing {

/// Rows a, alpha, d in the standard convention; joints without limits.
inline DhTable standardTable(const std::string& name, const std::vector<Eigen::Vector3d>& rows) {
  DhTable table{.name = name, .convention = DhConvention::Standard};
  for (const Eigen::Vector3d& r : rows) table.rows.push_back({.a = r[0], .alpha = r[1], .d = r[2]});
  return table;
}

/// Arms without a spherical wrist and without three parallel axes, from the makers' tables (metres).
/// jaco2: Kinova Jaco 2 with the wrist of 60 degrees; xarm6: UFactory xArm 6 (modified convention there);
/// crx10ia: FANUC CRX-10iA.
inline DhTable generalArm(const std::string& name) {
  const double h = M_PI / 2, g = M_PI / 3, half = 0.5 / std::sin(g);
  if (name == "jaco2")
    return standardTable(name, {{0, h, 0.2755},
                                {0.41, M_PI, 0},
                                {0, h, -0.0098},
                                {0, g, -(0.2073 + half * 0.0741)},
                                {0, g, -2 * half * 0.0741},
                                {0, M_PI, -(half * 0.0741 + 0.16)}});
  if (name == "xarm6")
    return standardTable(
        name,
        {{0, -h, 0.267}, {0.28948866, 0, 0}, {0.0775, -h, 0}, {0, h, 0.3425}, {0.076, -h, 0}, {0, 0, 0.097}});
  return standardTable(
      name, {{0, -h, 0.245}, {0.54, M_PI, 0}, {0, -h, 0}, {0, h, -0.54}, {0, -h, 0.15}, {0, M_PI, -0.16}});
}

/// UFactory xArm 7 from the maker's table (metres, radians): S-R-S but for offsets at elbow and wrist; some
/// joints turn twice around.
inline DhTable xarm7() {
  DhTable table{.name = "xarm7", .convention = DhConvention::Modified};
  const double h = M_PI / 2, twice = 2 * M_PI;
  const auto row = [&](double alpha, double a, double d, double lower, double upper) {
    table.rows.push_back({.a = a, .alpha = alpha, .d = d, .lower = lower, .upper = upper});
  };
  row(0, 0, 0.267, -twice, twice), row(-h, 0, 0, -2.059, 2.0944), row(h, 0, 0.293, -twice, twice);
  row(h, 0.0525, 0, -0.19198, 3.927), row(h, 0.0775, 0.3425, -twice, twice);
  row(h, 0, 0, -1.69297, M_PI), row(-h, 0.076, 0.097, -twice, twice);
  return table;
}

/// Axes 1, 2 and 3 meet, and axes 5 and 6; everything else as it comes, limits too.
inline DhTable randomShoulderArm(std::mt19937_64& random) {
  DhTable table{.name = "shoulder", .convention = DhConvention::Modified};
  const auto between = [&](double a, double b) { return a + (b - a) * uniform01(random); };
  for (int i = 0; i < 7; ++i) {
    const bool bare = i == 1 || i == 2 || i == 5;
    const double side = uniform01(random) < 0.5 ? -1.0 : 1.0, middle = between(-1, 1), half = between(1, 4);
    table.rows.push_back({.a = bare || i == 0 ? 0.0 : between(-0.3, 0.3),
                          .alpha = i == 0 ? 0.0 : side * between(0.6, 2.5),
                          .d = i == 1 ? 0.0 : between(-0.5, 0.5),
                          .phi = between(-2, 2),
                          .lower = middle - half,
                          .upper = middle + half});
  }
  return table;
}

/// Lengths in [-1, 1] m, twists in [-pi, pi].
inline DhTable randomArm(std::mt19937_64& random) {
  std::vector<Eigen::Vector3d> rows;
  const auto symmetric = [&] { return 2.0 * uniform01(random) - 1.0; };
  for (int i = 0; i < 6; ++i) {
    const double a = symmetric(), alpha = M_PI * symmetric(), d = symmetric();
    rows.emplace_back(a, alpha, d);
  }
  return standardTable("random", rows);
}

inline SerialChain chainOf(const DhTable& table) {
  const Skeleton skeleton = toSkeleton(table);
  return extractSerialChain(skeleton, skeleton.jointCount() - 1).chain;
}

inline Vector6d randomAngles(std::mt19937_64& random) {
  Vector6d q;
  for (double& x : q) x = M_PI * (2.0 * uniform01(random) - 1.0);
  return q;
}

/// Largest difference of two configurations up to whole turns.
inline double apart(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  double most = 0.0;
  for (Eigen::Index i = 0; i < a.size(); ++i)
    most = std::max(most, std::abs(std::remainder(a[i] - b[i], 2.0 * M_PI)));
  return most;
}

}  // namespace gelenk::testing
