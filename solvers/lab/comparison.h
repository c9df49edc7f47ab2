#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "solvers/lab/problem_sets.h"
#include "solvers/lab/results.h"
#include "solvers/problem/ik_report.h"

namespace gelenk {

/// A set, and the random restarts that it is asked with: the plan's for "D1", 50 for "D1[restarts=50]".
struct SetChoice {
  const ProblemSetEntry* entry = nullptr;
  std::optional<int> restarts = {};
};
/// Throws std::invalid_argument for anything else, and lists the sets there are.
SetChoice setChoice(std::string_view text);

/// What is compared with what, and under which rules: everything that an answer depends on.
struct ComparisonPlan {
  std::vector<std::string> sets;     ///< texts of setChoice()
  std::vector<std::string> solvers;  ///< texts of solverSpec()
  int problems = 1000;               ///< of each set
  std::uint64_t seed = 1;
  double tolerance = 1e-6;  ///< metres and radians
  Budget budget{.maxIterations = 200, .maxSeconds = 1e9};
  int traces = 100;  ///< problems of each set whose residual curves are kept
  int seeds = 0;     ///< solver seeds budget.seed, +1, ... for solvers that draw random numbers; 0: 20 for
                     ///< stochastic methods, else 1
  int repeat = 1;    ///< solves a problem; the shortest time counts, the answer is the same
  int shard = 1, shards = 1;  ///< this run does every sequence s with s % shards == shard - 1
};

/// How many seeds the plan asks for with this solver and as many restarts: one where the answer does not
/// depend on any.
int seedCount(const ComparisonPlan& plan, const std::string& solver, int restarts);

/// Throws std::invalid_argument: no or unknown set or solver (names listed), counts below 1, tolerances that
/// are not positive, a shard outside its range.
void validate(const ComparisonPlan& plan);

/// Every setting that the answers depend on, all values of parameters included.
Record recordOf(const ComparisonPlan& plan, const LabModel& model);

/// Runs the plan into `folder` (created where absent) and continues there after an interruption: results.csv,
/// solutions.csv, goals.csv, traces.csv, seeds.csv, preparation.csv, problem_sets.csv, solvers.csv and the
/// marker gelenk-comparison.txt with the record. A run that was killed at any time leaves complete lines up
/// to there. Throws std::invalid_argument, and changes nothing, where the folder holds anything else or the
/// results of another plan; the settings that differ are named. progress(done, total, what): after every
/// sequence.
Results runComparison(const ComparisonPlan& plan, const LabModel& model, const std::string& folder,
                      const std::function<void(int, int, const std::string&)>& progress);

/// Joins the folders of all shards of one plan into `folder`: the same files as an unsharded run, times
/// aside. Throws std::runtime_error where a folder is no results folder, plans differ, or shards are missing
/// or repeated.
Results mergeComparisons(const std::vector<std::string>& shards, const std::string& folder);

}  // namespace gelenk
