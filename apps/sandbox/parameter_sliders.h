#pragma once

#include <span>
#include <string_view>

#include "solvers/problem/parameters.h"

namespace gelenk {

/// A slider for each of a solver's parameters and a button that takes all back to their defaults. values:
/// those away from their defaults. True where the user changed something. id: tells several solvers of a
/// panel apart.
bool parameterSliders(std::string_view id, std::span<const Parameter> parameters, ParameterValues& values);

}  // namespace gelenk
