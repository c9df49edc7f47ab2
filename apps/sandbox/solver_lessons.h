#pragma once

#include <string_view>

namespace gelenk {

/// What the list of solvers teaches of one. r: residual, target minus what is reached; J: its Jacobian.
struct SolverLesson {
  std::string_view solver;
  std::string_view page;      ///< docs/solvers/PAGE.md
  std::string_view formula;   ///< one line, in the notation of mathematics.h
  std::string_view sentence;  ///< what it does, and where it is good or bad
};

/// Every solver of the catalogue has one; nullptr for those that joined it from elsewhere.
const SolverLesson* solverLesson(std::string_view solver);

}  // namespace gelenk
