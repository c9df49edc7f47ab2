#pragma once

namespace gelenk {

class Sandbox;

/// Up to three other skinning methods beside the body, in the pose it is in: which they are, and what is
/// measured of them while it moves. A part of the tabs Skin, Muscles and Lab.
void drawSkinComparison(Sandbox& sandbox);

}  // namespace gelenk
