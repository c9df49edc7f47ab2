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
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <stdexcept>
#include <system_error>
#include <tuple>
#include <utility>

#include "kinematics/configuration.h"
#include "kinematics/io/csv.h"
#include "kinematics/io/text_file.h"
#include "solvers/iteration/evaluator.h"
#include "solvers/lab/truth.h"
#include "solvers/problem/goal_text.h"
#include "solvers/problem/goal_type.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/problem/judge.h"

namespace gelenk {

using Eigen::VectorXd;
namespace fs = std::filesystem;

namespace {

const std::string goalsHeader =
    "set,problem,goal,kind,joint,weight,point_x,point_y,point_z,target_x,target_y,target_z,target_qw,target_"
    "qx,target_qy,target_qz,text\n";
const std::string solversHeader = "solver,parameter,value,default,unit,source,meaning\n";

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " ") + name;
  return text;
}

double cpuSeconds() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Bytes that the program holds on its heap; NaN where the C library does not tell.
double heapBytes() {
#if defined(__GLIBC__) && (__GLIBC__ > 2 || __GLIBC_MINOR__ >= 33)
  const auto info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd);
#else
  return std::numeric_limits<double>::quiet_NaN();
#endif
}

/// The first goal's target; its orientation is empty where it asks for none. goals.csv holds all goals.
void addTarget(const Goal& goal, std::vector<std::string>& fields) {
  for (double x : goal.target) fields.push_back(csvNumber(x));
  const Eigen::Quaterniond& o = goal.orientation;
  for (double x : {o.w(), o.x(), o.y(), o.z()})
    fields.push_back(goal.kind == GoalKind::Pose ? csvNumber(x) : std::string());
}

SolutionRow solutionOf(const LabModel& model, const ResultRow& row, const IkProblem& problem,
                       const VectorXd& q) {
  std::vector<std::string> fields{model.name, row.set, row.solver, std::to_string(row.problem), row.status};
  const auto addPadded =
      [&](const VectorXd& values) {  // a set that holds the root fixed has fewer coordinates
        for (int k = 0; k < model.skeleton->nq(); ++k)
          fields.push_back(k < values.size() ? csvNumber(values[k]) : std::string());
      };
  addPadded(problem.start);
  addTarget(problem.goals.front(), fields);
  addPadded(q);
  return {row.set, row.solver, row.problem, csvLine(std::span<const std::string>(fields))};
}

// ---- solving one sequence

/// The answers of one solver on one sequence.
struct Unit {
  std::vector<ResultRow> rows;
  std::vector<SolutionRow> solutions;
  std::vector<TracePoint> traces;
  std::vector<SeedRow> seeds;
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

ResultRow judged(const std::string& setName, const ProblemSetEntry& set, const LabProblem& one,
                 const IkProblem& problem, const std::string& solver, const Answer& answer,
                 double tolerance) {
  const VectorXd& q = answer.report.q;
  const Judgement verdict = judge(problem, q);
  ResultRow row{.set = setName,
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

SeedRow seedRow(const ResultRow& row, std::uint64_t seed) {
  return {.set = row.set,
          .solver = row.solver,
          .problem = row.problem,
          .seed = seed,
          .solved = row.solved,
          .position = row.position,
          .orientation = row.orientation,
          .displacement = row.displacement,
          .iterations = row.counters.iterations,
          .seconds = row.seconds};
}

/// A set that is asked: its text, and the problems, which it may share with the same set asked otherwise.
struct Problems {
  std::vector<LabProblem> all;
  bool annotated = false;
};
struct LoadedSet {
  std::string name;
  const ProblemSetEntry* entry;
  Budget budget;
  std::shared_ptr<Problems> problems;
  std::map<int, std::vector<LabProblem*>> sequences = {};  ///< of this shard
};

/// The sequence again with the plan's further seeds.
void addOtherSeeds(const LoadedSet& set, const std::vector<LabProblem*>& frames, const std::string& name,
                   const IkSolver& solver, const ComparisonPlan& plan, Unit& unit) {
  Budget budget = set.budget;
  for (int k = 1; k < seedCount(plan, name, set.budget.restarts); ++k) {
    ++budget.seed;
    VectorXd before;
    for (const LabProblem* one : frames) {
      IkProblem problem = one->problem;
      if (one->frame > 0) problem.start = before;
      const Answer answer = timedSolve(solver, problem, plan, budget);
      unit.seeds.push_back(
          seedRow(judged(set.name, *set.entry, *one, problem, name, answer, plan.tolerance), budget.seed));
      before = answer.report.q;
    }
  }
}

/// All frames of a sequence, each from where the last one ended.
Unit solveSequence(const LoadedSet& set, const std::vector<LabProblem*>& frames, const std::string& name,
                   const IkSolver& solver, const ComparisonPlan& plan, const LabModel& model,
                   TruthFinder& truths) {
  Unit unit;
  VectorXd before, beforeThat;
  for (const LabProblem* one : frames) {
    IkProblem problem = one->problem;
    if (one->frame > 0) problem.start = before;
    const Answer answer = timedSolve(solver, problem, plan, set.budget);
    ResultRow row = judged(set.name, *set.entry, *one, problem, name, answer, plan.tolerance);
    const Truth truth = truths.of(problem);
    row.solutions = truth.solutions, row.nearest = truth.nearest;
    const VectorXd q = answer.report.q;
    if (set.entry->family == ProblemFamily::Drag && row.residual >= 0.0) {
      const VectorXd step = difference(*one->skeleton, problem.start, q);
      row.jump = step.lpNorm<Eigen::Infinity>();
      if (one->frame > 0)
        row.jitter = (step - difference(*one->skeleton, beforeThat, before)).lpNorm<Eigen::Infinity>();
    }
    unit.solutions.push_back(solutionOf(model, row, problem, q));
    if (seedCount(plan, name, set.budget.restarts) > 1) unit.seeds.push_back(seedRow(row, set.budget.seed));
    if (one->index < plan.traces) {
      const IkReport report = solver.solve(problem, set.budget, TraceLevel::Residuals);
      for (std::size_t i = 0; i < report.trace.size(); ++i)
        unit.traces.push_back({row.set, row.solver, row.problem, static_cast<int>(i),
                               report.trace[i].residual, report.trace[i].seconds});
    }
    unit.rows.push_back(std::move(row));
    beforeThat = problem.start;
    before = q;
  }
  addOtherSeeds(set, frames, name, solver, plan, unit);
  return unit;
}

// ---- the folder

/// "solver: is 'dls', asked 'ccd'" for every setting that differs.
std::string differences(const Record& there, const Record& asked) {
  std::string text;
  std::set<std::string> seen;
  for (const Record* record : {&there, &asked})
    for (const auto& [name, value] : *record) {
      if (!seen.insert(name).second) continue;
      const auto a = valuesOf(there, name), b = valuesOf(asked, name);
      if (a != b) text += "\n  " + name + ": there '" + joined(a) + "', asked '" + joined(b) + "'";
    }
  return text;
}

/// True where the folder holds results of this very plan.
bool claimFolder(const std::string& folder, const Record& record) {
  if (fs::exists(folder) && !fs::is_directory(folder))
    throw std::invalid_argument(folder + " is a file, not a folder for results");
  if (fs::exists(folder + '/' + markerName)) {
    const Record found = readRecord(folder);
    if (found.empty())
      throw std::invalid_argument(
          folder + '/' + markerName +
          " is not the mark of a Gelenk comparison of this version; nothing was changed");
    if (found != record)
      throw std::invalid_argument(folder + " holds the results of another comparison; nothing was changed" +
                                  differences(found, record));
    return true;
  }
  if (fs::exists(folder) && !fs::is_empty(folder))
    throw std::invalid_argument(folder + " is not empty and holds no Gelenk comparison (" + markerName +
                                " is missing); nothing was changed");
  fs::create_directories(folder);
  writeRecord(folder, record);
  return false;
}

/// Appends whole units; what reaches the file is a prefix of them.
class Appender {
 public:
  explicit Appender(const std::string& path) : path_(path), file_(std::fopen(path.c_str(), "ab")) {
    if (!file_) throw std::system_error(errno, std::generic_category(), "cannot append to " + path);
  }
  ~Appender() { std::fclose(file_); }
  Appender(const Appender&) = delete;
  template <typename Row>
  void append(const std::vector<Row>& rows) {
    std::string text;
    for (const Row& row : rows) {
      if constexpr (std::is_same_v<Row, SolutionRow>)
        text += row.line;
      else
        text += csvLine(row);
    }
    if (std::fwrite(text.data(), 1, text.size(), file_) != text.size() || std::fflush(file_) != 0)
      throw std::runtime_error("cannot write " + path_ + " (is the disk full?)");
  }

 private:
  std::string path_;
  std::FILE* file_;
};

std::vector<LoadedSet> loadSets(const ComparisonPlan& plan, const LabModel& model) {
  std::vector<LoadedSet> sets;
  for (const std::string& name : plan.sets) {
    const SetChoice choice = setChoice(name);
    LoadedSet set{.name = name, .entry = choice.entry, .budget = plan.budget, .problems = nullptr};
    if (choice.restarts) set.budget.restarts = *choice.restarts;
    for (const LoadedSet& other : sets)
      if (other.entry == set.entry) set.problems = other.problems;
    if (!set.problems)
      set.problems = std::make_shared<Problems>(
          Problems{makeProblems(*choice.entry, model, plan.problems, plan.seed, plan.tolerance)});
    for (LabProblem& one : set.problems->all)
      if (one.sequence % plan.shards == plan.shard - 1) set.sequences[one.sequence].push_back(&one);
    sets.push_back(std::move(set));
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

/// What is known before the first solve: problem_sets.csv, goals.csv, solvers.csv. Returns the first.
std::vector<SetRow> writeProblems(const std::vector<LoadedSet>& sets, const ComparisonPlan& plan,
                                  const std::string& folder) {
  std::vector<SetRow> rows;
  std::string goals = goalsHeader, checks = csvHeader<SetRow>(), solvers = solversHeader;
  for (const LoadedSet& set : sets) {
    const std::vector<LabProblem>& problems = set.problems->all;
    rows.push_back({.set = set.name,
                    .problems = static_cast<int>(problems.size()),
                    .seed = plan.seed,
                    .checksum = hex(checksum(problems))});
    checks += csvLine(rows.back());
    for (const LabProblem& one : problems)
      for (std::size_t g = 0; g < one.problem.goals.size(); ++g) {
        const Goal& goal = one.problem.goals[g];
        std::vector<std::string> fields{set.name,
                                        std::to_string(one.index),
                                        std::to_string(g + 1),
                                        std::string(goalType(goal.kind).name),
                                        one.skeleton->joint(goal.joint).name,
                                        csvNumber(goal.weight)};
        for (double x : goal.pointInJoint) fields.push_back(csvNumber(x));
        addTarget(goal, fields);
        fields.push_back(goalToText(goal, *one.skeleton));
        goals += csvLine(std::span<const std::string>(fields));
      }
  }
  for (const std::string& text : plan.solvers) {
    const SolverSpec choice = solverSpec(text);
    for (const Parameter& p : choice.entry->parameters) {
      const auto chosen = choice.values.find(p.name);
      const std::vector<std::string> fields{
          text,
          std::string(p.name),
          csvNumber(chosen == choice.values.end() ? p.value : chosen->second),
          csvNumber(p.value),
          std::string(p.unit),
          std::string(p.source),
          std::string(p.meaning)};
      solvers += csvLine(std::span<const std::string>(fields));
    }
  }
  writeFile(folder + "/goals.csv", goals);
  writeFile(folder + "/problem_sets.csv", checks);
  writeFile(folder + "/solvers.csv", solvers);
  return rows;
}

using Key = std::tuple<std::string, std::string, int>;  // set, solver, problem or sequence

/// What an interrupted run left, without what is cut off, unfinished or not in all files; and the (set,
/// solver, sequence) that are done.
std::set<Key> recover(const std::vector<LoadedSet>& sets, const ComparisonPlan& plan,
                      const std::string& folder, Results& kept) {
  const Results there = readResults(folder);
  const auto keyOf = [](const auto& row) { return Key{row.set, row.solver, row.problem}; };
  std::set<Key> haveSolution, haveResult;
  for (const SolutionRow& row : there.solutions) haveSolution.insert(keyOf(row));
  std::map<Key, int> framesDone;
  std::map<Key, Key> unitOf;
  for (const ResultRow& row : there.rows) {
    if (!haveSolution.count(keyOf(row)) || !haveResult.insert(keyOf(row)).second) continue;
    const Key unit{row.set, row.solver, row.sequence};
    unitOf[keyOf(row)] = unit;
    ++framesDone[unit];
  }
  std::set<Key> done;
  for (const LoadedSet& set : sets)
    for (const auto& [sequence, frames] : set.sequences)
      for (const std::string& solver : plan.solvers) {
        const Key unit{set.name, solver, sequence};
        if (framesDone.count(unit) && framesDone[unit] == static_cast<int>(frames.size())) done.insert(unit);
      }
  const auto keep = [&](const auto& rows, auto& into, bool once) {
    std::set<Key> seen;
    for (const auto& row : rows)
      if (const auto unit = unitOf.find(keyOf(row));
          unit != unitOf.end() && done.count(unit->second) && (!once || seen.insert(keyOf(row)).second))
        into.push_back(row);
  };
  keep(there.rows, kept.rows, true);
  keep(there.solutions, kept.solutions, true);
  keep(there.traces, kept.traces, false);
  keep(there.seeds, kept.seeds, false);
  return done;
}

}  // namespace

void validate(const ComparisonPlan& plan) {
  if (plan.sets.empty()) throw std::invalid_argument("no problem set was chosen");
  if (plan.solvers.empty()) throw std::invalid_argument("no solver was chosen");
  for (const std::string& set : plan.sets) setChoice(set);
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

SetChoice setChoice(std::string_view text) {
  const std::size_t open = text.find('[');
  SetChoice choice{.entry = &problemSet(text.substr(0, open))};
  if (open == std::string_view::npos) return choice;
  constexpr std::string_view before = "[restarts=";
  const std::string_view inner = text.substr(open);
  if (inner.starts_with(before) && inner.ends_with(']'))
    if (const auto restarts = parseInteger(inner.substr(before.size(), inner.size() - before.size() - 1));
        restarts && *restarts >= 0) {
      choice.restarts = restarts;
      return choice;
    }
  throw std::invalid_argument("'" + std::string(text) + "': expected a set such as D1 or D1[restarts=50]");
}

int seedCount(const ComparisonPlan& plan, const std::string& solver, int restarts) {
  constexpr int enough = 20;
  const bool stochastic = solverEntry(solver).stochastic;
  if (plan.seeds == 0) return stochastic ? enough : 1;
  return stochastic || restarts > 0 ? plan.seeds : 1;
}

Record recordOf(const ComparisonPlan& plan, const LabModel& model) {
  Record record{{"model", model.name}, {"nq", std::to_string(model.skeleton->nq())}};
  for (int joint : model.effectors) record.emplace_back("effector", model.skeleton->joint(joint).name);
  record.emplace_back("goals", model.pose ? "pose" : "position");
  for (const Goal& goal : model.goals) record.emplace_back("goal", goalToText(goal, *model.skeleton));
  for (const std::string& set : plan.sets) record.emplace_back("set", set);
  for (const std::string& solver : plan.solvers) record.emplace_back("solver", solver);
  for (const std::string& solver : plan.solvers) {
    const SolverSpec choice = solverSpec(solver);
    std::string all;
    for (const Parameter& p : choice.entry->parameters) {
      const auto chosen = choice.values.find(p.name);
      all += " " + std::string(p.name) + '=' +
             exactNumber(chosen == choice.values.end() ? p.value : chosen->second);
    }
    if (!all.empty()) record.emplace_back("parameters", solver + ':' + all);
  }
  record.emplace_back("problems", std::to_string(plan.problems));
  record.emplace_back("seed", std::to_string(plan.seed));
  record.emplace_back("tolerance", exactNumber(plan.tolerance));
  record.emplace_back("iterations", std::to_string(plan.budget.maxIterations));
  record.emplace_back("restarts", std::to_string(plan.budget.restarts));
  record.emplace_back("solver-seed", std::to_string(plan.budget.seed));
  record.emplace_back("budget-seconds", exactNumber(plan.budget.maxSeconds));
  record.emplace_back("traces", std::to_string(plan.traces));
  record.emplace_back("seeds", plan.seeds > 0 ? std::to_string(plan.seeds) : "automatic");
  record.emplace_back("repeat", std::to_string(plan.repeat));
  record.emplace_back("shard", std::to_string(plan.shard) + '/' + std::to_string(plan.shards));
  return record;
}

Results runComparison(const ComparisonPlan& plan, const LabModel& model, const std::string& folder,
                      const std::function<void(int, int, const std::string&)>& progress) {
  validate(plan);
  Results results{.record = recordOf(plan, model)};
  std::vector<LoadedSet> sets = loadSets(plan, model);
  const bool resumed = claimFolder(folder, results.record);
  results.sets = writeProblems(sets, plan, folder);
  std::set<Key> done;
  if (resumed) done = recover(sets, plan, folder, results);
  const std::string header = solutionsHeader(model.skeleton->nq());
  writeTables(folder, results, header);

  TruthFinder truths;
  int total = 0, finished = static_cast<int>(done.size());
  for (const LoadedSet& set : sets) total += static_cast<int>(set.sequences.size() * plan.solvers.size());
  {
    Appender traces(folder + "/traces.csv"), seeds(folder + "/seeds.csv"),
        solutions(folder + "/solutions.csv"), rows(folder + "/results.csv");
    const auto keep = [](Appender& file, auto& unit, auto& all) {
      file.append(unit);
      std::move(unit.begin(), unit.end(), std::back_inserter(all));
    };
    for (LoadedSet& set : sets)
      for (const std::string& name : plan.solvers) {
        const double heap = heapBytes();
        const auto begin = std::chrono::steady_clock::now();
        const auto solver = makeSolver(name);
        const Skeleton* prepared = set.problems->all.front().skeleton.get();
        solver->prepare(*prepared);
        results.preparations.push_back(
            {.set = set.name,
             .solver = name,
             .seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(),
             .bytes = heapBytes() - heap});
        for (const int sequence : bySkeleton(set)) {
          const auto& frames = set.sequences.at(sequence);
          if (done.count({set.name, name, sequence})) continue;
          if (!std::exchange(set.problems->annotated, true))
            for (const auto& [number, ofSequence] : set.sequences)
              for (LabProblem* one : ofSequence) {
                if (one->index % 50 == 0)
                  progress(finished, total, set.name + ": references, problem " + std::to_string(one->index));
                annotate(*set.entry, *one);
              }
          if (frames.front()->skeleton.get() != prepared) {
            prepared = frames.front()->skeleton.get();
            solver->prepare(*prepared);
          }
          Unit unit = solveSequence(set, frames, name, *solver, plan, model, truths);
          keep(traces, unit.traces, results.traces);
          keep(seeds, unit.seeds, results.seeds);
          keep(solutions, unit.solutions, results.solutions);
          keep(rows, unit.rows, results.rows);
          progress(++finished, total, set.name + ": " + name);
        }
      }
  }
  std::string preparations = csvHeader<Preparation>();
  for (const Preparation& one : results.preparations) preparations += csvLine(one);
  writeFile(folder + "/preparation.csv", preparations);
  writeTables(folder, results, header);
  return results;
}

Results mergeComparisons(const std::vector<std::string>& shards, const std::string& folder) {
  if (shards.empty()) throw std::runtime_error("nothing to merge: name the folders of the shards");
  Record common;
  std::set<int> seen;
  int count = 0;
  for (const std::string& shard : shards) {
    Record record = readRecord(shard);
    if (record.empty())
      throw std::runtime_error(shard + " holds no Gelenk comparison of this version (" + markerName +
                               " is missing or foreign)");
    const std::string which = joined(valuesOf(record, "shard"));
    std::erase_if(record, [](const auto& fact) { return fact.first == "shard"; });
    if (common.empty()) common = record;
    if (record != common)
      throw std::runtime_error(shard + " was run with other settings than " + shards.front() +
                               differences(common, record));
    int k = 0, n = 0;
    if (std::sscanf(which.c_str(), "%d/%d", &k, &n) != 2)
      throw std::runtime_error(shard + '/' + markerName + ": expected a shard K/N, found '" + which + "'");
    if (count == 0) count = n;
    if (n != count || !seen.insert(k).second)
      throw std::runtime_error(shard + " is shard " + which + ", which does not fit or is there twice");
  }
  if (static_cast<int>(seen.size()) != count)
    throw std::runtime_error(std::to_string(count - static_cast<int>(seen.size())) + " of " +
                             std::to_string(count) + " shards are missing");

  Results all{.record = common};
  all.record.emplace_back("shard", "1/1");
  for (const std::string& shard : shards) {
    Results part = readResults(shard);
    if (&shard == &shards.front()) {
      all.sets = part.sets;
      all.preparations = part.preparations;
    }
    const auto collect = [](auto& from, auto& into) {
      std::move(from.begin(), from.end(), std::back_inserter(into));
    };
    collect(part.rows, all.rows);
    collect(part.traces, all.traces);
    collect(part.seeds, all.seeds);
    collect(part.solutions, all.solutions);
  }
  std::size_t wanted = 0;
  for (const SetRow& set : all.sets) wanted += static_cast<std::size_t>(set.problems);
  wanted *= valuesOf(common, "solver").size();
  if (all.rows.size() != wanted)
    throw std::runtime_error("the shards hold " + std::to_string(all.rows.size()) + " of " +
                             std::to_string(wanted) +
                             " results: one of them is not finished (run it again to continue)");
  claimFolder(folder, all.record);
  for (const char* name : {"/goals.csv", "/problem_sets.csv", "/preparation.csv", "/solvers.csv"})
    writeFile(folder + name, readFile(shards.front() + name));
  const std::string solutions = readFile(shards.front() + "/solutions.csv");
  writeTables(folder, all, solutions.substr(0, solutions.find('\n') + 1));
  return all;
}

}  // namespace gelenk
