#include "solvers/lab/sweep.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

/// To four significant digits.
double rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return parseNumber(text).value_or(value);
}

}  // namespace

ParameterSweep parameterSweep(std::string_view text) {
  const auto refuse = [&](const std::string& why) {
    throw std::invalid_argument("'" + std::string(text) + "': " + why);
  };
  const std::size_t equals = text.find('='), first = text.find(':', equals == text.npos ? 0 : equals),
                    second = first == text.npos ? text.npos : text.find(':', first + 1);
  if (equals == text.npos || second == text.npos)
    refuse("expected SOLVER.PARAMETER=FROM:TO:logN or linN, such as dls.lambda=0.01:1:log9");
  const ParameterSetting from = parameterSetting(text.substr(0, first));
  const ParameterSetting to = parameterSetting(std::string(text.substr(0, equals + 1)) +
                                               std::string(text.substr(first + 1, second - first - 1)));
  const std::string_view spacing = text.substr(second + 1);
  const bool logarithmic = spacing.starts_with("log");
  const auto count = spacing.size() > 3 ? parseInteger(spacing.substr(3)) : std::nullopt;
  if (!(logarithmic || spacing.starts_with("lin")) || !count)
    refuse("expected log or lin and a number of values, found '" + std::string(spacing) + "'");
  if (*count < 2 || *count > 1000)
    refuse("the number of values must be 2 to 1000, not " + std::to_string(*count));
  if (!(from.value < to.value)) refuse("a sweep runs from a smaller value to a larger one");
  if (logarithmic && !(from.value > 0.0)) refuse("a logarithmic sweep begins above 0");

  const auto row = std::find_if(from.entry->parameters.begin(), from.entry->parameters.end(),
                                [&](const Parameter& p) { return p.name == from.parameter; });
  ParameterSweep sweep{.entry = from.entry, .parameter = from.parameter, .values = {}};
  for (int i = 0; i < *count; ++i) {
    const double share = static_cast<double>(i) / (*count - 1);
    double value = i == 0            ? from.value
                   : i == *count - 1 ? to.value
                   : logarithmic     ? from.value * std::pow(to.value / from.value, share)
                                     : from.value + share * (to.value - from.value);
    if (row->whole)
      value = std::round(value);
    else if (i > 0 && i < *count - 1)
      value = rounded(value);
    if (sweep.values.empty() || value > sweep.values.back()) sweep.values.push_back(value);
  }
  return sweep;
}

std::vector<std::string> withParameters(std::vector<std::string> solvers,
                                        const std::vector<std::string>& settings,
                                        const std::vector<std::string>& sweeps) {
  std::vector<ParameterSweep> grids;
  for (const std::string& text : sweeps) {
    grids.push_back(parameterSweep(text));
    const auto names = [&](const std::string& solver) { return &solverEntry(solver) == grids.back().entry; };
    if (std::none_of(solvers.begin(), solvers.end(), names)) solvers.emplace_back(grids.back().entry->name);
  }
  std::vector<SolverSpec> choices;
  for (const std::string& solver : solvers) choices.push_back(solverSpec(solver));
  for (const std::string& text : settings) {
    const ParameterSetting setting = parameterSetting(text);
    bool any = false;
    for (SolverSpec& choice : choices) {
      if (choice.entry != setting.entry) continue;
      choice = withParameter(choice, setting.parameter, setting.value);
      any = true;
    }
    if (any) continue;
    std::string names;
    for (const std::string& solver : solvers) names += (names.empty() ? "" : ", ") + solver;
    throw std::invalid_argument("'" + text +
                                "' sets a parameter of a solver that is not used; used: " + names);
  }
  for (const ParameterSweep& grid : grids) {
    std::vector<SolverSpec> wider;
    for (const SolverSpec& choice : choices) {
      if (choice.entry != grid.entry) {
        wider.push_back(choice);
        continue;
      }
      for (const double value : grid.values) wider.push_back(withParameter(choice, grid.parameter, value));
    }
    choices = std::move(wider);
  }
  std::vector<std::string> texts;
  for (const SolverSpec& choice : choices)
    if (std::string text = toText(choice); std::find(texts.begin(), texts.end(), text) == texts.end())
      texts.push_back(std::move(text));
  return texts;
}

}  // namespace gelenk
