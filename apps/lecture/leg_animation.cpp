#include "apps/lecture/leg_animation.h"

#include <algorithm>
#include <cmath>

#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/rotation.h"
#include "solvers/methods/two_link.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double degree = M_PI / 180.0;

/// Joints of one leg and the points of its sole, each in the frame of the joint that carries it.
struct Leg {
  int thigh, calf, foot, ball;
  Vector3d heelInFoot, ballInFoot, toeInBall;
};

Leg legOf(const Skeleton& figure, int side) {
  const std::string ending = side == 0 ? "_l" : "_r";
  const auto joint = [&](const char* name) { return figure.jointIndex(name + ending); };
  Leg leg{.thigh = joint("thigh"),
          .calf = joint("calf"),
          .foot = joint("foot"),
          .ball = joint("ball"),
          .heelInFoot = {},
          .ballInFoot = {},
          .toeInBall = {}};
  const Frames rest = restFrames(figure);
  // At rest the figure stands: the points of the sole lie on y = 0, the heel 5 cm behind the ankle.
  const auto onGround = [](Vector3d p) { return Vector3d(p.x(), 0.0, p.z()); };
  leg.heelInFoot = rest[leg.foot].inverse() * onGround(rest[leg.foot].translation() - Vector3d(0, 0, 0.05));
  leg.ballInFoot = rest[leg.foot].inverse() * onGround(rest[leg.ball].translation());
  leg.toeInBall = rest[leg.ball].inverse() * onGround(rest[joint("toe_end")].translation());
  return leg;
}

struct Sole {
  Vector3d heel, ball, toe;
};
Sole soleAt(const Leg& leg, const Frames& frames) {
  return {frames[leg.foot] * leg.heelInFoot, frames[leg.foot] * leg.ballInFoot,
          frames[leg.ball] * leg.toeInBall};
}

double smooth(double s) { return s <= 0.0 ? 0.0 : s >= 1.0 ? 1.0 : s * s * (3.0 - 2.0 * s); }

/// Leads the ball of the foot to a point by hip and knee; the foot's own angles stay.
void leadBall(const Skeleton& figure, const Leg& leg, const Vector3d& target, VectorXd& q) {
  static const std::unique_ptr<IkSolver> twoLink = makeTwoLink();
  const IkProblem problem{
      .skeleton = &figure,
      .start = q,
      .goals = {
          {.name = "ball of the foot", .joint = leg.foot, .pointInJoint = leg.ballInFoot, .target = target}}};
  q = twoLink->solve(problem, {}, TraceLevel::Off).q;
}

/// The ball at the target, then heel and toes out of the ground: turning the foot moves the ball, so both
/// alternate until the heel is above the ground to 1e-12 m.
void plant(const Skeleton& figure, const Leg& leg, const Vector3d& target, VectorXd& q) {
  const int ankle = figure.qIndex(leg.foot), toes = figure.qIndex(leg.ball);
  for (int i = 0; i < 60; ++i) {
    leadBall(figure, leg, target, q);
    const Sole sole = soleAt(leg, forwardKinematics(figure, q));
    const double depth = -sole.heel.y();
    if (depth <= 1e-12) break;
    q[ankle] += std::min(0.2, depth / (sole.ball - sole.heel).norm());  // plantar flexion raises the heel
    q = projectToLimits(figure, q);
  }
  for (int i = 0; i < 60; ++i) {
    const Frames frames = forwardKinematics(figure, q);
    const Sole sole = soleAt(leg, frames);
    if (sole.toe.y() >= -1e-12) break;
    q[toes] -=
        std::min(0.2, -sole.toe.y() / (sole.toe - frames[leg.ball].translation()).norm());  // toes bend up
    q = projectToLimits(figure, q);
  }
}

}  // namespace

LegKeys lectureLegKeys() {
  return {.hip = {{0.0, 24}, {0.12, 20}, {0.5, -14}, {0.6, -8}, {0.85, 30}, {1.0, 24}},
          .knee = {{0.0, 6}, {0.14, 18}, {0.4, 8}, {0.6, 38}, {0.73, 62}, {0.95, 6}, {1.0, 6}},
          .foot = {{0.0, 2}, {0.1, 8}, {0.45, -10}, {0.62, 18}, {0.8, -2}, {1.0, 2}}};
}

double keyedAngle(const std::vector<LegKey>& keys, double phase) {
  phase -= std::floor(phase);
  std::size_t next = 0;
  while (next < keys.size() && keys[next].phase <= phase) ++next;
  const LegKey before = next > 0 ? keys[next - 1] : LegKey{keys.back().phase - 1.0, keys.back().degrees};
  const LegKey after =
      next < keys.size() ? keys[next] : LegKey{keys.front().phase + 1.0, keys.front().degrees};
  const double s = after.phase > before.phase ? (phase - before.phase) / (after.phase - before.phase) : 0.0;
  return before.degrees + (after.degrees - before.degrees) * 0.5 * (1.0 - std::cos(M_PI * s));
}

LegAnimation keyframedLegs(const Skeleton& figure, const LegKeys& keys, int cycles) {
  LegAnimation animation;
  const std::array<Leg, 2> legs{legOf(figure, 0), legOf(figure, 1)};
  const int frames = static_cast<int>(std::lround(cycles * keys.cycle * animation.framesPerSecond));
  for (int f = 0; f < frames; ++f) {
    const double seconds = f / animation.framesPerSecond;
    VectorXd q = figure.rest();
    q[1] -= keys.crouch;
    q[2] += keys.speed * seconds;
    std::array<bool, 2> onGround{};
    for (int side = 0; side < 2; ++side) {  // from the top down: hip, knee, foot
      const double phase = seconds / keys.cycle + 0.5 * side;
      const Leg& leg = legs[side];
      const Vector3d hip(-keyedAngle(keys.hip, phase) * degree, 0.0, 0.0);
      setBallRotation(figure, q, leg.thigh,
                      (ballRotation(figure, q, leg.thigh) * expRotation(hip)).normalized());
      q[figure.qIndex(leg.calf)] = keyedAngle(keys.knee, phase) * degree;
      q[figure.qIndex(leg.foot)] =
          figure.rest()[figure.qIndex(leg.foot)] + keyedAngle(keys.foot, phase) * degree;
      const double within = phase - std::floor(phase);
      onGround[side] = within >= keys.footFlat && within < keys.liftOff;
    }
    animation.q.push_back(projectToLimits(figure, q));
    animation.onGround.push_back(onGround);
  }
  return animation;
}

std::array<Vector3d, 3> solePoints(const Skeleton& figure, const VectorXd& q, int side) {
  const Sole sole = soleAt(legOf(figure, side), forwardKinematics(figure, q));
  return {sole.heel, sole.ball, sole.toe};
}

std::vector<std::array<FootMeasure, 2>> measureFeet(const Skeleton& figure, const LegAnimation& animation) {
  std::vector<std::array<FootMeasure, 2>> feet(animation.q.size());
  for (int side = 0; side < 2; ++side) {
    const Leg leg = legOf(figure, side);
    Vector3d ballBefore = Vector3d::Zero();
    for (std::size_t f = 0; f < animation.q.size(); ++f) {
      const Sole sole = soleAt(leg, forwardKinematics(figure, animation.q[f]));
      feet[f][side].penetration = std::max(0.0, -std::min({sole.heel.y(), sole.ball.y(), sole.toe.y()}));
      if (f > 0 && animation.onGround[f][side] && animation.onGround[f - 1][side])
        feet[f][side].sliding = std::hypot(sole.ball.x() - ballBefore.x(), sole.ball.z() - ballBefore.z());
      ballBefore = sole.ball;
    }
  }
  return feet;
}

FootSummary summarise(const std::vector<std::array<FootMeasure, 2>>& feet) {
  FootSummary summary;
  for (const auto& frame : feet)
    for (const FootMeasure& foot : frame) {
      summary.worstSliding = std::max(summary.worstSliding, foot.sliding);
      summary.totalSliding += foot.sliding;
      summary.worstPenetration = std::max(summary.worstPenetration, foot.penetration);
      summary.framesBelowGround += foot.penetration > 1e-9;
    }
  return summary;
}

LegAnimation pinFeet(const Skeleton& figure, const LegAnimation& animation) {
  LegAnimation pinned = animation;
  const int frames = static_cast<int>(animation.q.size());
  for (int side = 0; side < 2; ++side) {
    const Leg leg = legOf(figure, side);
    const auto animatedBall = [&](int f) {
      return soleAt(leg, forwardKinematics(figure, animation.q[f])).ball;
    };
    Vector3d pin = Vector3d::Zero();
    Vector3d offset = Vector3d::Zero();  // pinned minus animated at lift-off, blended away in the air
    int liftOff = 0, touchDown = frames;
    for (int f = 0; f < frames; ++f) {
      VectorXd& q = pinned.q[f];
      const Vector3d animated = animatedBall(f);
      if (animation.onGround[f][side]) {
        if (f == 0 || !animation.onGround[f - 1][side]) {
          pin = animated;
          pin.y() = 0.0;
        }
        plant(figure, leg, pin, q);
        offset = pin - animated;
        continue;
      }
      if (f == 0 || animation.onGround[f - 1][side]) {
        liftOff = f;
        touchDown = f;
        while (touchDown < frames && !animation.onGround[touchDown][side]) ++touchDown;
      }
      // The way back to the animation, so that nothing jumps: the offset of the lift-off fades, that of the
      // coming pin (down to the ground) grows.
      const double s = (f - liftOff + 1.0) / (touchDown - liftOff + 1.0);
      const double landing = touchDown < frames ? -animatedBall(touchDown).y() : 0.0;
      Vector3d target = animated + (1.0 - smooth(s)) * offset + Vector3d(0.0, smooth(s) * landing, 0.0);
      target.y() = std::max(0.0, target.y());
      plant(figure, leg, target, q);
    }
  }
  return pinned;
}

}  // namespace gelenk
