#pragma once

#include <Eigen/Core>
#include <vector>

namespace gelenk {

/// sRGB values in [0, 1], as a person picks them, and straight alpha.
struct Colour {
  float r = 0, g = 0, b = 0, a = 1;
};
inline Colour withAlpha(Colour colour, float alpha) { return {colour.r, colour.g, colour.b, alpha}; }

/// Linear light of a colour, without its alpha.
Eigen::Vector3f linearLight(const Colour& colour);

/// viridis at t in [0, 1]: the perceptually uniform map of weights, residuals and manipulability.
Colour viridis(float t);
/// viridis of each value as linear light, for SkinnedMeshGl::setColours.
std::vector<Eigen::Vector3f> viridisColours(const std::vector<float>& values);

}  // namespace gelenk
