#include "apps/render/motion_marks.h"

#include <algorithm>
#include <cmath>

#include "kinematics/configuration.h"

namespace gelenk {

using Eigen::Vector3d;

MotionFacts motionFacts(const Skeleton& skeleton, const MotionClip& clip) {
  constexpr std::size_t mostWays = 8;
  MotionFacts facts{.feet = cmuFeet(skeleton)};
  facts.contacts = footContacts(skeleton, clip, facts.feet);
  std::vector<int> ends;
  for (const Foot& foot : facts.feet) ends.push_back(foot.ball);
  for (int i = skeleton.jointCount() - 1; i >= 0 && ends.size() < mostWays; --i)
    if (skeleton.children(i).empty() &&
        std::ranges::none_of(facts.feet, [&](const Foot& foot) { return skeleton.isAncestor(foot.ball, i); }))
      ends.push_back(i);
  facts.ways.resize(ends.size());
  facts.outside.resize(clip.frameCount());
  Frames frames;
  for (int f = 0; f < clip.frameCount(); ++f) {
    const Eigen::VectorXd q = clip.q.col(f);
    forwardKinematics(skeleton, q, frames);
    for (std::size_t k = 0; k < ends.size(); ++k) facts.ways[k].push_back(frames[ends[k]].translation());
    for (int i = 0; i < skeleton.jointCount(); ++i)
      if (limitViolation(skeleton, q, i) > 1e-9) facts.outside[f].push_back(i);
  }
  return facts;
}

int frameAt(const MotionClip& clip, double seconds) {
  return std::clamp(static_cast<int>(std::lround(seconds * clip.framesPerSecond)), 0, clip.frameCount() - 1);
}

void addMotionMarks(const Session& session, const MotionClip& clip, const MotionFacts& facts,
                    const Frames& worldFromJoint, double groundHeight, double size,
                    const MarkColours& colours, Overlay& inScene, Overlay& onTop) {
  const Playback& play = session.document().playback;
  const int frame = frameAt(clip, session.document().edits.seconds);
  if (play.trails) {
    const int reach = std::max(1, static_cast<int>(0.6 * clip.framesPerSecond)),
              step = std::max(1, reach / 40);
    const int from = std::max(0, frame - reach), to = std::min(clip.frameCount() - 1, frame + reach);
    for (const auto& way : facts.ways)
      for (int f = from; f + step <= to; f += step) {
        const float near = 1.0f - static_cast<float>(std::abs(f - frame)) / static_cast<float>(reach + 1);
        inScene.line(way[f], way[f + step],
                     withAlpha(f < frame ? colours.accent : colours.dim, 0.15f + 0.7f * near), 1.8f);
      }
  }
  if (play.contacts)
    for (const Contact& contact : facts.contacts) {
      const bool now = frame >= contact.first && frame <= contact.last;
      Vector3d at = facts.ways[contact.foot][std::clamp(frame, contact.first, contact.last)];
      at.y() = groundHeight + 0.002;
      const double r = 0.012 * size;
      inScene.annulus(at, Vector3d::UnitX(), Vector3d::UnitZ(), 0.6 * r, r,
                      now ? withAlpha(colours.held, 0.95f) : withAlpha(colours.dim, 0.3f));
    }
  if (play.limits)
    for (const int joint : facts.outside[frame])
      onTop.point(worldFromJoint[joint].translation(), colours.bad, 9.0f, Overlay::Shape::Ring);
}

}  // namespace gelenk
