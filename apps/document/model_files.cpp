#include "apps/document/model_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <stdexcept>

#include "apps/document/file_format.h"
#include "kinematics/io/text_file.h"
#include "kinematics/io/word_stream.h"
#include "kinematics/motion/standing.h"
#include "kinematics/skeleton_transform.h"
#include "skinning/bodies/robot_body.h"

namespace gelenk {
namespace {

#define GELENK_ADDRESS(Kind, format) &format,
constexpr std::array table{GELENK_FILE_FORMATS(GELENK_ADDRESS)};
#undef GELENK_ADDRESS

/// The blank-separated words of `list`.
std::vector<std::string_view> words(std::string_view list) {
  std::vector<std::string_view> result;
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(' '), list.size());
    if (end > 0) result.push_back(list.substr(0, end));
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return result;
}

/// Length of the longest of the endings that the name has, 0 for none.
std::size_t endingLength(std::string_view name, std::string_view endings) {
  std::size_t longest = 0;
  for (const std::string_view ending : words(endings))
    if (name.ends_with(ending)) longest = std::max(longest, ending.size());
  return longest;
}

/// The file's first 255 characters; empty where it cannot be read.
std::string headOf(const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (!file) return {};
  char head[255];
  const std::size_t n = std::fread(head, 1, sizeof head, file);
  std::fclose(file);
  return {head, n};
}

}  // namespace

const FileFormat& fileFormat(FileKind kind) { return *table[static_cast<std::size_t>(kind)]; }

std::optional<FileKind> fileKind(const std::string& path) {
  const std::string name = lowerCase(path);
  std::optional<std::string> head;
  std::optional<FileKind> found;
  std::size_t longest = 0;
  for (std::size_t i = 0; i < table.size(); ++i) {
    const FileFormat& format = *table[i];
    if (format.recognises && endingLength(name, format.sharedEndings) > 0) {
      if (!head) head = headOf(path);
      if (format.recognises(*head)) return static_cast<FileKind>(i);
    }
    if (const std::size_t length = endingLength(name, format.endings); length > longest)
      longest = length, found = static_cast<FileKind>(i);
  }
  return found;
}

bool isMesh(std::optional<FileKind> kind) { return kind && fileFormat(*kind).isMesh; }

std::string describe(FileKind kind) { return std::string(fileFormat(kind).description); }

std::string knownExtensions() {
  std::string list;
  for (const FileFormat* format : table)
    for (const std::string_view ending : words(format->endings))
      list += (list.empty() ? "" : ", ") + std::string(ending);
  return list;
}

std::string stem(const std::string& path) {
  std::string name = std::filesystem::path(path).filename().string();
  const std::size_t dot = name.find('.', 1);
  return dot == std::string::npos ? name : name.substr(0, dot);
}

double metresPerUnit(const std::string& unit) {
  static const std::map<std::string, double> named{{"m", 1.0},    {"dm", 0.1},    {"cm", 0.01},
                                                   {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}};
  if (const auto found = named.find(unit); found != named.end()) return found->second;
  const auto value = parseNumber(unit);
  if (!value || !(*value > 0.0))
    throw std::invalid_argument("a unit must be m, dm, cm, mm, in, ft or a positive number of metres, not '" +
                                unit + "'");
  return *value;
}

Model openModelFile(const std::string& path) { return importFiles(path).model; }

Model rotated(Model model, const Eigen::Quaterniond& worldFromOld) {
  model.skeleton = rotated(model.skeleton, worldFromOld);
  if (model.skin) {
    for (auto& p : model.skin->mesh.positions) p = worldFromOld * p;
    for (auto& n : model.skin->mesh.normals) n = worldFromOld * n;
    for (auto& frame : model.skin->jointFromRestWorld)
      frame = frame * Eigen::Isometry3d(worldFromOld.conjugate());
  }
  return model;
}

namespace {

/// The rest pose at the place of the motion's first frame: an ASF's own stands with its hips on the floor.
void standWhereMotionBegins(Model& model) {
  if (model.skin) return;  // bound where it stands
  Eigen::VectorXd rest = model.skeleton.rest();
  const Joint& root = model.skeleton.joint(0);
  for (std::size_t k = 0; k < root.axes.size(); ++k)
    if (root.axes[k].kind == AxisDof::Kind::Translation) rest[k] = model.clip->q(k, 0);
  model.skeleton = Skeleton(model.skeleton.joints(), rest);
}

/// The axis against gravity, which few formats say. Values stay as they are in the file.
void findUp(const FileFormat& format, const std::string& wanted, Model& model) {
  if (!wanted.empty() && format.saysUp)
    throw std::invalid_argument(std::string(format.description) +
                                " says which axis is up; another cannot be given");
  if (!wanted.empty() && wanted != "y" && wanted != "z")
    throw std::invalid_argument("the axis that points up is y or z, not '" + wanted + "'");
  if (!wanted.empty()) model.up = wanted == "z" ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
  if (!wanted.empty() || format.saysUp || model.planar) return;
  MotionClip some{.framesPerSecond = 1.0, .q = {}};  // frames enough to find it standing
  if (model.clip) {
    const int frames = model.clip->frameCount(), step = std::max(1, frames / 200);
    some.q = model.clip->q(Eigen::all, Eigen::seq(0, frames - 1, step));
  }
  model.up = upOf(model.skeleton, some, standingParts(model.skeleton));
  if (model.up.z() > 0.5)
    tellFact(model.notes, "up-axis", "the body stands along z, which is taken as up",
             "--up chooses; convert --up-in z turns it");
}

/// Largest extent of the body (else of the joints) in the pose it stands in, metres.
double extentOf(const Model& model) {
  Eigen::AlignedBox3d box;
  const Eigen::VectorXd q = model.clip ? Eigen::VectorXd(model.clip->q.col(0)) : model.skeleton.rest();
  for (const auto& frame : forwardKinematics(model.skeleton, q)) box.extend(frame.translation());
  return box.sizes().maxCoeff();
}

/// The first joint that lies in its parent's place, -1 where there is none. Skeletons of bones have no such
/// joints, ASF's and glTF's often do.
int jointOfNoLength(const Skeleton& skeleton) {
  const Frames frames = restFrames(skeleton);
  for (int i = 1; i < skeleton.jointCount(); ++i)
    if ((frames[i].translation() - frames[skeleton.parent(i)].translation()).norm() < 1e-9) return i;
  return -1;
}

}  // namespace

Eigen::VectorXd motionFrame(const Model& model, int frame) {
  if (!model.clip)
    throw std::invalid_argument(
        fmt::format("'{}' has no motion, of which frame {} was asked for", model.name, frame));
  if (frame < 1 || frame > model.clip->frameCount())
    throw std::invalid_argument(
        fmt::format("the motion has frames 1 to {}, {} was asked for", model.clip->frameCount(), frame));
  return model.clip->q.col(frame - 1);
}

Eigen::VectorXd poseOf(const Imported& imported, int frame) {
  if (frame == 0)
    return imported.model.clip && imported.model.clip->frameCount() == 1
               ? Eigen::VectorXd(imported.model.clip->q.col(0))
               : imported.model.skeleton.rest();
  return motionFrame(imported.model, frame);
}

void demandLengths(const Skeleton& skeleton) {
  const int i = jointOfNoLength(skeleton);
  if (i >= 0)
    throw std::invalid_argument(fmt::format(
        "joint '{}' lies in the place of its parent '{}'; this format has bones of positive length only",
        skeleton.joint(i).name, skeleton.joint(skeleton.parent(i)).name));
}

Skeleton places(Model& model) {
  const Skeleton& skeleton = model.skeleton;
  const Frames frames = restFrames(skeleton);
  std::vector<Joint> joints;
  std::vector<int> now(skeleton.jointCount());
  std::string left;
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const int parent = skeleton.parent(i);
    const Eigen::Vector3d offset =
        frames[i].translation() -
        (parent < 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(frames[parent].translation()));
    if (parent >= 0 && offset.norm() < 1e-9) {
      now[i] = now[parent];
      left += (left.empty() ? "" : ", ") + skeleton.joint(i).name;
      continue;
    }
    now[i] = static_cast<int>(joints.size());
    joints.push_back({.name = skeleton.joint(i).name,
                      .parent = parent < 0 ? -1 : now[parent],
                      .parentFromZero = Eigen::Isometry3d(Eigen::Translation3d(offset))});
  }
  if (!left.empty())
    tell(model.notes, "left-out", "left out, since they lie in their parents' places: " + left);
  return Skeleton(std::move(joints));
}

std::vector<Note> modelNotes(const Model& model) {
  std::vector<Note> notes;
  const double extent = extentOf(model);
  constexpr double largest = 6.0, smallest = 0.05;
  if (extent > largest || (extent > 0.0 && extent < smallest)) {
    std::string guess;
    for (const char* unit : {"dm", "cm", "mm", "in", "ft"})
      if (const double size = extent * metresPerUnit(unit); guess.empty() && size > 1.2 && size < 2.3)
        guess = fmt::format(" (with '{}' it would be {:.3g} m)", unit, size);
    tell(notes, "unit-suspect",
         fmt::format("the joints span {:.3g} m: is the unit another one?{}", extent, guess));
  }
  std::vector<std::string> locked, unmoved;
  const Skeleton& skeleton = model.skeleton;
  std::vector<bool> moved(skeleton.jointCount(), false);
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    const Joint& mover = joint.coupling ? skeleton.joint(joint.coupling->source) : joint;
    const bool own = mover.ball || std::any_of(mover.axes.begin(), mover.axes.end(),
                                               [](const AxisDof& dof) { return dof.lower < dof.upper; });
    if (!own && !joint.coupling && !joint.axes.empty() &&
        !(joint.axes[0].lower == 0.0 && joint.axes[0].upper == 0.0))
      locked.push_back(joint.name);
    moved[i] = own || (joint.parent >= 0 && moved[joint.parent]);
    if (!moved[i] && i > 0) unmoved.push_back(joint.name);
  }
  if (!locked.empty())
    tell(notes, "joint-locked", "joints that their limits hold in one place: " + listed(locked),
         static_cast<int>(locked.size()));
  if (!unmoved.empty())
    tellFact(notes, "joint-unmoved",
             fmt::format("joints that no degree of freedom moves: {}", listed(unmoved)));
  return notes;
}

namespace {

/// Nothing that was given is left aside without a word.
void demandUsed(const std::string& nameOrFile, const Companions& given, std::string_view used) {
  const std::vector<std::string_view> taken = splitWords(used);
  for (const auto& [file, name] : companionNames)
    if (!(given.*file).empty() && std::ranges::count(taken, name) == 0)
      throw std::invalid_argument(
          fmt::format("'{}' is not read together with --{} {}", nameOrFile, name, given.*file));
}

}  // namespace

Imported importFiles(const std::string& nameOrFile, const Companions& companions,
                     const ImportOptions& options) {
  if (standsInNoFile(nameOrFile)) {
    demandUsed(nameOrFile, companions, "");
    return {.model = openModel(nameOrFile)};
  }
  const auto kind = fileKind(nameOrFile);
  if (!kind && !std::filesystem::exists(nameOrFile))
    return {.model = openModel(nameOrFile)};  // its message lists the names
  if (!kind)
    throw std::invalid_argument("cannot tell what '" + nameOrFile +
                                "' holds; known extensions: " + knownExtensions() +
                                "; beside models there are scenes (.json) and surfaces to be rigged (.stl)");
  const FileFormat& format = fileFormat(*kind);
  if (options.metresPerUnit && format.alwaysMetres)
    throw std::invalid_argument(describe(*kind) +
                                " is in metres by definition; another unit cannot be given");
  if (options.framesPerSecond && *kind != FileKind::Amc && companions.amc.empty())
    throw std::invalid_argument("'" + nameOrFile +
                                "' says its own frame rate; another one can be given for an AMC only");
  if (!companions.clip.empty() && !format.namesMotions)
    throw std::invalid_argument("'" + nameOrFile + "' does not name its motions: --clip is for glTF");
  demandUsed(nameOrFile, companions, std::string(format.companions) + " clip up");  // these: above, below
  Imported result{.model = {.name = stem(nameOrFile), .skeleton = {}}};
  format.read(nameOrFile, companions, options, result);
  if (result.model.clip && result.asf) standWhereMotionBegins(result.model);
  findUp(format, companions.up, result.model);
  tell(result.model.notes, modelNotes(result.model));
  if (options.zUp) {
    std::erase_if(result.model.notes, [](const Note& note) { return note.kind == "up-axis"; });
    result.model.up = Eigen::Vector3d::UnitY();
    const Eigen::Quaterniond upright(Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitX()));
    result.model = rotated(std::move(result.model), upright);
    result.figure.reset();  // its root no longer stands as in the file
    result.tutorial.reset();
  }
  return result;
}

namespace {

[[noreturn]] void refuseToWrite(const FileFormat& format) {
  throw std::invalid_argument("writing " + std::string(format.description) + " is not possible; read only");
}

}  // namespace

void exportFile(const std::string& path, Imported& imported, const ExportOptions& options) {
  const auto kind = fileKind(path);
  if (!kind)
    throw std::invalid_argument("cannot tell the format of '" + path +
                                "'; known extensions: " + knownExtensions());
  const FileFormat& format = fileFormat(*kind);
  if (options.metresPerUnit && format.alwaysMetres)
    throw std::invalid_argument(describe(*kind) + " is in metres by definition; leave --unit-out away");
  if (format.write) return format.write(path, imported, options);
  if (!format.writeMotion) refuseToWrite(format);
  Model& model = imported.model;
  MotionExport motion{.skeleton = model.skeleton,
                      .skin = model.skin ? &*model.skin : nullptr,
                      .metresPerUnit = options.metresPerUnit};
  if (options.allMotions && options.frame == 0 && format.namesMotions) motion.clips = imported.clips;
  if (motion.clips.empty() && (model.clip || options.frame > 0 || !format.namesMotions)) {
    GltfClip one{.name = model.clipName.empty() ? model.name : model.clipName, .clip = {}};
    if (model.clip && options.frame == 0)
      one.clip = *model.clip;
    else
      one.clip = {.framesPerSecond = model.clip ? model.clip->framesPerSecond : 30.0,
                  .q = poseOf(imported, options.frame)};
    motion.clips.push_back(std::move(one));
  }
  format.writeMotion(path, motion);
}

std::string motionEndings() {
  std::string endings;
  for (const FileFormat* format : table)
    if (format->writeMotion)
      for (const std::string_view ending : words(format->endings))
        endings += (endings.empty() ? "" : ", ") + std::string(ending);
  return endings;
}

void exportMotion(const std::string& path, const Skeleton& skeleton, const Skin* skin,
                  const std::string& name, const MotionClip& clip) {
  const auto kind = fileKind(path);
  if (!kind || !fileFormat(*kind).writeMotion)
    throw std::invalid_argument("'" + path + "': a motion can be written as " + motionEndings());
  fileFormat(*kind).writeMotion(path, {.skeleton = skeleton, .skin = skin, .clips = {{name, clip}}});
}

namespace {

/// As links without a material have it.
std::shared_ptr<const MeshLook> robotLook(const Mesh& mesh) {
  return std::make_shared<const MeshLook>(MeshLook{
      .materials = {linkMaterial()}, .parts = {{.triangleCount = static_cast<int>(mesh.triangles.size())}}});
}

}  // namespace

Model readModel(const ModelReference& reference) {
  Model model = withBody(importFiles(reference.nameOrFile, reference.files).model);
  // A robot whose file brings no shape is made of metal too.
  if (fileKind(reference.nameOrFile) == FileKind::Urdf && model.skin && !model.look)
    model.look = robotLook(model.skin->mesh);
  return model;
}

}  // namespace gelenk
