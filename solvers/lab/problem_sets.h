#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "solvers/problem/ik_problem.h"

namespace gelenk {

/// What the laboratory asks solvers to do with a model.
struct LabModel {
  std::string name;
  std::shared_ptr<const Skeleton> skeleton;
  std::vector<int> effectors = {};  ///< joints that get a goal
  bool pose = false;                ///< Pose goals; Position otherwise
  /// Asked for besides, of any kind: in every problem captured from its reference pose (GoalType::capture).
  std::vector<Goal> goals = {};
};

/// Goals on the named joints; with no names on every joint without children. Poses where one effector has at
/// least six degrees of freedom above it, positions otherwise. Throws std::invalid_argument that lists the
/// joints for an unknown name.
LabModel labModel(std::string name, const Skeleton& skeleton, const std::vector<std::string>& effectors = {});

enum class ProblemFamily {
  Reachable,
  NearSingular,
  ReachBoundary,
  Unreachable,
  Drag,
  TightLimits,
  Conflict,
  Solutions
};

struct ProblemSetEntry {
  std::string_view name;  ///< "D1" ... "D8"
  std::string_view title;
  std::string_view levels;  ///< what `level` of a problem means and which values it takes in turn
  ProblemFamily family;
  bool meetable;  ///< every goal can be met (but for D8's level 0); otherwise problems are scored by the
                  ///< residual above the best one known
};

std::span<const ProblemSetEntry> problemSetCatalogue();
/// Throws std::invalid_argument that lists the names there are.
const ProblemSetEntry& problemSet(std::string_view name);

/// One problem and what is known about it. A drag is a sequence of problems in which a solver starts where it
/// ended.
struct LabProblem {
  int index = 0;     ///< within the set
  int sequence = 0;  ///< equal to the index but on drags
  int frame = 0;     ///< within the sequence
  double level = 0.0;
  std::shared_ptr<const Skeleton> skeleton;
  IkProblem problem = {};  ///< start: of frame 0 of a drag, later frames start where the solver ended
  Eigen::VectorXd reference =
      {};  ///< meets the goals where the set is meetable; found by annotate() elsewhere
  // filled by annotate():
  double sigmaMin = 0.0;  ///< smallest structural singular value of J at the reference
  double limitMargin =
      0.0;  ///< at the reference: distance to the nearest limit, 1 in the middle of a range, 0 at its end
  double bestResidual =
      0.0;  ///< 0 where meetable, else the smallest of 12 starts of the exact-Hessian and gain-ratio solvers
  double shortest = 0.0;  ///< |difference(start, end)| of the minimal-change path; NaN where it does not
                          ///< arrive, and on drags
};

constexpr int dragLength = 50;  ///< frames of a sequence

/// The problems 0 ... count-1 of a set. Problem i (on drags: sequence i) depends on the seed, the set and i
/// alone, not on count. Throws std::invalid_argument for a count below 1 or a model that the set cannot use,
/// with the reason.
std::vector<LabProblem> makeProblems(const ProblemSetEntry& set, const LabModel& model, int count,
                                     std::uint64_t seed, double tolerance);

/// FNV-1a over the bits of all starts and goals: the same number means the same problems.
std::uint64_t checksum(const std::vector<LabProblem>& problems);

/// Computes what costs time; deterministic.
void annotate(const ProblemSetEntry& set, LabProblem& problem);

}  // namespace gelenk
