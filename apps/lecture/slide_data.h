#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

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

// Where examples begin for which the slides print no start.
inline constexpr double oneLinkStart = 0.1;                 // Newton in one dimension
inline const Eigen::Vector2d twoLinkDegrees{60.0, -120.0};  // a branch of 10.1.3
inline const Eigen::Vector2d squareStart{-0.5, 1.5};        // Newton, n = m
inline const std::array<Eigen::Vector3d, 3> ballAngles{
    // (phi^x, phi^y, phi^z) of three ball joints
    Eigen::Vector3d(Eigen::Vector3d(20, -30, 40) * (M_PI / 180.0)),
    Eigen::Vector3d(Eigen::Vector3d(-50, 60, 10) * (M_PI / 180.0)),
    Eigen::Vector3d(Eigen::Vector3d(70, -20, -80) * (M_PI / 180.0))};
inline constexpr double walkStart = 0.35;  // seconds, the leg's animation

}  // namespace gelenk::slide
