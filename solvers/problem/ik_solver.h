#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "solvers/problem/ik_problem.h"
#include "solvers/problem/ik_report.h"

namespace gelenk {

/// One inverse-kinematics method. Stateless between solves: the same problem, budget and seed give the same
/// answer.
class IkSolver {
 public:
  virtual ~IkSolver() = default;

  /// Work that depends on the skeleton alone (tables, symbolic structure); timed apart from solve().
  virtual void prepare(const Skeleton&) {}

  /// Whether the method is meant for such problems; a solver asked all the same returns Stop::Unsupported.
  /// The reason, in words for a person, where it is not; empty where it is.
  virtual std::string whyUnsupported(const IkProblem& problem) const = 0;

  /// Never throws for a well-formed problem; a numerical failure is a Stop, not an exception.
  virtual IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const = 0;
};

/// A row of the solver catalogue.
struct SolverEntry {
  std::string_view name;   ///< as typed on the command line and shown in the sandbox, e.g. "pseudo-inverse"
  std::string_view title;  ///< "Pseudo-inverse Newton"
  std::string_view reference;  ///< paper or slide
  std::unique_ptr<IkSolver> (*make)();
  bool stochastic = false;  ///< the method itself draws random numbers, beyond the restarts that all have:
                            ///< judge it over many seeds
};

/// Every solver there is, an explicit table in solver_catalogue.cpp.
std::span<const SolverEntry> solverCatalogue();

/// The name that a solver has now: older files call the drag solver "hybrid".
std::string_view presentName(std::string_view name);

/// "default" names the default solver of serial chains, the catalogue's first.
/// Throws std::invalid_argument that lists the names there are.
std::unique_ptr<IkSolver> makeSolver(std::string_view name);

/// The row that makeSolver uses. Throws likewise.
const SolverEntry& solverEntry(std::string_view name);

}  // namespace gelenk
