#pragma once

#include "apps/document/camera.h"
#include "apps/render/overlay.h"

namespace gelenk {

/// What the coordinates along a picture's edges take of it, pixels at scale 1.
inline constexpr double rulerWidth = 44.0, rulerHeight = 22.0;

/// Coordinates of the plane z = height along the left and the lower edge, and the axes through its origin:
/// for a picture that sees the plane straight from above, x to the right; nothing for any other. pixelScale:
/// pixels of the picture for one at scale 1.
void addRulers(Overlay& overlay, const Camera& camera, const Viewport& viewport, float pixelScale,
               double height, const Colour& colour);

/// 1, 2 or 5 times a power of ten, the smallest one not below `step`.
double niceStep(double step);

}  // namespace gelenk
