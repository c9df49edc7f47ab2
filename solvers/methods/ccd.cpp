#include "solvers/methods/ccd.h"

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

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// The effector while a sweep moves the dofs above it one by one.
struct Effector {
  Vector3d point;
  Matrix3d rotation;

  Effector(const Frames& frames, const Goal& goal)
      : point(frames[goal.joint] * goal.pointInJoint), rotation(frames[goal.joint].linear()) {}

  void turn(const Vector3d& about, const Matrix3d& by) {
    point = about + by * (point - about);
    rotation = by * rotation;
  }
};

struct Wanted {
  bool position, orientation;
  double orientationWeight;  ///< arm^2, m^2
  Vector3d point;
  Matrix3d rotation;
};

/// The angle about an axis through `about` that minimises the objective above.
double bestAngle(const Wanted& wanted, const Effector& effector, const Vector3d& about,
                 const Vector3d& axis) {
  double sine = 0.0, cosine = 0.0;
  const auto add = [&](const Vector3d& from, const Vector3d& to, double weight) {
    sine += weight * axis.dot(from.cross(to));
    cosine += weight * (from.dot(to) - axis.dot(from) * axis.dot(to));
  };
  if (wanted.position) add(effector.point - about, wanted.point - about, 2.0);
  if (wanted.orientation)
    for (int k = 0; k < 3; ++k)
      add(effector.rotation.col(k), wanted.rotation.col(k), wanted.orientationWeight);
  return std::hypot(sine, cosine) > 1e-14 ? std::atan2(sine, cosine) : 0.0;
}

/// New value of a rotation's angle within its range; whole turns are free where the range holds one.
double turned(const AxisDof& dof, double q, double by) { return intoRange(dof, q + by); }

class Sweep {
 public:
  Sweep(const Goal& goal, CountedEvaluator& at, double arm)
      : skeleton_(at.skeleton()),
        frames_(&at.frames()),
        q_(at.q()),
        goal_(goal),
        effector_(at.frames(), goal),
        wanted_{goal.kind != GoalKind::Orientation, goal.kind != GoalKind::Position, arm * arm, goal.target,
                goal.orientation.normalized().toRotationMatrix()} {
    dofTwists(skeleton_, q_, *frames_, twists_);
  }

  const VectorXd& run() {
    for (int j = goal_.joint; j >= 0; j = skeleton_.parent(j)) {
      const Joint& joint = skeleton_.joint(j);
      if (const int source = sourceOf(j); source >= 0) {
        moveTogether(source);
        continue;
      }
      if (joint.ball) turnBall(j);
      for (int k = static_cast<int>(joint.axes.size()) - 1; k >= 0; --k)
        moveAxis(joint.axes[k], skeleton_.qIndex(j) + k, skeleton_.vIndex(j) + k);
    }
    skeleton_.couple(q_);
    return q_;
  }

 private:
  /// What a joint on the path moves together with others there by; -1: alone.
  int sourceOf(int j) const {
    if (!skeleton_.isCoupled(j)) return -1;
    if (const auto& coupling = skeleton_.joint(j).coupling) return coupling->source;
    for (const int follower : skeleton_.followers())
      if (skeleton_.joint(follower).coupling->source == j && skeleton_.isAncestor(follower, goal_.joint))
        return j;
    return -1;
  }

  /// The value of the source, once a sweep, that brings the effector nearest while all that follow it move
  /// too.
  void moveTogether(int source) {
    if (std::count(together_.begin(), together_.end(), source)) return;
    together_.push_back(source);
    const AxisDof& dof = skeleton_.joint(source).axes[0];
    const double now = q_[skeleton_.qIndex(source)],
                 around = dof.kind == AxisDof::Kind::Rotation ? M_PI : 1.0;
    const auto place = [&](double value) {
      q_[skeleton_.qIndex(source)] = value;
      skeleton_.couple(q_);
      forwardKinematics(skeleton_, q_, moved_);
      effector_ = Effector(moved_, goal_);
    };
    const double best = lowestOn(
        std::max(dof.lower, now - around), std::min(dof.upper, now + around), now, [&](double value) {
          place(value);
          return (wanted_.position ? (effector_.point - wanted_.point).squaredNorm() : 0.0) +
                 (wanted_.orientation ? 0.5 * wanted_.orientationWeight *
                                            (effector_.rotation - wanted_.rotation).squaredNorm()
                                      : 0.0);
        });
    place(best);
    frames_ = &moved_;
    dofTwists(skeleton_, q_, moved_, twists_);
  }

  /// Dofs above have not moved in this sweep, so the twists of its beginning still hold.
  void moveAxis(const AxisDof& dof, int iq, int iv) {
    const Vector3d v = twists_.col(iv).head<3>(), omega = twists_.col(iv).tail<3>();
    if (dof.kind == AxisDof::Kind::Translation) {
      if (!wanted_.position) return;
      const double to = intoRange(dof, q_[iq] + v.dot(wanted_.point - effector_.point));
      effector_.point += v * (to - q_[iq]);
      q_[iq] = to;
      return;
    }
    const Vector3d about = omega.cross(v);  // the point of the axis next to the world's origin
    const double to = turned(dof, q_[iq], bestAngle(wanted_, effector_, about, omega));
    effector_.turn(about, Eigen::AngleAxisd(to - q_[iq], omega).toRotationMatrix());
    q_[iq] = to;
  }

  void turnBall(int j) {
    const Vector3d about = (*frames_)[j].translation();
    const Matrix3d& world = (*frames_)[j].linear();
    Matrix3d turn = Matrix3d::Identity();
    if (!wanted_.orientation) {
      const Vector3d from = effector_.point - about, to = wanted_.point - about;
      if (from.norm() < 1e-12 || to.norm() < 1e-12) return;
      turn = rotationBetween(from, to).toRotationMatrix();
    } else {
      Effector moved = effector_;
      for (int k = 0; k < 3; ++k) {
        const Vector3d axis = world.col(k);
        const Matrix3d part =
            Eigen::AngleAxisd(bestAngle(wanted_, moved, about, axis), axis).toRotationMatrix();
        moved.turn(about, part);
        turn = part * turn;
      }
    }
    const Quaterniond before = ballRotation(skeleton_, q_, j);
    setBallRotation(skeleton_, q_, j, (before * Quaterniond(world.transpose() * turn * world)).normalized());
    if (skeleton_.joint(j).ballLimit && limitViolation(skeleton_, q_, j) > 0.0) {
      projectToLimits(skeleton_, q_, q_);
      turn = world * (before.conjugate() * ballRotation(skeleton_, q_, j)).toRotationMatrix() *
             world.transpose();
    }
    effector_.turn(about, turn);
  }

  const Skeleton& skeleton_;
  const Frames* frames_;
  Frames moved_;  ///< after joints moved together
  VectorXd q_;
  const Goal& goal_;
  std::vector<int> together_;  ///< sources moved in this sweep
  Twists twists_;
  Effector effector_;
  Wanted wanted_;
};

class Ccd final : public IkSolver {
 public:
  explicit Ccd(const CcdParameters& parameters) : p_(parameters) {}
  std::string whyUnsupported(const IkProblem& problem) const override {
    if (problem.goals.empty()) return {};
    if (problem.goals.size() != 1) return "moves one effector only";
    const GoalKind kind = problem.goals[0].kind;
    if (kind != GoalKind::Position && kind != GoalKind::Orientation && kind != GoalKind::Pose)
      return "solves position, orientation and pose goals only";
    return {};
  }

  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const override {
    if (!whyUnsupported(problem).empty()) return unsupported(problem);
    return solveWithRestarts(problem, budget, trace, [&](Attempt& attempt) {
      while (!attempt.isOver()) {
        if (attempt.rest() == Attempt::Rest::Over) return;
        const VectorXd before = attempt.at.q();
        const VectorXd q = Sweep(problem.goals[0], attempt.at, p_.arm).run();
        attempt.countIteration(difference(*problem.skeleton, before, q).norm(), 0.0);
        attempt.propose(q);
      }
    });
  }

 private:
  CcdParameters p_;
};

}  // namespace

std::unique_ptr<IkSolver> makeCcd(const CcdParameters& parameters) {
  return std::make_unique<Ccd>(parameters);
}

}  // namespace gelenk
