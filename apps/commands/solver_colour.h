#pragma once

#include <Eigen/Core>
#include <string_view>

namespace gelenk {

/// The colour of a solver wherever it appears: viewport, plot, report. sRGB, 0..1, in catalogue order; the
/// drag solver is blue. Eighteen colours, then again from the second (plots then tell the two by
/// dashes). They grow from the palette of Okabe and Ito (2008): each further one is, among those that stand
/// out on white and on dark grey, about the farthest from all before in Oklab, partly as seen without green
/// cones.
Eigen::Vector3f solverColour(std::string_view solver);

}  // namespace gelenk
