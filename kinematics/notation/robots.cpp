#include "kinematics/notation/robots.h"

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace gelenk {
namespace {

constexpr double pi = M_PI;
constexpr double degree = M_PI / 180.0;

Eigen::VectorXd pose(std::initializer_list<double> values) {
  return Eigen::Map<const Eigen::VectorXd>(values.begin(), static_cast<Eigen::Index>(values.size()));
}

/// Unimation PUMA 560, standard convention; limits from the maker's data sheet.
DhTable puma560() {
  const auto row = [](double a, double d, double alpha, double lower, double upper) {
    return DhRow{.a = a, .alpha = alpha, .d = d, .lower = lower * degree, .upper = upper * degree};
  };
  return {.name = "puma560",
          .convention = DhConvention::Standard,
          .rows = {row(0.0, 0.67183, pi / 2, -160, 160), row(0.4318, 0.0, 0.0, -110, 110),
                   row(0.0203, 0.15005, -pi / 2, -135, 135), row(0.0, 0.4318, pi / 2, -266, 266),
                   row(0.0, 0.0, -pi / 2, -100, 100), row(0.0, 0.0, 0.0, -266, 266)},
          .rest = pose({0.0, 60 * degree, -130 * degree, 0.0, -60 * degree, 0.0})};
}

/// Universal Robots UR5, standard convention; every joint turns twice around.
DhTable ur5() {
  const auto row = [](double a, double d, double alpha) {
    return DhRow{.a = a, .alpha = alpha, .d = d, .lower = -2 * pi, .upper = 2 * pi};
  };
  return {.name = "ur5",
          .convention = DhConvention::Standard,
          .rows = {row(0.0, 0.089159, pi / 2), row(-0.425, 0.0, 0.0), row(-0.39225, 0.0, 0.0),
                   row(0.0, 0.10915, pi / 2), row(0.0, 0.09465, -pi / 2), row(0.0, 0.0823, 0.0)},
          .rest = pose({0.0, -pi / 3, pi / 2, -2 * pi / 3, -pi / 2, 0.0})};
}

/// Franka Emika Panda, modified convention (the lecture's); the last row is the flange.
DhTable panda() {
  const auto row = [](double a, double d, double alpha, double lower, double upper) {
    return DhRow{.a = a, .alpha = alpha, .d = d, .lower = lower, .upper = upper};
  };
  return {.name = "panda",
          .convention = DhConvention::Modified,
          .rows = {row(0.0, 0.333, 0.0, -2.8973, 2.8973), row(0.0, 0.0, -pi / 2, -1.7628, 1.7628),
                   row(0.0, 0.316, pi / 2, -2.8973, 2.8973), row(0.0825, 0.0, pi / 2, -3.0718, -0.0698),
                   row(-0.0825, 0.384, -pi / 2, -2.8973, 2.8973), row(0.0, 0.0, pi / 2, -0.0175, 3.7525),
                   row(0.088, 0.0, pi / 2, -2.8973, 2.8973), DhRow{.kind = DhJoint::Fixed, .d = 0.107}},
          .rest = pose({0.0, -pi / 4, 0.0, -3 * pi / 4, 0.0, pi / 2, pi / 4})};
}

/// KUKA LBR iiwa 14 R820, standard convention.
DhTable iiwa14() {
  const auto row = [](double d, double alpha, double limit) {
    return DhRow{.alpha = alpha, .d = d, .lower = -limit * degree, .upper = limit * degree};
  };
  return {
      .name = "iiwa14",
      .convention = DhConvention::Standard,
      .rows = {row(0.36, -pi / 2, 170), row(0.0, pi / 2, 120), row(0.42, pi / 2, 170), row(0.0, -pi / 2, 120),
               row(0.40, -pi / 2, 170), row(0.0, pi / 2, 120), row(0.126, 0.0, 175)},
      .rest = pose({0.0, pi / 6, 0.0, -pi / 2, 0.0, pi / 3, 0.0})};
}

/// A SCARA arm with the measures of the Adept Cobra s600 (reach 0.6 m, stroke 0.21 m), modified convention:
/// two parallel turning axes, a sliding one that points down, and the roll of the tool.
DhTable scara() {
  return {.name = "scara",
          .convention = DhConvention::Modified,
          .rows = {DhRow{.d = 0.387, .lower = -105 * degree, .upper = 105 * degree},
                   DhRow{.a = 0.325, .lower = -150 * degree, .upper = 150 * degree},
                   DhRow{.kind = DhJoint::Prismatic, .a = 0.275, .alpha = pi, .lower = 0.0, .upper = 0.21},
                   DhRow{.lower = -2 * pi, .upper = 2 * pi}, DhRow{.kind = DhJoint::Fixed, .d = 0.12}},
          .rest = pose({pi / 6, -pi / 3, 0.05, 0.0})};
}

constexpr std::array table{
    Robot{"puma560", "Unimation PUMA 560", &puma560},   Robot{"ur5", "Universal Robots UR5", &ur5},
    Robot{"panda", "Franka Emika Panda", &panda},       Robot{"iiwa14", "KUKA LBR iiwa 14", &iiwa14},
    Robot{"scara", "SCARA (Adept Cobra s600)", &scara},
};

}  // namespace

std::span<const Robot> robots() { return table; }

DhTable robotTable(std::string_view name) {
  std::string known;
  for (const Robot& robot : table) {
    if (robot.name == name) return robot.table();
    known += (known.empty() ? "" : ", ") + std::string(robot.name);
  }
  throw std::invalid_argument("no robot is called '" + std::string(name) + "'; there are: " + known);
}

}  // namespace gelenk
