#include <stdexcept>

#include "apps/session.h"

namespace gelenk {
namespace {

/// A catalogue solver, started from the present pose with a small budget, so that a frame stays a frame. Time is no part of
/// the budget: the same frames give the same poses on every machine.
class WarmSolver final : public FrameSolver {
 public:
  WarmSolver(const std::string& name, const Skeleton& skeleton) : solver_(makeSolver(name)) { solver_->prepare(skeleton); }

  IkReport frame(const IkProblem& problem) override {
    return solver_->solve(problem, {.maxIterations = 20, .maxSeconds = 3600.0}, TraceLevel::Residuals);
  }

 private:
  std::unique_ptr<IkSolver> solver_;
};

}  // namespace

std::vector<std::string> frameSolverNames() {
  std::vector<std::string> names{"hybrid"};
  for (const SolverEntry& entry : solverCatalogue())
    if (entry.name != "hybrid") names.emplace_back(entry.name);
  return names;
}

std::unique_ptr<FrameSolver> makeFrameSolver(const std::string& name, const Skeleton& skeleton) {
  return std::make_unique<WarmSolver>(name == "hybrid" ? "dls" : name, skeleton);
}

}  // namespace gelenk
