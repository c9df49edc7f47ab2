#include "apps/document/second_clip.h"

#include <fmt/format.h>

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
  if (fileKind(path) != FileKind::Amc) return importFiles(path);
  const auto kind = fileKind(modelFile);
  companions.amc = path;
  if (kind == FileKind::ObjMesh || kind == FileKind::Nurbs)
    return importFiles(modelFile, companions);  // a fitted body: the root's path is scaled for it
  companions.amc.clear();
  if (companions.asf.empty() && kind == FileKind::Asf) companions.asf = modelFile;
  return importFiles(path, companions);
}

}  // namespace

std::string describe(const JointMatching& matching) {
  std::string words = fmt::format("{} joints carried over by name", matching.matches.size());
  if (!matching.unmatchedTarget.empty()) words += "; nothing moves " + listed(matching.unmatchedTarget, 12);
  if (!matching.unmatchedSource.empty()) words += "; not used are " + listed(matching.unmatchedSource, 12);
  return words;
}

FittedClip clipFor(const Model& model, double framesPerSecond, const std::string& path,
                   const std::string& modelFile, Companions companions) {
  const Imported other = open(path, modelFile, std::move(companions));
  if (!other.model.clip) throw std::invalid_argument("'" + path + "' has no motion");
  FittedClip result{.clip = *other.model.clip, .notes = {}};
  if (!sameJoints(other.model.skeleton, model.skeleton)) {
    RetargetedClip carried = retargeted(other.model.skeleton, result.clip, model.skeleton);
    result.clip = std::move(carried.clip);
    tellFact(
        result.notes, "retargeted",
        path + ": " + describe(carried.matching) + fmt::format("; path scaled by {:.4f}", carried.scale));
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
