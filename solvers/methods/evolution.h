#pragma once

#include <memory>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

struct EvolutionParameters {
  int population = 16, parents = 8, elite = 2, polish = 4, patience = 10;
  double mutation = 0.3;

  static constexpr auto fields() {
    using P = EvolutionParameters;
    return std::to_array<ParameterField<P>>(
        {{&P::population, "population", 2, 1000, "1", "ours", "Configurations of a generation."},
         {&P::parents, "parents", 1, 1000, "1", "ours",
          "The best that stay and are drawn from; at most the population."},
         {&P::elite, "elite", 0, 1000, "1", "ours", "The best that are polished; at most the parents."},
         {&P::polish, "polish", 0, 100, "1", "ours", "Levenberg-Marquardt steps of a polish."},
         {&P::patience, "patience", 1, 10000, "1", "ours",
          "Generations without a fall of the best by 1 % after which a population is drawn anew."},
         {&P::mutation, "mutation", 0.0, 10.0, "1", "ours",
          "Width of a mutation over the root mean square distance of the parents."}});
  }
};
/// A memetic search in the manner of bio_ik: configurations within the limits; every generation the better
/// half stays, children are drawn between two parents with the parents' momentum and a mutation whose width
/// follows the parents' distance, and the best are polished by Levenberg-Marquardt steps. A population that
/// no longer gets better is drawn anew; the best answer so far is kept. Throws std::invalid_argument for
/// more parents than configurations or a larger elite than parents.
/// Iterations count generations. Random numbers come from Budget::seed alone. Ruppel, Hendrich, Starke, Zhang
/// 2018; Starke, Hendrich, Zhang 2018.
std::unique_ptr<IkSolver> makeEvolution(const EvolutionParameters& parameters = {});

}  // namespace gelenk
