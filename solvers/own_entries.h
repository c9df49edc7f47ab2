#pragma once

#include "solvers/problem/ik_solver.h"

namespace gelenk {

// Between own_solver.cpp and solver_catalogue.cpp.

/// Whether the name is one of the table in solver_catalogue.cpp, which every program has.
bool isBuiltIn(std::string_view name);
/// Puts an entry behind that table, at `slot` of the own ones; slots are filled in order.
void putEntry(int slot, const SolverEntry& entry);
inline constexpr int mostOwnEntries = 64;

}  // namespace gelenk
