#pragma once

#include <Eigen/Core>

namespace gelenk::slide {

// What the slides are given: start values, lengths, targets. What they print as results stands in the checks
// (topics_*.cpp). The chain P_1 = (50, 400), l = 150, 200, 100 itself is lecturePlanarChain().

// 10.1.2, example with three links
inline const Eigen::Vector3d forwardLengths{4.0, 6.0, 2.0};
inline const Eigen::Vector3d forwardDegrees{60.0, 270.0, 60.0};

// 10.1.3, numerical example of the explicit solution; P_1 = (0, 0)
inline constexpr double armLength = 10.0;  // l_1 = l_2
inline const Eigen::Vector2d armTarget{10.0, 0.0};

// 10.1.4, example of inverse kinematics
inline const Eigen::Vector3d startAngles{0.6, 1.0, -0.7};
inline const Eigen::Vector2d newTarget{350.0, 700.0};

}  // namespace gelenk::slide
