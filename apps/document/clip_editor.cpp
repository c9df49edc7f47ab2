#include "apps/document/clip_editor.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include "kinematics/configuration.h"

namespace gelenk {
namespace {

constexpr std::size_t longestHistory = 20;  // whole clips: 5,000 frames of 62 values are 2.5 MB

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
  now_.base = original_;
  rebuild();
}

void ClipEditor::rebuild() {
  keyed_ = now_.base;
  for (const auto& [joint, keys] : now_.keys) keyed_ = keyed(skeleton_, keyed_, joint, keys, now_.falloff);
  ++version_;
}

void ClipEditor::change(State next) {
  std::erase_if(next.keys, [](const auto& entry) { return entry.second.empty(); });
  past_.push_back(std::exchange(now_, std::move(next)));
  if (past_.size() > longestHistory) past_.erase(past_.begin());
  future_.clear();
  rebuild();
}

void ClipEditor::requireFrame(int frame) const {
  if (frame < 0 || frame >= now_.base.frameCount())
    throw std::invalid_argument("the clip has frames 1 to " + std::to_string(now_.base.frameCount()) +
                                ", not " + std::to_string(frame + 1));
}

void ClipEditor::replace(MotionClip edited) {
  validate(skeleton_, edited);
  change({.base = std::move(edited), .falloff = now_.falloff});
}

void ClipEditor::crossFade(const MotionClip& second, double seconds) {
  replace(crossFaded(skeleton_, keyed_, second, seconds));
}

void ClipEditor::lay(const Layer& layer) { replace(layered(skeleton_, keyed_, layer)); }

void ClipEditor::setFrameRate(double framesPerSecond) {
  if (!(framesPerSecond > 0.0) || !std::isfinite(framesPerSecond))
    throw std::invalid_argument("a frame rate must be positive");
  original_.framesPerSecond = now_.base.framesPerSecond = framesPerSecond;
  for (auto* states : {&past_, &future_})
    for (State& state : *states) state.base.framesPerSecond = framesPerSecond;
  rebuild();
}

bool ClipEditor::hasKey(int joint, int frame) const {
  const auto at = now_.keys.find(joint);
  return at != now_.keys.end() && std::any_of(at->second.begin(), at->second.end(),
                                              [&](const JointKey& key) { return key.frame == frame; });
}

std::vector<int> ClipEditor::keyFrames() const {
  std::set<int> frames;
  for (const auto& [joint, keys] : now_.keys)
    for (const JointKey& key : keys) frames.insert(key.frame);
  return {frames.begin(), frames.end()};
}

void ClipEditor::setKeys(const std::vector<int>& joints, int frame, const Eigen::VectorXd& q) {
  requireFrame(frame);
  if (q.size() != skeleton_.nq() || !q.allFinite())
    throw std::invalid_argument("a key's pose does not fit the skeleton");
  State next = now_;
  for (const int joint : joints) setKey(next.keys[joint], {frame, q});
  if (!joints.empty()) change(std::move(next));
}

void ClipEditor::removeKeys(int frame) {
  State next = now_;
  bool any = false;
  for (auto& [joint, keys] : next.keys) any = dropKey(keys, frame) || any;
  if (any) change(std::move(next));
}

void ClipEditor::removeKey(int joint, int frame) {
  if (!hasKey(joint, frame)) return;
  State next = now_;
  dropKey(next.keys[joint], frame);
  change(std::move(next));
}

void ClipEditor::moveKeys(int from, int to) {
  requireFrame(to);
  if (from == to) return;
  State next = now_;
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
  now_.falloff = seconds;
  rebuild();
}

bool ClipEditor::undo() {
  if (past_.empty()) return false;
  future_.push_back(std::exchange(now_, std::move(past_.back())));
  past_.pop_back();
  rebuild();
  return true;
}

bool ClipEditor::redo() {
  if (future_.empty()) return false;
  past_.push_back(std::exchange(now_, std::move(future_.back())));
  future_.pop_back();
  rebuild();
  return true;
}

void ClipEditor::backToOriginal() { replace(original_); }

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
