#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "solvers/problem/ik_solver.h"

namespace gelenk {

/// A method that the running program adds to its catalogue, such as a script's.
struct OwnSolver {
  struct OwnParameter {
    std::string name;
    double value = 0.0, lower = 0.0, upper = 0.0;
    std::string unit = "1", meaning = {};
  };
  std::string name, title, reference;
  std::vector<OwnParameter> parameters = {};
  std::function<std::unique_ptr<IkSolver>(const ParameterValues&)> make = {};
  bool stochastic = false;
};

/// Adds it to solverCatalogue(); one of the same name takes the place of the one before, of which solvers
/// that were made stay as they are. At most 64 names in the life of the program. Throws std::invalid_argument
/// for a name that is empty, holds other than a to z, 0 to 9 and '-', or belongs to a solver that was there
/// from the start, for parameters without a name, twice, or with a default outside the range, and where there
/// are too many.
void addSolver(OwnSolver solver);

/// Counts the calls of addSolver: what was made from the catalogue before may be of an older method.
int solverChanges();

}  // namespace gelenk
