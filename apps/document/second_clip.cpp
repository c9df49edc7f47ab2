#include "apps/document/second_clip.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gelenk {
namespace {

/// Configurations mean the same in both, whatever the lengths of the bones.
bool sameJoints(const Skeleton& a, const Skeleton& b) {
  if (a.jointCount() != b.jointCount() || a.nq() != b.nq()) return false;
  for (int i = 0; i < a.jointCount(); ++i) {
    const Joint &p = a.joint(i), &q = b.joint(i);
    if (p.name != q.name || p.parent != q.parent || p.ball != q.ball || p.axes.size() != q.axes.size())
      return false;
    for (std::size_t k = 0; k < p.axes.size(); ++k)
      if (p.axes[k].kind != q.axes[k].kind || (p.axes[k].axis - q.axes[k].axis).norm() > 1e-9) return false;
  }
  return true;
}

Imported open(const std::string& path, const std::string& modelFile, Companions companions) {
  companions.clip.clear();  // these are the model's
  companions.up.clear();
  if (fileKind(path) != FileKind::Amc) return importFiles(path);
  const auto kind = fileKind(modelFile);
  companions.amc = path;
  if (isMesh(kind))
    return importFiles(modelFile, companions);  // a fitted body: the root's path is scaled for it
  return importFiles(path, {.asf = kind == FileKind::Asf ? modelFile : companions.asf});
}

}  // namespace

std::string describe(const JointMatching& matching) {
  std::string words = fmt::format("{} joints carried over by name", matching.matches.size());
  if (!matching.unmatchedTarget.empty()) words += "; nothing moves " + listed(matching.unmatchedTarget, 12);
  if (!matching.unmatchedSource.empty()) words += "; not used are " + listed(matching.unmatchedSource, 12);
  return words;
}

std::vector<Note> describe(const Skeleton& target, const RetargetedClip& carried, double framesPerSecond) {
  std::vector<Note> notes;
  tellFact(notes, "retargeted",
           describe(carried.matching) + fmt::format("; path scaled by {:.4f}", carried.scale) +
               (carried.rootMoves ? "" : ", but no joint can carry it"));
  if (carried.scale < smallestUsualScale || carried.scale > largestUsualScale)
    tell(notes, "path-scale",
         fmt::format("a path scaled by {:.4g} is unusual: is the motion in another unit?", carried.scale));
  if (carried.sourceUp.z() > 0.5) tellFact(notes, "up-axis", "the motion stands along z: turned to y");
  constexpr double stands = 0.8;
  if (carried.uprightness < stands)
    tell(notes, "no-stance",
         "the motion never stands upright along y or z: directions of bones are compared in its most upright "
         "pose");
  else if (carried.standingFrame >= 0)
    tellFact(notes, "standing-frame",
             fmt::format("its zero pose is no stance: directions of bones are compared in frame {}",
                         carried.standingFrame + 1));
  constexpr double degree = M_PI / 180.0, worthTelling = 0.5 * degree;
  std::vector<std::string> left;
  for (const RemainingAngle& angle : carried.remaining)
    if (angle.largest > worthTelling)
      left.push_back(fmt::format("{} {:.1f} (at most {:.1f})", target.joint(angle.joint).name,
                                 angle.mean / degree, angle.largest / degree));
  tellFact(notes, "remaining-angle",
           left.empty()
               ? fmt::format("all {} matched bones point as the motion's do, to 0.5 degrees",
                             carried.remaining.size())
               : "degrees that are left on average between bones and the motion's: " + listed(left, 100));
  for (const KeptPlace& kept : carried.kept)
    tellFact(
        notes, "kept-place",
        fmt::format("{}: {:.2f} mm from its place on average, {:.2f} at most", target.joint(kept.joint).name,
                    1e3 * kept.mean, 1e3 * kept.largest) +
            (kept.framesBeyond == 0
                 ? ""
                 : fmt::format(": in {} of {} frames the place lies beyond the limb's reach, in the others "
                               "{:.2f} at most are left",
                               kept.framesBeyond, carried.clip.frameCount(), 1e3 * kept.largestWithin)) +
            (kept.contactFrames == 0
                 ? ""
                 : fmt::format("; standing it slides {:.4f} m/s, the motion's {:.4f}",
                               kept.targetSlide * framesPerSecond, kept.sourceSlide * framesPerSecond)));
  return notes;
}

FittedClip clipFor(const Model& model, double framesPerSecond, const std::string& path,
                   const std::string& modelFile, Companions companions) {
  const Imported other = open(path, modelFile, std::move(companions));
  if (!other.model.clip) throw std::invalid_argument("'" + path + "' has no motion");
  FittedClip result{.clip = *other.model.clip, .notes = {}};
  for (const Note& note : other.model.notes)  // those of a skeleton that both have were told before
    if (std::ranges::find(model.notes, note.text, &Note::text) == model.notes.end())
      result.notes.push_back(note);
  if (!sameJoints(other.model.skeleton, model.skeleton)) {
    RetargetedClip carried =
        retargeted(other.model.skeleton, result.clip, model.skeleton, {.targetUp = model.up});
    tell(result.notes, describe(model.skeleton, carried, result.clip.framesPerSecond));
    result.clip = std::move(carried.clip);
  }
  if (std::abs(result.clip.framesPerSecond - framesPerSecond) > 1e-9 * framesPerSecond) {
    tellFact(result.notes, "resampled",
             fmt::format("{}: resampled from {:.6g} to {:.6g} Hz", path, result.clip.framesPerSecond,
                         framesPerSecond));
    result.clip = resampled(model.skeleton, result.clip, framesPerSecond);
  }
  return result;
}

}  // namespace gelenk
