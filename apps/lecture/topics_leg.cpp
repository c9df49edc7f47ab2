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

std::string steps() {
  const LegKeys keys = lectureLegKeys();
  std::string out =
      "Top-down: the hip's angle is keyed first, then the knee's, then the foot's; nothing asks where the "
      "foot ends up.\n";
  const auto list = [](const char* name, const std::vector<LegKey>& curve) {
    std::vector<std::string> phases{name, "phase"}, angles{"", "degrees"};
    for (const LegKey& key : curve) {
      phases.push_back(fmt::format("{:g}", key.phase));
      angles.push_back(fmt::format("{:g}", key.degrees));
    }
    return text::row(phases) + text::row(angles);
  };
  out += list("hip", keys.hip) + list("knee", keys.knee) + list("foot", keys.foot);
  out += fmt::format(
      "  a cycle of {:g} s, the ball of the foot on the ground from phase {:g} to {:g}, root {:g} m/s "
      "forward; {} frames at {:g} fps\n\n",
      keys.cycle, keys.footFlat, keys.liftOff, keys.speed, walk().keyed.q.size(),
      walk().keyed.framesPerSecond);
  out += "The two problems, measured at the sole (heel, ball, toe tip) of both feet:\n";
  const FootSummary &before = walk().before, &after = walk().after;
  out += text::heads({"", "keyframes", "pinned"});
  out += text::row({"worst sliding [m a frame]", text::scientific(before.worstSliding),
                    text::scientific(after.worstSliding)});
  out += text::row(
      {"sliding in total [m]", text::fixed(before.totalSliding, 4), text::fixed(after.totalSliding, 4)});
  out += text::row({"worst depth [m]", text::scientific(before.worstPenetration),
                    text::scientific(after.worstPenetration)});
  out += text::row({"feet and frames below ground", std::to_string(before.framesBelowGround),
                    std::to_string(after.framesBelowGround)});
  out += text::row({"largest step of a joint [rad]", text::fixed(largestMotion(walk().keyed), 3),
                    text::fixed(largestMotion(walk().pinned), 3)});
  out +=
      "\nPinned: the ball of a foot on the ground stays where it came down; hip and knee follow from the "
      "two-link closed form (10.1.3), the ankle turns the heel and the toe hinge the toes out of the ground; "
      "in the air the foot blends back to the animation.\n";
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
    out += text::row({name, text::fixed(keyedAngle(*curve, phase), 3), "degrees"});
  const auto bothFeet = [&](const char* what, const auto& of) { return text::row({what, of(0), of(1)}); };
  out += "\nBoth soles:\n" + text::heads({"", "left", "right"});
  out += bothFeet("stands", [&](std::size_t side) {
    return shown.onGround[static_cast<std::size_t>(frame)][side] ? "yes" : "no";
  });
  out +=
      bothFeet("slides [m a frame]", [&](std::size_t side) { return text::scientific(feet[side].sliding); });
  out += bothFeet("depth [m]", [&](std::size_t side) { return text::scientific(feet[side].penetration); });
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
