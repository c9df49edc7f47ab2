#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <utility>

#include "apps/commands/arm_path.h"
#include "apps/commands/arm_request.h"
#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/document/file_format.h"
#include "apps/document/model.h"
#include "apps/document/model_files.h"
#include "apps/document/notes.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/io/bvh.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "skinning/io/gltf.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/problem/judge.h"
#include "solvers/solutions/path_planner.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::VectorXd;

struct Request {
  std::string model = "panda", joint, path, out;
  std::vector<double> start;
  int keys = 0;
  double rate = 30.0;
  PathOptions options;
  bool compare = false;
};

/// Whoever wrote it meant a number, be it infinite or too large for one.
bool meansNumber(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error != std::errc::invalid_argument && end == word.data() + word.size();
}

/// Lines X Y Z QW QX QY QZ, between commas or blanks; a first line without any number is a heading, # a
/// comment.
std::vector<Isometry3d> readPoses(const std::string& path) {
  const std::string text = readFile(path);
  std::vector<Isometry3d> poses;
  int number = 0;
  bool first = true;
  for (const std::string_view line : splitLines(plainText(text, path))) {
    ++number;
    std::string words(line.substr(0, line.find('#')));
    std::replace(words.begin(), words.end(), ',', ' ');
    std::replace(words.begin(), words.end(), ';', ' ');
    const auto list = splitWords(words);
    if (list.empty()) continue;
    const bool heading = std::none_of(list.begin(), list.end(), meansNumber);
    if (std::exchange(first, false) && heading) continue;
    double v[7];
    if (list.size() != 7)
      throw ParseError(path, number, "X Y Z QW QX QY QZ", fmt::format("{} values", list.size()));
    for (int i = 0; i < 7; ++i) {
      const auto value = parseNumber(list[i]);
      if (!value) throw ParseError(path, number, "a finite number", badNumber(list[i]));
      v[i] = *value;
    }
    const Eigen::Quaterniond q(v[3], v[4], v[5], v[6]);
    if (!(std::abs(q.norm() - 1.0) < 1e-3))
      throw ParseError(path, number, "a quaternion of length 1", fmt::format("length {:.6g}", q.norm()));
    poses.push_back(Eigen::Translation3d(v[0], v[1], v[2]) * q.normalized());
  }
  if (poses.size() < 2) throw ParseError(path, 0, "two poses at least", fmt::format("{}", poses.size()));
  return poses;
}

VectorXd wholeConfiguration(const Skeleton& skeleton, const SerialChain& chain, const VectorXd& q,
                            VectorXd all) {
  for (int i = 0; i < chain.n; ++i) all[chain.qIndex[i]] = q[i];
  skeleton.couple(all);
  return all;
}

/// Farthest that the tip strays from the straight way between two poses, half-way between the joints' values.
struct Stray {
  double place = 0.0, angle = 0.0;
};
Stray stray(const SerialChain& chain, const PathPlan& plan, const std::vector<Isometry3d>& poses,
            double jump) {
  Stray most;
  for (size_t k = 0; k + 1 < plan.q.size(); ++k) {
    if ((plan.q[k + 1] - plan.q[k]).cwiseAbs().maxCoeff() > jump) continue;
    const Isometry3d tip = tipFrame(chain, 0.5 * (plan.q[k] + plan.q[k + 1])),
                     wanted = between(poses[k], poses[k + 1], 0.5);
    most.place = std::max(most.place, (tip.translation() - wanted.translation()).norm());
    most.angle = std::max(
        most.angle, Eigen::Quaterniond(tip.linear()).angularDistance(Eigen::Quaterniond(wanted.linear())));
  }
  return most;
}

bool isTable(const std::string& out) { return out.ends_with(".csv"); }

void demandWritable(const std::string& out) {
  if (out.empty() || isTable(out)) return;
  const auto kind = fileKind(out);
  if (!kind || !fileFormat(*kind).writeMotion)
    throw std::invalid_argument(
        fmt::format("'{}': the motion can be written as .csv, {}", out, motionEndings()));
}

void write(const Request& request, const Model& model, const SerialChain& chain, const PathPlan& plan) {
  const VectorXd rest = model.skeleton.rest();
  const std::string& out = request.out;
  if (isTable(out)) {
    std::string text = "pose";
    for (int i = 0; i < chain.n; ++i) text += fmt::format(",q{}", i + 1);
    text += "\n";
    for (size_t k = 0; k < plan.q.size(); ++k) {
      text += std::to_string(k);
      for (const double x : plan.q[k]) text += "," + exactNumber(x);
      text += "\n";
    }
    return writeFile(out, text);
  }
  MotionClip clip;
  clip.framesPerSecond = request.rate;
  clip.q.resize(model.skeleton.nq(), static_cast<Eigen::Index>(plan.q.size()));
  for (size_t k = 0; k < plan.q.size(); ++k)
    clip.q.col(static_cast<Eigen::Index>(k)) = wholeConfiguration(model.skeleton, chain, plan.q[k], rest);
  exportMotion(out, model.skeleton, model.skin ? &*model.skin : nullptr, model.name, clip);
}

/// Every solver of the catalogue from pose to pose, each started where it ended, from the plan's first pose.
void printGreedy(const Model& model, int joint, const SerialChain& chain, const PathPlan& plan,
                 const std::vector<Isometry3d>& poses, double jump) {
  fmt::print("{:<20} {:>7} {:>6} {:>10} {:>9}\n", "warm start", "solved", "jumps", "length", "ms");
  const auto line = [](std::string_view name, size_t solved, size_t jumps, double length, double ms) {
    fmt::print("{:<20} {:>7} {:>6} {:>10.4f} {:>9.2f}\n", name, solved, jumps, length, ms);
  };
  for (const SolverEntry& entry : solverCatalogue()) {
    const auto solver = entry.make();
    IkProblem problem{.skeleton = &model.skeleton,
                      .start = wholeConfiguration(model.skeleton, chain, plan.q[0], model.skeleton.rest())};
    problem.goals = {{.kind = GoalKind::Pose, .joint = joint}};
    if (!solver->whyUnsupported(problem).empty()) continue;
    solver->prepare(model.skeleton);
    size_t solved = 0, jumps = 0;
    double length = 0.0;
    const auto begin = std::chrono::steady_clock::now();
    for (size_t k = 0; k < poses.size(); ++k) {
      problem.goals[0].target = poses[k].translation();
      problem.goals[0].orientation = Eigen::Quaterniond(poses[k].linear());
      const IkReport report =
          solver->solve(problem, {.maxIterations = 200, .maxSeconds = 1e9, .restarts = 0}, TraceLevel::Off);
      solved += judge(problem, report.q).solved;
      const VectorXd step = report.q - problem.start;
      if (k > 0) {
        jumps += step.cwiseAbs().maxCoeff() > jump;
        length += step.norm();
      }
      problem.start = report.q;
    }
    const double ms = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() * 1e3;
    line(entry.name, solved, jumps, length, ms);
  }
}

/// True if the whole path can be followed without a jump.
bool run(const Request& request) {
  demandWritable(request.out);
  const Model model = openModel(request.model);
  sayNotes(request.model, model.notes);
  const int joint = effectorOf(model, request.joint);
  std::vector<Isometry3d> poses = readPoses(request.path);
  if (request.keys > 0) poses = splineThrough(poses, request.keys);
  const PathPlanner planner(model.skeleton, joint);
  const SerialChain& chain = planner.chain();
  VectorXd start;
  if (!request.start.empty()) {
    const VectorXd all = startConfiguration(request.start, model.skeleton, "--start");
    start.resize(chain.n);
    for (int i = 0; i < chain.n; ++i) start[i] = all[chain.qIndex[i]];
  }
  const auto begin = std::chrono::steady_clock::now();
  PathPlan plan;
  try {
    plan = planArmPath(planner, poses, request.options, request.start.empty() ? nullptr : &start);
  } catch (const NoPath& none) {
    fmt::print("{}\n", none.what());
    return false;
  }
  const double ms = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() * 1e3;
  fmt::print("{} poses, {} jump{}, length {:.4f} rad, largest step {:.4f} rad, {:.2f} ms\n", poses.size(),
             plan.jumps.size(), plan.jumps.size() == 1 ? "" : "s", plan.length, plan.largestStep, ms);
  for (const PathJump& jump : plan.jumps) {
    const std::string where =
        jump.pose < 0 ? "the start and pose 1" : fmt::format("poses {} and {}", jump.pose + 1, jump.pose + 2);
    fmt::print("  jump between {}: a joint turns by {:.4f} rad; {}\n", where, jump.turn, jump.reason);
  }
  const Stray most = stray(chain, plan, poses, request.options.jump);
  fmt::print("between the poses the tip strays by {:.3e} m and {:.3e} rad at most\n", most.place, most.angle);
  if (request.compare) printGreedy(model, joint, chain, plan, poses, request.options.jump);
  if (!request.out.empty()) write(request, model, chain, plan);
  return plan.jumps.empty();
}

}  // namespace

void addPathCommand(Command& app) {
  auto request = std::make_shared<Request>();
  Command command =
      app.command("path",
                  "Joint motion along poses of the tip with the fewest jumps, then the least motion; "
                  "exit status 2 where a jump cannot be avoided or a pose cannot be reached");
  command.option("--model", request->model, "Built-in model or file").showDefault();
  command.option("--path", request->path, "File of poses, a line each: X Y Z QW QX QY QZ, metres").required();
  command.option("--joint", request->joint, "Joint that follows the path; default: the model's only end");
  command.option("--keys", request->keys, "The file's poses are keys of a spline; take this many poses of it")
      .range(2, 1e6);
  command.option(
      "--start", request->start,
      "Configuration before the first pose, within limits; the way from there counts in length and jumps");
  command
      .option("--jump", request->options.jump, "A joint that turns farther between two poses jumps, radians")
      .positive()
      .showDefault();
  command
      .option("--slices", request->options.slices, "Seven joints: solutions looked at along each self-motion")
      .range(1, 1e5)
      .showDefault();
  command.option("-o,--out", request->out, "Write the motion: .csv, .bvh, .gltf or .glb");
  command.option("--fps", request->rate, "Poses a second in a motion file").frameRate().showDefault();
  command.flag("--compare", request->compare,
               "Also lets every solver follow the path, started where it ended");
  command.run([request] {
    if (!run(*request)) throw ExitStatus{2};
  });
}

}  // namespace gelenk
