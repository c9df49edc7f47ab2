#pragma once

#include "apps/document/session.h"
#include "apps/render/overlay.h"
#include "apps/render/signs.h"

namespace gelenk {

// Signs of a document, made from session and frames. size: a typical length of the scene.

/// The range of a joint that lies at its limit: a sector for each axis at a bound, a cone for a ball. colour:
/// of the outline; its alpha is how brightly it glows.
void addLimit(Overlay& overlay, const Session& session, const Frames& worldFromJoint, int joint, double size,
              const Colour& colour);

/// What the end of a planar chain can reach when its joints turn freely: the ring between the shortest and
/// the longest reach.
void addWorkspace(Overlay& overlay, const Session& session, const Frames& worldFromJoint,
                  const MarkColours& colours);

/// The picture's right, level: orthogonal to up. Unit length.
Eigen::Vector3d levelRight(const Camera& camera, const Eigen::Vector3d& up);

/// The body moved aside as the document's camera sees it, so many places to the left (below 0: to the right),
/// each of step metres, less where the camera is near.
Frames framesBeside(const Session& session, Frames worldFromJoint, double step, int place = 1);

/// Goals that can be seen and taken now; pole handles only where their limb is held.
bool isGoalShown(const Session& session, const SceneGoal& goal);
/// Handles, pins and what is missed: discs are positions, squares pins, rings orientations, diamonds wishes
/// such as poles; and what a goal's type says it looks like. hovered: drawn larger; what
/// is hovered, dragged or selected shows the fainter lines of its type too. shows: whether it is drawn.
void addGoals(Overlay& overlay, const Session& session, double size, const MarkColours& colours,
              std::optional<GoalId> hovered, std::optional<GoalId> selected,
              const std::function<bool(const SceneGoal&)>& shows);

}  // namespace gelenk
