#pragma once

#include <functional>
#include <string>
#include <vector>

#include "solvers/lab/problem_sets.h"
#include "solvers/problem/ik_report.h"

namespace gelenk {

/// What is compared with what, and under which rules: everything that an answer depends on.
struct ComparisonPlan {
  std::vector<std::string> sets;     ///< names of problemSetCatalogue()
  std::vector<std::string> solvers;  ///< names of solverCatalogue(), or "default"
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

/// One solver on one problem, judged outside the solver.
struct ResultRow {
  std::string set, solver;
  int problem = 0, sequence = 0, frame = 0;
  double level = 0.0;
  std::string status;  ///< toString(Stop)
  bool solved =
      false;  ///< by the judge, at the plan's tolerance; in unmeetable sets: excess within it, limits kept
  double position = 0.0, orientation = 0.0;  ///< largest error of all goals, metres and radians
  double residual = 0.0;                     ///< weighted norm
  double excess = 0.0;                       ///< residual above the best one known
  double limitViolation = 0.0;
  double displacement = 0.0;  ///< |difference(start, answer)|
  double shortest = 0.0;      ///< the same of the minimal-change path; NaN where there is none
  double jump = 0.0,
         jitter = 0.0;  ///< drags: largest coordinate of the first and second difference from frame to frame
  Counters counters;
  double sigmaMin = 0.0, limitMargin = 0.0;
  double seconds = 0.0, cpuSeconds = 0.0;  ///< everything but these two is the same in every run
};

struct TracePoint {
  std::string set, solver;
  int problem = 0, iteration = 0;
  double residual = 0.0, seconds = 0.0;
};

/// The same problem with another solver seed.
struct SeedRow {
  std::string set, solver;
  int problem = 0;
  std::uint64_t seed = 0;
  bool solved = false;
  double position = 0.0, orientation = 0.0, displacement = 0.0;
  int iterations = 0;
  double seconds = 0.0;
};

/// What a solver did once for a set's first skeleton, before it solved.
struct Preparation {
  std::string set, solver;
  double seconds = 0.0;
  double bytes = 0.0;  ///< heap that stays allocated; NaN where the C library does not tell
};

/// What a results folder holds.
struct Results {
  std::vector<ResultRow> rows;
  std::vector<TracePoint> traces;
  std::vector<SeedRow> seeds;  ///< of the solvers that were run with several; the first is the one of `rows`
  std::vector<Preparation> preparations;
};

/// How many seeds the plan asks for with this solver: one where the answer does not depend on any.
int seedCount(const ComparisonPlan& plan, const std::string& solver);

/// Throws std::invalid_argument: no or unknown set or solver (names listed), counts below 1, tolerances that
/// are not positive, a shard outside its range.
void validate(const ComparisonPlan& plan);

/// One line that says everything the answers depend on; two runs with the same line have the same answers.
std::string fingerprint(const ComparisonPlan& plan, const LabModel& model);

/// Runs the plan into `folder` (created where absent) and continues there after an interruption: results.csv,
/// solutions.csv, goals.csv, traces.csv, seeds.csv, preparation.csv, problem_sets.csv and the marker
/// gelenk-comparison.txt with the fingerprint. A run that was killed at any time leaves complete lines up to
/// there. Throws std::runtime_error, and changes nothing, where the folder holds anything else or the results
/// of another plan. progress(done, total, what): after every sequence.
void runComparison(const ComparisonPlan& plan, const LabModel& model, const std::string& folder,
                   const std::function<void(int, int, const std::string&)>& progress);

/// Joins the folders of all shards of one plan into `folder`: the same files as an unsharded run, times
/// aside. Throws std::runtime_error where a folder is no results folder, plans differ, or shards are missing
/// or repeated.
void mergeComparisons(const std::vector<std::string>& shards, const std::string& folder);

/// Reads a folder's tables. Throws ParseError or std::runtime_error.
Results readResults(const std::string& folder);

/// The marker's text after its first line; empty where the folder is none of ours.
std::string readMarker(const std::string& folder);

}  // namespace gelenk
