#include "solvers/methods/task_priority.h"

#include <algorithm>

#include "solvers/iteration/normal_equations.h"
#include "solvers/iteration/step_iteration.h"

namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct TaskPriority {
  using Parameters = TaskPriorityParameters;
  static constexpr bool monotone = false;
  static constexpr bool ownOrder = true;

  TaskPriority(const IkProblem& problem, const Parameters& parameters) : p(parameters) {
    int row = 0;
    for (const Goal& goal : problem.goals) {
      const int rows = residualRows(goal, *problem.skeleton);
      const int priority = goalType(goal.kind).judged ? goal.servedAs() : std::numeric_limits<int>::max();
      auto level =
          std::find_if(levels.begin(), levels.end(), [&](const Level& l) { return l.priority == priority; });
      if (level == levels.end()) level = levels.insert(levels.end(), Level{.priority = priority});
      for (int k = 0; k < rows; ++k) level->rows.push_back(row + k);
      row += rows;
    }
    std::sort(levels.begin(), levels.end(),
              [](const Level& a, const Level& b) { return a.priority < b.priority; });
    const int nv = problem.skeleton->nv();
    for (Level& level : levels) {
      level.J.resize(static_cast<Eigen::Index>(level.rows.size()), nv);
      level.r.resize(static_cast<Eigen::Index>(level.rows.size()));
    }
    N.resize(nv, nv);
  }
  double largestStep() const { return p.largestStep; }
  double damping() const { return 0.0; }

  void step(CountedEvaluator&, const LimitSet&, const MatrixXd& J, const VectorXd& r, const VectorXd&,
            VectorXd& dq) {
    dq.setZero();
    N.setIdentity();
    for (Level& level : levels) {
      for (std::size_t i = 0; i < level.rows.size(); ++i) {
        level.J.row(i) = J.row(level.rows[i]);
        level.r[i] = r[level.rows[i]];
      }
      const double lambda2 = p.damping * level.r.squaredNorm() + p.base;
      level.r.noalias() -= level.J * dq;
      restricted.noalias() = level.J * N;
      level.svd.factorise(restricted);
      const VectorXd& sigma = level.svd.sigma();
      for (Eigen::Index i = 0; i < sigma.size(); ++i) {
        if (!(sigma[i] > 1e-9)) continue;
        dq += level.svd.U().col(i).dot(level.r) * sigma[i] / (sigma[i] * sigma[i] + lambda2) *
              level.svd.V().col(i);
        if (sigma[i] > p.truncation * sigma[0])
          N.noalias() -= level.svd.V().col(i) * level.svd.V().col(i).transpose();
      }
    }
  }

  struct Level {
    int priority;
    std::vector<int> rows = {};
    MatrixXd J = {};
    VectorXd r = {};
    SingularSystem svd = {};
  };
  Parameters p;
  std::vector<Level> levels;
  MatrixXd N, restricted;
};

}  // namespace

std::unique_ptr<IkSolver> makeTaskPriority(const TaskPriorityParameters& parameters) {
  return std::make_unique<StepSolver<TaskPriority>>(parameters);
}

}  // namespace gelenk
