#pragma once

#include <span>
#include <string>
#include <string_view>

#include "solvers/lab/report.h"

namespace gelenk {

/// An experiment from the literature that the laboratory repeats.
struct Reproduction {
  std::string_view name;
  std::string_view title;
};
std::span<const Reproduction> reproductions();

/// Runs the experiment, prints our values beside the published ones, and writes NAME.json and NAME.md into the folder where one is
/// given. Throws std::invalid_argument that lists the names there are.
void reproduce(const std::string& name, const std::string& folder, const ReportStyle& style);

}  // namespace gelenk
