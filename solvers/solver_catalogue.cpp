#include <array>
#include <stdexcept>

#include "solvers/ik_solver.h"
#include "solvers/step_rules.h"

namespace gelenk {
namespace {

constexpr std::array catalogue{
    SolverEntry{"pseudo-inverse", "Pseudo-inverse Newton", "Lecture 10.1.4, n > m", &makePseudoInverse},
    SolverEntry{"jacobian-transpose", "Jacobian transpose", "Buss 2004", &makeJacobianTranspose},
    SolverEntry{"dls", "Damped least squares", "Wampler 1986; Buss 2004", &makeDampedLeastSquares},
};

}  // namespace

std::span<const SolverEntry> solverCatalogue() { return catalogue; }

std::unique_ptr<IkSolver> makeSolver(std::string_view name) {
  std::string known;
  for (const SolverEntry& entry : catalogue) {
    if (entry.name == name) return entry.make();
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  }
  throw std::invalid_argument("no solver is called '" + std::string(name) + "'; there are: " + known);
}

}  // namespace gelenk
