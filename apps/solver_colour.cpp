#include "apps/solver_colour.h"

#include <array>

#include "solvers/ik_solver.h"

namespace gelenk {

Eigen::Vector3f solverColour(std::string_view solver) {
  static const std::array<Eigen::Vector3f, 6> palette{{{0.835f, 0.369f, 0.000f},    // vermilion
                                                       {0.000f, 0.620f, 0.451f},    // bluish green
                                                       {0.902f, 0.624f, 0.000f},    // orange
                                                       {0.800f, 0.475f, 0.655f},    // reddish purple
                                                       {0.337f, 0.706f, 0.914f},    // sky blue
                                                       {0.490f, 0.430f, 0.120f}}};  // olive, in place of the palette's pale yellow
  std::size_t index = 0;
  for (const SolverEntry& entry : solverCatalogue()) {
    if (entry.name == "hybrid") continue;
    if (entry.name == solver) return palette[index % palette.size()];
    ++index;
  }
  return {0.000f, 0.447f, 0.698f};  // blue
}

}  // namespace gelenk
