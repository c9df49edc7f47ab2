#pragma once

#include <string>
#include <vector>

#include "apps/document/model_files.h"
#include "kinematics/motion/motion_retarget.h"

namespace gelenk {

/// A motion of another file, made to fit a model.
struct FittedClip {
  MotionClip clip;
  std::vector<Note>
      notes;  ///< what was done to it: resampled, carried over by names, joints that nothing moves
};

/// The motion in `path` for the model, at the given rate (Hz). A motion of the same skeleton is taken as it
/// is; another one goes by joints of equal names (motion_retarget.h). modelFile and companions: what the
/// model was opened from; an AMC is read with its ASF. Throws ParseError and std::invalid_argument (no
/// motion, nothing matches).
FittedClip clipFor(const Model& model, double framesPerSecond, const std::string& path,
                   const std::string& modelFile, Companions companions);

/// "12 of the motion's joints carried over by name; nothing moves a, b, c; not used are d, e".
std::string describe(const JointMatching& matching);

}  // namespace gelenk
