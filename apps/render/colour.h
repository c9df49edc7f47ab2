#pragma once

namespace gelenk {

/// sRGB values in [0, 1], as a person picks them, and straight alpha.
struct Colour {
  float r = 0, g = 0, b = 0, a = 1;
};
inline Colour withAlpha(Colour colour, float alpha) { return {colour.r, colour.g, colour.b, alpha}; }

/// viridis at t in [0, 1]: the perceptually uniform map of weights, residuals and manipulability.
Colour viridis(float t);

}  // namespace gelenk
