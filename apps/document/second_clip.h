#pragma once

#include <string>
#include <vector>

#include "apps/document/model_files.h"
#include "kinematics/motion/motion_retarget.h"

namespace gelenk {

/// A motion of another file, made to fit a model.
struct FittedClip {
  MotionClip clip;
  std::vector<Note> notes;  ///< its file's, and what was done to it: carried over by names, resampled
};

/// The motion in `path` for the model, at the given rate (Hz). A motion of the same skeleton is taken as it
/// is; another one goes by joints of equal names (motion_retarget.h). modelFile and companions: what the
/// model was opened from; an AMC is read with its ASF. Throws ParseError and std::invalid_argument (no
/// motion, nothing matches). A scale that is no usual one is told, not refused.
FittedClip clipFor(const Model& model, double framesPerSecond, const std::string& path,
                   const std::string& modelFile, Companions companions);

/// What was found and done when a motion was carried over: the joints by name, the axis that points up, the
/// frame that stands, the scale, kept hands and feet, and the angles that hinges leave, above half a degree.
/// Notes, not facts: a scale below 0.2 or above 5 ("path-scale"), a motion that never stands ("no-stance").
std::vector<Note> describe(const Skeleton& target, const RetargetedClip& carried, double framesPerSecond);

/// "12 of the motion's joints carried over by name; nothing moves a, b, c; not used are d, e".
std::string describe(const JointMatching& matching);

}  // namespace gelenk
