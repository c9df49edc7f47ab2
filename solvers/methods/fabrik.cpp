#include "solvers/methods/fabrik.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "kinematics/configuration.h"
#include "kinematics/limits.h"
#include "kinematics/rotation.h"
#include "solvers/iteration/attempt.h"
#include "solvers/methods/line_search.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// to + length * direction from `to` to `from`; where the two coincide, along the fallback.
Vector3d pulled(const Vector3d& to, const Vector3d& from, double length, const Vector3d& fallback) {
  const Vector3d along = from - to;
  const double square = along.squaredNorm();
  return to + (square > 1e-24 ? Vector3d(along * (length / std::sqrt(square))) : Vector3d(fallback * length));
}

/// A straight chain cannot bend by pulling along its own line: its inner points move aside by a share of the
/// first bone.
void bendIfInLine(std::span<Vector3d> points, const Vector3d& target, double share) {
  const Vector3d line = points.back() - points.front();
  const double length = line.norm();
  if (points.size() < 3 || length == 0.0) return;
  const Vector3d u = line / length;
  const auto aside = [&](const Vector3d& p) {
    return (p - points.front() - u * u.dot(p - points.front())).norm();
  };
  double most = aside(target);
  for (const Vector3d& p : points) most = std::max(most, aside(p));
  if (most > 1e-6 * length) return;
  const double by = share * (points[1] - points[0]).norm();
  for (size_t i = 1; i + 1 < points.size(); i += 2) points[i] += u.unitOrthogonal() * by;
}

/// A joint on the path that can turn, and the next place below it (the next such joint, or the effector's
/// point).
struct Pivot {
  int joint;
  Isometry3d fromParentPivot;  ///< of the joint's zero frame, in the moved frame of the pivot above (the
                               ///< world for the first)
};

class FabrikChain {
 public:
  FabrikChain(const Skeleton& skeleton, const Goal& goal, const VectorXd& q,
              const FabrikParameters& parameters)
      : skeleton_(skeleton), goal_(goal), p_(parameters) {
    std::vector<int> path;
    for (int j = goal.joint; j >= 0; j = skeleton.parent(j)) path.push_back(j);
    Isometry3d since = Isometry3d::Identity(), worldFromPivot = Isometry3d::Identity();
    Vector3d normal = Vector3d::Zero();
    for (auto j = path.rbegin(); j != path.rend(); ++j) {
      const Joint& joint = skeleton.joint(*j);
      since = since * joint.parentFromZero;
      const bool turns =
          joint.ball || std::any_of(joint.axes.begin(), joint.axes.end(),
                                    [](const AxisDof& d) { return d.kind == AxisDof::Kind::Rotation; });
      if (joint.coupling) slides_ = slides_ || joint.axes[0].kind == AxisDof::Kind::Translation;
      if (!turns) {
        since = since * jointMotion(skeleton, q, *j);  // translations are held where they are
        continue;
      }
      pivots_.push_back({*j, since});
      worldFromPivot = worldFromPivot * since;
      for (const AxisDof& dof : joint.axes) {
        const Vector3d axis = worldFromPivot.linear() * dof.axis;
        if (normal.isZero()) normal = axis;
        inPlane_ = inPlane_ && dof.kind == AxisDof::Kind::Rotation && axis.cross(normal).norm() < 1e-9;
      }
      inPlane_ = inPlane_ && !joint.ball;
      free_ = free_ && joint.ball && joint.axes.empty() && !joint.ballLimit;
      since = Isometry3d::Identity();
    }
    tip_ = since * goal.pointInJoint;
    points_.resize(pivots_.size() + 1);
    lengths_.resize(pivots_.size());
  }

  bool hasPivots() const { return !pivots_.empty(); }
  bool isFree() const { return free_; }
  /// A sliding joint on the path follows another one: the lengths between pivots are none.
  bool changesLength() const { return slides_; }

  /// Places the points at the configuration.
  void moveTo(const VectorXd& q) {
    placeAt(q, points_);
    for (size_t i = 0; i + 1 < points_.size(); ++i) lengths_[i] = (points_[i + 1] - points_[i]).norm();
  }

  /// All iterations on bare points, then the rotations. Returns the iterations.
  int runOnPoints(VectorXd& q, double tolerance, int maxIterations) {
    const FabrikResult result = fabrikPoints(points_, goal_.target, tolerance, maxIterations, p_);
    turnTowardsPoints(q);
    return result.iterations;
  }

  /// One iteration with rotations and limits.
  void iterate(VectorXd& q) {
    moveTo(q);
    here_ = points_;
    bendIfInLine(points_, goal_.target, p_.bend);
    Vector3d place = goal_.target;
    for (size_t i = lengths_.size(); i-- > 0;) {
      points_[i + 1] = place;
      place = pulled(place, points_[i], lengths_[i], Vector3d::UnitZ());
    }
    turnTowardsPoints(q);
  }

 private:
  void placeAt(const VectorXd& q, std::vector<Vector3d>& points) const {
    Isometry3d above = Isometry3d::Identity();
    for (size_t i = 0; i < pivots_.size(); ++i) {
      const Isometry3d here =
          above * pivots_[i].fromParentPivot * jointMotion(skeleton_, q, pivots_[i].joint);
      points[i] = here.translation();
      above = here;
    }
    points.back() = above * tip_;
  }

  /// Root first: each joint turns its next place towards points_[i + 1], within its limits.
  void turnTowardsPoints(VectorXd& q) {
    Isometry3d above = Isometry3d::Identity();
    for (size_t i = 0; i < pivots_.size(); ++i) {
      const Isometry3d zero = above * pivots_[i].fromParentPivot;
      if (const int source = sourceOf(pivots_[i].joint); source >= 0)
        turnTogether(i, source, q);
      else
        turnJoint(i, zero, q);
      above = zero * jointMotion(skeleton_, q, pivots_[i].joint);
    }
    skeleton_.couple(q);
  }

  /// What the joint turns together with others on the path by; -1: it turns alone.
  int sourceOf(int joint) const {
    if (!skeleton_.isCoupled(joint)) return -1;
    if (const auto& coupling = skeleton_.joint(joint).coupling) return coupling->source;
    for (const Pivot& pivot : pivots_)
      if (const auto& coupling = skeleton_.joint(pivot.joint).coupling; coupling && coupling->source == joint)
        return joint;
    return -1;
  }

  /// At the first of them: the source's value that brings all places below closest to where they are wanted.
  void turnTogether(size_t i, int source, VectorXd& q) {
    for (size_t k = 0; k < i; ++k)
      if (sourceOf(pivots_[k].joint) == source) return;
    const AxisDof& dof = skeleton_.joint(source).axes[0];
    const auto place = [&](double value) {
      q[skeleton_.qIndex(source)] = value;
      skeleton_.couple(q);
      placeAt(q, here_);
    };
    const double now = q[skeleton_.qIndex(source)];
    const double around = dof.kind == AxisDof::Kind::Rotation ? M_PI : 1.0;
    place(lowestOn(std::max(dof.lower, now - around), std::min(dof.upper, now + around), now,
                   [&](double value) {
                     place(value);
                     double sum = 0.0;
                     for (size_t k = i + 1; k < points_.size(); ++k)
                       sum += (here_[k] - points_[k]).squaredNorm();
                     return sum;
                   }));
  }

  void turnJoint(size_t i, const Isometry3d& zero, VectorXd& q) {
    const int j = pivots_[i].joint;
    const Joint& joint = skeleton_.joint(j);
    const auto carryOn = [&](const Isometry3d& before) {  // everything below moves along
      const Isometry3d moved = zero * jointMotion(skeleton_, q, j) * before.inverse();
      for (size_t k = i + 1; k < here_.size(); ++k) here_[k] = moved * here_[k];
    };
    if (joint.ball) {
      const Isometry3d before = zero * jointMotion(skeleton_, q, j);
      turnBall(i, zero, q);
      carryOn(before);
    }
    const int passes = joint.axes.size() > 1 || (joint.ball && !joint.axes.empty()) ? 2 : 1;
    for (int pass = 0; pass < passes; ++pass)
      for (size_t k = joint.axes.size(); k-- > 0;)
        if (joint.axes[k].kind == AxisDof::Kind::Rotation) {
          const Isometry3d before = zero * jointMotion(skeleton_, q, j);
          turnHinge(i, static_cast<int>(k), zero, q);
          carryOn(before);
        }
  }

  void turnBall(size_t i, const Isometry3d& zero, VectorXd& q) const {
    const int j = pivots_[i].joint;
    const Vector3d next =
        i + 1 == pivots_.size() ? tip_ : Vector3d(pivots_[i + 1].fromParentPivot.translation());
    const Isometry3d here = zero * jointMotion(skeleton_, q, j);
    const Vector3d target = here.inverse() * points_[i + 1];
    if (next.norm() < 1e-12 || target.norm() < 1e-12) return;  // the next pivot is in the same place
    setBallRotation(skeleton_, q, j,
                    (ballRotation(skeleton_, q, j) * rotationBetween(next, target)).normalized());
    if (skeleton_.joint(j).ballLimit && limitViolation(skeleton_, q, j) > 0.0)
      projectToLimits(skeleton_, q, q);
  }

  /// In the plane the angle that brings the next place onto the line to where the backward pass wants it, as
  /// in the paper. A hinge about another axis often cannot get it there, or does not move it at all (a
  /// twist): it takes the angle that brings all places below closest to where they are wanted, in the sum of
  /// squares.
  void turnHinge(size_t i, int k, const Isometry3d& zero, VectorXd& q) const {
    const Joint& joint = skeleton_.joint(pivots_[i].joint);
    const int at = skeleton_.qIndex(pivots_[i].joint);
    Isometry3d axisFrame = zero;  // the frame in which this axis turns
    for (int m = 0; m < k; ++m) {
      if (joint.axes[m].kind == AxisDof::Kind::Rotation)
        axisFrame.rotate(Eigen::AngleAxisd(q[at + m], joint.axes[m].axis));
      else
        axisFrame.translate(joint.axes[m].axis * q[at + m]);
    }
    const AxisDof& dof = joint.axes[k];
    const Isometry3d axisFromWorld = axisFrame.inverse();
    double sine = 0.0, cosine = 0.0;
    for (size_t m = i + 1; m < (inPlane_ ? i + 2 : points_.size()); ++m) {
      const Vector3d from = axisFromWorld * here_[m], to = axisFromWorld * points_[m];
      sine += dof.axis.dot(from.cross(to));
      cosine += from.dot(to) - dof.axis.dot(from) * dof.axis.dot(to);
    }
    if (std::hypot(sine, cosine) < 1e-14) return;
    q[at + k] = intoRange(dof, q[at + k] + std::atan2(sine, cosine));
  }

  const Skeleton& skeleton_;
  const Goal& goal_;
  FabrikParameters p_;
  std::vector<Pivot> pivots_;
  Vector3d tip_ = Vector3d::Zero();  ///< the effector's point in the last pivot's frame
  std::vector<Vector3d> points_;     ///< of the pivots and the effector: where the passes want them
  std::vector<Vector3d> here_;       ///< where they are
  std::vector<double> lengths_;
  bool slides_ = false;  ///< see changesLength
  bool free_ = true;     ///< unlimited balls alone
  bool inPlane_ = true;  ///< hinges about parallel axes alone
};

class Fabrik final : public IkSolver {
 public:
  explicit Fabrik(const FabrikParameters& parameters) : p_(parameters) {}
  std::string whyUnsupported(const IkProblem& problem) const override {
    if (problem.goals.empty()) return {};
    if (problem.goals.size() != 1 || problem.goals[0].kind != GoalKind::Position)
      return "solves exactly one position goal";
    const FabrikChain chain(*problem.skeleton, problem.goals[0], neutral(*problem.skeleton), p_);
    if (chain.changesLength()) return "a joint on the path slides as another one moves";
    return chain.hasPivots() ? "" : "no joint on the path turns";
  }

  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const override {
    if (!whyUnsupported(problem).empty()) return unsupported(problem);
    return solveWithRestarts(problem, budget, trace, [&](Attempt& attempt) {
      if (attempt.isOver()) return;
      FabrikChain chain(*problem.skeleton, problem.goals[0], attempt.at.q(), p_);
      if (chain.isFree()) {
        VectorXd q = attempt.at.q();
        chain.moveTo(q);
        const int iterations =
            chain.runOnPoints(q, 0.5 * problem.positionTolerance, budget.maxIterations - 1);
        attempt.propose(q);
        for (int i = 0; i < iterations; ++i) attempt.countIteration(0.0, 0.0);
      }
      while (!attempt.isOver()) {
        if (attempt.rest() == Attempt::Rest::Over) return;
        VectorXd q = attempt.at.q();
        chain.iterate(q);
        attempt.countIteration(difference(*problem.skeleton, attempt.at.q(), q).norm(), 0.0);
        attempt.propose(q);
      }
    });
  }

 private:
  FabrikParameters p_;
};

}  // namespace

FabrikResult fabrikPoints(std::span<Vector3d> points, const Vector3d& target, double tolerance,
                          int maxIterations, const FabrikParameters& parameters) {
  FabrikResult result;
  const size_t n = points.size() - 1;
  constexpr size_t onStack = 64;
  double few[onStack];
  std::vector<double> many(n > onStack ? n : 0);
  double* lengths = n > onStack ? many.data() : few;
  for (size_t i = 0; i < n; ++i) lengths[i] = (points[i + 1] - points[i]).norm();
  const Vector3d root = points[0];
  bendIfInLine(points, target, parameters.bend);
  const double enough = tolerance * tolerance;
  while (result.iterations < maxIterations && (points[n] - target).squaredNorm() > enough) {
    ++result.iterations;
    const Vector3d end = points[n];
    points[n] = target;
    for (size_t i = n; i-- > 0;) points[i] = pulled(points[i + 1], points[i], lengths[i], Vector3d::UnitZ());
    points[0] = root;
    for (size_t i = 0; i < n; ++i)
      points[i + 1] = pulled(points[i], points[i + 1], lengths[i], Vector3d::UnitZ());
    if ((points[n] - end).squaredNorm() < 1e-24 * (1.0 + target.squaredNorm()))
      break;  // out of reach: the chain is straight
  }
  result.distance = (points[n] - target).norm();
  return result;
}

std::unique_ptr<IkSolver> makeFabrik(const FabrikParameters& parameters) {
  return std::make_unique<Fabrik>(parameters);
}

}  // namespace gelenk
