#include "solvers/own_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "solvers/own_entries.h"

namespace gelenk {
namespace {

constexpr int most = mostOwnEntries;

/// What an entry of the catalogue points to; lives as long as the program.
struct Kept {
  OwnSolver solver;
  std::vector<Parameter> parameters;
};

struct Registry {
  std::mutex mutex;
  std::array<std::shared_ptr<const Kept>, most> slots;
  std::vector<std::shared_ptr<const Kept>> replaced;  ///< entries may still name them
  int count = 0, changes = 0;
};
Registry& registry() {
  static Registry& one = *new Registry;  // outlives everything that asks
  return one;
}

std::unique_ptr<IkSolver> makeOf(int slot, const ParameterValues& values) {
  std::shared_ptr<const Kept> kept;
  {
    const std::lock_guard lock(registry().mutex);
    kept = registry().slots[slot];
  }
  return kept->solver.make(values);
}

/// An entry's `build` is a plain function: every slot has one.
template <int slot>
std::unique_ptr<IkSolver> build(const ParameterValues& values) {
  return makeOf(slot, values);
}
template <int... slots>
constexpr auto builders(std::integer_sequence<int, slots...>) {
  return std::array{&build<slots>...};
}
constexpr auto buildOf = builders(std::make_integer_sequence<int, most>{});

void validate(const OwnSolver& solver) {
  const auto plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-'; };
  const auto isPlain = [&](const std::string& name) {
    return !name.empty() && std::all_of(name.begin(), name.end(), plain);
  };
  if (!isPlain(solver.name))
    throw std::invalid_argument("a solver's name has letters a to z, digits and '-': '" + solver.name + "'");
  if (!solver.make) throw std::invalid_argument("the solver '" + solver.name + "' has no method");
  for (auto p = solver.parameters.begin(); p != solver.parameters.end(); ++p) {
    const std::string where = "the solver '" + solver.name + "', parameter '" + p->name + "': ";
    if (!isPlain(p->name)) throw std::invalid_argument(where + "a name has letters a to z, digits and '-'");
    if (std::any_of(solver.parameters.begin(), p, [&](const auto& other) { return other.name == p->name; }))
      throw std::invalid_argument(where + "it is there twice");
    if (!(std::isfinite(p->lower) && std::isfinite(p->upper) && p->lower <= p->value && p->value <= p->upper))
      throw std::invalid_argument(where + "the default must lie within a finite range");
  }
}

}  // namespace

void addSolver(OwnSolver solver) {
  validate(solver);
  if (isBuiltIn(presentName(solver.name)) || solver.name == "default")
    throw std::invalid_argument("'" + solver.name + "' is a solver of the program; take another name");
  auto kept = std::make_shared<Kept>();
  kept->solver = std::move(solver);
  for (const auto& p : kept->solver.parameters)
    kept->parameters.push_back({p.name, p.value, p.lower, p.upper, p.unit, "own", p.meaning});
  const SolverEntry entry{kept->solver.name, kept->solver.title,     kept->solver.reference, kept->parameters,
                          nullptr,           kept->solver.stochastic};
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  int slot = 0;
  while (slot < all.count && all.slots[slot]->solver.name != kept->solver.name) ++slot;
  if (slot == most)
    throw std::invalid_argument("there are " + std::to_string(most) + " solvers of your own already");
  if (slot < all.count) all.replaced.push_back(all.slots[slot]);
  all.slots[slot] = std::move(kept);
  all.count = std::max(all.count, slot + 1);
  ++all.changes;
  SolverEntry built = entry;
  built.build = buildOf[slot];
  putEntry(slot, built);
}

int solverChanges() {
  const std::lock_guard lock(registry().mutex);
  return registry().changes;
}

}  // namespace gelenk
