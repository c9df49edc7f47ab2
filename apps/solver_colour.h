#pragma once

#include <Eigen/Core>
#include <string_view>

namespace gelenk {

/// The colour of a solver wherever it appears: viewport, plot, report. sRGB, 0..1. The palette of Okabe and Ito (2008), which
/// is told apart with any colour vision, in catalogue order; the hybrid drag solver is blue.
Eigen::Vector3f solverColour(std::string_view solver);

}  // namespace gelenk
