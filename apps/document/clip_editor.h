#pragma once

#include <map>
#include <memory>
#include <vector>

#include "kinematics/motion/motion_edit.h"

namespace gelenk {

/// What was done to a motion: an edited whole, with keys of single joints on top.
struct ClipEdits {
  std::shared_ptr<const MotionClip> base = {};     ///< null: the motion as its file holds it
  double framesPerSecond = 0.0;                    ///< plays faster or slower; 0: as the base says
  std::map<int, std::vector<JointKey>> keys = {};  ///< by joint, ascending frames
  double falloff = 0.25;  ///< seconds in which a joint comes back before its first and after its last key
};

/// A clip being edited: edits of the whole clip, one after the other, with keys of single joints on top.
/// Values only, no window; the way back is the document's (edits() and setEdits()).
///
/// Keys can be moved and taken away until the next edit of the whole clip, which takes the keyed clip as it
/// is.
class ClipEditor {
 public:
  /// Throws std::invalid_argument for a clip that does not fit it.
  ClipEditor(const Skeleton& skeleton, MotionClip original);

  /// What plays: the edited clip with the keys.
  const MotionClip& clip() const { return keyed_; }
  /// Counts the changes, for those who keep what they made of clip().
  int version() const { return version_; }

  /// What was done so far; null: nothing.
  const std::shared_ptr<const ClipEdits>& edits() const { return now_; }
  /// Throws std::invalid_argument for edits that do not fit skeleton and clip.
  void setEdits(std::shared_ptr<const ClipEdits> edits);

  /// The result of any edit of clip().
  void replace(MotionClip edited);
  /// Fades into a second clip (crossFaded).
  void crossFade(const MotionClip& second, double seconds);
  void lay(const Layer& layer);
  void setFrameRate(double framesPerSecond);  ///< plays the same frames faster or slower

  /// Frames of each joint's keys, ascending.
  const std::map<int, std::vector<JointKey>>& keys() const { return edited().keys; }
  bool hasKey(int joint, int frame) const;
  /// Every frame in which a joint has a key, ascending.
  std::vector<int> keyFrames() const;
  /// The joint takes this pose (nq, its own entries) in that frame.
  void setKeys(const std::vector<int>& joints, int frame, const Eigen::VectorXd& q);
  void removeKeys(int frame);  ///< of all joints in that frame
  void removeKey(int joint, int frame);
  /// All keys of one frame go to another, replacing what is there.
  void moveKeys(int from, int to);
  double falloff() const { return edited().falloff; }
  void setFalloff(double seconds);
  void backToOriginal() { setEdits({}); }

 private:
  const ClipEdits& edited() const;
  MotionClip baseOf(const ClipEdits& edits) const;
  void change(ClipEdits next);
  void requireFrame(int frame) const;

  Skeleton skeleton_;
  MotionClip original_, keyed_;
  std::shared_ptr<const ClipEdits> now_;
  int version_ = 0;
};

/// Joints whose own motion differs between two configurations by more than 1e-6 rad or m.
std::vector<int> movedJoints(const Skeleton& skeleton, const Eigen::VectorXd& from,
                             const Eigen::VectorXd& to);

}  // namespace gelenk
