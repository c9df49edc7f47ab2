#include "kinematics/motion/skeleton_transfer.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "kinematics/motion/joint_matching.h"
#include "kinematics/rotation.h"

namespace gelenk {

using Eigen::Quaterniond;
using Eigen::Vector3d;

std::vector<BonePath> parseBonePaths(std::string_view text, const std::string& file) {
  std::vector<BonePath> paths;
  const auto lines = splitLines(plainText(text, file));
  for (std::size_t n = 0; n < lines.size(); ++n) {
    const int line = static_cast<int>(n) + 1;
    const std::string_view content = lines[n].substr(0, lines[n].find('#'));
    if (splitWords(content).empty()) continue;
    const std::size_t colon = content.find(':');
    if (colon == std::string_view::npos) throw ParseError(file, line, "bones : joints", "no colon");
    BonePath path{.bones = {}, .joints = {}, .file = file, .line = line};
    for (const auto word : splitWords(content.substr(0, colon))) path.bones.emplace_back(word);
    for (const auto word : splitWords(content.substr(colon + 1))) path.joints.emplace_back(word);
    if (path.bones.empty()) throw ParseError(file, line, "at least one bone before the colon", "none");
    if (path.joints.size() < 2)
      throw ParseError(file, line, "at least two joints after the colon", std::to_string(path.joints.size()));
    paths.push_back(std::move(path));
  }
  if (paths.empty()) throw ParseError(file, 0, "at least one line 'bones : joints'", "none");
  return paths;
}

std::vector<BonePath> cmuOnPinocchioHuman() {
  std::vector<BonePath> paths{{{"lowerback", "upperback", "thorax"}, {"pelvis", "spine", "chest"}},
                              {{"lowerneck", "upperneck", "head"}, {"chest", "head"}}};
  for (const std::string side : {"left", "right"}) {
    const std::string s = side.substr(0, 1);
    paths.push_back({{s + "hipjoint"}, {"pelvis", "hip_" + side}});
    paths.push_back({{s + "femur"}, {"hip_" + side, "knee_" + side}});
    paths.push_back({{s + "tibia"}, {"knee_" + side, "ankle_" + side}});
    paths.push_back({{s + "foot"}, {"ankle_" + side, "toe_" + side}});
    paths.push_back({{s + "clavicle"}, {"chest", "shoulder_" + side}});
    paths.push_back({{s + "humerus"}, {"shoulder_" + side, "elbow_" + side}});
    paths.push_back({{s + "radius", s + "wrist"}, {"elbow_" + side, "hand_" + side}});
  }
  return paths;
}

namespace {

/// A path that cannot be laid: with its line where it has one.
[[noreturn]] void refuse(const BonePath& path, const std::string& expected, const std::string& found) {
  if (path.line > 0) throw ParseError(path.file, path.line, expected, found);
  throw std::invalid_argument("expected " + expected + ", found " + found);
}

template <class Items, class NameOf>
std::string listed(const Items& items, NameOf nameOf) {
  std::string names;
  for (const auto& item : items) names += (names.empty() ? "" : ", ") + nameOf(item);
  return names;
}

int fittedJoint(const Skeleton& fitted, const BonePath& path, const std::string& name) {
  if (const auto found = fitted.findJoint(name)) return *found;
  if (const auto index = parseInteger(name); index && *index >= 0 && *index < fitted.jointCount())
    return *index;
  refuse(path,
         "a joint of the fitted skeleton (" +
             listed(fitted.joints(), [](const Joint& joint) { return joint.name; }) + ")",
         "'" + name + "'");
}

int asfBone(const AsfSkeleton& asf, const BonePath& path, const std::string& name) {
  if (const auto found = asf.findBone(name)) return *found;
  refuse(path,
         "a bone of the ASF skeleton (" +
             listed(asf.bones, [](const AsfSkeleton::Bone& bone) { return bone.name; }) + ")",
         "'" + name + "'");
}

/// A path with its names looked up and its geometry measured.
struct LaidPath {
  std::vector<int> bones, joints;
  std::vector<Vector3d> corners;
  std::vector<double> arc;  ///< length along the path up to each corner
};

LaidPath lay(const AsfSkeleton& asf, const Skeleton& fitted, const Frames& rest, const BonePath& path) {
  LaidPath laid;
  for (const std::string& name : path.bones) {
    const int bone = asfBone(asf, path, name);
    if (bone == 0)
      refuse(path, "a bone (the root is none: it goes where the paths of its bones begin)", "'" + name + "'");
    if (!laid.bones.empty() && asf.skeleton.parent(bone) != laid.bones.back())
      refuse(path, "a bone that hangs on '" + asf.bones[laid.bones.back()].name + "' before it",
             "'" + name + "'");
    laid.bones.push_back(bone);
  }
  for (const std::string& name : path.joints) {
    const int joint = fittedJoint(fitted, path, name);
    laid.arc.push_back(0.0);
    if (!laid.joints.empty()) {
      const int before = laid.joints.back();
      if (fitted.parent(joint) != before && fitted.parent(before) != joint)
        refuse(path, "a joint that a bone joins to '" + fitted.joint(before).name + "'",
               "'" + fitted.joint(joint).name + "'");
      laid.arc.back() =
          laid.arc[laid.arc.size() - 2] + (rest[joint].translation() - laid.corners.back()).norm();
    }
    laid.corners.push_back(rest[joint].translation());
    laid.joints.push_back(joint);
  }
  return laid;
}

Vector3d pointAt(const LaidPath& path, double s) {
  std::size_t k = 1;
  while (k + 1 < path.arc.size() && s > path.arc[k]) ++k;
  const double length = path.arc[k] - path.arc[k - 1];
  const double t = length > 0.0 ? std::clamp((s - path.arc[k - 1]) / length, 0.0, 1.0) : 1.0;
  return path.corners[k - 1] + t * (path.corners[k] - path.corners[k - 1]);
}

/// Pieces of the fitted bones between two lengths along the path.
void addPieces(const LaidPath& path, const Skeleton& fitted, double from, double to, int joint,
               std::vector<BonePiece>& pieces) {
  for (std::size_t k = 1; k < path.arc.size(); ++k) {
    const double length = path.arc[k] - path.arc[k - 1];
    const double a = std::max(from, path.arc[k - 1]), b = std::min(to, path.arc[k]);
    if (!(b > a)) continue;
    const double s = (a - path.arc[k - 1]) / length, t = (b - path.arc[k - 1]) / length;
    const bool outwards = fitted.parent(path.joints[k]) == path.joints[k - 1];
    if (outwards)
      pieces.push_back({path.joints[k], s, t, joint});
    else
      pieces.push_back({path.joints[k - 1], 1.0 - t, 1.0 - s, joint});
  }
}

}  // namespace

namespace {

/// The joints from one to another through the tree, both included.
std::vector<int> wayThrough(const Skeleton& skeleton, int from, int to) {
  std::vector<int> up{from}, down{to};
  while (!skeleton.isAncestor(up.back(), to)) up.push_back(skeleton.parent(up.back()));
  while (down.back() != up.back()) down.push_back(skeleton.parent(down.back()));
  up.insert(up.end(), down.rbegin() + 1, down.rend());
  return up;
}

int pelvisOf(const Skeleton& skeleton) {
  const auto names = plainNames(skeleton);
  const auto found = std::find(names.begin(), names.end(), PlainName{"pelvis"});
  return found == names.end() ? 0 : static_cast<int>(found - names.begin());
}

}  // namespace

std::vector<BonePath> bonePathsByName(const AsfSkeleton& asf, const Skeleton& fitted) {
  const Skeleton& bones = asf.skeleton;
  std::vector<int> fittedOf(bones.jointCount(), -1);
  for (const JointMatch& match : matchJoints(bones, fitted).matches) fittedOf[match.source] = match.target;
  if (fittedOf[0] < 0) fittedOf[0] = pelvisOf(fitted);
  std::vector<bool> taken(bones.jointCount(), false);
  std::vector<BonePath> paths;
  for (int end = 1; end < bones.jointCount(); ++end) {
    if (fittedOf[end] < 0) continue;
    // The bones above, up to a matched one or one at the root; a bone at the root begins where the root's
    // match is.
    std::vector<int> chain;
    for (int bone = bones.parent(end); bone > 0; bone = bones.parent(bone)) {
      chain.insert(chain.begin(), bone);
      if (fittedOf[bone] >= 0) break;
    }
    if (chain.empty() || std::any_of(chain.begin(), chain.end(), [&](int bone) { return taken[bone]; }))
      continue;
    const int first = bones.parent(chain.front()) == 0 ? fittedOf[0] : fittedOf[chain.front()];
    if (first == fittedOf[end]) continue;
    BonePath path;
    for (const int bone : chain) path.bones.push_back(asf.bones[bone].name), taken[bone] = true;
    for (const int joint : wayThrough(fitted, first, fittedOf[end]))
      path.joints.push_back(fitted.joint(joint).name);
    paths.push_back(std::move(path));
  }
  return paths;
}

TransferredSkeleton transferSkeleton(const AsfSkeleton& asf, const Skeleton& fitted,
                                     const std::vector<BonePath>& paths) {
  const Frames rest = restFrames(fitted);
  const int boneCount = static_cast<int>(asf.bones.size());
  TransferredSkeleton result;
  std::vector<std::optional<Vector3d>> wantedEnd(boneCount);
  std::optional<int> rootJoint;
  double oldSum = 0.0, newSum = 0.0;

  for (const BonePath& path : paths) {
    const LaidPath laid = lay(asf, fitted, rest, path);
    if (asf.skeleton.parent(laid.bones.front()) == 0) {
      if (rootJoint && *rootJoint != laid.joints.front())
        refuse(path, "all bones at the root to begin at one joint, '" + fitted.joint(*rootJoint).name + "'",
               "'" + fitted.joint(laid.joints.front()).name + "'");
      rootJoint = laid.joints.front();
    }
    double total = 0.0;
    for (const int bone : laid.bones) total += asf.bones[bone].length;
    double done = 0.0;
    for (const int bone : laid.bones) {
      if (wantedEnd[bone])
        refuse(path, "every bone in one path only", "'" + asf.bones[bone].name + "' again");
      const double share =
          total > 0.0 ? asf.bones[bone].length / total : 1.0 / static_cast<double>(laid.bones.size());
      const double next = bone == laid.bones.back() ? laid.arc.back() : done + share * laid.arc.back();
      wantedEnd[bone] = pointAt(laid, next);
      addPieces(laid, fitted, done, next, bone, result.pieces);
      done = next;
    }
    oldSum += total;
    newSum += laid.arc.back();
  }
  if (!rootJoint) throw std::invalid_argument("no path begins at a bone of the root");
  const double meanRatio = oldSum > 0.0 ? newSum / oldSum : 1.0;

  // Bones from the root outwards: where each ends, how long it is, how it turned.
  std::vector<Vector3d> end(boneCount);
  std::vector<double> length(boneCount, 0.0);
  result.turns.assign(asf.skeleton.jointCount(), Quaterniond::Identity());
  result.bindFrames.resize(asf.skeleton.jointCount());
  end[0] = rest[*rootJoint].translation();
  const auto place = [&](int joint, const Quaterniond& orientation, const Vector3d& position) {
    result.bindFrames[joint].linear() = orientation.normalized().toRotationMatrix();
    result.bindFrames[joint].translation() = position;
    result.bindFrames[joint].makeAffine();
  };
  place(0, asf.bones[0].axis, end[0]);
  for (int b = 1; b < boneCount; ++b) {
    const AsfSkeleton::Bone& bone = asf.bones[b];
    const int parent = asf.skeleton.parent(b);
    const Vector3d start = end[parent];
    result.turns[b] = result.turns[parent];
    if (wantedEnd[b]) {
      const Vector3d along = *wantedEnd[b] - start;
      length[b] = along.norm();
      if (length[b] > 0.0 && bone.direction.norm() > 0.0)
        result.turns[b] = rotationBetween(bone.direction, along);
      end[b] = *wantedEnd[b];
    } else {
      length[b] = meanRatio * bone.length;
      end[b] = start + length[b] * (result.turns[b] * bone.direction);
      result.unmatchedBones.push_back(bone.name);
    }
    place(b, result.turns[b] * bone.axis, start);
  }

  // The skeleton: frames as in the ASF, lengths as fitted. Directions in a bone's own frame are the same in
  // both.
  std::vector<Joint> joints = asf.skeleton.joints();
  for (int i = 1; i < asf.skeleton.jointCount(); ++i) {
    const int parent = joints[i].parent;
    const AsfSkeleton::Bone& above = asf.bones[parent];
    joints[i].parentFromZero.translation() = above.axis.conjugate() * (length[parent] * above.direction);
    if (i >= boneCount) {  // a fixed end
      result.turns[i] = result.turns[parent];
      place(i, Quaterniond(result.bindFrames[parent].linear()), end[parent]);
    }
  }
  Skeleton zeroPose(joints);
  Eigen::VectorXd atFittedPlace = zeroPose.rest();
  for (std::size_t k = 0; k < joints[0].axes.size(); ++k)
    if (joints[0].axes[k].kind == AxisDof::Kind::Translation)
      atFittedPlace[k] = joints[0].axes[k].axis.dot(joints[0].parentFromZero.linear().transpose() *
                                                    (end[0] - joints[0].parentFromZero.translation()));
  result.skeleton = Skeleton(std::move(joints), atFittedPlace);

  double lowestBound = std::numeric_limits<double>::infinity(), lowestZero = lowestBound;
  const Frames asfZero = restFrames(asf.skeleton);
  for (const auto& frame : result.bindFrames) lowestBound = std::min(lowestBound, frame.translation().y());
  for (const auto& frame : asfZero) lowestZero = std::min(lowestZero, frame.translation().y());
  const double asfHeight = asfZero[0].translation().y() - lowestZero, fittedHeight = end[0].y() - lowestBound;
  result.heightRatio = asfHeight > 1e-6 && fittedHeight > 1e-6 ? fittedHeight / asfHeight : meanRatio;

  for (int j = 1; j < fitted.jointCount(); ++j)
    if (std::none_of(result.pieces.begin(), result.pieces.end(),
                     [j](const BonePiece& piece) { return piece.child == j; }))
      result.unmatchedJoints.push_back(fitted.joint(j).name);
  return result;
}

MotionClip withScaledRoot(const Skeleton& skeleton, MotionClip clip, double factor) {
  const Joint& root = skeleton.joint(0);
  for (std::size_t k = 0; k < root.axes.size(); ++k)
    if (root.axes[k].kind == AxisDof::Kind::Translation) clip.q.row(k) *= factor;
  return clip;
}

}  // namespace gelenk
