// The drag solver on the built-in figure: five goals (both hands, head, two planted feet). `drag_benchmark
// --marks` prints the table of docs/solvers/drag.md instead of timing one thing after the other,
// `--balanced-marks` the one of docs/goals.md.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstring>

#include "solvers/problem/judge.h"
#include "solvers/tree/drag_solver.h"
#include "tests/solvers/tree/drag_marks.h"

namespace gelenk {
namespace {

using marks::Figure;
using marks::Path;
using marks::quantile;
using marks::Shown;

enum class Kind { Reachable, Unreachable, Held };

/// One frame an iteration, along a path that begins anew at its end.
void DragFrame(benchmark::State& state, Kind kind, double step, bool balanced = false) {
  const Figure figure;
  std::mt19937_64 random(1);
  const Path path = kind == Kind::Unreachable
                        ? marks::wildPath(figure, random, 2000, step)
                        : marks::reachablePath(figure, random, kind == Kind::Held ? 100 : 2000, step);
  DragOptions options;
  if (balanced) options.balance = marks::balanceOf(figure);
  DragSolver solver(figure.skeleton, options);
  std::vector<Goal> goals = figure.goals();
  if (kind == Kind::Held) {
    marks::follow(figure, solver, path, step);
    figure.setTargets(goals, path.back());
    for (int i = 0; i < 100; ++i) solver.frame(goals);
  }
  std::vector<double> seconds;
  seconds.reserve(1 << 20);
  std::size_t at = 0;
  for (auto _ : state) {
    if (kind != Kind::Held) {
      if (at == path.size()) {
        at = 0;
        solver.reset(figure.start);
      }
      figure.setTargets(goals, path[at++]);
    }
    const IkReport& report = solver.frame(goals);
    seconds.push_back(report.seconds);
    benchmark::DoNotOptimize(report.q.data());
  }
  state.counters["p50_us"] = 1e6 * quantile(seconds, 0.5);
  state.counters["p99_us"] = 1e6 * quantile(seconds, 0.99);
}
BENCHMARK_CAPTURE(DragFrame, reachable_1cm, Kind::Reachable, 0.01)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(DragFrame, reachable_5cm, Kind::Reachable, 0.05)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(DragFrame, unreachable_1cm, Kind::Unreachable, 0.01)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(DragFrame, unreachable_5cm, Kind::Unreachable, 0.05)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(DragFrame, held, Kind::Held, 0.01)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(DragFrame, balanced_reachable_5cm, Kind::Reachable, 0.05, true)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(DragFrame, balanced_unreachable_5cm, Kind::Unreachable, 0.05, true)
    ->Unit(benchmark::kMicrosecond);

std::vector<IkProblem> coldProblems(const Figure& figure, int count, bool wholeRange) {
  std::mt19937_64 random(1);
  std::vector<IkProblem> problems;
  for (int i = 0; i < count; ++i) {
    Eigen::VectorXd pose = marks::halfRangePose(figure.skeleton, random);
    if (wholeRange) {
      pose = randomWithinLimits(figure.skeleton, random);
      pose.head<3>().setZero();
    }
    const Frames frames = forwardKinematics(figure.skeleton, pose);
    IkProblem problem{.skeleton = &figure.skeleton,
                      .start = figure.skeleton.rest(),
                      .goals = {},
                      .positionTolerance = 1e-3};
    for (const int joint : {figure.hands[0], figure.hands[1], figure.head, figure.feet[0], figure.feet[1]})
      problem.goals.push_back({.joint = joint, .target = frames[joint].translation()});
    problems.push_back(problem);
  }
  return problems;
}

void ColdSolve(benchmark::State& state, bool wholeRange) {
  const Figure figure;
  const auto problems = coldProblems(figure, 1000, wholeRange);
  const auto cold = makeDrag();
  std::vector<double> seconds;
  std::size_t at = 0, solved = 0;
  for (auto _ : state) {
    const IkProblem& problem = problems[at++ % problems.size()];
    const IkReport report = cold->solve(problem, {.restarts = 30}, TraceLevel::Off);
    seconds.push_back(report.seconds);
    solved += report.why == Stop::Converged;
  }
  state.counters["solved"] = static_cast<double>(solved) / static_cast<double>(at);
  state.counters["p50_us"] = 1e6 * quantile(seconds, 0.5);
  state.counters["p95_us"] = 1e6 * quantile(seconds, 0.95);
}
BENCHMARK_CAPTURE(ColdSolve, half_range, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(ColdSolve, whole_range, true)->Unit(benchmark::kMicrosecond);

// ---- the table
// ----------------------------------------------------------------------------------------------------

void row(const char* name, const Shown& s) {
  std::printf("%-20s %7.3f %8.3f %9.3f %8.3f %7.2f  %8.1e %5d %6.2f %7.1f %7.1f %6.1f%% %7.1f\n", name,
              1e3 * quantile(s.errors, 0.5), 1e3 * quantile(s.errors, 0.99), 1e3 * s.worstPin,
              s.worstRotation, s.worstJump, s.worstViolation, s.notFinite,
              static_cast<double>(s.iterations) / static_cast<double>(s.seconds.size()),
              1e6 * quantile(s.seconds, 0.5), 1e6 * quantile(s.seconds, 0.99),
              100.0 * s.outside / static_cast<double>(s.seconds.size()), 1e3 * s.worstTipping);
}

void printMarks(unsigned long long seed, bool balanced) {
  constexpr int paths = 10, frames = 1000;
  const Figure figure;
  DragOptions options;
  if (balanced) options.balance = marks::balanceOf(figure);
  DragSolver solver(figure.skeleton, options);
  std::mt19937_64 random(seed);
  if (balanced) std::printf("with balance; tipped: share of frames and most mm outside the soles\n");
  std::printf("%d frames a row, seed %llu; errors and pins in mm, joints in radians a frame\n",
              paths * frames, seed);
  std::printf("%-20s %7s %8s %9s %8s %7s  %8s %5s %6s %7s %7s %7s %7s\n", "drag", "p50", "p99", "pin max",
              "rot max", "jump", "limits", "NaN", "steps", "us p50", "us p99", "tipped", "most");
  for (const bool reachable : {true, false})
    for (const double step : {0.01, 0.05}) {
      Shown all, held;
      double after25 = 0.0, after200 = 0.0;
      int moving25 = 0;
      for (int i = 0; i < paths; ++i) {
        const Path path = reachable ? marks::reachablePath(figure, random, frames, step)
                                    : marks::wildPath(figure, random, frames, step);
        solver.reset(figure.start);
        all.add(marks::follow(figure, solver, path, step));
        marks::follow(figure, solver, Path(25, path.back()), 0.0);
        const double rotation = marks::follow(figure, solver, Path(175, path.back()), 0.0).worstRotation;
        moving25 += rotation > 1e-4;
        after25 = std::max(after25, rotation);
        const Shown end = marks::follow(figure, solver, Path(50, path.back()), 0.0);
        after200 = std::max(after200, end.worstRotation);
        held.add(end);
      }
      char name[40];
      std::snprintf(name, sizeof name, "%s %.0f cm", reachable ? "reachable" : "unreachable", 100.0 * step);
      row(name, all);
      row("  then held", held);
      std::printf(
          "  held: largest rotation a frame after 25 frames %.1e (above 1e-4 on %d of %d), after 200 %.1e; "
          "largest error %.1e m\n",
          after25, moving25, paths, after200, quantile(held.errors, 1.0));
    }

  if (balanced) return;
  double worst = 0.0;
  for (int i = 0; i < paths; ++i) {
    solver.reset(figure.start);
    Path path = marks::reachablePath(figure, random, 100, 0.02);
    marks::follow(figure, solver, Path(120, path.front()), 0.0);
    const Eigen::VectorXd begin = solver.q();
    marks::follow(figure, solver, path, 0.02);
    std::reverse(path.begin(), path.end());
    marks::follow(figure, solver, path, 0.02);
    marks::follow(figure, solver, Path(120, path.back()), 0.0);
    worst = std::max(worst, figure.largestRotation(begin, solver.q()));
  }
  std::printf("out and back: poses at most %.1e rad apart in any joint\n", worst);

  for (const bool wholeRange : {false, true})
    for (const int restarts : {0, 30}) {
      const auto cold = makeDrag();
      std::vector<double> seconds;
      int solved = 0;
      for (const IkProblem& problem : coldProblems(figure, 1000, wholeRange)) {
        const IkReport report = cold->solve(problem, {.restarts = restarts}, TraceLevel::Off);
        seconds.push_back(report.seconds);
        solved += judge(problem, report.q).solved;
      }
      std::printf(
          "cold, 5 goals to 1 mm, targets of poses over %s range, %2d restarts: %d of 1000, us p50 %.1f p95 "
          "%.1f\n",
          wholeRange ? "the whole" : "half the ", restarts, solved, 1e6 * quantile(seconds, 0.5),
          1e6 * quantile(seconds, 0.95));
    }
}

}  // namespace
}  // namespace gelenk

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i)
    if (std::strcmp(argv[i], "--marks") == 0 || std::strcmp(argv[i], "--balanced-marks") == 0) {
      gelenk::printMarks(i + 1 < argc ? std::strtoull(argv[i + 1], nullptr, 10) : 2024,
                         std::strcmp(argv[i], "--balanced-marks") == 0);
      return 0;
    }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
