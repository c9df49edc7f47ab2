#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "solvers/lab/report.h"

namespace gelenk {

/// An experiment from the literature that the laboratory repeats.
struct Reproduction {
  std::string_view name;
  std::string_view title;
};
std::span<const Reproduction> reproductions();

/// What an experiment found: a table, what was published, and what differs between the two.
struct Findings {
  std::string setting;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows = {};
  std::string published = {};
  std::string differs = {};
};

/// Runs the experiment (a few seconds). Throws std::invalid_argument that lists the names there are.
Findings runExperiment(const std::string& name);

/// Runs the experiment, prints our values beside the published ones, and writes NAME.json and NAME.md into
/// the folder where one is given.
void reproduce(const std::string& name, const std::string& folder, const ReportStyle& style);

}  // namespace gelenk
