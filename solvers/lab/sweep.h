#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

/// Values of one parameter to try in turn.
struct ParameterSweep {
  const SolverEntry* entry = nullptr;
  std::string parameter;
  std::vector<double> values;  ///< rising
};

/// "dls.lambda=0.01:1:log9": nine values from 0.01 to 1, evenly spaced by their logarithms; "lin9": by
/// themselves. Inner values are rounded to four digits (whole numbers for parameters that want them, each
/// once), so that their names stay short. Throws std::invalid_argument for another form, for what there is
/// not, and for values out of range.
ParameterSweep parameterSweep(std::string_view text);

/// Solvers (texts of choices) with every setting "dls.lambda=0.1" put into those it names, and every sweep's
/// grid in place of the solver it names; several sweeps of one solver make all combinations. A solver that is
/// only swept is added at the end. Throws std::invalid_argument for a setting that names no solver of the
/// list.
std::vector<std::string> withParameters(std::vector<std::string> solvers,
                                        const std::vector<std::string>& settings,
                                        const std::vector<std::string>& sweeps = {});

}  // namespace gelenk
