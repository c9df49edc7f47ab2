#pragma once

#include "solvers/solutions/planar_system.h"

namespace gelenk {

/// Three hinges H1 X1 H2 X2 H3 that bring the point c to the place g, where one to three of them slide.
struct Placing {
  const Eigen::Isometry3d *X1, *X2;
  Eigen::Vector3d c, g;
  unsigned slides;  ///< bits 0 to 2
};

/// One way to do it: turns (none of what slides) and lengths (zero of what turns).
struct Placed {
  planar::Turn t[3];
  double length[3];
  unsigned free;  ///< hinges that could take any value; they took the reference's
};

/// All ways, at most eight (four: one quartic, or two quadratics), to the accuracy of their polynomial's
/// roots. Families in which a hinge slides are none.
int place(const Placing& placing, const double reference[3], Placed out[8]);

}  // namespace gelenk
