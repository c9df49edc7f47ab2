// The closed form of two_link.h on the joints of a skeleton.

#include <algorithm>
#include <cmath>
#include <optional>

#include "kinematics/configuration.h"
#include "kinematics/notation/euler.h"
#include "kinematics/rotation.h"
#include "solvers/iteration/attempt.h"
#include "solvers/methods/two_link.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// An elbow or a knee: it turns about its first axis; axes after that one (the forearm's twist) are held.
bool isHinge(const Joint& joint) {
  if (joint.ball || joint.axes.empty() || joint.axes[0].kind != AxisDof::Kind::Rotation) return false;
  return joint.axes.size() == 1 || joint.axes[0].upper - joint.axes[0].lower > 1.5;
}

/// The first axis of the joint in the world.
Vector3d hingeAxis(const Skeleton& skeleton, const Frames& frames, int i) {
  const Joint& joint = skeleton.joint(i);
  const Vector3d inParent = joint.parentFromZero.linear() * joint.axes[0].axis;
  return joint.parent < 0 ? inParent : Vector3d(frames[joint.parent].linear() * inParent);
}

/// Three rotations about coordinate axes: the Euler order, where that is one.
std::optional<EulerOrder> eulerOrderOf(const Joint& joint) {
  if (joint.ball || joint.axes.size() != 3) return std::nullopt;
  std::string name;
  for (const AxisDof& dof : joint.axes)
    for (int k = 0; k < 3; ++k)
      if (dof.kind == AxisDof::Kind::Rotation && dof.axis == Vector3d::Unit(k)) name += "xyz"[k];
  return findEulerOrder(name);
}

bool canAim(const Joint& joint) {
  return (joint.ball && joint.axes.empty()) || eulerOrderOf(joint).has_value();
}

/// Shoulder, elbow and the point that is led to the target.
struct Chain {
  int shoulder = -1, elbow = -1;
  bool inPlane = false;    ///< the shoulder is a hinge parallel to the elbow's
  bool turnsHand = false;  ///< a pose goal: its ball joint is turned last, so the joint's origin is led
};

/// The joint nearest above the elbow that can aim it; in the plane a hinge parallel to the elbow's.
std::optional<Chain> shoulderAbove(const Skeleton& skeleton, const Frames& frames, Chain chain) {
  const bool hinge = isHinge(skeleton.joint(chain.elbow));
  for (int i = skeleton.parent(chain.elbow); i >= 0; i = skeleton.parent(i)) {
    const Joint& joint = skeleton.joint(i);
    if (skeleton.isCoupled(i)) continue;
    chain.shoulder = i;
    if (canAim(joint)) return chain;
    chain.inPlane =
        hinge && joint.axes.size() == 1 && isHinge(joint) &&
        std::abs(hingeAxis(skeleton, frames, i).dot(hingeAxis(skeleton, frames, chain.elbow))) > 1.0 - 1e-9;
    if (chain.inPlane) return chain;
  }
  return std::nullopt;
}

/// Of all pairs above the goal the one whose shorter link is longest: the arm rather than the finger. Hinges
/// come before balls.
std::optional<Chain> chainAbove(const Skeleton& skeleton, const Goal& goal, const Frames& frames) {
  const bool turnsHand = goal.kind == GoalKind::Pose;
  const Joint& hand = skeleton.joint(goal.joint);
  if (turnsHand && (!hand.ball || !hand.axes.empty())) return std::nullopt;
  const Vector3d end =
      turnsHand ? frames[goal.joint].translation() : Vector3d(frames[goal.joint] * goal.pointInJoint);
  for (const bool balls : {false, true}) {
    std::optional<Chain> best;
    double longest = 1e-9;
    for (int i = turnsHand ? hand.parent : goal.joint; i >= 0; i = skeleton.parent(i)) {
      const Joint& joint = skeleton.joint(i);
      if (skeleton.isCoupled(i)) continue;  // it does not turn alone
      if (balls ? !joint.ball || !joint.axes.empty() : !isHinge(joint)) continue;
      const std::optional<Chain> chain =
          shoulderAbove(skeleton, frames, {.elbow = i, .turnsHand = turnsHand});
      if (!chain) continue;
      const Vector3d elbow = frames[i].translation();
      const double shorter =
          std::min((end - elbow).norm(), (elbow - frames[chain->shoulder].translation()).norm());
      if (shorter <= longest * (1.0 + 1e-9)) continue;
      longest = shorter;
      best = chain;
    }
    if (best) return best;
  }
  return std::nullopt;
}

const Goal* poleOf(const IkProblem& problem, int elbow) {
  for (const Goal& goal : problem.goals)
    if (goal.kind == GoalKind::Pole && goal.joint == elbow) return &goal;
  return nullptr;
}

/// The angle within limits at which the end is `distance` away from the shoulder, nearest to `now`; where
/// there is none, the one that comes nearest to it. distance^2(theta) = K - 2 (A cos theta + B sin theta),
/// from arm vectors in a frame whose z is the hinge: the law of cosines for any position of the points along
/// the hinge.
double elbowAngle(const Vector3d& shoulderInHinge, const Vector3d& endInHinge, double distance, double now,
                  double lower, double upper) {
  const Vector3d& p = shoulderInHinge;
  const Vector3d& c = endInHinge;
  const double A = p.x() * c.x() + p.y() * c.y(), B = p.y() * c.x() - p.x() * c.y();
  const double along = p.z() - c.z();
  const double K = p.head<2>().squaredNorm() + c.head<2>().squaredNorm() + along * along;
  const double size = std::hypot(A, B);
  if (size == 0.0) return now;
  const double cosine = std::clamp((K - distance * distance) / (2.0 * size), -1.0, 1.0);
  const double middle = std::atan2(B, A),
               spread = std::atan2(std::sqrt((1.0 - cosine) * (1.0 + cosine)), cosine);
  const auto error = [&](double theta) {
    return std::abs(std::sqrt(std::max(0.0, K - 2.0 * (A * std::cos(theta) + B * std::sin(theta)))) -
                    distance);
  };
  std::vector<double> candidates{std::clamp(now, lower, upper)};
  for (const double limit : {lower, upper})
    if (std::isfinite(limit)) candidates.push_back(limit);
  for (const double root : {middle + spread, middle - spread}) {
    const double nearest = root + 2.0 * M_PI * std::round((now - root) / (2.0 * M_PI));
    for (const double theta : {nearest - 2.0 * M_PI, nearest, nearest + 2.0 * M_PI})
      if (theta >= lower && theta <= upper) candidates.push_back(theta);
  }
  double smallest = unlimited, best = now;
  for (const double theta : candidates) smallest = std::min(smallest, error(theta));
  const double same = 1e-12 * std::sqrt(K);
  double change = unlimited;
  for (const double theta : candidates)
    if (error(theta) <= smallest + same && std::abs(theta - now) < change) {
      best = theta;
      change = std::abs(theta - now);
    }
  return best;
}

class TwoLinkSolver final : public IkSolver {
 public:
  std::string whyUnsupported(const IkProblem& problem) const override {
    const Skeleton& skeleton = *problem.skeleton;
    const Frames frames = forwardKinematics(skeleton, problem.start);
    std::vector<int> used;
    bool any = false;
    for (const Goal& goal : problem.goals) {
      if (goal.kind == GoalKind::Pole || goal.kind == GoalKind::Posture) continue;
      const std::string name = goal.name.empty() ? skeleton.joint(goal.joint).name : goal.name;
      if (goal.kind != GoalKind::Position && goal.kind != GoalKind::Pose)
        return "the two-link closed form serves positions and poses; '" + name + "' asks for something else";
      const std::optional<Chain> chain = chainAbove(skeleton, goal, frames);
      if (!chain) return "above '" + name + "' there is no joint that bends below one that aims";
      for (const int joint : {chain->shoulder, chain->elbow}) {
        if (std::find(used.begin(), used.end(), joint) != used.end())
          return "two goals share the joint '" + skeleton.joint(joint).name + "'";
        used.push_back(joint);
      }
      any = true;
    }
    return any ? std::string() : "there is no position to reach";
  }

  IkReport solve(const IkProblem& problem, const Budget&, TraceLevel trace) const override {
    CountedEvaluator at(problem);
    IkReport report;
    report.q = problem.start;
    if (!whyUnsupported(problem).empty()) {
      report.why = Stop::Unsupported;
      at.moveTo(problem.start);
      report.residual = at.residual().norm();
      return report;
    }
    VectorXd first = projectToLimits(*problem.skeleton, problem.start);
    MovingJoints(problem).restore(first);
    at.moveTo(first);
    if (trace != TraceLevel::Off)
      report.trace.push_back(
          {.q = trace == TraceLevel::Full ? at.q() : VectorXd(), .residual = at.residual().norm()});
    for (const Goal* goal : fromTheRoot(problem, at.frames())) bend(at, *goal);
    at.counters().iterations = 1;
    VectorXd bent = at.q();  // moving on the manifold makes every ball's quaternion unit again
    MovingJoints(problem).restore(bent);
    at.moveTo(bent);
    report.q = at.q();
    report.residual = at.residual().norm();
    report.why = !report.q.allFinite()  ? Stop::Failure
                 : at.withinTolerance() ? Stop::Converged
                                        : whyAtRest(problem, at.q());
    if (report.why == Stop::Failure) report.q = problem.start;
    report.counters = at.counters();
    report.seconds = at.seconds();
    if (!report.trace.empty())
      report.trace[0].stepNorm = difference(*problem.skeleton, problem.start, report.q).norm();
    return report;
  }

 private:
  /// Goals whose shoulders come first are served first: they carry the others along.
  static std::vector<const Goal*> fromTheRoot(const IkProblem& problem, const Frames& frames) {
    std::vector<std::pair<int, const Goal*>> order;
    for (const Goal& goal : problem.goals)
      if (goal.kind == GoalKind::Position || goal.kind == GoalKind::Pose)
        order.emplace_back(chainAbove(*problem.skeleton, goal, frames)->shoulder, &goal);
    std::stable_sort(order.begin(), order.end(),
                     [](const auto& x, const auto& y) { return x.first < y.first; });
    std::vector<const Goal*> goals;
    for (const auto& [shoulder, goal] : order) goals.push_back(goal);
    return goals;
  }

  static void bend(CountedEvaluator& at, const Goal& goal) {
    const Skeleton& skeleton = at.skeleton();
    const std::optional<Chain> chain = chainAbove(skeleton, goal, at.frames());
    if (!chain) return;
    const Vector3d pointInJoint = chain->turnsHand ? Vector3d(Vector3d::Zero()) : goal.pointInJoint;
    const Vector3d target =
        chain->turnsHand ? Vector3d(goal.target - goal.orientation * goal.pointInJoint) : goal.target;
    const auto end = [&] { return Vector3d(at.frames()[goal.joint] * pointInJoint); };
    const double step = (target - end()).norm();
    bendElbow(at, *chain, end(), target);
    aimShoulder(at, *chain, end(), target);
    if (const Goal* pole = poleOf(at.problem(), chain->elbow); pole && !chain->inPlane)
      swivel(at, *chain, end(), pole->target, step);
    if (chain->turnsHand) turnHand(at, goal);
  }

  /// Brings the end to the target's distance from the shoulder.
  static void bendElbow(CountedEvaluator& at, const Chain& chain, const Vector3d& end,
                        const Vector3d& target) {
    const Skeleton& skeleton = at.skeleton();
    const Joint& joint = skeleton.joint(chain.elbow);
    const Isometry3d& elbow = at.frames()[chain.elbow];
    const Vector3d shoulder = at.frames()[chain.shoulder].translation();
    double distance = (target - shoulder).norm();
    VectorXd q = at.q();
    const int index = skeleton.qIndex(chain.elbow);
    if (isHinge(joint)) {
      const Vector3d axis = hingeAxis(skeleton, at.frames(), chain.elbow);
      if (chain.inPlane) distance = (target - shoulder - axis * axis.dot(target - shoulder)).norm();
      const Quaterniond upright = rotationBetween(axis, Vector3d::UnitZ());
      Vector3d p = upright * (shoulder - elbow.translation()), c = upright * (end - elbow.translation());
      if (chain.inPlane) p.z() = c.z() = 0.0;
      // c as it would lie at angle 0
      const Vector3d atZero = Eigen::AngleAxisd(-q[index], Vector3d::UnitZ()) * c;
      q[index] = elbowAngle(p, atZero, distance, q[index], joint.axes[0].lower, joint.axes[0].upper);
    } else {  // a ball bends about the normal of its present plane, or towards its pole
      const Vector3d p = shoulder - elbow.translation(), c = end - elbow.translation();
      Vector3d axis = p.cross(c);
      if (axis.norm() < 1e-9 * p.norm() * c.norm()) {
        const Goal* pole = poleOf(at.problem(), chain.elbow);
        if (pole) axis = (pole->target - shoulder).cross(c);
        if (axis.norm() < 1e-9 * p.norm() * c.norm()) axis = c.unitOrthogonal();
      }
      axis.normalize();
      const Quaterniond upright = rotationBetween(axis, Vector3d::UnitZ());
      const double angle = elbowAngle(upright * p, upright * c, distance, 0.0, -unlimited, unlimited);
      const Vector3d axisInJoint = elbow.linear().transpose() * axis;
      setBallRotation(
          skeleton, q, chain.elbow,
          (ballRotation(skeleton, q, chain.elbow) * expRotation(angle * axisInJoint)).normalized());
      q = projectToLimits(skeleton, q);
    }
    at.moveTo(q);
  }

  /// Turns the shoulder by the smallest rotation that points the end at the target.
  static void aimShoulder(CountedEvaluator& at, const Chain& chain, const Vector3d& end,
                          const Vector3d& target) {
    const Isometry3d& frame = at.frames()[chain.shoulder];
    Vector3d from = end - frame.translation(), to = target - frame.translation();
    if (chain.inPlane) {
      const Skeleton& skeleton = at.skeleton();
      const AxisDof& dof = skeleton.joint(chain.shoulder).axes[0];
      const Vector3d axis = frame.linear() * dof.axis;
      from -= axis * axis.dot(from);
      to -= axis * axis.dot(to);
      if (from.norm() == 0.0 || to.norm() == 0.0) return;
      VectorXd q = at.q();
      double& angle = q[skeleton.qIndex(chain.shoulder)];
      angle += std::atan2(from.cross(to).dot(axis), from.dot(to));
      if (angle > dof.upper && angle - 2.0 * M_PI >= dof.lower) angle -= 2.0 * M_PI;
      if (angle < dof.lower && angle + 2.0 * M_PI <= dof.upper) angle += 2.0 * M_PI;
      at.moveTo(projectToLimits(skeleton, q));
      return;
    }
    if (from.norm() == 0.0 || to.norm() == 0.0) return;
    turnShoulder(at, chain, rotationBetween(from, to));
  }

  /// Turns the arm about the line shoulder - end towards the pole: no faster than twice the target's step
  /// moves the elbow, and, when the target rests, by 0.05 rad at most.
  static void swivel(CountedEvaluator& at, const Chain& chain, const Vector3d& end, const Vector3d& pole,
                     double step) {
    const Vector3d shoulder = at.frames()[chain.shoulder].translation();
    const Vector3d reach = end - shoulder;
    if (reach.norm() < 1e-9) return;
    const Vector3d u = reach.normalized();
    const auto beside = [&](const Vector3d& point) {
      return Vector3d(point - shoulder - u * u.dot(point - shoulder));
    };
    const Vector3d e = beside(at.frames()[chain.elbow].translation()), wanted = beside(pole);
    const double h = e.norm();
    if (h < 1e-3 * reach.norm() || wanted.norm() < 1e-9) return;
    const double angle = std::atan2(e.cross(wanted).dot(u), e.dot(wanted));
    const double largest = step > 1e-9 ? std::min(M_PI, 2.0 * step / h) : 0.05;
    turnShoulder(at, chain, Quaterniond(Eigen::AngleAxisd(std::clamp(angle, -largest, largest), u)));
  }

  static void turnShoulder(CountedEvaluator& at, const Chain& chain, const Quaterniond& turnInWorld) {
    const Skeleton& skeleton = at.skeleton();
    const Joint& joint = skeleton.joint(chain.shoulder);
    const Matrix3d F = at.frames()[chain.shoulder].linear();
    VectorXd q = at.q();
    if (joint.ball) {
      const Quaterniond turnInJoint(F.transpose() * turnInWorld.toRotationMatrix() * F);
      setBallRotation(skeleton, q, chain.shoulder,
                      (ballRotation(skeleton, q, chain.shoulder) * turnInJoint).normalized());
    } else {
      const EulerOrder order = *eulerOrderOf(joint);
      const int index = skeleton.qIndex(chain.shoulder);
      const Vector3d before = q.segment<3>(index);
      const Matrix3d motion =
          rotationFromEuler(order, before) * F.transpose() * turnInWorld.toRotationMatrix() * F;
      q.segment<3>(index) = nearestEuler(order, motion, before);
    }
    at.moveTo(projectToLimits(skeleton, q));
  }

  /// Of the angles that give the same rotation those nearest to what they were.
  static Vector3d nearestEuler(const EulerOrder& order, const Matrix3d& R, const Vector3d& before) {
    Vector3d one = eulerFromRotation(order, R);
    Vector3d other = order.isProper() ? Vector3d(one[0] + M_PI, -one[1], one[2] + M_PI)
                                      : Vector3d(one[0] + M_PI, M_PI - one[1], one[2] + M_PI);
    for (Vector3d* angles : {&one, &other})
      for (int k = 0; k < 3; ++k)
        (*angles)[k] += 2.0 * M_PI * std::round((before[k] - (*angles)[k]) / (2.0 * M_PI));
    return (one - before).squaredNorm() <= (other - before).squaredNorm() ? one : other;
  }

  static void turnHand(CountedEvaluator& at, const Goal& goal) {
    const Skeleton& skeleton = at.skeleton();
    VectorXd q = at.q();
    const Quaterniond now(at.frames()[goal.joint].linear());
    setBallRotation(
        skeleton, q, goal.joint,
        (ballRotation(skeleton, q, goal.joint) * now.conjugate() * goal.orientation).normalized());
    at.moveTo(projectToLimits(skeleton, q));
  }
};

}  // namespace

std::unique_ptr<IkSolver> makeTwoLink() { return std::make_unique<TwoLinkSolver>(); }

}  // namespace gelenk
