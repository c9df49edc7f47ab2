#include "solvers/problem/parameters.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kinematics/io/text_file.h"

namespace gelenk {

std::string listed(std::span<const Parameter> table) {
  std::string text;
  for (const Parameter& p : table) {
    text += (text.empty() ? "" : ", ") + std::string(p.name) + " (" + exactNumber(p.value);
    if (p.unit != "1") text += " " + std::string(p.unit);
    text += "; " + exactNumber(p.lower) + " to " + exactNumber(p.upper) + ")";
  }
  return text;
}

void validate(std::string_view owner, std::span<const Parameter> table, const ParameterValues& values) {
  for (const auto& [name, value] : values) {
    const auto found = std::find_if(table.begin(), table.end(),
                                    [&, &name = name](const Parameter& p) { return p.name == name; });
    const std::string full = std::string(owner) + "." + name;
    if (found == table.end())
      throw std::invalid_argument(table.empty()
                                      ? "'" + std::string(owner) + "' has no parameters, so no '" + name + "'"
                                      : "'" + std::string(owner) + "' has no parameter '" + name +
                                            "'; there are: " + listed(table));
    if (!(value >= found->lower && value <= found->upper))
      throw std::invalid_argument(full + " must lie in " + exactNumber(found->lower) + " to " +
                                  exactNumber(found->upper) +
                                  (found->unit == "1" ? "" : " " + std::string(found->unit)) + ", not " +
                                  (std::isfinite(value) ? exactNumber(value) : "there"));
    if (found->whole && value != std::floor(value))
      throw std::invalid_argument(full + " must be a whole number, not " + exactNumber(value));
  }
}

}  // namespace gelenk
