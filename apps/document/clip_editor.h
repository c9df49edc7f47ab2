#pragma once

#include <map>
#include <vector>

#include "kinematics/motion/motion_edit.h"

namespace gelenk {

/// A clip being edited: edits of the whole clip, one after the other, with keys of single joints on top, and
/// the way back. Values only, no window.
///
/// Keys can be moved and taken away until the next edit of the whole clip, which takes the keyed clip as it
/// is. Every change that is made can be undone.
class ClipEditor {
 public:
  /// Throws std::invalid_argument for a clip that does not fit it.
  ClipEditor(const Skeleton& skeleton, MotionClip original);

  /// What plays: the edited clip with the keys.
  const MotionClip& clip() const { return keyed_; }
  /// Counts the changes, for those who keep what they made of clip().
  int version() const { return version_; }

  /// The result of any edit of clip().
  void replace(MotionClip edited);
  /// Fades into a second clip (crossFaded).
  void crossFade(const MotionClip& second, double seconds);
  void lay(const Layer& layer);
  void setFrameRate(double framesPerSecond);  ///< plays the same frames faster or slower; not undone

  /// Frames of each joint's keys, ascending.
  const std::map<int, std::vector<JointKey>>& keys() const { return now_.keys; }
  bool hasKey(int joint, int frame) const;
  /// Every frame in which a joint has a key, ascending.
  std::vector<int> keyFrames() const;
  /// The joint takes this pose (nq, its own entries) in that frame; one change of several joints is undone at
  /// once.
  void setKeys(const std::vector<int>& joints, int frame, const Eigen::VectorXd& q);
  void removeKeys(int frame);  ///< of all joints in that frame
  void removeKey(int joint, int frame);
  /// All keys of one frame go to another, replacing what is there.
  void moveKeys(int from, int to);
  /// Seconds in which a joint comes back to the clip before its first and after its last key.
  double falloff() const { return now_.falloff; }
  void setFalloff(double seconds);

  bool undo();
  bool redo();
  bool canUndo() const { return !past_.empty(); }
  bool canRedo() const { return !future_.empty(); }
  void backToOriginal();

 private:
  struct State {
    MotionClip base;
    std::map<int, std::vector<JointKey>> keys = {};
    double falloff = 0.25;
  };
  void change(State next);
  void rebuild();
  void requireFrame(int frame) const;

  Skeleton skeleton_;
  MotionClip original_, keyed_;
  State now_;
  std::vector<State> past_, future_;
  int version_ = 0;
};

/// Joints whose own motion differs between two configurations by more than 1e-6 rad or m.
std::vector<int> movedJoints(const Skeleton& skeleton, const Eigen::VectorXd& from,
                             const Eigen::VectorXd& to);

}  // namespace gelenk
