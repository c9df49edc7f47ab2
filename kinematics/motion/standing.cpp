#include "kinematics/motion/standing.h"

#include <algorithm>
#include <limits>
#include <string_view>

#include "kinematics/motion/joint_matching.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

constexpr double standsAbove = 0.8;  // 37 degrees from upright

/// Of several joints with one plain name, the one with the shortest name.
int jointNamed(const Skeleton& skeleton, const std::vector<PlainName>& names, std::string_view part,
               Side side) {
  int found = -1;
  for (int i = 0; i < skeleton.jointCount(); ++i)
    if (names[i].part == part && names[i].side == side &&
        (found < 0 || skeleton.joint(i).name.size() < skeleton.joint(found).name.size()))
      found = i;
  return found;
}

double cosine(const Frames& frames, int from, int to, const Vector3d& up) {
  const Vector3d way = frames[to].translation() - frames[from].translation();
  return way.norm() > 1e-9 ? way.normalized().dot(up) : -1.0;
}

}  // namespace

StandingParts standingParts(const Skeleton& skeleton) {
  const auto names = plainNames(skeleton);
  const auto named = [&](std::string_view part, Side side) {
    return jointNamed(skeleton, names, part, side);
  };
  StandingParts parts;
  for (const Side side : {Side::Left, Side::Right}) {
    StandingParts::Leg leg{named("thigh", side), named("foot", side)};
    if (leg.foot < 0) leg.foot = named("calf", side);
    if (leg.hip >= 0 && leg.foot >= 0) parts.legs.push_back(leg);
  }
  parts.pelvis = named("pelvis", Side::Middle);
  for (const char* part : {"head", "neck", "chest"})
    if (parts.head < 0) parts.head = named(part, Side::Middle);
  return parts;
}

double uprightness(const StandingParts& parts, const Frames& frames, const Vector3d& up) {
  if (parts.empty()) return 0.0;
  double least = 1.0;
  for (const StandingParts::Leg& leg : parts.legs)
    least = std::min(least, cosine(frames, leg.foot, leg.hip, up));
  if (parts.pelvis >= 0 && parts.head >= 0)
    least = std::min(least, cosine(frames, parts.pelvis, parts.head, up));
  return least;
}

double legLength(const Skeleton& skeleton, const StandingParts& parts, const Frames& frames) {
  double sum = 0.0;
  for (const StandingParts::Leg& leg : parts.legs) {
    if (!skeleton.isAncestor(leg.hip, leg.foot)) continue;
    for (int j = leg.foot; j != leg.hip; j = skeleton.parent(j))
      sum += (frames[j].translation() - frames[skeleton.parent(j)].translation()).norm();
  }
  return parts.legs.empty() ? 0.0 : sum / static_cast<double>(parts.legs.size());
}

StandingPose standingPose(const Skeleton& skeleton, const MotionClip& clip, const StandingParts& parts,
                          const Vector3d& up) {
  StandingPose pose{.frames = restFrames(skeleton)};
  if (parts.empty()) return pose;
  pose.uprightness = uprightness(parts, pose.frames, up);
  if (pose.uprightness >= standsAbove) return pose;
  Frames frames;
  for (int f = 0; f < clip.frameCount(); ++f) {
    forwardKinematics(skeleton, clip.q.col(f), frames);
    constexpr double clearly = 1e-3;  // the first of frames that are alike
    if (const double found = uprightness(parts, frames, up); found > pose.uprightness + clearly)
      pose = {frames, f, found};
  }
  return pose;
}

namespace {

/// On feet: the lowest ends along `up` lie on both sides of the middle.
bool standsOnItsEnds(const Skeleton& skeleton, const Frames& frames, const Vector3d& up) {
  Eigen::AlignedBox3d box;
  double lowest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    box.extend(frames[i].translation());
    if (skeleton.children(i).empty()) lowest = std::min(lowest, up.dot(frames[i].translation()));
  }
  const double size = box.sizes().maxCoeff(), height = up.dot(box.sizes());
  int left = 0, right = 0;
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Vector3d& p = frames[i].translation();
    if (!skeleton.children(i).empty() || up.dot(p) > lowest + 0.06 * height) continue;
    const double aside = p.x() - box.center().x();
    left += aside > 0.02 * size;
    right += aside < -0.02 * size;
  }
  return height > 0.3 * size && left > 0 && right > 0;
}

}  // namespace

Vector3d upOf(const Skeleton& skeleton, const MotionClip& clip, const StandingParts& parts) {
  const auto standsAlong = [&](const Vector3d& up) {
    if (!parts.empty()) return standingPose(skeleton, clip, parts, up).uprightness >= standsAbove;
    return standsOnItsEnds(skeleton, restFrames(skeleton), up) ||
           (clip.frameCount() > 0 &&
            standsOnItsEnds(skeleton, forwardKinematics(skeleton, clip.q.col(0)), up));
  };
  return !standsAlong(Vector3d::UnitY()) && standsAlong(Vector3d::UnitZ()) ? Vector3d(Vector3d::UnitZ())
                                                                           : Vector3d(Vector3d::UnitY());
}

}  // namespace gelenk
