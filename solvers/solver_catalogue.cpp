#include <array>
#include <stdexcept>

#include "solvers/ik_solver.h"
#include "solvers/serial_pose.h"
#include "solvers/step_rules.h"

namespace gelenk {
namespace {

constexpr std::array catalogue{
    SolverEntry{"serial-pose", "Box-limited LM with raced restarts", "Chan and Lawrence 1988; this project", &makeSerialPose},
    SolverEntry{"serial-pose-table", "The same with a table of starts", "this project", &makeSerialPoseTable},
    SolverEntry{"pseudo-inverse", "Pseudo-inverse Newton", "Lecture 10.1.4, n > m", &makePseudoInverse},
    SolverEntry{"jacobian-transpose", "Jacobian transpose", "Buss 2004", &makeJacobianTranspose},
    SolverEntry{"dls", "Damped least squares", "Wampler 1986; Buss 2004", &makeDampedLeastSquares},
};

}  // namespace

std::span<const SolverEntry> solverCatalogue() { return catalogue; }

std::unique_ptr<IkSolver> makeSolver(std::string_view name) {
  if (name == "default") name = catalogue.front().name;
  std::string known;
  for (const SolverEntry& entry : catalogue) {
    if (entry.name == name) return entry.make();
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  }
  throw std::invalid_argument("no solver is called '" + std::string(name) + "'; there are: " + known);
}

}  // namespace gelenk
