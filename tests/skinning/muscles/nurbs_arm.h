#pragma once

#include <algorithm>
#include <cmath>

#include "skinning/muscles/nurbs_surface.h"

namespace gelenk::testing {

/// The left arm of assets/nurbs_arm.nurbs: elliptical rings along the two bones of assets/nurbs_arm.skel,
/// which rests with the elbow bent by 12 degrees towards +z. At distance s from the shoulder, before the
/// elbow (s < 0.28):
///     centre = (0.18 + s, 1.40, 0),   A = height y,   B = depth z
/// and behind it turned about y by a(s) = 12 degrees smoothstep((s - 0.22) / 0.12), half of it at the elbow.
inline std::vector<TubeRing> armRings() {
  struct Row {
    double s, height, depth, rise;  ///< metres: half axes, offset along y
  };
  constexpr Row rows[] = {
      {-0.075, 0.046, 0.044, 0.000}, {-0.050, 0.062, 0.058, 0.000}, {0.010, 0.068, 0.063, 0.002},
      {0.070, 0.058, 0.058, 0.001},  {0.125, 0.050, 0.055, 0.000},  {0.180, 0.047, 0.053, 0.000},
      {0.235, 0.042, 0.043, 0.000},  {0.280, 0.040, 0.039, -0.001}, {0.320, 0.044, 0.043, 0.000},
      {0.365, 0.044, 0.042, 0.000},  {0.420, 0.036, 0.037, 0.000},  {0.475, 0.028, 0.031, 0.000},
      {0.525, 0.020, 0.028, 0.000},  {0.565, 0.018, 0.036, 0.000},  {0.610, 0.017, 0.043, 0.000},
      {0.655, 0.014, 0.041, -0.001}, {0.695, 0.011, 0.033, -0.003}, {0.715, 0.006, 0.016, -0.004}};
  constexpr double bend = 12.0 * M_PI / 180.0, elbow = 0.28;
  std::vector<TubeRing> rings;
  for (const Row& row : rows) {
    const double t = std::clamp((row.s - 0.22) / 0.12, 0.0, 1.0), angle = bend * t * t * (3.0 - 2.0 * t);
    const double beyond = std::max(row.s - elbow, 0.0), before = row.s - beyond;
    const Eigen::Vector3d centre(0.18 + before + beyond * std::cos(bend), 1.40 + row.rise,
                                 beyond * std::sin(bend));
    rings.push_back({centre,
                     {0.0, row.height, 0.0},
                     row.depth * Eigen::Vector3d(-std::sin(angle), 0.0, std::cos(angle))});
  }
  return rings;
}

}  // namespace gelenk::testing
