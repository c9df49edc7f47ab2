#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "solvers/problem/ik_report.h"

namespace gelenk {

// What a comparison leaves behind, in memory and as a folder of tables (comma-separated values). A solver is
// named by its choice's text, such as dls[lambda=0.1]; a set by its name and, where it is asked with a number
// of restarts of its own, that number: D1[restarts=50].

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
  double displacement = 0.0;   ///< |difference(start, answer)|
  double shortest = 0.0;       ///< the same of the minimal-change path; NaN where there is none
  std::string solutions = {};  ///< how many the problem has, see Truth
  double nearest = 0.0;  ///< |difference(start, nearest solution)|; NaN where there is none or not known
  double jump = 0.0,
         jitter = 0.0;  ///< drags: largest coordinate of the first and second difference from frame to frame
  Counters counters;
  double sigmaMin = 0.0, limitMargin = 0.0;
  double seconds = 0.0, cpuSeconds = 0.0;  ///< everything but these two is the same in every run
};

/// Enough to judge a row again; written, and read back as text only.
struct SolutionRow {
  std::string set, solver;
  int problem = 0;
  std::string line;  ///< of the file, end of line included
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

/// The problems of a set: the same checksum means the same bits.
struct SetRow {
  std::string set;
  int problems = 0;
  std::uint64_t seed = 0;
  std::string checksum;
};

/// Every setting that the answers depend on, in order; names may repeat ("set", "solver", "parameter"). Two
/// runs with the same record have the same answers.
using Record = std::vector<std::pair<std::string, std::string>>;
std::vector<std::string> valuesOf(const Record& record, const std::string& name);

/// What a results folder holds.
struct Results {
  Record record = {};
  std::vector<SetRow> sets = {};
  std::vector<ResultRow> rows = {};
  std::vector<TracePoint> traces = {};
  std::vector<SeedRow> seeds =
      {};  ///< of the solvers that were run with several; the first is the one of `rows`
  std::vector<Preparation> preparations = {};
  std::vector<SolutionRow> solutions = {};
};

// ---- one table: the header, a row as a line, the complete lines of a file as rows

template <typename Row>
std::string csvHeader();
template <typename Row>
std::string csvLine(const Row& row);
/// The file's rows; a last line that was cut off is no row, an absent file has none. Throws ParseError.
template <typename Row>
std::vector<Row> readTable(const std::string& path);

/// "model,set,solver,...": of solutions for nq coordinates.
std::string solutionsHeader(int nq);
/// Likewise; lines that are not whole are left out.
std::vector<SolutionRow> readSolutions(const std::string& path);

/// Shortest text; empty where the number is not finite.
std::string csvNumber(double value);

// ---- the folder

inline constexpr const char* markerName = "gelenk-comparison.txt";

/// The marker's record; empty where the folder holds none of ours.
Record readRecord(const std::string& folder);
void writeRecord(const std::string& folder, const Record& record);

/// Sorts rows into the record's order of sets and solvers and writes every table of answers.
void writeTables(const std::string& folder, Results& results, const std::string& solutionsHeader);

/// Reads a folder's tables. Throws ParseError or std::runtime_error.
Results readResults(const std::string& folder);

}  // namespace gelenk
