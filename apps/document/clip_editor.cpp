#include "apps/document/clip_editor.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include "kinematics/configuration.h"

namespace gelenk {
namespace {

auto keyAt(std::vector<JointKey>& keys, int frame) {
  return std::lower_bound(keys.begin(), keys.end(), frame,
                          [](const JointKey& key, int f) { return key.frame < f; });
}

void setKey(std::vector<JointKey>& keys, JointKey key) {
  const auto at = keyAt(keys, key.frame);
  if (at != keys.end() && at->frame == key.frame)
    *at = std::move(key);
  else
    keys.insert(at, std::move(key));
}

bool dropKey(std::vector<JointKey>& keys, int frame) {
  const auto at = keyAt(keys, frame);
  if (at == keys.end() || at->frame != frame) return false;
  keys.erase(at);
  return true;
}

}  // namespace

ClipEditor::ClipEditor(const Skeleton& skeleton, MotionClip original)
    : skeleton_(skeleton), original_(std::move(original)) {
  validate(skeleton_, original_);
  setEdits({});
}

const ClipEdits& ClipEditor::edited() const {
  static const ClipEdits none;
  return now_ ? *now_ : none;
}

MotionClip ClipEditor::baseOf(const ClipEdits& edits) const {
  MotionClip clip = edits.base ? *edits.base : original_;
  if (edits.framesPerSecond > 0.0) clip.framesPerSecond = edits.framesPerSecond;
  return clip;
}

void ClipEditor::setEdits(std::shared_ptr<const ClipEdits> edits) {
  MotionClip clip = baseOf(edits ? *edits : ClipEdits{});
  validate(skeleton_, clip);
  if (edits)
    for (const auto& [joint, keys] : edits->keys) clip = keyed(skeleton_, clip, joint, keys, edits->falloff);
  keyed_ = std::move(clip);
  now_ = std::move(edits);
  ++version_;
}

void ClipEditor::change(ClipEdits next) {
  std::erase_if(next.keys, [](const auto& entry) { return entry.second.empty(); });
  setEdits(std::make_shared<const ClipEdits>(std::move(next)));
}

void ClipEditor::requireFrame(int frame) const {
  if (frame < 0 || frame >= keyed_.frameCount())
    throw std::invalid_argument("the clip has frames 1 to " + std::to_string(keyed_.frameCount()) + ", not " +
                                std::to_string(frame + 1));
}

void ClipEditor::replace(MotionClip clip) {
  validate(skeleton_, clip);
  change({.base = std::make_shared<const MotionClip>(std::move(clip)), .falloff = falloff()});
}

void ClipEditor::crossFade(const MotionClip& second, double seconds) {
  replace(crossFaded(skeleton_, keyed_, second, seconds));
}

void ClipEditor::lay(const Layer& layer) { replace(layered(skeleton_, keyed_, layer)); }

void ClipEditor::setFrameRate(double framesPerSecond) {
  if (!(framesPerSecond > 0.0) || !std::isfinite(framesPerSecond))
    throw std::invalid_argument("a frame rate must be positive");
  ClipEdits next = edited();
  next.framesPerSecond = framesPerSecond;
  change(std::move(next));
}

bool ClipEditor::hasKey(int joint, int frame) const {
  const auto at = keys().find(joint);
  return at != keys().end() && std::any_of(at->second.begin(), at->second.end(),
                                           [&](const JointKey& key) { return key.frame == frame; });
}

std::vector<int> ClipEditor::keyFrames() const {
  std::set<int> frames;
  for (const auto& [joint, list] : keys())
    for (const JointKey& key : list) frames.insert(key.frame);
  return {frames.begin(), frames.end()};
}

void ClipEditor::setKeys(const std::vector<int>& joints, int frame, const Eigen::VectorXd& q) {
  requireFrame(frame);
  if (q.size() != skeleton_.nq() || !q.allFinite())
    throw std::invalid_argument("a key's pose does not fit the skeleton");
  ClipEdits next = edited();
  for (const int joint : joints) setKey(next.keys[joint], {frame, q});
  if (!joints.empty()) change(std::move(next));
}

void ClipEditor::removeKeys(int frame) {
  ClipEdits next = edited();
  bool any = false;
  for (auto& [joint, keys] : next.keys) any = dropKey(keys, frame) || any;
  if (any) change(std::move(next));
}

void ClipEditor::removeKey(int joint, int frame) {
  if (!hasKey(joint, frame)) return;
  ClipEdits next = edited();
  dropKey(next.keys[joint], frame);
  change(std::move(next));
}

void ClipEditor::moveKeys(int from, int to) {
  requireFrame(to);
  if (from == to) return;
  ClipEdits next = edited();
  bool any = false;
  for (auto& [joint, keys] : next.keys) {
    const auto at = keyAt(keys, from);
    if (at == keys.end() || at->frame != from) continue;
    JointKey key{to, std::move(at->q)};
    keys.erase(at);
    setKey(keys, std::move(key));
    any = true;
  }
  if (any) change(std::move(next));
}

void ClipEditor::setFalloff(double seconds) {
  if (!(seconds >= 0.0) || !std::isfinite(seconds))
    throw std::invalid_argument("the time in which a key fades cannot be negative");
  ClipEdits next = edited();
  next.falloff = seconds;
  change(std::move(next));
}

std::vector<int> movedJoints(const Skeleton& skeleton, const Eigen::VectorXd& from,
                             const Eigen::VectorXd& to) {
  const Eigen::VectorXd dq = difference(skeleton, from, to);
  std::vector<int> moved;
  for (int i = 0; i < skeleton.jointCount(); ++i)
    if (skeleton.vCount(i) > 0 && dq.segment(skeleton.vIndex(i), skeleton.vCount(i)).norm() > 1e-6)
      moved.push_back(i);
  return moved;
}

}  // namespace gelenk
