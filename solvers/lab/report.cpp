#include "solvers/lab/report.h"

#include <fmt/format.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "kinematics/io/text_file.h"
#include "solvers/lab/comparison.h"
#include "solvers/lab/statistics.h"
#include "solvers/problem/ik_solver.h"

namespace gelenk {

using json = nlohmann::ordered_json;

namespace {

constexpr double microsecond = 1e-6;
constexpr double sameSolution = 1e-3;  ///< radians and metres of all joints: no farther than the nearest
const std::vector<double> scoredTolerances{1e-3, 1e-6, 1e-9};

/// The rows of one set, by solver in order of first appearance.
struct Group {
  std::string set;
  std::vector<std::string> solvers = {};
  std::map<std::string, std::vector<const ResultRow*>> rows = {};
  bool meetable = true, drag = false;
};

std::vector<Group> grouped(const Results& results) {
  std::vector<Group> groups;
  for (const ResultRow& row : results.rows) {
    auto group = std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.set == row.set; });
    if (group == groups.end()) {
      const ProblemSetEntry& entry = *setChoice(row.set).entry;
      group = groups.insert(
          groups.end(),
          {.set = row.set, .meetable = entry.meetable, .drag = entry.family == ProblemFamily::Drag});
    }
    if (!group->rows.count(row.solver)) group->solvers.push_back(row.solver);
    group->rows[row.solver].push_back(&row);
  }
  return groups;
}

bool unsupported(const ResultRow& row) { return row.status == toString(Stop::Unsupported); }

/// Met at another tolerance than the one it was solved at; unsupported problems are never met.
bool metAt(const ResultRow& row, bool meetable, double tolerance) {
  if (unsupported(row) || !(row.limitViolation <= 1e-9)) return false;
  return meetable ? row.position <= tolerance && row.orientation <= tolerance : row.excess <= tolerance;
}

template <typename Value>
std::vector<double> column(const std::vector<const ResultRow*>& rows, Value value) {
  std::vector<double> values;
  for (const ResultRow* row : rows) values.push_back(value(*row));
  return values;
}

json orNull(double value) { return std::isfinite(value) ? json(value) : json(); }

json quantiles(const std::vector<double>& values) {
  json out{{"mean", orNull(mean(values))}};
  for (const auto& [name, p] :
       {std::pair{"min", 0.0}, {"median", 0.5}, {"p90", 0.9}, {"p99", 0.99}, {"max", 1.0}})
    out[name] = orNull(quantile(values, p));
  return out;
}

/// Answers beside all solutions, of the problems whose solutions are known.
json summariseTruth(const std::vector<const ResultRow*>& rows) {
  int known = 0, without = 0, nearest = 0, failed = 0, wrong = 0;
  std::vector<double> farther;
  for (const ResultRow* row : rows) {
    if (row->solutions.empty() || unsupported(*row)) continue;
    ++known;
    const bool none = row->solutions == "0";
    without += none;
    wrong += none && row->solved;
    failed += !none && !row->solved;
    if (!row->solved || !std::isfinite(row->nearest)) continue;
    farther.push_back(row->displacement - row->nearest);
    nearest += farther.back() <= sameSolution;
  }
  if (known == 0) return {};
  const Interval bounds = wilsonInterval(nearest, known - without);
  return {{"problems_known", known},
          {"without_solution", without},
          {"solved_without_solution", wrong},
          {"failed_with_solution", failed},
          {"nearest_found", nearest},
          {"nearest_found_share", orNull(known > without ? double(nearest) / (known - without) : NAN)},
          {"nearest_found_wilson_95", {bounds.lower, bounds.upper}},
          {"farther_than_nearest", quantiles(farther)}};
}

json summariseSolver(const Group& group, const std::vector<const ResultRow*>& rows) {
  const int n = static_cast<int>(rows.size());
  json out{{"problems", n}};
  std::map<std::string, int> statuses;
  int solved = 0;
  for (const ResultRow* row : rows) {
    ++statuses[row->status];
    solved += row->solved;
  }
  out["solved"] = solved;
  const Interval interval = wilsonInterval(solved, n);
  out["solved_share"] = static_cast<double>(solved) / n;
  out["solved_wilson_95"] = {interval.lower, interval.upper};
  out["status"] = statuses;
  for (double tolerance : scoredTolerances) {
    const int met = static_cast<int>(std::count_if(rows.begin(), rows.end(), [&](const ResultRow* row) {
      return metAt(*row, group.meetable, tolerance);
    }));
    const Interval bounds = wilsonInterval(met, n);
    out["met"][fmt::format("{:g}", tolerance)] = {{"share", static_cast<double>(met) / n},
                                                  {"wilson_95", {bounds.lower, bounds.upper}}};
  }
  out["position_error"] = quantiles(column(rows, [](const ResultRow& r) { return r.position; }));
  out["orientation_error"] = quantiles(column(rows, [](const ResultRow& r) { return r.orientation; }));
  if (!group.meetable)
    out["excess_residual"] = quantiles(column(rows, [](const ResultRow& r) { return r.excess; }));
  out["largest_limit_violation"] =
      quantile(column(rows, [](const ResultRow& r) { return r.limitViolation; }), 1.0);
  out["iterations"] = quantiles(column(rows, [](const ResultRow& r) { return r.counters.iterations; }));
  out["forward_kinematics"] =
      quantiles(column(rows, [](const ResultRow& r) { return r.counters.forwardKinematics; }));
  out["jacobians"] = quantiles(column(rows, [](const ResultRow& r) { return r.counters.jacobians; }));
  out["hessians"] = quantiles(column(rows, [](const ResultRow& r) { return r.counters.hessians; }));
  out["factorisations"] =
      quantiles(column(rows, [](const ResultRow& r) { return r.counters.factorisations; }));
  out["restarts"] = quantiles(column(rows, [](const ResultRow& r) { return r.counters.restarts; }));
  out["displacement"] =
      quantiles(column(rows, [](const ResultRow& r) { return r.solved ? r.displacement : NAN; }));
  out["displacement_over_minimal_change"] = quantiles(column(rows, [](const ResultRow& r) {
    return r.solved && r.shortest > 1e-9 ? r.displacement / r.shortest : NAN;
  }));
  if (group.drag) {
    out["largest_jump"] = quantiles(column(rows, [](const ResultRow& r) { return r.jump; }));
    out["jump_over_rate"] = quantiles(column(rows, [](const ResultRow& r) { return r.jump / r.level; }));
    out["jitter"] = quantiles(column(rows, [](const ResultRow& r) { return r.jitter; }));
  }
  if (json truth = summariseTruth(rows); !truth.empty()) out["all_solutions"] = std::move(truth);
  const std::vector<double> seconds =
      column(rows, [](const ResultRow& r) { return unsupported(r) ? NAN : r.seconds; });
  out["time"] = {
      {"seconds", quantiles(seconds)},
      {"cpu_seconds",
       quantiles(column(rows, [](const ResultRow& r) { return unsupported(r) ? NAN : r.cpuSeconds; }))},
      {"expected_running_time",
       orNull(solved > 0 ? mean(seconds) * (n - statuses[toString(Stop::Unsupported)]) / solved : NAN)}};
  return out;
}

/// Pairs of two solvers: all of them when there are few, otherwise all against the first.
json comparePairs(const Group& group) {
  json pairs = json::array();
  const std::size_t firsts = group.solvers.size() <= 6 ? group.solvers.size() : 1;
  for (std::size_t a = 0; a < firsts; ++a)
    for (std::size_t b = a + 1; b < group.solvers.size(); ++b) {
      const auto &first = group.rows.at(group.solvers[a]), &second = group.rows.at(group.solvers[b]);
      const std::size_t n = std::min(first.size(), second.size());
      int onlyFirst = 0, onlySecond = 0;
      std::vector<double> timesA, timesB;
      for (std::size_t i = 0; i < n; ++i) {
        onlyFirst += first[i]->solved && !second[i]->solved;
        onlySecond += second[i]->solved && !first[i]->solved;
        if (unsupported(*first[i]) || unsupported(*second[i])) continue;
        timesA.push_back(first[i]->seconds);
        timesB.push_back(second[i]->seconds);
      }
      json pair{{"first", group.solvers[a]},
                {"second", group.solvers[b]},
                {"only_first_solved", onlyFirst},
                {"only_second_solved", onlySecond},
                {"mcnemar_p", mcNemar(onlyFirst, onlySecond)}};
      if (!timesA.empty()) {
        const RatioEstimate ratio = pairedRatio(timesA, timesB, 1);
        pair["time"] = {{"first_over_second", ratio.ratio},
                        {"bootstrap_95", {ratio.interval.lower, ratio.interval.upper}}};
      }
      pairs.push_back(pair);
    }
  return pairs;
}

/// The spread over solver seeds: of the share solved, of the mean time, and how many problems every or no
/// seed solved.
json summariseSeeds(const std::string& set, const std::string& solver, const Results& results) {
  struct Sums {
    double solved = 0.0, seconds = 0.0, problems = 0.0;
  };
  std::map<std::uint64_t, Sums> bySeed;
  std::map<int, int> solvedSeeds;
  for (const SeedRow& row : results.seeds) {
    if (row.set != set || row.solver != solver) continue;
    Sums& sums = bySeed[row.seed];
    sums.solved += row.solved;
    sums.seconds += row.seconds;
    sums.problems += 1.0;
    solvedSeeds[row.problem] += row.solved;
  }
  if (bySeed.empty()) return {};
  std::vector<double> shares, times;
  for (const auto& [seed, sums] : bySeed) {
    shares.push_back(sums.solved / sums.problems);
    times.push_back(sums.seconds / sums.problems);
  }
  const int count = static_cast<int>(bySeed.size());
  int always = 0, never = 0;
  for (const auto& [problem, solved] : solvedSeeds) {
    always += solved == count;
    never += solved == 0;
  }
  const auto spread = [](const std::vector<double>& values) {
    return json{{"min", orNull(quantile(values, 0.0))},
                {"median", orNull(quantile(values, 0.5))},
                {"max", orNull(quantile(values, 1.0))},
                {"standard_deviation", orNull(standardDeviation(values))}};
  };
  return {{"count", count},
          {"solved_share", spread(shares)},
          {"mean_seconds", spread(times)},
          {"problems_solved_by_every_seed", always},
          {"problems_solved_by_no_seed", never}};
}

/// Every value of a solver's parameters.
json parametersOfChoice(const std::string& solver) {
  const SolverSpec choice = solverSpec(solver);
  json out = json::object();
  for (const Parameter& p : choice.entry->parameters) {
    const auto chosen = choice.values.find(p.name);
    out[std::string(p.name)] = chosen == choice.values.end() ? p.value : chosen->second;
  }
  return out;
}

json summarise(const Results& results, const std::vector<Group>& groups) {
  json out;
  for (const auto& [name, value] : results.record) {
    json& setting = out["settings"][name];
    if (setting.is_null())
      setting = value;
    else if (setting.is_array())
      setting.push_back(value);
    else
      setting = json::array({setting, value});
  }
  for (const SetRow& set : results.sets) out["checksums"][set.set] = set.checksum;
  for (const Group& group : groups) {
    json& set = out["sets"][group.set];
    for (const std::string& solver : group.solvers) {
      json& one = set["solvers"][solver] = summariseSolver(group, group.rows.at(solver));
      if (json parameters = parametersOfChoice(solver); !parameters.empty())
        one["parameters"] = std::move(parameters);
      for (const Preparation& preparation : results.preparations)
        if (preparation.set == group.set && preparation.solver == solver)
          one["preparation"] = {{"seconds", orNull(preparation.seconds)},
                                {"bytes", orNull(preparation.bytes)}};
      if (json seeds = summariseSeeds(group.set, solver, results); !seeds.empty())
        one["seeds"] = std::move(seeds);
    }
    set["pairs"] = comparePairs(group);
  }
  return out;
}

// ---- plots

/// A gnuplot data block of (x, y) pairs or rows of several numbers.
std::string block(const std::string& name, const std::vector<std::vector<double>>& rows) {
  std::string text = "$" + name + " << EOD\n";
  for (const auto& row : rows) {
    for (double value : row) text += std::isfinite(value) ? fmt::format("{:.8g} ", value) : "NaN ";
    text += '\n';
  }
  return text + "EOD\n";
}

std::string preamble() {
  return "set encoding utf8\nset border 3 lc rgb '#888888'\nset tics nomirror tc rgb '#444444' scale 0.5\n"
         "set grid lc rgb '#e4e4e4' lt 1 lw 0.6\nset key outside right top vertical Left reverse samplen 1.6 "
         "spacing 1.0 maxcols 1 tc rgb '#222222'\n"
         "set format y '%g'\n";
}
const std::string logX = "set logscale x\nset format x '10^{%L}'\n";
const std::string logY = "set logscale y\nset format y '10^{%L}'\n";

class Curves {
 public:
  /// Of the solvers (all of a set, drawn or not) those of one colour are told apart by their dashes, and
  /// those of one method with other parameters by the shade.
  Curves(const ReportStyle& style, const std::vector<std::string>& solvers) : style_(style) {
    std::map<std::string, int> uses;
    std::map<std::string_view, std::vector<std::string>> variants;
    for (const std::string& solver : solvers) {
      dashes_[solver] = 1 + uses[style.colour(solver)]++ % 5;
      variants[solverEntry(solver).name].push_back(solver);
    }
    for (const auto& [name, texts] : variants)
      for (std::size_t i = 0; i < texts.size(); ++i)
        colours_[texts[i]] =
            texts.size() < 2 ? style.colour(texts[i])
                             : shaded(style.colour(texts[i]), static_cast<double>(i) / (texts.size() - 1.0));
  }
  void add(const std::string& solver, const std::vector<std::vector<double>>& rows) {
    if (rows.empty()) return;
    const std::string name = "d" + std::to_string(++count_);
    blocks_ += block(name, rows);
    plots_ += fmt::format("{}${} using 1:2 with steps lw 2 {} lc rgb '{}' title '{}'",
                          plots_.empty() ? "" : ", ", name, dash(solver), colours_.at(solver), solver);
  }
  /// rows: x, lower, median, upper.
  void addBand(const std::string& solver, const std::vector<std::vector<double>>& rows, bool shade) {
    if (rows.empty()) return;
    const std::string name = "d" + std::to_string(++count_);
    blocks_ += block(name, rows);
    const std::string colour = colours_.at(solver);
    if (shade)
      plots_ +=
          fmt::format("{}${} using 1:2:4 with filledcurves fc rgb '{}' fs transparent solid 0.14 notitle",
                      plots_.empty() ? "" : ", ", name, colour);
    plots_ += fmt::format("{}${} using 1:3 with lines lw 2 {} lc rgb '{}' title '{}'",
                          plots_.empty() ? "" : ", ", name, dash(solver), colour, solver);
  }
  void addPoints(const std::string& solver, const std::vector<std::vector<double>>& rows) {
    if (rows.empty()) return;
    const std::string name = "d" + std::to_string(++count_);
    blocks_ += block(name, rows);
    plots_ += fmt::format("{}${} using 1:2 with points pt {} ps 1.1 lc rgb '{}' title '{}'",
                          plots_.empty() ? "" : ", ", name, symbol(solver), colours_.at(solver), solver);
  }
  int symbol(const std::string& solver) const { return std::array{7, 5, 9, 13, 15}[dashes_.at(solver) - 1]; }
  bool empty() const { return plots_.empty(); }
  std::string script(const std::string& settings) const {
    return preamble() + blocks_ + settings + "plot " + plots_ + "\n";
  }

 private:
  /// "#rrggbb" towards black (share 0) or white (share 1).
  static std::string shaded(const std::string& colour, double share) {
    const unsigned rgb = std::stoul(colour.substr(1), nullptr, 16);
    std::string out = "#";
    for (const int shift : {16, 8, 0}) {
      const double c = rgb >> shift & 255;
      out += fmt::format("{:02x}", static_cast<int>(share < 0.5 ? c * (0.45 + 1.1 * share)
                                                                : c + (225.0 - c) * (1.4 * share - 0.7)));
    }
    return out;
  }
  std::string dash(const std::string& solver) const { return fmt::format("dt {}", dashes_.at(solver)); }
  const ReportStyle& style_;
  std::string blocks_, plots_;
  std::map<std::string, int> dashes_;
  std::map<std::string, std::string> colours_;
  int count_ = 0;
};

bool neverSupported(const Group& group, const std::string& solver) {
  const auto& rows = group.rows.at(solver);
  return std::all_of(rows.begin(), rows.end(), [](const ResultRow* row) { return unsupported(*row); });
}

std::vector<double> logSteps(double low, double high, int count) {
  std::vector<double> steps;
  for (int i = 0; i <= count; ++i)
    steps.push_back(low * std::pow(high / low, static_cast<double>(i) / count));
  return steps;
}

std::string profilePlot(const Group& group, const ReportStyle& style) {
  std::vector<std::vector<double>> times;
  for (const std::string& solver : group.solvers)
    times.push_back(
        column(group.rows.at(solver), [](const ResultRow& r) { return r.solved ? r.seconds : INFINITY; }));
  std::size_t n = times[0].size();
  for (auto& t : times) n = std::min(n, t.size());
  for (auto& t : times) t.resize(n);
  const std::vector<double> taus = logSteps(1.0, 1000.0, 300);
  const auto profile = performanceProfile(times, taus);
  Curves curves(style, group.solvers);
  for (std::size_t m = 0; m < times.size(); ++m) {
    if (neverSupported(group, group.solvers[m])) continue;
    std::vector<std::vector<double>> rows;
    for (std::size_t t = 0; t < taus.size(); ++t) rows.push_back({taus[t], profile[m][t]});
    curves.add(group.solvers[m], rows);
  }
  return curves.script(logX +
                       "set yrange [0:1.02]\nset xlabel 'time over the fastest solver of the problem'\nset "
                       "ylabel 'share of problems solved'\n");
}

std::string successPlot(const Group& group, const ReportStyle& style) {
  Curves curves(style, group.solvers);
  double low = 1e300, high = 0.0;
  for (const auto& [solver, rows] : group.rows)
    for (const ResultRow* row : rows)
      if (row->solved) low = std::min(low, row->seconds), high = std::max(high, row->seconds);
  if (high <= 0.0) return {};
  const std::vector<double> steps = logSteps(0.8 * low, 1.2 * high, 300);
  for (const std::string& solver : group.solvers) {
    if (neverSupported(group, solver)) continue;
    std::vector<double> times =
        column(group.rows.at(solver), [](const ResultRow& r) { return r.solved ? r.seconds : INFINITY; });
    std::sort(times.begin(), times.end());
    std::vector<std::vector<double>> rows;
    for (double t : steps)
      rows.push_back({t / microsecond,
                      static_cast<double>(std::upper_bound(times.begin(), times.end(), t) - times.begin()) /
                          static_cast<double>(times.size())});
    curves.add(solver, rows);
  }
  return curves.script(
      logX + "set yrange [0:1.02]\nset xlabel 'time [µs]'\nset ylabel 'share of problems solved'\n");
}

/// A solver whose inner loops keep no history traces its start and its answer without times.
bool keepsNoHistory(const Group& group, const Results& results, const std::string& solver) {
  for (const TracePoint& point : results.traces)
    if (point.set == group.set && point.solver == solver && point.seconds > 0.0) return false;
  return true;
}

/// For the caption: who is not drawn, and why.
std::string withoutHistory(const Group& group, const Results& results) {
  std::string names;
  for (const std::string& solver : group.solvers)
    if (!neverSupported(group, solver) && keepsNoHistory(group, results, solver))
      names += (names.empty() ? " Not drawn, since they keep no history of iterations: " : ", ") + solver;
  return names.empty() ? names : names + ".";
}

/// Residual curves of one solver by problem: (x, residual) steps, held at their last value.
std::string residualPlot(const Group& group, const Results& results, const ReportStyle& style,
                         bool overTime) {
  Curves curves(style, group.solvers);
  for (const std::string& solver : group.solvers) {
    std::map<int, std::vector<std::pair<double, double>>> traces;
    double longest = overTime ? 0.0 : 1.0, shortest = 1e300;
    for (const TracePoint& point : results.traces) {
      if (point.set != group.set || point.solver != solver || !std::isfinite(point.residual)) continue;
      const double x = overTime ? point.seconds / microsecond : point.iteration;
      traces[point.problem].push_back({x, std::max(point.residual, 1e-17)});
      longest = std::max(longest, x);
      if (x > 0.0) shortest = std::min(shortest, x);
    }
    if (traces.empty() || !(longest > 0.0) || keepsNoHistory(group, results, solver)) continue;
    longest = std::min(longest, overTime ? longest : 100.0);
    std::vector<double> xs;
    if (overTime)
      xs = logSteps(std::min(shortest, 0.99 * longest), longest, 80);
    else
      for (int i = 0; i <= static_cast<int>(longest); ++i) xs.push_back(i);
    std::vector<std::vector<double>> rows;
    for (double x : xs) {
      std::vector<double> values;
      for (const auto& [problem, points] : traces) {
        auto after = std::upper_bound(points.begin(), points.end(), x,
                                      [](double a, const auto& p) { return a < p.first; });
        if (after != points.begin()) --after;
        values.push_back(after->second);
      }
      rows.push_back({x, quantile(values, 0.25), quantile(values, 0.5), quantile(values, 0.75)});
    }
    curves.addBand(solver, rows, group.solvers.size() <= 6);
  }
  if (curves.empty()) return {};
  return curves.script(logY + (overTime ? logX : std::string()) + "set xlabel '" +
                       (overTime ? "time [µs]" : "iteration, all attempts together") +
                       "'\nset ylabel 'residual [m, rad], median and quartiles'\n");
}

/// Share solved in a grid of sigma_min (logarithmic) and limit margin, one panel a solver.
std::string hardnessPlot(const Group& group) {
  std::vector<std::string> solvers;
  for (const std::string& solver : group.solvers)
    if (!neverSupported(group, solver) && solvers.size() < 6) solvers.push_back(solver);
  const std::size_t panels = solvers.size();
  std::string blocks, plots;
  constexpr int nx = 6, ny = 5;
  for (std::size_t m = 0; m < panels; ++m) {
    double count[nx][ny] = {}, solved[nx][ny] = {};
    for (const ResultRow* row : group.rows.at(solvers[m])) {
      const int x = std::clamp(static_cast<int>(std::floor(std::log10(std::max(row->sigmaMin, 1e-12)) + 5.0)),
                               0, nx - 1);
      const int y = std::clamp(static_cast<int>(row->limitMargin * ny), 0, ny - 1);
      count[x][y] += 1.0;
      solved[x][y] += row->solved;
    }
    std::vector<std::vector<double>> rows;
    for (int x = 0; x < nx; ++x)
      for (int y = 0; y < ny; ++y)
        if (count[x][y] > 0.0)
          rows.push_back({x - 4.5, (y + 0.5) / ny, solved[x][y] / count[x][y], count[x][y]});
    blocks += block("d" + std::to_string(m), rows);
    plots += fmt::format(
        "set title '{}' tc rgb '#222222'\nplot $d{} using 1:2:(0.48):(0.09):3 with boxxyerrorbars fs solid 1 "
        "noborder lc palette notitle\n",
        solvers[m], m);
  }
  return preamble() + blocks +
         fmt::format(
             "unset key\nset colorbox user origin 0.92,0.2 size 0.014,0.6\nset palette defined (0 '#440154', "
             "0.25 '#3b528b', 0.5 '#21918c', 0.75 '#5ec962', 1 '#fde725')\nset cbrange [0:1]\nset xrange "
             "[-5:1]\nset yrange [0:1]\nset xtics 1\nset ytics 0.5\n"
             "set xlabel 'log_{{10}} σ_{{min}}' offset 0,0.4\nset ylabel 'limit margin' offset 1.5,0\nset "
             "multiplot layout {},{} margins 0.07,0.89,0.13,0.92 spacing 0.07,0.2\n",
             panels > 3 ? 2 : 1, std::min<std::size_t>(panels, 3)) +
         plots + "unset multiplot\n";
}

std::string displacementPlot(const Group& group, const ReportStyle& style) {
  Curves curves(style, group.solvers);
  for (const std::string& solver : group.solvers) {
    std::vector<double> ratios;
    for (const ResultRow* row : group.rows.at(solver))
      if (row->solved && row->shortest > 1e-9) ratios.push_back(row->displacement / row->shortest);
    std::sort(ratios.begin(), ratios.end());
    std::vector<std::vector<double>> rows;
    for (std::size_t i = 0; i < ratios.size(); i += std::max<std::size_t>(1, ratios.size() / 200))
      rows.push_back({ratios[i], (static_cast<double>(i) + 1.0) / static_cast<double>(ratios.size())});
    curves.add(solver, rows);
  }
  if (curves.empty()) return {};
  return curves.script(
      "set xrange [0:6]\nset yrange [0:1.02]\nset xlabel 'joint displacement over that of the minimal-change "
      "path'\nset ylabel 'share of the solved problems'\n");
}

std::string jitterPlot(const Group& group, const ReportStyle& style) {
  Curves curves(style, group.solvers);
  for (const std::string& solver : group.solvers) {
    std::map<double, std::vector<const ResultRow*>> levels;
    for (const ResultRow* row : group.rows.at(solver))
      if (!unsupported(*row)) levels[row->level].push_back(row);
    std::vector<std::vector<double>> rows;
    for (const auto& [level, some] : levels)
      rows.push_back(
          {std::max(1e-12, quantile(column(some, [](const ResultRow& r) { return r.position; }), 0.9)),
           std::max(1e-12, quantile(column(some, [](const ResultRow& r) { return r.jitter; }), 0.9))});
    curves.addPoints(solver, rows);
  }
  if (curves.empty()) return {};
  return curves.script(logX + logY +
                       "set xlabel 'lag: position error behind the target, 90 % quantile [m]'\nset ylabel "
                       "'jitter, 90 % quantile [rad a frame^2]'\n");
}

/// Solvers of a set that differ in one parameter alone, by its value.
struct Sweep {
  const SolverEntry* entry;
  const Parameter* parameter;
  std::string rest;  ///< the other values away from their defaults, as text
  std::map<double, std::string> solvers = {};
};

std::vector<Sweep> sweepsOf(const Group& group) {
  constexpr std::size_t fewest = 3;  // values that make a curve
  std::vector<Sweep> sweeps;
  std::set<std::tuple<const SolverEntry*, const Parameter*, std::string>> known;
  for (const std::string& solver : group.solvers) {
    const SolverSpec choice = solverSpec(solver);
    for (const auto& [name, chosen] : choice.values) {
      SolverSpec rest = choice;
      rest.values.erase(name);
      Sweep sweep{.entry = choice.entry, .parameter = nullptr, .rest = toText(rest)};
      for (const Parameter& p : choice.entry->parameters)
        if (p.name == name) sweep.parameter = &p;
      if (!known.insert({sweep.entry, sweep.parameter, sweep.rest}).second) continue;
      for (const std::string& other : group.solvers) {
        SolverSpec that = solverSpec(other);
        if (that.entry != sweep.entry || neverSupported(group, other)) continue;
        const auto value = that.values.find(name);
        const double x = value == that.values.end() ? sweep.parameter->value : value->second;
        that.values.erase(name);
        that.name = choice.name;
        if (toText(that) == sweep.rest) sweep.solvers.emplace(x, other);
      }
      if (sweep.solvers.size() >= fewest) sweeps.push_back(std::move(sweep));
    }
  }
  return sweeps;
}

/// Success, time and iterations over the parameter, one above the other.
std::string sweepPlot(const Group& group, const Sweep& sweep, const ReportStyle& style) {
  std::vector<std::vector<double>> data;
  for (const auto& [x, solver] : sweep.solvers) {
    const auto& rows = group.rows.at(solver);
    const int n = static_cast<int>(rows.size());
    const int solved = static_cast<int>(
        std::count_if(rows.begin(), rows.end(), [](const ResultRow* row) { return row->solved; }));
    const Interval share = wilsonInterval(solved, n);
    const auto seconds = column(rows, [](const ResultRow& r) { return unsupported(r) ? NAN : r.seconds; });
    const auto iterations =
        column(rows, [](const ResultRow& r) { return unsupported(r) ? NAN : double(r.counters.iterations); });
    std::vector<double> row{x, static_cast<double>(solved) / n, share.lower, share.upper};
    for (const double p : {0.5, 0.25, 0.75}) row.push_back(quantile(seconds, p) / microsecond);
    for (const double p : {0.5, 0.25, 0.75}) row.push_back(quantile(iterations, p));
    data.push_back(std::move(row));
  }
  const double low = sweep.solvers.begin()->first, high = sweep.solvers.rbegin()->first;
  const bool logarithmic = low > 0.0 && high / low >= 20.0;
  const std::string colour = style.colour(sweep.solvers.begin()->second);
  std::string unit(sweep.parameter->unit);
  if (unit == "1") unit.clear();
  std::string script =
      preamble() + block("sweep", data) + "unset key\n" + (logarithmic ? logX : std::string());
  script += "set multiplot layout 3,1 margins 0.11,0.97,0.1,0.98 spacing 0.03\n";
  script += fmt::format("set xrange [{:.8g}:{:.8g}]\n", logarithmic ? low / 1.1 : low - 0.03 * (high - low),
                        logarithmic ? high * 1.1 : high + 0.03 * (high - low));
  const double usual = sweep.parameter->value;
  if (usual >= low && usual <= high)
    script += fmt::format(
        "set arrow 1 from first {0:.8g}, graph 0 to first {0:.8g}, graph 1 nohead dt 3 lc rgb "
        "'#555555'\n",
        usual);
  const auto panel = [&](const char* label, int at, const std::string& settings) {
    script += fmt::format(
        "{}set ylabel '{}'\nplot $sweep using 1:{}:{}:{} with yerrorbars lw 1.2 pt 7 ps 0.7 lc rgb '{}', "
        "$sweep "
        "using 1:{} with lines lw 2 lc rgb '{}'\n",
        settings, label, at, at + 1, at + 2, colour, at, colour);
  };
  panel("share solved", 2, "set yrange [-0.03:1.03]\nset format x ''\n");
  panel("time [µs]", 5, "set yrange [*:*]\nset logscale y\n");
  panel("iterations", 8,
        fmt::format("set logscale y\nset format x '%g'\nset xlabel '{}.{}{}'\n", sweep.entry->name,
                    sweep.parameter->name, unit.empty() ? unit : " [" + unit + "]"));
  return script + "unset multiplot\n";
}

// ---- the page

std::string escaped(const std::string& text) {
  std::string out;
  for (char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else
      out += c;
  }
  return out;
}

std::string shown(const json& value, double scale, const char* format) {
  if (!value.is_number()) return "–";
  return fmt::format(fmt::runtime(format), value.get<double>() * scale);
}

std::string tableOf(const json& set, const ReportStyle& style, bool drag, bool meetable) {
  std::string html =
      "<table><tr><th>solver</th><th>solved</th><th>95 % "
      "interval</th><th>10<sup>-3</sup></th><th>10<sup>-6</sup></th>"
      "<th>10<sup>-9</sup></th><th>mean µs</th><th>median</th><th>p99</th><th>expected µs to a "
      "solution</th><th>iterations</th><th>FK</th>"
      "<th>factorisations</th><th>displacement ratio</th><th>limit violation</th><th>preparation "
      "ms</th><th>kB</th>";
  if (drag) html += "<th>largest jump</th><th>jitter p99</th>";
  if (!meetable) html += "<th>excess, median</th><th>excess, p99</th>";
  html += "</tr>\n";
  for (const auto& [name, s] : set["solvers"].items()) {
    const json& time = s["time"];
    html += fmt::format("<tr><td><i style=\"background:{}\"></i>{}</td>", style.colour(name), escaped(name));
    const auto cell = [&](const std::string& text) { html += "<td>" + text + "</td>"; };
    const int unsupportedCount =
        s["status"].contains("unsupported") ? s["status"]["unsupported"].get<int>() : 0;
    if (unsupportedCount == s["problems"].get<int>()) {
      html += "<td colspan=\"" + std::to_string(16 + 2 * drag + 2 * !meetable) + "\">unsupported</td></tr>\n";
      continue;
    }
    cell(shown(s["solved_share"], 100.0, "{:.2f} %") +
         (unsupportedCount ? fmt::format(" ({} unsupported)", unsupportedCount) : ""));
    cell(shown(s["solved_wilson_95"][0], 100.0, "{:.2f}") + " – " +
         shown(s["solved_wilson_95"][1], 100.0, "{:.2f}"));
    for (const char* tolerance : {"0.001", "1e-06", "1e-09"})
      cell(shown(s["met"][tolerance]["share"], 100.0, "{:.2f} %"));
    for (const char* key : {"mean", "median", "p99"}) cell(shown(time["seconds"][key], 1e6, "{:.1f}"));
    cell(shown(time["expected_running_time"], 1e6, "{:.1f}"));
    cell(shown(s["iterations"]["median"], 1.0, "{:.0f}") + " / " +
         shown(s["iterations"]["p99"], 1.0, "{:.0f}"));
    cell(shown(s["forward_kinematics"]["mean"], 1.0, "{:.1f}"));
    cell(shown(s["factorisations"]["mean"], 1.0, "{:.1f}"));
    cell(shown(s["displacement_over_minimal_change"]["median"], 1.0, "{:.2f}"));
    cell(shown(s["largest_limit_violation"], 1.0, "{:.1e}"));
    const json preparation = s.value("preparation", json::object());
    cell(shown(preparation.value("seconds", json()), 1e3, "{:.3g}"));
    cell(shown(preparation.value("bytes", json()), 1e-3, "{:.4g}"));
    if (drag) {
      cell(shown(s["largest_jump"]["max"], 1.0, "{:.3g}"));
      cell(shown(s["jitter"]["p99"], 1.0, "{:.3g}"));
    }
    if (!meetable) {
      cell(shown(s["excess_residual"]["median"], 1.0, "{:.2e}"));
      cell(shown(s["excess_residual"]["p99"], 1.0, "{:.2e}"));
    }
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

std::string seedsTable(const json& set) {
  std::string rows;
  for (const auto& [name, s] : set["solvers"].items()) {
    if (!s.contains("seeds")) continue;
    const json& seeds = s["seeds"];
    const auto spread = [&](const char* key, double scale, const char* format) {
      std::string cells;
      for (const char* what : {"min", "median", "max", "standard_deviation"})
        cells += "<td>" + shown(seeds[key][what], scale, format) + "</td>";
      return cells;
    };
    rows +=
        fmt::format("<tr><td>{}</td><td>{}</td>{}{}<td>{}</td><td>{}</td></tr>\n", escaped(name),
                    seeds["count"].get<int>(), spread("solved_share", 100.0, "{:.2f}"),
                    spread("mean_seconds", 1e6, "{:.1f}"), seeds["problems_solved_by_every_seed"].get<int>(),
                    seeds["problems_solved_by_no_seed"].get<int>());
  }
  if (rows.empty()) return {};
  return "<p>Methods that draw random numbers, over solver "
         "seeds:</p><table><tr><th>solver</th><th>seeds</th><th>solved %: "
         "least</th><th>median</th><th>most</th>"
         "<th>sd</th><th>mean µs: least</th><th>median</th><th>most</th><th>sd</th><th>problems every seed "
         "solves</th><th>none solves</th></tr>\n" +
         rows + "</table>\n";
}

/// Beside all solutions, where they are known.
std::string truthTable(const json& set) {
  std::string rows;
  for (const auto& [name, s] : set["solvers"].items()) {
    if (!s.contains("all_solutions")) continue;
    const json& t = s["all_solutions"];
    rows += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{} – {}</td><td>{}</td><td>{}</td>"
        "<td>{}</td></tr>\n",
        escaped(name), t["problems_known"].get<int>(), t["without_solution"].get<int>(),
        shown(t["nearest_found_share"], 100.0, "{:.2f} %"),
        shown(t["nearest_found_wilson_95"][0], 100.0, "{:.2f}"),
        shown(t["nearest_found_wilson_95"][1], 100.0, "{:.2f}"),
        shown(t["farther_than_nearest"]["median"], 1.0, "{:.3g}"),
        shown(t["farther_than_nearest"]["p90"], 1.0, "{:.3g}"), t["failed_with_solution"].get<int>());
  }
  if (rows.empty()) return {};
  return "<p>Beside all solutions within the limits, of the problems where they are known: how often the "
         "answer was the nearest to the start, and how much farther away the solved ones were.</p><table><tr>"
         "<th>solver</th><th>problems known</th><th>without a solution</th><th>nearest found</th><th>95 % "
         "interval</th><th>farther: median</th><th>p90</th><th>failed though there is a "
         "solution</th></tr>\n" +
         rows + "</table>\n";
}

std::string pairsTable(const json& pairs) {
  std::string html =
      "<details><summary>Pairs of solvers: McNemar and paired "
      "bootstrap</summary><table><tr><th>first</th><th>second</th>"
      "<th>only first solved</th><th>only second</th><th>McNemar p</th><th>time first / second</th><th>95 % "
      "bootstrap</th></tr>\n";
  for (const json& pair : pairs) {
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.3g}</td>",
                        pair["first"].get<std::string>(), pair["second"].get<std::string>(),
                        pair["only_first_solved"].get<int>(), pair["only_second_solved"].get<int>(),
                        pair["mcnemar_p"].get<double>());
    if (pair.contains("time"))
      html +=
          fmt::format("<td>{}</td><td>{} – {}</td>", shown(pair["time"]["first_over_second"], 1.0, "{:.3g}"),
                      shown(pair["time"]["bootstrap_95"][0], 1.0, "{:.3g}"),
                      shown(pair["time"]["bootstrap_95"][1], 1.0, "{:.3g}"));
    html += "</tr>\n";
  }
  return html + "</table></details>\n";
}

std::string methodsSection(const Results& results, const ReportStyle& style, const json& summary) {
  std::string html = "<h2>Methods</h2>\n<table class=\"facts\">\n";
  const auto fact = [&](const std::string& name, const std::string& value) {
    html += "<tr><th>" + escaped(name) + "</th><td>" + escaped(value) + "</td></tr>\n";
  };
  fact("program", "gelenk " + style.version);
  fact("command", style.commandLine);
  const std::string facts = machineFacts();
  for (std::string_view line : splitLines(facts))
    fact(std::string(line.substr(0, line.find(':'))), std::string(line.substr(line.find(':') + 2)));
  for (const auto& [name, value] : results.record) fact(name, value);
  for (const auto& [set, check] : summary["checksums"].items())
    fact("checksum of " + set, check.get<std::string>());
  html +=
      "</table>\n<p>Every solver begins at the same start and works through the same counted evaluator; one "
      "judge outside the solvers "
      "recomputes errors and limits by forward kinematics. <b>Solved</b>: every goal within the tolerance "
      "(metres, radians, on the error itself, "
      "not its square) and limits kept to 10<sup>-9</sup>; in D4 and D7, whose goals cannot be met: residual "
      "within the tolerance of the best known. "
      "Times are of all problems, solved or not, one thread, wall clock, the shortest of the repetitions; "
      "the machine may have been shared, so ratios "
      "within one run say more than microseconds. Expected time to a solution: total time over solved "
      "problems. Displacement ratio: joint displacement from the "
      "start over that of the minimal-change path (pseudo-inverse in steps of at most 0.02 rad). All "
      "solutions "
      "are those of complete sets (Gelenk's own); an answer is the nearest where it lies no more than "
      "10<sup>-3</sup> farther from the start. Intervals are Wilson's. "
      "A time budget, where one is set, makes answers depend on the machine.</p>\n";
  return html;
}

/// The summary for the terminal, one line a set and solver.
std::string summaryTable(const json& summary) {
  std::size_t set = 3, solver = 20;
  for (const auto& [setName, facts] : summary["sets"].items()) {
    set = std::max(set, setName.size());
    for (const auto& [name, s] : facts["solvers"].items()) solver = std::max(solver, name.size());
  }
  std::string text =
      fmt::format("{:<{}} {:<{}} {:>8} {:>18} {:>10} {:>10} {:>10} {:>7}\n", "set", set, "solver", solver,
                  "solved", "95 % interval", "mean us", "median us", "p99 us", "iter.");
  for (const auto& [setName, facts] : summary["sets"].items())
    for (const auto& [name, s] : facts["solvers"].items()) {
      if (s["status"].contains("unsupported") && s["status"]["unsupported"] == s["problems"]) {
        text += fmt::format("{:<{}} {:<{}} {:>8}\n", setName, set, name, solver, "unsupported");
        continue;
      }
      const json& seconds = s["time"]["seconds"];
      text +=
          fmt::format("{:<{}} {:<{}} {:>8} {:>18} {:>10} {:>10} {:>10} {:>7}\n", setName, set, name, solver,
                      shown(s["solved_share"], 100.0, "{:.2f}%"),
                      shown(s["solved_wilson_95"][0], 100.0, "{:.2f}") + " - " +
                          shown(s["solved_wilson_95"][1], 100.0, "{:.2f}"),
                      shown(seconds["mean"], 1e6, "{:.1f}"), shown(seconds["median"], 1e6, "{:.1f}"),
                      shown(seconds["p99"], 1e6, "{:.1f}"), shown(s["iterations"]["median"], 1.0, "{:.0f}"));
    }
  std::string truth;
  for (const auto& [setName, facts] : summary["sets"].items())
    for (const auto& [name, s] : facts["solvers"].items()) {
      if (!s.contains("all_solutions")) continue;
      const json& t = s["all_solutions"];
      truth += fmt::format("{:<{}} {:<{}} {:>8} {:>11} {:>13} {:>15} {:>12}\n", setName, set, name, solver,
                           t["problems_known"].get<int>(), t["without_solution"].get<int>(),
                           shown(t["nearest_found_share"], 100.0, "{:.2f}%"),
                           shown(t["farther_than_nearest"]["median"], 1.0, "{:.3g}"),
                           t["failed_with_solution"].get<int>());
    }
  if (!truth.empty())
    text +=
        fmt::format("\n{:<{}} {:<{}} {:>8} {:>11} {:>13} {:>15} {:>12}\n", "set", set, "beside all solutions",
                    solver, "known", "no solution", "nearest found", "farther, median", "failed alone") +
        truth;
  return text;
}

const char* const pageStyle =
    "body{font:15px/1.5 system-ui,sans-serif;color:#222;max-width:1180px;margin:2em auto;padding:0 "
    "1em}h1{font-weight:600}h2{margin-top:2em;border-bottom:1px solid "
    "#ddd}table{border-collapse:collapse;font-size:13px;margin:1em "
    "0;display:block;overflow-x:auto}td,th{padding:3px 9px;text-align:right;border-bottom:1px solid #eee;"
    "white-space:nowrap}th{font-weight:600;color:#555}td:first-child,th:first-child{text-align:left}td "
    "i{display:inline-block;width:10px;height:10px;border-radius:5px;"
    "margin-right:7px}.facts td,.facts th{text-align:left;white-space:normal}figure{margin:1.2em "
    "0}figcaption{color:#555;font-size:13px}svg{max-width:100%;height:auto}"
    ".plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(560px,1fr));gap:10px}";

}  // namespace

std::string plotSvg(const std::string& script, int width, int height) {
  if (script.empty()) return {};
  const std::string out =
      (std::filesystem::temp_directory_path() / ("gelenk-plot-" + std::to_string(getpid()) + ".svg"))
          .string();
  std::FILE* pipe = popen("gnuplot >/dev/null 2>&1", "w");
  if (!pipe) return {};
  const std::string head = fmt::format(
      "set terminal svg size {},{} dynamic font 'sans-serif,12' background '#ffffff'\nset output '{}'\n",
      width, height, out);
  std::fwrite(head.data(), 1, head.size(), pipe);
  std::fwrite(script.data(), 1, script.size(), pipe);
  const bool fine = pclose(pipe) == 0;
  std::string svg;
  if (fine && std::filesystem::exists(out)) svg = readFile(out);
  std::filesystem::remove(out);
  return svg.find("<svg") == std::string::npos ? std::string() : svg.substr(svg.find("<svg"));
}

std::string machineFacts() {
  std::string processor = "unknown";
  try {
    const std::string text = readFile("/proc/cpuinfo");
    for (std::string_view line : splitLines(text))
      if (line.starts_with("model name")) {
        processor = std::string(line.substr(line.find(':') + 2));
        break;
      }
  } catch (const std::exception&) {  // no such file on this system
  }
#if defined(__clang__)
  const std::string compiler = "clang " __clang_version__;
#else
  const std::string compiler = "gcc " __VERSION__;
#endif
  return fmt::format(
      "processor: {}, {} processors\ncompiler: {}\nflags: {}\nlibraries: Eigen {}.{}.{}, Ceres Solver {}\n",
      processor, sysconf(_SC_NPROCESSORS_ONLN), compiler, GELENK_COMPILER_FLAGS, EIGEN_WORLD_VERSION,
      EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION, GELENK_CERES_VERSION);
}

Report writeReport(const std::string& folder, const Results& results, const ReportStyle& style) {
  const std::vector<Group> groups = grouped(results);
  json summary = summarise(results, groups);
  summary["program"] = "gelenk " + style.version;
  summary["machine"] = machineFacts();
  writeFile(folder + "/summary.json", summary.dump(2) + "\n");

  std::string note;
  const bool canPlot = !plotSvg("plot x\n", 100, 100).empty();
  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Gelenk: solvers "
      "compared</title><style>" +
      std::string(pageStyle) + "</style></head><body>\n<h1>Inverse kinematics: solvers compared";
  for (const std::string& model : valuesOf(results.record, "model")) html += " on " + escaped(model);
  html += "</h1>\n";
  if (!canPlot)
    html += "<p><b>No plots: the program gnuplot was not found when this report was written.</b></p>\n";
  if (canPlot) std::filesystem::create_directories(folder + "/plots");
  for (const Group& group : groups) {
    const SetChoice choice = setChoice(group.set);
    const ProblemSetEntry& entry = *choice.entry;
    std::string restarts = choice.restarts ? std::to_string(*choice.restarts) : std::string();
    for (const std::string& usual : valuesOf(results.record, "restarts"))
      if (!choice.restarts) restarts = usual;
    html += fmt::format("<h2>{}: {}</h2>\n<p>{} problems. Level: {}. {}.</p>\n", escaped(group.set),
                        entry.title, group.rows.at(group.solvers[0]).size(), entry.levels,
                        restarts == "0" ? "One attempt" : "Up to " + restarts + " random restarts");
    html += tableOf(summary["sets"][group.set], style, group.drag, group.meetable) +
            truthTable(summary["sets"][group.set]) + seedsTable(summary["sets"][group.set]) +
            pairsTable(summary["sets"][group.set]["pairs"]);
    if (!canPlot) continue;
    html += "<div class=\"plots\">\n";
    int sweeps = 0;
    const auto figure = [&](const std::string& name, const std::string& script, const std::string& caption,
                            int height = 0) {
      if (script.empty()) return;
      if (height == 0) height = std::max(380, 60 + 17 * static_cast<int>(group.solvers.size()));
      const std::string svg = plotSvg(script, 760, height);
      if (svg.empty()) {
        note +=
            (note.empty() ? "" : "; ") + ("gnuplot could not draw the plot '" + name + "' of " + group.set);
        return;
      }
      html += "<figure>" + svg + "<figcaption>" + caption + "</figcaption></figure>\n";
      writeFile(folder + "/plots/" + group.set + "-" + name + ".svg", svg + "\n");
    };
    figure("profile", profilePlot(group, style), "Performance profile (Dolan, Moré 2002) of the times.");
    figure("success", successPlot(group, style), "Share of problems solved within a time.");
    const std::string missing = withoutHistory(group, results);
    figure("residual-by-iteration", residualPlot(group, results, style, false),
           "Residual by iteration: median and quartiles of the traced problems." + missing);
    figure("residual-by-time", residualPlot(group, results, style, true),
           "Residual by time: median and quartiles of the traced problems." + missing);
    figure("hardness", hardnessPlot(group),
           "Share solved by the smallest singular value at the solution and the distance to the nearest "
           "limit (1: middle of every range), of the first six solvers that do the problems.",
           group.solvers.size() > 3 ? 500 : 300);
    figure(
        "displacement", displacementPlot(group, style),
        "Joint displacement of the solved problems against the minimal-change path (left is less motion).");
    for (const Sweep& sweep : sweepsOf(group)) {
      const std::string name = fmt::format("{}.{}", sweep.entry->name, sweep.parameter->name);
      const std::string rest = sweep.rest == sweep.entry->name ? "" : " of " + sweep.rest;
      figure("sweep-" + name + (rest.empty() ? "" : "-" + std::to_string(++sweeps)),
             sweepPlot(group, sweep, style),
             escaped(fmt::format(
                 "{}{}: {} Success (Wilson 95 %), time and iterations (median, quartiles); dotted: "
                 "the default, {:g}.",
                 name, rest, sweep.parameter->meaning, sweep.parameter->value)),
             640);
    }
    if (group.drag) figure("jitter", jitterPlot(group, style), "Jitter against lag, one point a drag speed.");
    html += "</div>\n";
  }
  html += methodsSection(results, style, summary) + "</body></html>\n";
  writeFile(folder + "/report.html", html);
  if (!canPlot) note = "gnuplot was not found: report.html has no plots (install the package gnuplot-nox)";
  return {.note = note, .table = summaryTable(summary)};
}

}  // namespace gelenk
