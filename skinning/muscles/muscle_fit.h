#pragma once

#include <vector>

#include "skinning/muscles/muscle_skin.h"

namespace gelenk {

/// What may move when a muscle is fitted to a sculpted displacement: planes 2 and 4 of every link.
enum class MuscleFreedom {
  Scale,           ///< symmetric 2 x 2 stretch: 3 numbers a plane
  ScaleAndOffset,  ///< and an offset in the plane: 5
  FreePoints,      ///< the 16 control points: 48
};

struct MuscleFit {
  std::vector<MuscleState> states;  ///< one a link
  double residual = 0.0;  ///< root mean square of what is left over that of the displacement, [0, 1]
  int vertices = 0;       ///< with a displacement, on the limb
};

/// Least squares: the states whose deformation of the resting limb comes nearest to the displacement.
/// displacement: one a vertex of the skin, metres, zero where not sculpted; only vertices on the limb's
/// volumes with one count. The deformation is linear in these parameters, so the fit is exact. FreePoints is
/// regularised by a share of 1e-6 of the mean diagonal, because points far from the skin hardly move it.
MuscleFit fitMuscle(const MuscleSkin& body, int limb, const Frames& restFrames,
                    const std::vector<Eigen::Vector3d>& displacement, MuscleFreedom freedom);

}  // namespace gelenk
