#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "apps/commands/arm_request.h"
#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/document/model.h"
#include "apps/document/notes.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/io/text_file.h"
#include "solvers/problem/judge.h"
#include "solvers/serial/serial_pose.h"
#include "solvers/solutions/complete_set.h"
#include "solvers/solutions/self_motion.h"

namespace gelenk {
namespace {

using Eigen::VectorXd;
using json = nlohmann::ordered_json;

struct Request {
  std::string model = "ur5", joint, out;
  std::vector<double> target, near, axis;
  double step = SelfMotionOptions{}.step;
  bool limits = true, asJson = false;
};

std::vector<double> listOf(const VectorXd& q) { return {q.begin(), q.end()}; }

constexpr double singular = 1e-6;  ///< sigma_min below this is told

/// One solution with everything that is told of it.
struct Told {
  VectorXd q;  ///< of the arm's joints
  double position, orientation, distance;
  bool withinLimits;
  long images;
  std::string branch;
  Singularity singularity;
  unsigned free;
};

/// "joints 4, 6 move together along dq = (0, 0, 0, 0.707, 0, -0.707)", "joint 3 may stand anywhere"
std::string familyText(const Told& t) {
  std::vector<int> joints;
  for (int i = 0; i < t.q.size(); ++i)
    if (std::abs(t.singularity.direction[i]) > 1e-6) joints.push_back(i + 1);
  if (joints.size() == 1 && t.free != 0) return fmt::format("joint {} may stand anywhere", joints[0]);
  VectorXd d = t.singularity.direction;
  for (double& x : d)
    if (std::abs(x) < 5e-4) x = 0.0;
  return fmt::format("joints {} move together along dq = ({:.3f})", fmt::join(joints, ", "),
                     fmt::join(listOf(d), ", "));
}

std::vector<Told> tell(const CompleteSet& set, const ArmSolutions& found, const IkProblem& problem,
                       const VectorXd& near, bool limits) {
  std::vector<Told> list;
  const int n = set.joints();
  for (const ArmSolution& s : found.all()) {
    if (limits && !s.withinLimits) continue;
    Told t{.q = s.q.head(n), .withinLimits = s.withinLimits, .branch = branchName(s), .free = s.free};
    VectorXd all = problem.start;
    for (int i = 0; i < n; ++i) all[set.chain().qIndex[i]] = t.q[i];
    problem.skeleton->couple(all);
    const Judgement verdict = judge(problem, all);
    t.position = verdict.goals[0].position;
    t.orientation = verdict.goals[0].orientation;
    t.distance = (t.q - near).norm();
    t.singularity = set.singularity(t.q);
    t.images = 1;
    for (int i = 0; i < n; ++i)
      if (set.chain().constants.revolute[i] > 0.5)
        t.images *= imageCount(t.q[i], set.chain().lower[i], set.chain().upper[i]);
    list.push_back(t);
  }
  std::stable_sort(list.begin(), list.end(),
                   [](const Told& a, const Told& b) { return a.distance < b.distance; });
  return list;
}

json toJson(const Told& t) {
  json out{{"q", listOf(t.q)},
           {"position_error", t.position},
           {"orientation_error", t.orientation},
           {"distance", t.distance},
           {"within_limits", t.withinLimits},
           {"images_within_limits", t.images},
           {"sigma_min", t.singularity.sigmaMin}};
  if (!t.branch.empty()) out["branch"] = t.branch;
  if (t.singularity.sigmaMin < singular) {
    out["singular"] = true;
    out["family"] = t.free != 0;
    out["direction"] = listOf(t.singularity.direction);
  }
  return out;
}

/// The pose nearest to one that cannot be reached, by the default solver.
SerialPoseAnswer closestPose(const SerialChain& chain, const Goal& goal, const VectorXd& near) {
  return SerialPoseSolver(chain).solve(
      {.kind = goal.kind, .target = goal.target, .orientation = goal.orientation.toRotationMatrix()},
      near.cwiseMax(chain.lower).cwiseMin(chain.upper), {.restarts = 400, .maxSeconds = 1e9});
}

json toJson(const SerialPoseAnswer& closest) {
  return {{"q", listOf(closest.q)},
          {"position_error", closest.positionError},
          {"orientation_error", closest.orientationError}};
}
void print(const SerialPoseAnswer& closest) {
  fmt::print("closest: q = ({:.6f}), {:.6f} m and {:.6f} rad away\n", fmt::join(listOf(closest.q), ", "),
             closest.positionError, closest.orientationError);
}

/// The curves as a table: a line for each pose, in their order.
void writeCurves(const std::string& path, const std::vector<SelfMotionCurve>& curves) {
  std::string text = "curve,arc_length,q1,q2,q3,q4,q5,q6,q7\n";
  for (size_t c = 0; c < curves.size(); ++c)
    for (size_t k = 0; k < curves[c].q.size(); ++k) {
      text += fmt::format("{},{}", c + 1, exactNumber(curves[c].arcLength[k]));
      for (const double x : curves[c].q[k]) text += "," + exactNumber(x);
      text += "\n";
    }
  writeFile(path, text);
}

/// Seven joints for a pose: the self-motion, curve by curve. True if there is a solution.
bool runSevenJoints(const Request& request, const Model& model, const SerialChain& chain, const Goal& goal) {
  const SevenJointArm arm(chain);
  const VectorXd start = startConfiguration(request.near, model.skeleton, "--near");
  Vector7d near;
  for (int i = 0; i < 7; ++i) near[i] = start[chain.qIndex[i]];
  const Eigen::Isometry3d target = Eigen::Translation3d(goal.target) * goal.orientation;
  const SelfMotionOptions options{.limits = request.limits, .step = request.step};
  std::vector<SelfMotionCurve> curves = arm.selfMotion(target, options);
  struct Place {
    size_t pose = 0;
    double distance = INFINITY;
  };
  const auto nearestOf = [&](const SelfMotionCurve& curve) {
    Place place;
    for (size_t k = 0; k < curve.q.size(); ++k)
      if (const double d = (curve.q[k] - near).norm(); d < place.distance) place = {k, d};
    return place;
  };
  std::stable_sort(curves.begin(), curves.end(), [&](const SelfMotionCurve& a, const SelfMotionCurve& b) {
    return nearestOf(a).distance < nearestOf(b).distance;
  });
  if (!request.out.empty()) writeCurves(request.out, curves);
  Vector7d best;
  const bool reachable = arm.nearest(target, near, best, options);
  std::optional<SerialPoseAnswer> closest;
  if (!reachable) closest = closestPose(chain, goal, near);
  double position = 0.0, orientation = 0.0;
  if (reachable) {
    VectorXd all = start;
    for (int i = 0; i < 7; ++i) all[chain.qIndex[i]] = best[i];
    model.skeleton.couple(all);
    const Judgement verdict = judge({.skeleton = &model.skeleton, .start = start, .goals = {goal}}, all);
    position = verdict.goals[0].position, orientation = verdict.goals[0].orientation;
  }
  if (request.asJson) {
    json out{{"model", model.name},     {"joint", model.skeleton.joint(goal.joint).name},
             {"class", arm.describe()}, {"limits", request.limits},
             {"reachable", reachable},  {"curves", json::array()}};
    if (reachable)
      out["nearest"] = {{"q", listOf(best)},
                        {"distance", (best - near).norm()},
                        {"position_error", position},
                        {"orientation_error", orientation}};
    for (const SelfMotionCurve& curve : curves) {
      json poses = json::array();
      for (const Vector7d& q : curve.q) poses.push_back(listOf(q));
      out["curves"].push_back({{"closed", curve.closed},
                               {"length", curve.length()},
                               {"arc_length", curve.arcLength},
                               {"q", poses}});
    }
    if (closest) out["closest"] = toJson(*closest);
    out["notes"] = asJson(model.notes);
    fmt::print("{}\n", out.dump(2));
    return reachable;
  }
  fmt::print("{}, tip {}: {}\n", model.name, model.skeleton.joint(goal.joint).name, arm.describe());
  fmt::print("{} curve{} of solutions{}\n", curves.size(), curves.size() == 1 ? "" : "s",
             request.limits ? " within limits" : "");
  if (reachable)
    fmt::print("nearest: q = ({:.6f})\n    error {:.1e} m, {:.1e} rad; distance {:.4f}\n",
               fmt::join(listOf(best), ", "), position, orientation, (best - near).norm());
  int number = 0;
  for (const SelfMotionCurve& curve : curves) {
    const Place place = nearestOf(curve);
    fmt::print("{:2}  {}, {:.4f} rad long, {} poses; its nearest at {:.4f} rad, distance {:.4f}\n", ++number,
               curve.closed ? "closed" : "from limit to limit", curve.length(), curve.q.size(),
               curve.arcLength[place.pose], place.distance);
    fmt::print("    from q = ({:.6f})\n      to q = ({:.6f})\n", fmt::join(listOf(curve.q.front()), ", "),
               fmt::join(listOf(curve.q.back()), ", "));
  }
  if (!reachable) fmt::print("not reachable{}\n", request.limits ? " within limits" : "");
  if (closest) print(*closest);
  return reachable;
}

/// True if there is a solution.
bool run(const Request& request) {
  const Model model = openModel(request.model);
  if (request.asJson)
    demandNoNotes(request.model, model.notes);
  else
    sayNotes(request.model, model.notes);
  const int joint = effectorOf(model, request.joint);
  Goal goal = targetGoal(request.target, joint);
  const SerialChainResult serial = extractSerialChain(model.skeleton, joint);
  if (serial.whyNot.empty() && serial.chain.n == 7 && !serial.chain.hasPrismatic &&
      goal.kind == GoalKind::Pose && request.axis.empty())
    return runSevenJoints(request, model, serial.chain, goal);
  if (!request.out.empty())
    throw std::invalid_argument("-o writes the curves of an arm of seven joints that shall reach a pose");
  CompleteSetTask task{.task = goal.kind == GoalKind::Pose ? TipTask::Pose : TipTask::Position};
  if (!request.axis.empty()) {
    if (goal.kind != GoalKind::Pose)
      throw std::invalid_argument(
          "--axis needs a target with an orientation, which tells where the axis points");
    task.task = TipTask::Axis;
    task.axisInTip = Eigen::Vector3d::Map(request.axis.data());
    if (!(task.axisInTip.norm() > 1e-9)) throw std::invalid_argument("--axis must not be zero");
    task.axisInTip.normalize();
  }
  const CompleteSet set(model.skeleton, joint, task);
  const int n = set.joints();
  const VectorXd start = startConfiguration(request.near, model.skeleton, "--near");
  Vector6d reference = Vector6d::Zero();
  for (int i = 0; i < n; ++i) reference[i] = start[set.chain().qIndex[i]];
  const VectorXd near = reference.head(n);
  const Eigen::Isometry3d target = Eigen::Translation3d(goal.target) * goal.orientation;
  ArmSolutions found;
  set.solve(target, reference, found);
  if (task.task == TipTask::Axis) goal.kind = GoalKind::Position;
  const IkProblem problem{.skeleton = &model.skeleton, .start = start, .goals = {goal}};
  const std::vector<Told> list = tell(set, found, problem, near, request.limits);
  const int outside = found.count - static_cast<int>(list.size());
  std::optional<SerialPoseAnswer> closest;
  if (list.empty() && task.task != TipTask::Axis) closest = closestPose(set.chain(), goal, near);
  if (request.asJson) {
    json out{{"model", model.name},           {"joint", model.skeleton.joint(joint).name},
             {"class", set.arm().describe()}, {"complete", found.complete},
             {"count", list.size()},          {"outside_limits", outside},
             {"solutions", json::array()}};
    for (const Told& t : list) out["solutions"].push_back(toJson(t));
    if (list.empty()) out["reachable"] = false;
    if (closest) out["closest"] = toJson(*closest);
    out["notes"] = asJson(model.notes);
    fmt::print("{}\n", out.dump(2));
    return !list.empty();
  }
  fmt::print("{}, tip {}: {}\n", model.name, model.skeleton.joint(joint).name, set.arm().describe());
  const bool hasFamilies = std::any_of(list.begin(), list.end(), [](const Told& t) { return t.free != 0; });
  if (!found.complete)
    fmt::print("the set may lack members: {}\n",
               hasFamilies ? "there are curves of solutions, and a member of some is told"
                           : "the elimination was ill-conditioned here");
  fmt::print("{} solution{}{}\n", list.size(), list.size() == 1 ? "" : "s",
             request.limits ? fmt::format(" within limits, {} outside", outside) : "");
  int number = 0;
  for (const Told& t : list) {
    fmt::print("{:2}  q = ({:.6f})\n", ++number, fmt::join(listOf(t.q), ", "));
    fmt::print("    error {:.1e} m, {:.1e} rad; distance {:.4f}; {}{}\n", t.position, t.orientation,
               t.distance,
               t.withinLimits ? fmt::format("within limits, {} image{}", t.images, t.images == 1 ? "" : "s")
                              : "outside the limits",
               t.branch.empty() ? "" : "; " + t.branch);
    if (t.singularity.sigmaMin < singular)
      fmt::print("    singular: {}{}\n", t.free ? "one of a family; " : "branches merge here; ",
                 familyText(t));
  }
  if (list.empty() && outside > 0) fmt::print("not reachable within limits\n");
  if (list.empty() && outside == 0) fmt::print("not reachable\n");
  if (closest) print(*closest);
  return !list.empty();
}

}  // namespace

void addSolutionsCommand(Command& app) {
  auto request = std::make_shared<Request>();
  Command command = app.command(
      "solutions",
      "Every joint configuration of an arm that reaches a pose, for seven joints every curve of them; exit "
      "status 2 if there is none");
  command.option("--model", request->model, "Built-in model or file").showDefault();
  command
      .option("--target", request->target,
              "X Y Z [QW QX QY QZ]: metres and a unit quaternion, world frame; without the quaternion the "
              "place alone")
      .required();
  command
      .option("--axis", request->axis,
              "X Y Z of the tip: only this axis must point as the target's orientation says (five joints)")
      .count(3);
  command.option("--joint", request->joint,
                 "Joint that shall reach the target; default: the model's only end");
  command.option(
      "--near", request->near,
      "Configuration that solutions are ordered by, and that free joints keep; default: the rest pose");
  command.option("--step", request->step, "Seven joints: radians of all joints between neighbours on a curve")
      .positive()
      .showDefault();
  command.option("-o,--out", request->out, "Seven joints: write the curves as a table, .csv");
  command.flag("--limits,!--no-limits", request->limits, "Only solutions within the joint limits (default)");
  command.flag("--json", request->asJson, "Print JSON");
  command.run([request] {
    if (!run(*request)) throw ExitStatus{2};
  });
}

}  // namespace gelenk
