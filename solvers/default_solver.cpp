#include "solvers/default_solver.h"

#include <array>

#include "solvers/methods/step_rules.h"
#include "solvers/serial/pose_goals.h"
#include "solvers/serial/serial_pose.h"
#include "solvers/tree/drag_solver.h"

namespace gelenk {
namespace {

class Fitting final : public IkSolver {
 public:
  void prepare(const Skeleton& skeleton) override {
    for (const auto& solver : solvers_) solver->prepare(skeleton);
  }
  std::string whyUnsupported(const IkProblem& problem) const override {
    return fitting(problem).whyUnsupported(problem);
  }
  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const override {
    return fitting(problem).solve(problem, budget, trace);
  }

 private:
  const IkSolver& fitting(const IkProblem& problem) const {
    for (const auto& solver : solvers_)
      if (solver->whyUnsupported(problem).empty()) return *solver;
    return *solvers_.back();
  }

  std::array<std::unique_ptr<IkSolver>, 3> solvers_{mergingPoseGoals(makeSerialPose()), makeDrag(),
                                                    makeLmGainRatio()};
};

}  // namespace

std::unique_ptr<IkSolver> makeFitting() { return std::make_unique<Fitting>(); }

}  // namespace gelenk
