#pragma once

#include <Eigen/Geometry>
#include <array>

namespace gelenk {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// The inverse problem of a six-joint revolute arm as a closed loop of six hinges:
///     Rz(u_1) X_1 Rz(u_2) X_2 ... Rz(u_6) X_6 = I
/// X_i is the fixed way from hinge i to hinge i + 1; X_6 leads from the last hinge over the wanted pose back
/// to the first, so the goal is nothing but the shape of one link. A loop has no first joint: where it is cut
/// and in which sense it is walked is free, and every method below is written for one place only.
/// A hinge may slide along its axis instead: Tz(u_i) in place of Rz(u_i), u_i a length.
struct Loop {
  std::array<Eigen::Isometry3d, 6> link;
  unsigned slides = 0;  ///< bit i: hinge i slides
  bool slidesAt(int i) const { return slides >> i & 1u; }
};

/// Where a loop is cut: its joint j is joint joint(j) of the arm, walked against the arm's sense where
/// reversed.
struct Cut {
  int first = 0;
  bool reversed = false;
  int joint(int j) const { return reversed ? (first - j + 12) % 6 : (first + j) % 6; }
  double sign() const { return reversed ? -1.0 : 1.0; }  ///< u_arm = sign * u_loop
};

inline Loop cutAt(const Loop& loop, const Cut& cut) {
  Loop out;
  for (int j = 0; j < 6; ++j) {
    out.link[j] =
        cut.reversed ? loop.link[(cut.joint(j) + 5) % 6].inverse(Eigen::Isometry) : loop.link[cut.joint(j)];
    if (loop.slidesAt(cut.joint(j))) out.slides |= 1u << j;
  }
  return out;
}

/// The link of the cut loop that leads over the goal: X_6 of the arm.
inline int goalLink(const Cut& cut) {
  int j = 0;
  while ((cut.reversed ? (cut.joint(j) + 5) % 6 : cut.joint(j)) != 5) ++j;
  return j;
}

}  // namespace gelenk
