// Lecture 10.1.1: hierarchical top-down animation of a leg, and its two problems.

#include "apps/lecture/derivations.h"
#include "apps/lecture/example.h"
#include "apps/lecture/leg_animation.h"
#include "apps/lecture/text.h"
#include "kinematics/configuration.h"
#include "kinematics/notation/mannequin.h"

namespace gelenk {
namespace {

struct Walk {
  Skeleton figure = mannequin();
  LegAnimation keyed = keyframedLegs(figure, lectureLegKeys());
  LegAnimation pinned = pinFeet(figure, keyed);
  FootSummary before = summarise(measureFeet(figure, keyed));
  FootSummary after = summarise(measureFeet(figure, pinned));
};

const Walk& walk() {
  static const Walk w;
  return w;
}

/// Largest change of a joint's rotation from frame to frame, radians.
double largestMotion(const LegAnimation& animation) {
  double largest = 0.0;
  for (std::size_t f = 1; f < animation.q.size(); ++f)
    largest = std::max(largest, difference(walk().figure, animation.q[f - 1], animation.q[f])
                                    .tail(walk().figure.nv() - 3)
                                    .lpNorm<Eigen::Infinity>());
  return largest;
}

std::string row(const char* name, const FootSummary& s, double motion) {
  return fmt::format("  {:<10} {:18.3e} {:14.4f} {:18.3e} {:17} {:18.3f}\n", name, s.worstSliding,
                     s.totalSliding, s.worstPenetration, s.framesBelowGround, motion);
}

std::string steps() {
  const LegKeys keys = lectureLegKeys();
  std::string out =
      "Top-down: the hip's angle is keyed first, then the knee's, then the foot's; nothing asks where the "
      "foot ends up.\n";
  const auto list = [](const char* name, const std::vector<LegKey>& curve) {
    std::string line = fmt::format("  {:<5}", name);
    for (const LegKey& key : curve) line += fmt::format(" {:g}:{:g}", key.phase, key.degrees);
    return line + "   (phase:degrees)\n";
  };
  out += list("hip", keys.hip) + list("knee", keys.knee) + list("foot", keys.foot);
  out += fmt::format(
      "  a cycle of {:g} s, the ball of the foot on the ground from phase {:g} to {:g}, root {:g} m/s "
      "forward; {} frames at {:g} fps\n\n",
      keys.cycle, keys.footFlat, keys.liftOff, keys.speed, walk().keyed.q.size(),
      walk().keyed.framesPerSecond);
  out += "The two problems, measured at the sole (heel, ball, toe tip) of both feet:\n";
  out +=
      "             worst sliding [m]  in total [m]  worst depth [m]  frames below ground  largest joint "
      "step [rad]\n";
  out += row("keyframes", walk().before, largestMotion(walk().keyed));
  out += row("pinned", walk().after, largestMotion(walk().pinned));
  out +=
      "\nPinned: the ball of a foot on the ground stays where it came down; hip and knee follow from the "
      "two-link closed form (10.1.3), the ankle\n"
      "turns the heel and the toe hinge the toes out of the ground; in the air the foot blends back to the "
      "animation.\n";
  return out;
}

}  // namespace

std::string legDerivation(const LegAnimation& shown, const std::array<FootMeasure, 2>& feet, int frame) {
  const LegKeys keys = lectureLegKeys();
  const double phase = frame / shown.framesPerSecond / keys.cycle;
  std::string out = fmt::format("Frame {} of {}, phase {:.3f} of the cycle\n", frame + 1, shown.q.size(),
                                std::fmod(phase, 1.0));
  out += "Top-down: each angle between its keys, hip, then knee, then foot; left leg:\n";
  for (const auto& [name, curve] :
       {std::pair{"hip", &keys.hip}, std::pair{"knee", &keys.knee}, std::pair{"foot", &keys.foot}})
    out += fmt::format("  {:<6}   {:8.3f} degrees\n", name, keyedAngle(*curve, phase));
  out += "\n          stands      slides [m a frame]     depth [m]\n";
  for (std::size_t side = 0; side < 2; ++side)
    out += fmt::format("  {:<6}   {:<6}      {:<16.3e}       {:.3e}\n", side == 0 ? "left" : "right",
                       shown.onGround[static_cast<std::size_t>(frame)][side] ? "yes" : "no",
                       feet[side].sliding, feet[side].penetration);
  return out;
}

LectureTopic legTopic() {
  LectureTopic topic{.id = "leg",
                     .section = "10.1.1",
                     .title = "Hierarchical animation of a leg",
                     .steps = &steps,
                     .checks = {}};
  const std::string section = "10.1.1, hierarchical animation, problems";
  topic.checks = {
      {.id = "leg-sliding-before",
       .section = section,
       .what = "keyframes alone: worst sliding of a standing foot, m a frame",
       .printed = {1e-3},
       .tolerance = {0},
       .compute = [] { return std::vector{walk().before.worstSliding}; },
       .comparison = Comparison::AtLeast,
       .note = "the slide's first problem"},
      {.id = "leg-penetration-before",
       .section = section,
       .what = "keyframes alone: worst depth of the sole below the ground, m",
       .printed = {1e-2},
       .tolerance = {0},
       .compute = [] { return std::vector{walk().before.worstPenetration}; },
       .comparison = Comparison::AtLeast,
       .note = "the slide's second problem"},
      {.id = "leg-sliding-after",
       .section = section,
       .what = "pinned feet: worst sliding, m a frame",
       .printed = {1e-9},
       .tolerance = {0},
       .compute = [] { return std::vector{walk().after.worstSliding}; },
       .comparison = Comparison::AtMost},
      {.id = "leg-penetration-after",
       .section = section,
       .what = "pinned feet: worst depth, m",
       .printed = {1e-9},
       .tolerance = {0},
       .compute = [] { return std::vector{walk().after.worstPenetration}; },
       .comparison = Comparison::AtMost},
      {.id = "leg-calm",
       .section = section,
       .what = "pinned feet: largest joint step between frames, rad",
       .printed = {0.5},
       .tolerance = {0},
       .compute = [] { return std::vector{largestMotion(walk().pinned)}; },
       .comparison = Comparison::AtMost,
       .note = "at the end of a swing, where the leg comes back from its full stretch"},
  };
  return topic;
}

}  // namespace gelenk
