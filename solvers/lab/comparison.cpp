#include "solvers/lab/comparison.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#if defined(__GLIBC__)
#include <malloc.h>
#endif
#include <filesystem>
#include <map>
#include <set>
#include <stdexcept>
#include <tuple>

#include "kinematics/configuration.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "solvers/iteration/evaluator.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/problem/judge.h"

namespace gelenk {

using Eigen::VectorXd;
namespace fs = std::filesystem;

namespace {

const std::string markerName = "gelenk-comparison.txt";
const std::string markerTitle = "Gelenk comparison, format 1";
const std::string resultsHeader =
    "set,solver,problem,sequence,frame,level,status,solved,position_error,orientation_error,residual,excess,"
    "limit_violation,"
    "displacement,shortest_displacement,jump,jitter,iterations,forward_kinematics,jacobians,hessians,"
    "factorisations,restarts,"
    "sigma_min,limit_margin,seconds,cpu_seconds";
const std::string tracesHeader = "set,solver,problem,iteration,residual,seconds";
const std::string seedsHeader =
    "set,solver,problem,seed,solved,position_error,orientation_error,displacement,iterations,seconds";
const std::string preparationHeader = "set,solver,seconds,bytes";
const std::string goalsHeader =
    "set,problem,goal,kind,joint,weight,point_x,point_y,point_z,target_x,target_y,target_z,target_qw,target_"
    "qx,target_qy,target_qz";
const std::string setsHeader = "set,problems,seed,checksum";

std::string number(double value) { return std::isfinite(value) ? exactNumber(value) : std::string(); }

double cpuSeconds() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Bytes that the program holds on its heap; NaN where the C library does not tell.
double heapBytes() {
#if defined(__GLIBC__) && __GLIBC_PREREQ(2, 33)
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
#else
  return std::numeric_limits<double>::quiet_NaN();
#endif
}

std::vector<std::string> splitFields(std::string_view line) {
  std::vector<std::string> fields;
  while (true) {
    const std::size_t comma = line.find(',');
    fields.emplace_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

/// The complete lines of a file after its header; a last line that was cut off is no line.
std::vector<std::string> completeLines(const std::string& path) {
  std::vector<std::string> lines;
  if (!fs::exists(path)) return lines;
  const std::string text = readFile(path);
  std::size_t at = 0;
  while (true) {
    const std::size_t end = text.find('\n', at);
    if (end == std::string::npos) return lines;
    if (at > 0) lines.push_back(text.substr(at, end - at));
    at = end + 1;
  }
}

// ---- one row as text and back

std::string toLine(const ResultRow& row) {
  std::string line = row.set + ',' + row.solver;
  const auto add = [&](const std::string& field) { line += ',' + field; };
  for (int value : {row.problem, row.sequence, row.frame}) add(std::to_string(value));
  add(number(row.level));
  add(row.status);
  add(row.solved ? "1" : "0");
  for (double value : {row.position, row.orientation, row.residual, row.excess, row.limitViolation,
                       row.displacement, row.shortest, row.jump, row.jitter})
    add(number(value));
  const Counters& c = row.counters;
  for (int value : {c.iterations, c.forwardKinematics, c.jacobians, c.hessians, c.factorisations, c.restarts})
    add(std::to_string(value));
  for (double value : {row.sigmaMin, row.limitMargin, row.seconds, row.cpuSeconds}) add(number(value));
  return line;
}

/// Takes the fields of a line one after the other.
class FieldReader {
 public:
  FieldReader(const std::string& file, int line, std::string_view text, std::size_t expected)
      : file_(file), line_(line), fields_(splitFields(text)) {
    if (fields_.size() != expected)
      throw ParseError(file, line, std::to_string(expected) + " fields", std::to_string(fields_.size()));
  }
  std::string text() { return fields_[at_++]; }
  int integer() {
    const auto value = parseInteger(fields_[at_]);
    if (!value)
      throw ParseError(file_, line_, "an integer in field " + std::to_string(at_ + 1),
                       "'" + fields_[at_] + "'");
    ++at_;
    return *value;
  }
  double number() {  // an empty field stands for a value that does not exist
    if (fields_[at_].empty()) return ++at_, std::numeric_limits<double>::quiet_NaN();
    const auto value = parseNumber(fields_[at_]);
    if (!value)
      throw ParseError(file_, line_, "a number in field " + std::to_string(at_ + 1),
                       "'" + fields_[at_] + "'");
    ++at_;
    return *value;
  }

 private:
  std::string file_;
  int line_;
  std::vector<std::string> fields_;
  std::size_t at_ = 0;
};

ResultRow toRow(FieldReader& in) {
  ResultRow row;
  row.set = in.text();
  row.solver = in.text();
  for (int* value : {&row.problem, &row.sequence, &row.frame}) *value = in.integer();
  row.level = in.number();
  row.status = in.text();
  row.solved = in.integer() != 0;
  for (double* value : {&row.position, &row.orientation, &row.residual, &row.excess, &row.limitViolation,
                        &row.displacement, &row.shortest, &row.jump, &row.jitter})
    *value = in.number();
  Counters& c = row.counters;
  for (int* value :
       {&c.iterations, &c.forwardKinematics, &c.jacobians, &c.hessians, &c.factorisations, &c.restarts})
    *value = in.integer();
  for (double* value : {&row.sigmaMin, &row.limitMargin, &row.seconds, &row.cpuSeconds}) *value = in.number();
  return row;
}

std::string solutionsHeader(int nq) {
  std::string header = "model,set,solver,problem,status";
  for (int k = 1; k <= nq; ++k) header += ",start_" + std::to_string(k);
  header += ",target_x,target_y,target_z,target_qw,target_qx,target_qy,target_qz";
  for (int k = 1; k <= nq; ++k) header += ",solution_" + std::to_string(k);
  return header;
}

/// The first goal's target; its orientation is empty where it asks for none. goals.csv holds all goals.
std::string targetFields(const Goal& goal) {
  std::string fields;
  for (double x : goal.target) fields += ',' + number(x);
  const Eigen::Quaterniond& o = goal.orientation;
  for (double x : {o.w(), o.x(), o.y(), o.z()})
    fields += ',' + (goal.kind == GoalKind::Pose ? number(x) : std::string());
  return fields;
}

std::string solutionLine(const LabModel& model, const ResultRow& row, const IkProblem& problem,
                         const VectorXd& q) {
  std::string line =
      model.name + ',' + row.set + ',' + row.solver + ',' + std::to_string(row.problem) + ',' + row.status;
  const auto addPadded =
      [&](const VectorXd& values) {  // a set that holds the root fixed has fewer coordinates
        for (int k = 0; k < model.skeleton->nq(); ++k)
          line += ',' + (k < values.size() ? number(values[k]) : std::string());
      };
  addPadded(problem.start);
  line += targetFields(problem.goals.front());
  addPadded(q);
  return line;
}

// ---- solving one sequence

struct UnitText {
  std::string results, solutions, traces, seeds;
};

struct Answer {
  IkReport report;
  double seconds = 0.0, cpuSeconds = 0.0;
};

Answer timedSolve(const IkSolver& solver, const IkProblem& problem, const ComparisonPlan& plan,
                  const Budget& budget) {
  Answer answer;
  answer.seconds = answer.cpuSeconds = std::numeric_limits<double>::infinity();
  for (int i = 0; i < plan.repeat; ++i) {
    const double cpu = cpuSeconds();
    const auto begin = std::chrono::steady_clock::now();
    answer.report = solver.solve(problem, budget, TraceLevel::Off);
    const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    answer.seconds = std::min(answer.seconds, wall);
    answer.cpuSeconds = std::min(answer.cpuSeconds, cpuSeconds() - cpu);
  }
  return answer;
}

ResultRow judged(const ProblemSetEntry& set, const LabProblem& one, const IkProblem& problem,
                 const std::string& solver, const Answer& answer, double tolerance) {
  const VectorXd& q = answer.report.q;
  const Judgement verdict = judge(problem, q);
  ResultRow row{.set = std::string(set.name),
                .solver = solver,
                .problem = one.index,
                .sequence = one.sequence,
                .frame = one.frame,
                .level = one.level,
                .status = toString(answer.report.why),
                .counters = answer.report.counters};
  for (const GoalError& error : verdict.goals) {
    row.position = std::max(row.position, error.position);
    row.orientation = std::max(row.orientation, error.orientation);
  }
  row.limitViolation = verdict.limitViolation;
  if (verdict.finite) {
    CountedEvaluator at(problem);
    at.moveTo(q);
    row.residual = at.residual().norm();
    row.displacement = difference(*one.skeleton, problem.start, q).norm();
  } else {
    row.position = row.orientation = row.residual = row.displacement =
        std::numeric_limits<double>::quiet_NaN();
  }
  row.excess = row.residual - one.bestResidual;
  row.solved = set.meetable ? verdict.solved
                            : verdict.finite && verdict.limitViolation <= 1e-9 && row.excess <= tolerance;
  row.shortest = one.shortest;
  row.sigmaMin = one.sigmaMin;
  row.limitMargin = one.limitMargin;
  row.seconds = answer.seconds;
  row.cpuSeconds = answer.cpuSeconds;
  return row;
}

std::string traceLines(const ResultRow& row, const IkSolver& solver, const IkProblem& problem,
                       const Budget& budget) {
  std::string text;
  const IkReport report = solver.solve(problem, budget, TraceLevel::Residuals);
  for (std::size_t i = 0; i < report.trace.size(); ++i)
    text += row.set + ',' + row.solver + ',' + std::to_string(row.problem) + ',' + std::to_string(i) + ',' +
            number(report.trace[i].residual) + ',' + number(report.trace[i].seconds) + '\n';
  return text;
}

std::string seedLine(const ResultRow& row, std::uint64_t seed) {
  std::string line = row.set + ',' + row.solver + ',' + std::to_string(row.problem) + ',' +
                     std::to_string(seed) + (row.solved ? ",1" : ",0");
  for (double value : {row.position, row.orientation, row.displacement}) line += ',' + number(value);
  return line + ',' + std::to_string(row.counters.iterations) + ',' + number(row.seconds) + '\n';
}

/// The sequence again with the plan's further seeds.
std::string otherSeeds(const ProblemSetEntry& set, const std::vector<const LabProblem*>& frames,
                       const std::string& name, const IkSolver& solver, const ComparisonPlan& plan) {
  std::string text;
  Budget budget = plan.budget;
  for (int k = 1; k < seedCount(plan, name); ++k) {
    ++budget.seed;
    VectorXd before;
    for (const LabProblem* one : frames) {
      IkProblem problem = one->problem;
      if (one->frame > 0) problem.start = before;
      const Answer answer = timedSolve(solver, problem, plan, budget);
      text += seedLine(judged(set, *one, problem, name, answer, plan.tolerance), budget.seed);
      before = answer.report.q;
    }
  }
  return text;
}

/// All frames of a sequence, each from where the last one ended.
UnitText solveSequence(const ProblemSetEntry& set, const std::vector<const LabProblem*>& frames,
                       const std::string& name, const IkSolver& solver, const ComparisonPlan& plan,
                       const LabModel& model) {
  UnitText text;
  VectorXd before, beforeThat;
  for (const LabProblem* one : frames) {
    IkProblem problem = one->problem;
    if (one->frame > 0) problem.start = before;
    const Answer answer = timedSolve(solver, problem, plan, plan.budget);
    ResultRow row = judged(set, *one, problem, name, answer, plan.tolerance);
    const VectorXd q = answer.report.q;
    if (set.family == ProblemFamily::Drag && row.residual >= 0.0) {
      const VectorXd step = difference(*one->skeleton, problem.start, q);
      row.jump = step.lpNorm<Eigen::Infinity>();
      if (one->frame > 0)
        row.jitter = (step - difference(*one->skeleton, beforeThat, before)).lpNorm<Eigen::Infinity>();
    }
    text.results += toLine(row) + '\n';
    text.solutions += solutionLine(model, row, problem, q) + '\n';
    if (seedCount(plan, name) > 1) text.seeds += seedLine(row, plan.budget.seed);
    if (one->index < plan.traces) text.traces += traceLines(row, solver, problem, plan.budget);
    beforeThat = problem.start;
    before = q;
  }
  text.seeds += otherSeeds(set, frames, name, solver, plan);
  return text;
}

// ---- the folder

using Key = std::tuple<std::string, std::string, int>;  // set, solver, problem

/// Lines of a file, each with its key; solutions.csv has the model in front.
std::vector<std::pair<Key, std::string>> keyedLines(const std::string& path, std::size_t firstField) {
  std::vector<std::pair<Key, std::string>> lines;
  for (std::string& line : completeLines(path)) {
    const std::vector<std::string> fields = splitFields(line);
    if (fields.size() < firstField + 3) continue;
    const auto problem = parseInteger(fields[firstField + 2]);
    if (problem) lines.push_back({{fields[firstField], fields[firstField + 1], *problem}, std::move(line)});
  }
  return lines;
}

/// Writes the lines in the order of the plan, one a key (several for traces, which stay in order).
void rewrite(const std::string& path, const std::string& header,
             std::vector<std::pair<Key, std::string>> lines, const ComparisonPlan& plan) {
  const auto rank = [](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) - names.begin();
  };
  std::stable_sort(lines.begin(), lines.end(), [&](const auto& a, const auto& b) {
    const auto place = [&](const Key& key) {
      return std::tuple(rank(plan.sets, std::get<0>(key)), rank(plan.solvers, std::get<1>(key)),
                        std::get<2>(key));
    };
    return place(a.first) < place(b.first);
  });
  std::string text = header + '\n';
  for (const auto& [key, line] : lines) text += line + '\n';
  writeFile(path, text);
}

void claimFolder(const std::string& folder, const std::string& print) {
  if (fs::exists(folder) && !fs::is_directory(folder))
    throw std::runtime_error(folder + " is a file, not a folder for results");
  if (fs::exists(folder + '/' + markerName)) {
    const std::string found = readMarker(folder);
    if (found.empty())
      throw std::runtime_error(folder + '/' + markerName +
                               " is not the mark of a Gelenk comparison; nothing was changed");
    if (found != print)
      throw std::runtime_error(
          folder + " holds the results of another comparison; nothing was changed\n  there: " + found +
          "\n  asked: " + print);
    return;
  }
  if (fs::exists(folder) && !fs::is_empty(folder))
    throw std::runtime_error(folder + " is not empty and holds no Gelenk comparison (" + markerName +
                             " is missing); nothing was changed");
  fs::create_directories(folder);
  writeFile(folder + '/' + markerName, markerTitle + '\n' + print + '\n');
}

/// Appends whole units; what reaches the file is a prefix of them.
class Appender {
 public:
  Appender(const std::string& path, const std::string& header) : path_(path) {
    if (!fs::exists(path)) writeFile(path, header + '\n');
    file_ = std::fopen(path.c_str(), "ab");
    if (!file_) throw std::runtime_error("cannot append to " + path);
  }
  ~Appender() { std::fclose(file_); }
  Appender(const Appender&) = delete;
  void append(const std::string& text) {
    if (std::fwrite(text.data(), 1, text.size(), file_) != text.size() || std::fflush(file_) != 0)
      throw std::runtime_error("cannot write " + path_ + " (is the disk full?)");
  }

 private:
  std::string path_;
  std::FILE* file_;
};

struct LoadedSet {
  const ProblemSetEntry* entry;
  std::vector<LabProblem> problems;
  std::map<int, std::vector<const LabProblem*>> sequences = {};  ///< of this shard
};

std::vector<LoadedSet> loadSets(const ComparisonPlan& plan, const LabModel& model) {
  std::vector<LoadedSet> sets;
  for (const std::string& name : plan.sets) {
    const ProblemSetEntry& entry = problemSet(name);
    sets.push_back({&entry, makeProblems(entry, model, plan.problems, plan.seed, plan.tolerance)});
    for (LabProblem& one : sets.back().problems) {
      if (one.sequence % plan.shards != plan.shard - 1) continue;
      sets.back().sequences[one.sequence].push_back(&one);
    }
  }
  return sets;
}

/// The sequences, those of one skeleton together, so that solvers prepare once for each (tight limits have
/// several).
std::vector<int> bySkeleton(const LoadedSet& set) {
  std::map<const Skeleton*, std::vector<int>> groups;
  std::vector<const Skeleton*> order;
  for (const auto& [sequence, frames] : set.sequences) {
    const Skeleton* skeleton = frames.front()->skeleton.get();
    if (!groups.count(skeleton)) order.push_back(skeleton);
    groups[skeleton].push_back(sequence);
  }
  std::vector<int> sequences;
  for (const Skeleton* skeleton : order)
    sequences.insert(sequences.end(), groups[skeleton].begin(), groups[skeleton].end());
  return sequences;
}

std::string hex(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

void writeProblems(const std::vector<LoadedSet>& sets, const ComparisonPlan& plan,
                   const std::string& folder) {
  static constexpr const char* kinds[] = {"position", "orientation", "pose", "aim", "pole", "posture"};
  std::string goals = goalsHeader + '\n', checks = setsHeader + '\n';
  for (const LoadedSet& set : sets) {
    const std::string name(set.entry->name);
    checks += name + ',' + std::to_string(set.problems.size()) + ',' + std::to_string(plan.seed) + ',' +
              hex(checksum(set.problems)) + '\n';
    for (const LabProblem& one : set.problems)
      for (std::size_t g = 0; g < one.problem.goals.size(); ++g) {
        const Goal& goal = one.problem.goals[g];
        goals += name + ',' + std::to_string(one.index) + ',' + std::to_string(g + 1) + ',' +
                 kinds[static_cast<int>(goal.kind)] + ',' + one.skeleton->joint(goal.joint).name + ',' +
                 number(goal.weight);
        for (double x : goal.pointInJoint) goals += ',' + number(x);
        goals += targetFields(goal) + '\n';
      }
  }
  writeFile(folder + "/goals.csv", goals);
  writeFile(folder + "/problem_sets.csv", checks);
}

/// Drops what is cut off, unfinished or not in all files; returns the (set, solver, sequence) that are done.
std::set<Key> recover(const std::vector<LoadedSet>& sets, const ComparisonPlan& plan, const LabModel& model,
                      const std::string& folder) {
  const auto solutions = keyedLines(folder + "/solutions.csv", 1);
  std::set<Key> haveSolution;
  for (const auto& [key, line] : solutions) haveSolution.insert(key);
  std::map<Key, int> framesDone;
  std::map<Key, Key> unitOf;
  const auto results = keyedLines(folder + "/results.csv", 0);
  std::set<Key> haveResult;
  for (const auto& [key, line] : results) {
    const std::vector<std::string> fields = splitFields(line);
    if (fields.size() != 27 || !haveSolution.count(key) || !haveResult.insert(key).second) continue;
    const Key unit{std::get<0>(key), std::get<1>(key), parseInteger(fields[3]).value_or(-1)};
    unitOf[key] = unit;
    ++framesDone[unit];
  }
  std::set<Key> done;
  for (const LoadedSet& set : sets)
    for (const auto& [sequence, frames] : set.sequences)
      for (const std::string& solver : plan.solvers) {
        const Key unit{std::string(set.entry->name), solver, sequence};
        if (framesDone.count(unit) && framesDone[unit] == static_cast<int>(frames.size())) done.insert(unit);
      }
  const auto keep = [&](const std::vector<std::pair<Key, std::string>>& lines, bool once) {
    std::vector<std::pair<Key, std::string>> kept;
    std::set<Key> seen;
    for (const auto& [key, line] : lines)
      if (unitOf.count(key) && done.count(unitOf[key]) && (!once || seen.insert(key).second))
        kept.push_back({key, line});
    return kept;
  };
  rewrite(folder + "/traces.csv", tracesHeader, keep(keyedLines(folder + "/traces.csv", 0), false), plan);
  rewrite(folder + "/seeds.csv", seedsHeader, keep(keyedLines(folder + "/seeds.csv", 0), false), plan);
  rewrite(folder + "/solutions.csv", solutionsHeader(model.skeleton->nq()), keep(solutions, true), plan);
  rewrite(folder + "/results.csv", resultsHeader, keep(results, true), plan);
  return done;
}

void sortFiles(const ComparisonPlan& plan, const std::string& header, const std::string& folder) {
  rewrite(folder + "/traces.csv", tracesHeader, keyedLines(folder + "/traces.csv", 0), plan);
  rewrite(folder + "/seeds.csv", seedsHeader, keyedLines(folder + "/seeds.csv", 0), plan);
  rewrite(folder + "/solutions.csv", header, keyedLines(folder + "/solutions.csv", 1), plan);
  rewrite(folder + "/results.csv", resultsHeader, keyedLines(folder + "/results.csv", 0), plan);
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " ") + name;
  return text;
}

}  // namespace

void validate(const ComparisonPlan& plan) {
  if (plan.sets.empty()) throw std::invalid_argument("no problem set was chosen");
  if (plan.solvers.empty()) throw std::invalid_argument("no solver was chosen");
  for (const std::string& set : plan.sets) problemSet(set);
  for (const std::string& solver : plan.solvers) makeSolver(solver);
  const auto repeated = [](std::vector<std::string> names) {
    std::sort(names.begin(), names.end());
    const auto at = std::adjacent_find(names.begin(), names.end());
    if (at != names.end()) throw std::invalid_argument("'" + *at + "' was chosen twice");
  };
  repeated(plan.sets);
  repeated(plan.solvers);
  if (plan.problems < 1)
    throw std::invalid_argument("the number of problems must be at least 1, not " +
                                std::to_string(plan.problems));
  if (!(plan.tolerance > 0.0) || !std::isfinite(plan.tolerance))
    throw std::invalid_argument("the tolerance must be a positive number, not " +
                                std::to_string(plan.tolerance));
  if (plan.budget.maxIterations < 1)
    throw std::invalid_argument("the number of iterations must be at least 1");
  if (plan.budget.restarts < 0) throw std::invalid_argument("the number of restarts must not be negative");
  if (!(plan.budget.maxSeconds > 0.0)) throw std::invalid_argument("the time budget must be positive");
  if (plan.seeds < 0) throw std::invalid_argument("the number of seeds must not be negative");
  if (plan.traces < 0) throw std::invalid_argument("the number of traces must not be negative");
  if (plan.repeat < 1) throw std::invalid_argument("the number of repetitions must be at least 1");
  if (plan.shards < 1 || plan.shard < 1 || plan.shard > plan.shards)
    throw std::invalid_argument("a shard K/N needs 1 <= K <= N, not " + std::to_string(plan.shard) + '/' +
                                std::to_string(plan.shards));
}

int seedCount(const ComparisonPlan& plan, const std::string& solver) {
  constexpr int enough = 20;
  const bool stochastic = solverEntry(solver).stochastic;
  if (plan.seeds == 0) return stochastic ? enough : 1;
  return stochastic || plan.budget.restarts > 0 ? plan.seeds : 1;
}

std::string fingerprint(const ComparisonPlan& plan, const LabModel& model) {
  std::string effectors;
  for (int joint : model.effectors)
    effectors += (effectors.empty() ? "" : " ") + model.skeleton->joint(joint).name;
  return "model=" + model.name + "; nq=" + std::to_string(model.skeleton->nq()) + "; effectors=" + effectors +
         "; goals=" + (model.pose ? "pose" : "position") + "; sets=" + joined(plan.sets) +
         "; solvers=" + joined(plan.solvers) + "; problems=" + std::to_string(plan.problems) +
         "; seed=" + std::to_string(plan.seed) + "; tolerance=" + exactNumber(plan.tolerance) +
         "; iterations=" + std::to_string(plan.budget.maxIterations) +
         "; restarts=" + std::to_string(plan.budget.restarts) +
         "; solver-seed=" + std::to_string(plan.budget.seed) +
         "; budget-seconds=" + exactNumber(plan.budget.maxSeconds) +
         "; traces=" + std::to_string(plan.traces) +
         "; seeds=" + (plan.seeds > 0 ? std::to_string(plan.seeds) : "automatic") +
         "; repeat=" + std::to_string(plan.repeat) + "; shard=" + std::to_string(plan.shard) + '/' +
         std::to_string(plan.shards);
}

std::string readMarker(const std::string& folder) {
  const std::string path = folder + '/' + markerName;
  if (!fs::exists(path)) return {};
  const std::string text = readFile(path);
  const auto lines = splitLines(text);
  return lines.size() == 2 && lines[0] == markerTitle ? std::string(lines[1]) : std::string();
}

void runComparison(const ComparisonPlan& plan, const LabModel& model, const std::string& folder,
                   const std::function<void(int, int, const std::string&)>& progress) {
  validate(plan);
  std::vector<LoadedSet> sets = loadSets(plan, model);
  claimFolder(folder, fingerprint(plan, model));
  writeProblems(sets, plan, folder);
  const std::set<Key> done = recover(sets, plan, model, folder);

  int total = 0, finished = static_cast<int>(done.size());
  for (const LoadedSet& set : sets) total += static_cast<int>(set.sequences.size() * plan.solvers.size());
  const std::string header = solutionsHeader(model.skeleton->nq());
  {
    Appender traces(folder + "/traces.csv", tracesHeader), seeds(folder + "/seeds.csv", seedsHeader),
        solutions(folder + "/solutions.csv", header), results(folder + "/results.csv", resultsHeader);
    std::string preparations = preparationHeader + '\n';
    for (LoadedSet& set : sets) {
      const std::string setName(set.entry->name);
      bool annotated = false;
      for (const std::string& name : plan.solvers) {
        const double heap = heapBytes();
        const auto begin = std::chrono::steady_clock::now();
        const auto solver = makeSolver(name);
        solver->prepare(*set.problems.front().skeleton);
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        preparations +=
            setName + ',' + name + ',' + number(seconds) + ',' + number(heapBytes() - heap) + '\n';
        const Skeleton* prepared = set.problems.front().skeleton.get();
        for (const int sequence : bySkeleton(set)) {
          const auto& frames = set.sequences.at(sequence);
          if (done.count({setName, name, sequence})) continue;
          if (!annotated) {
            for (LabProblem& one : set.problems) {
              if (one.sequence % plan.shards != plan.shard - 1) continue;
              if (one.index % 50 == 0)
                progress(finished, total, setName + ": references, problem " + std::to_string(one.index));
              annotate(*set.entry, one);
            }
            annotated = true;
          }
          if (frames.front()->skeleton.get() != prepared) {
            prepared = frames.front()->skeleton.get();
            solver->prepare(*prepared);
          }
          const UnitText text = solveSequence(*set.entry, frames, name, *solver, plan, model);
          traces.append(text.traces);
          seeds.append(text.seeds);
          solutions.append(text.solutions);
          results.append(text.results);
          progress(++finished, total, setName + ": " + name);
        }
      }
    }
    writeFile(folder + "/preparation.csv", preparations);
  }
  sortFiles(plan, header, folder);
}

void mergeComparisons(const std::vector<std::string>& shards, const std::string& folder) {
  if (shards.empty()) throw std::runtime_error("nothing to merge: name the folders of the shards");
  std::string common;
  std::set<int> seen;
  int count = 0;
  for (const std::string& shard : shards) {
    const std::string print = readMarker(shard);
    if (print.empty())
      throw std::runtime_error(shard + " holds no Gelenk comparison (" + markerName +
                               " is missing or foreign)");
    const std::size_t at = print.rfind("; shard=");
    const std::string settings = print.substr(0, at), which = print.substr(at + 8);
    if (common.empty()) common = settings;
    if (settings != common)
      throw std::runtime_error(shard + " was run with other settings than " + shards.front() + "\n  " +
                               settings + "\n  " + common);
    const int k = std::stoi(which), n = std::stoi(which.substr(which.find('/') + 1));
    if (count == 0) count = n;
    if (n != count || !seen.insert(k).second)
      throw std::runtime_error(shard + " is shard " + which + ", which does not fit or is there twice");
  }
  if (static_cast<int>(seen.size()) != count)
    throw std::runtime_error(std::to_string(count - static_cast<int>(seen.size())) + " of " +
                             std::to_string(count) + " shards are missing");

  ComparisonPlan plan;  // only the order of sets and solvers matters here
  const auto names = [&](const std::string& key) {
    const std::size_t begin = common.find("; " + key + "=") + key.size() + 3;
    std::vector<std::string> list;
    const std::string text = common.substr(begin, common.find(';', begin) - begin);
    for (std::string_view word : splitWords(text)) list.emplace_back(word);
    return list;
  };
  plan.sets = names("sets");
  plan.solvers = names("solvers");
  std::vector<std::pair<Key, std::string>> traces, seeds, solutions, results;
  std::string header;
  const auto collect = [](std::vector<std::pair<Key, std::string>>& all,
                          std::vector<std::pair<Key, std::string>> more) {
    std::move(more.begin(), more.end(), std::back_inserter(all));
  };
  for (const std::string& shard : shards) {
    collect(traces, keyedLines(shard + "/traces.csv", 0));
    collect(seeds, keyedLines(shard + "/seeds.csv", 0));
    collect(solutions, keyedLines(shard + "/solutions.csv", 1));
    collect(results, keyedLines(shard + "/results.csv", 0));
    const std::string text = readFile(shard + "/solutions.csv");
    header = text.substr(0, text.find('\n'));
  }
  const auto rowsWanted = [&] {
    const std::size_t begin = common.find("; problems=") + 11;
    return static_cast<std::size_t>(std::stoll(common.substr(begin))) * plan.sets.size() *
           plan.solvers.size();
  }();
  if (results.size() != rowsWanted)
    throw std::runtime_error("the shards hold " + std::to_string(results.size()) + " of " +
                             std::to_string(rowsWanted) +
                             " results: one of them is not finished (run it again to continue)");
  claimFolder(folder, common + "; shard=1/1");
  for (const char* name : {"/goals.csv", "/problem_sets.csv", "/preparation.csv"})
    writeFile(folder + name, readFile(shards.front() + name));
  rewrite(folder + "/traces.csv", tracesHeader, std::move(traces), plan);
  rewrite(folder + "/seeds.csv", seedsHeader, std::move(seeds), plan);
  rewrite(folder + "/solutions.csv", header, std::move(solutions), plan);
  rewrite(folder + "/results.csv", resultsHeader, std::move(results), plan);
}

namespace {

/// Calls read(fields) for every complete line of a file in the folder.
template <typename Read>
void forEachLine(const std::string& path, std::size_t fields, Read read) {
  int line = 1;
  for (const std::string& text : completeLines(path)) {
    FieldReader in(path, ++line, text, fields);
    read(in);
  }
}

}  // namespace

Results readResults(const std::string& folder) {
  Results results;
  forEachLine(folder + "/results.csv", 27, [&](FieldReader& in) { results.rows.push_back(toRow(in)); });
  forEachLine(folder + "/traces.csv", 6, [&](FieldReader& in) {
    TracePoint point{.set = in.text(), .solver = in.text()};
    point.problem = in.integer();
    point.iteration = in.integer();
    point.residual = in.number();
    point.seconds = in.number();
    results.traces.push_back(point);
  });
  forEachLine(folder + "/seeds.csv", 10, [&](FieldReader& in) {
    SeedRow row{.set = in.text(), .solver = in.text()};
    row.problem = in.integer();
    row.seed = static_cast<std::uint64_t>(in.number());
    row.solved = in.integer() != 0;
    for (double* value : {&row.position, &row.orientation, &row.displacement}) *value = in.number();
    row.iterations = in.integer();
    row.seconds = in.number();
    results.seeds.push_back(row);
  });
  forEachLine(folder + "/preparation.csv", 4, [&](FieldReader& in) {
    Preparation one{.set = in.text(), .solver = in.text()};
    one.seconds = in.number();
    one.bytes = in.number();
    results.preparations.push_back(one);
  });
  return results;
}

}  // namespace gelenk
