#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/commands/reproductions.h"
#include "apps/commands/solver_colour.h"
#include "apps/document/model.h"
#include "apps/document/notes.h"
#include "kinematics/io/text_file.h"
#include "solvers/lab/comparison.h"
#include "solvers/lab/report.h"
#include "solvers/lab/sweep.h"
#include "solvers/problem/goal_text.h"
#include "solvers/problem/ik_solver.h"

namespace gelenk {
namespace {

struct Request {
  std::string model = "panda";
  std::vector<std::string> sets;  ///< of problems, D1, or of a parameter, dls.lambda=0.1
  std::vector<std::string> solvers, effectors, sweeps, goals;
  int restarts = -1;  ///< not given: one attempt, and the restarts that `solve` has
  ComparisonPlan plan;
  double budgetMilliseconds = 0.0;
  std::string out, shard = "1/1", reproduce;
  bool list = false, rods = false;
  std::vector<std::string> mergeFolders;
};

ReportStyle reportStyle(const std::string& commandLine) {
  return {.version = GELENK_VERSION, .commandLine = commandLine, .colour = [](const std::string& solver) {
            const Eigen::Vector3f c = solverColour(solver) * 255.0f;
            return fmt::format("#{:02x}{:02x}{:02x}", static_cast<int>(c.x() + 0.5f),
                               static_cast<int>(c.y() + 0.5f), static_cast<int>(c.z() + 0.5f));
          }};
}

/// The command line of this process, without the folder of the program.
std::string typedCommand() {
  std::string text;
  try {
    text = readFile("/proc/self/cmdline");
  } catch (const std::exception&) {  // no such file on this system
    return "gelenk compare";
  }
  std::replace(text.begin(), text.end(), '\0', ' ');
  const std::size_t program = text.substr(0, text.find(' ')).rfind('/');
  return program == std::string::npos ? text : text.substr(program + 1);
}

/// A bar on a terminal; a line every tenth elsewhere.
class Progress {
 public:
  void operator()(int done, int total, const std::string& what) {
    const int share = total > 0 ? 100 * done / total : 100;
    if (isatty(STDERR_FILENO)) {
      if (share == lastShare_ && what == lastWhat_) return;
      const int filled = share * 30 / 100;
      fmt::print(stderr, "\r[{}{}] {:3d} %  {:<40}", std::string(filled, '#'), std::string(30 - filled, '.'),
                 share, what);
      if (done == total) fmt::print(stderr, "\n");
      std::fflush(stderr);
    } else if (share / 10 != lastShare_ / 10) {
      fmt::print(stderr, "{:3d} %  {}\n", share, what);
    }
    lastShare_ = share;
    lastWhat_ = what;
  }

 private:
  int lastShare_ = -1;
  std::string lastWhat_;
};

void printList() {
  fmt::print("solvers\n");
  for (const SolverEntry& entry : solverCatalogue()) {
    fmt::print("  {:<20} {} ({})\n", entry.name, entry.title, entry.reference);
    for (const Parameter& p : entry.parameters)
      fmt::print("    .{:<19} {:g}{}{}, {:g} to {:g} ({}): {}\n", p.name, p.value, p.unit == "1" ? "" : " ",
                 p.unit == "1" ? "" : p.unit, p.lower, p.upper, p.source, p.meaning);
  }
  fmt::print("  {:<20} serial-pose on serial chains, drag elsewhere, see docs/solvers\n", "default");
  fmt::print("problem sets\n");
  for (const ProblemSetEntry& entry : problemSetCatalogue())
    fmt::print("  {:<20} {}; level: {}\n", entry.name, entry.title, entry.levels);
  fmt::print("reproductions\n");
  for (const Reproduction& entry : reproductions()) fmt::print("  {:<20} {}\n", entry.name, entry.title);
  fmt::print("models\n");
  for (const std::string& name : builtInModels()) fmt::print("  {}\n", name);
  fmt::print(
      "  planar:X,Y:L1,L2,...  a planar chain of hinges\n  balls:L1,L2,...       a chain of ball joints\n");
}

std::vector<std::string> allSolvers() {
  std::vector<std::string> names;
  for (const SolverEntry& entry : solverCatalogue()) names.emplace_back(entry.name);
  return names;
}

void parseShard(const std::string& text, ComparisonPlan& plan) {
  int k = 0, n = 0;
  char end = 0;
  if (std::sscanf(text.c_str(), "%d/%d%c", &k, &n, &end) != 2)
    throw std::invalid_argument("--shard wants K/N, such as 3/8, not '" + text + "'");
  plan.shard = k;
  plan.shards = n;
}

/// The restarts that `gelenk solve` has.
constexpr int usualRestarts = 50;

/// --set takes sets of problems and values of parameters: the latter have a dot before their equals sign.
bool isSetting(std::string_view text) {
  const std::size_t equals = text.find('=');
  return equals != text.npos && text.substr(0, equals).find('.') != text.npos;
}

void report(const Results& results, const std::string& folder, const std::string& commandLine) {
  const Report report = writeReport(folder, results, reportStyle(commandLine));
  if (!report.note.empty()) fmt::print(stderr, "gelenk: {}\n", report.note);
  fmt::print("{}", report.table);
  for (const SetRow& set : results.sets) fmt::print("checksum {} {}\n", set.set, set.checksum);
  fmt::print("{}\n", (std::filesystem::path(folder) / "report.html").string());
}

/// The model with its effectors, and with goals of any kind that are asked for besides.
LabModel labModelOf(const Request& request, const Model& model) {
  const bool none = request.effectors == std::vector<std::string>{"none"};
  LabModel lab = labModel(model.name, model.skeleton,
                          request.effectors.empty() || none ? model.handles : request.effectors);
  if (none) lab.effectors.clear();
  const std::shared_ptr<const Masses> masses =
      request.rods ? std::make_shared<const Masses>(rodMasses(model.skeleton)) : model.masses;
  for (const std::string& text : request.goals) {
    if (text == "position" || text == "pose")
      lab.pose = text == "pose";
    else
      lab.goals.push_back(goalTemplateFromText(text, model.skeleton, masses));
  }
  if (none && lab.goals.empty()) throw std::invalid_argument("--effector none needs a --goal KIND ...");
  return lab;
}

void compare(Request& request, const std::string& commandLine) {
  if (request.list) return printList();
  if (!request.reproduce.empty()) return reproduce(request.reproduce, request.out, reportStyle(commandLine));
  ComparisonPlan& plan = request.plan;
  std::vector<std::string> settings;
  for (const std::string& text : request.sets) (isSetting(text) ? settings : plan.sets).push_back(text);
  if (plan.sets.empty()) plan.sets = {"D1"};
  if (request.restarts >= 0) {
    plan.budget.restarts = request.restarts;
  } else {  // two questions: how good is one attempt, and what does a user get
    std::vector<std::string> both;
    for (const std::string& set : plan.sets) {
      both.push_back(set);
      if (!setChoice(set).restarts) both.push_back(fmt::format("{}[restarts={}]", set, usualRestarts));
    }
    plan.sets = both;
  }
  if (request.solvers.empty() && request.sweeps.empty()) request.solvers = allSolvers();
  plan.solvers = withParameters(request.solvers, settings, request.sweeps);
  if (request.budgetMilliseconds < 0.0 || std::isnan(request.budgetMilliseconds))
    throw std::invalid_argument("--budget-ms must not be negative");
  if (request.budgetMilliseconds > 0.0) plan.budget.maxSeconds = 1e-3 * request.budgetMilliseconds;
  plan.budget.seed = plan.seed;
  parseShard(request.shard, plan);
  validate(plan);
  if (request.out.empty()) throw std::invalid_argument("--out DIR is needed: the folder for the results");

  const Model model = openModel(request.model);
  sayNotes(request.model, model.notes);
  report(runComparison(plan, labModelOf(request, model), request.out, Progress()), request.out, commandLine);
}

void merge(const std::vector<std::string>& folders, const std::string& out, const std::string& commandLine) {
  report(mergeComparisons(folders, out), out, commandLine);
}

}  // namespace

void addCompareCommand(Command& app) {
  auto request = std::make_shared<Request>();
  Command command = app.command("compare", "Compare solvers on frozen problem sets and write a report");
  ComparisonPlan& plan = request->plan;
  command.option("--model", request->model, "Built-in model or file").showDefault();
  command.option("--set", request->sets,
                 "Problem set, D1 to D8, or D1[restarts=50] (default D1), or the value of a parameter, "
                 "dls.lambda=0.1 (repeatable)");
  command.option("--sweep", request->sweeps,
                 "Runs a grid over a parameter: dls.lambda=0.01:1:log9, or lin9 (repeatable)");
  command.option("--solver", request->solvers,
                 "Solver by name, default, or dls[lambda=0.1] (repeatable; default: all)");
  command.option("--effector", request->effectors,
                 "Joint that gets a goal, or none (repeatable; default: the model's handles, else its ends)");
  command
      .option(
          "--goal", request->goals,
          "position or pose: what the effectors get (default: pose where one effector has 6 dofs). Or a "
          "goal of any kind that is asked for besides, such as 'distance joint=hand_l other=hand_r'; what "
          "it leaves out (target, length, ...) is read off each problem's reference pose (repeatable)")
      .oneAtATime();
  command.flag("--rod-masses", request->rods,
               "Weigh every bone as a rod of the same mass a metre, for goals that need masses");
  command.notes("Kinds of goals and their fields, optional ones in brackets:\n" + describeGoalTypes());
  command.option("--problems", plan.problems, "Problems of each set").showDefault();
  command.option("--seed", plan.seed, "Seed of problems, restarts and stochastic solvers").showDefault();
  command.option("--tolerance", plan.tolerance, "Metres and radians, on the error itself").showDefault();
  command.option("--max-iterations", plan.budget.maxIterations, "Iterations of one attempt").showDefault();
  command.option("--budget-ms", request->budgetMilliseconds,
                 "Time of one solve in milliseconds; 0: no limit (answers then never depend on the machine)");
  command.option("--restarts", request->restarts,
                 "Random restarts after the first attempt (default: every set twice, with none and with 50)");
  command
      .option("--seeds", plan.seeds,
              "Solver seeds, for solvers that draw random numbers; 0: 20 for stochastic methods, 1 for "
              "those that only restart")
      .showDefault();
  command.option("--repeat", plan.repeat, "Solves a problem; the shortest time counts").showDefault();
  command.option("--traces", plan.traces, "Problems of each set whose residual curves are kept")
      .showDefault();
  command.option("--shard", request->shard, "K/N: only the K-th of N parts; join them with 'compare merge'");
  command.option("--out", request->out, "Folder for the results; an interrupted run continues there");
  command.option("--reproduce", request->reproduce, "An experiment from the literature, see --list");
  command.flag("--list", request->list, "List solvers, problem sets, reproductions and models");
  Command merging = command.command("merge", "Join the folders of all shards: merge --out DIR SHARD...");
  merging.option("--out", request->out, "Folder for the joined results").required();
  merging.option("shards", request->mergeFolders, "Folders of the shards").required();
  command.run([request, merging] {
    if (!merging.given()) compare(*request, typedCommand());
  });
  merging.run([request] { merge(request->mergeFolders, request->out, typedCommand()); });
}

}  // namespace gelenk
