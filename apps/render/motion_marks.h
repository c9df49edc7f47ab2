#pragma once

#include <vector>

#include "apps/document/session.h"
#include "apps/render/overlay.h"
#include "apps/render/signs.h"
#include "kinematics/motion/motion_edit.h"

namespace gelenk {

/// What is known of a motion before it plays.
struct MotionFacts {
  std::vector<Foot> feet = {};
  std::vector<Contact> contacts = {};
  std::vector<std::vector<Eigen::Vector3d>> ways =
      {};                                      ///< of the ends, every frame: metres, world; feet first
  std::vector<std::vector<int>> outside = {};  ///< joints beyond their limits, every frame
};
MotionFacts motionFacts(const Skeleton& skeleton, const MotionClip& clip);

/// The frame at so many seconds, from 0.
int frameAt(const MotionClip& clip, double seconds);

/// The marks that the document asks for (Playback) about the frame under its playhead: trails of the ends,
/// places where feet stand, rings at joints beyond their limits.
void addMotionMarks(const Session& session, const MotionClip& clip, const MotionFacts& facts,
                    const Frames& worldFromJoint, double groundHeight, double size,
                    const MarkColours& colours, Overlay& inScene, Overlay& onTop);

}  // namespace gelenk
