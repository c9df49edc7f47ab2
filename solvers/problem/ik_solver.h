#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "solvers/problem/ik_problem.h"
#include "solvers/problem/ik_report.h"
#include "solvers/problem/parameters.h"

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
  std::string_view reference;             ///< paper or slide
  std::span<const Parameter> parameters;  ///< its constants that can be chosen
  std::unique_ptr<IkSolver> (*build)(const ParameterValues&);
  bool stochastic = false;  ///< the method itself draws random numbers, beyond the restarts that all have:
                            ///< judge it over many seeds

  /// The method with these values of its parameters, the others at their defaults. Throws
  /// std::invalid_argument for an unknown parameter or a value out of range, and lists what there is.
  std::unique_ptr<IkSolver> make(const ParameterValues& values = {}) const;
};

/// Every solver there is, an explicit table in solver_catalogue.cpp.
std::span<const SolverEntry> solverCatalogue();

/// The name that a solver has now: older files call the drag solver "hybrid" and the closed forms
/// "spherical-wrist".
std::string_view presentName(std::string_view name);

// A solver is chosen by a text: its name, or its name and values of parameters in brackets, such as
// "dls[lambda=0.1,largest-step=1]". "default" names the solver that fits the problem: the catalogue's first
// on serial chains, the drag solver elsewhere; it has no parameters of its own.

struct SolverSpec {
  std::string name;  ///< as chosen: the entry's, or "default"
  const SolverEntry* entry = nullptr;
  ParameterValues values = {};  ///< those that differ from their defaults
};

/// Throws std::invalid_argument for an unknown solver, parameter or value, and lists what there is.
SolverSpec solverSpec(std::string_view text);

/// The one text for a choice: parameters in the order of their table, defaults left out.
std::string toText(const SolverSpec& choice);

/// The choice with one more value. Throws likewise.
SolverSpec withParameter(SolverSpec choice, std::string_view parameter, double value);

/// "dls.lambda=0.1": throws std::invalid_argument where it has another form or names what there is not.
struct ParameterSetting {
  const SolverEntry* entry = nullptr;
  std::string parameter;
  double value = 0.0;
};
ParameterSetting parameterSetting(std::string_view text);

/// The solver of a choice's text. Throws likewise.
std::unique_ptr<IkSolver> makeSolver(std::string_view text);
std::unique_ptr<IkSolver> makeSolver(std::string_view name, const ParameterValues& values);

/// The row that makeSolver uses. Throws likewise.
const SolverEntry& solverEntry(std::string_view text);

}  // namespace gelenk
