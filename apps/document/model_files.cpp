#include "apps/document/model_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <stdexcept>

#include "apps/document/chain_models.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/pinocchio_skeleton.h"
#include "kinematics/io/text_file.h"
#include "kinematics/io/word_stream.h"
#include "kinematics/motion/standing.h"
#include "kinematics/motion/skeleton_transfer.h"
#include "kinematics/skeleton_transform.h"
#include "skinning/io/gltf.h"
#include "skinning/io/nurbs.h"
#include "skinning/io/obj.h"
#include "skinning/io/pinocchio_weights.h"
#include "skinning/io/urdf_body.h"
#include "skinning/rigging/bone_heat.h"
#include "skinning/rigging/weight_transfer.h"

namespace gelenk {
namespace {

struct Extension {
  std::string_view ending;
  FileKind kind;
};
/// Longer endings first where one ends like another.
constexpr std::array extensions = {
    Extension{".obj", FileKind::ObjMesh},
    Extension{".nurbs", FileKind::Nurbs},
    Extension{".skeleton.out", FileKind::PinocchioSkeleton},
    Extension{".skeleton", FileKind::PinocchioSkeleton},
    Extension{".skel", FileKind::PinocchioSkeleton},
    Extension{".attachment.out", FileKind::PinocchioWeights},
    Extension{".attachment", FileKind::PinocchioWeights},
    Extension{".weights", FileKind::PinocchioWeights},
    Extension{".asf", FileKind::Asf},
    Extension{".amc", FileKind::Amc},
    Extension{".bvh", FileKind::Bvh},
    Extension{".figure", FileKind::TutorialSkeleton},
    Extension{".pose", FileKind::TutorialPose},
    Extension{".gltf", FileKind::Gltf},
    Extension{".glb", FileKind::Gltf},
    Extension{".urdf", FileKind::Urdf},
    Extension{".dh", FileKind::DhTable},
};

/// The first characters tell the tutorial's files from others with the same extension.
bool beginsWithNumJoints(const std::string& path, bool& isPose) {
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (!file) return false;
  char head[256] = {};
  const std::size_t n = std::fread(head, 1, sizeof head - 1, file);
  std::fclose(file);
  const std::string_view text(head, n);
  const std::size_t at = text.find_first_not_of(" \t\r\n");
  isPose = text.find("JointAngles") != std::string_view::npos;
  return at != std::string_view::npos && text.substr(at).starts_with("NumJoints");
}

}  // namespace

std::optional<FileKind> fileKind(const std::string& path) {
  const std::string name = lowerCase(path);
  if (bool isPose = false;
      (name.ends_with(".skel") || name.ends_with(".txt")) && beginsWithNumJoints(path, isPose))
    return isPose ? FileKind::TutorialPose : FileKind::TutorialSkeleton;
  for (const Extension& extension : extensions)
    if (name.ends_with(extension.ending)) return extension.kind;
  return std::nullopt;
}

std::string describe(FileKind kind) {
  switch (kind) {
    case FileKind::ObjMesh: return "OBJ mesh";
    case FileKind::Nurbs: return "NURBS surface";
    case FileKind::PinocchioSkeleton: return "Pinocchio skeleton";
    case FileKind::PinocchioWeights: return "Pinocchio bone weights";
    case FileKind::DhTable: return "Denavit-Hartenberg table";
    case FileKind::Asf: return "Acclaim skeleton (ASF)";
    case FileKind::Amc: return "Acclaim motion (AMC)";
    case FileKind::Bvh: return "Biovision motion (BVH)";
    case FileKind::TutorialSkeleton: return "tutorial skeleton";
    case FileKind::TutorialPose: return "tutorial pose";
    case FileKind::Gltf: return "glTF 2.0";
    case FileKind::Urdf: return "URDF robot";
  }
  return "";
}

std::string knownExtensions() {
  std::string list;
  for (const Extension& extension : extensions)
    list += (list.empty() ? "" : ", ") + std::string(extension.ending);
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

Mesh readMesh(const std::string& path, std::vector<Note>* notes) {
  if (fileKind(path) != FileKind::Nurbs) return readObj(path, notes);
  const NurbsSurface surface = readNurbs(path);
  const auto cells = [](const std::vector<double>& knots, int degree, int count) {
    int spans = 0;
    for (int i = degree; i < count; ++i) spans += knots[i + 1] > knots[i];
    return std::clamp(12 * spans, 8, 400);
  };
  Mesh mesh = tessellate(surface, cells(surface.knotsU, surface.degreeU, surface.countU),
                         cells(surface.knotsV, surface.degreeV, surface.countV));
  if (mesh.triangles.empty())
    throw ParseError(path, 0, "a surface", "control points that all lie in one place or line");
  return mesh;
}

namespace {

Mesh meshInMetres(const std::string& path, double metresPerUnit, std::vector<Note>* notes = nullptr) {
  Mesh mesh = readMesh(path, notes);
  for (auto& p : mesh.positions) p *= metresPerUnit;
  return mesh;
}

bool saysItsUnit(const std::string& path) {
  const auto kind = fileKind(path);
  return kind == FileKind::Asf || kind == FileKind::Gltf || kind == FileKind::Urdf ||
         kind == FileKind::DhTable;
}

}  // namespace

namespace {

void tellWeightLoss(std::vector<Note>& notes, const WeightLoss& loss, std::size_t vertices) {
  const std::string text = fmt::format(
      "four largest weights kept, bones that turn about one joint counted together: {:.2f} % of "
      "the weight lost on average, {:.1f} % at most ({} of {} vertices had more)",
      100.0 * loss.mean, 100.0 * loss.max, loss.verticesOverFour, vertices);
  loss.verticesOverFour > 0 ? tell(notes, "weights-lost", text) : tellFact(notes, "weights-lost", text);
}

}  // namespace

Model openBody(const std::string& objPath, const std::string& skeletonPath,
               const std::optional<std::string>& weightsPath, double metresPerUnit) {
  std::vector<Note> meshNotes;
  Mesh mesh = meshInMetres(objPath, metresPerUnit, &meshNotes);
  Model model =
      importFiles(skeletonPath, {},
                  {.metresPerUnit = saysItsUnit(skeletonPath) ? std::nullopt : std::optional(metresPerUnit)})
          .model;
  model.name = stem(objPath);
  tell(model.notes, meshNotes);
  const Frames rest = restFrames(model.skeleton);
  SparseWeights weights;
  if (weightsPath) {
    weights = jointWeights(readPinocchioWeights(*weightsPath, model.skeleton.jointCount() - 1, mesh),
                           model.skeleton);
  } else {
    const std::vector<Bone> bones = bonesOf(model.skeleton, rest, mesh);
    weights = boneHeatWeights(mesh, bones);
    tellFact(model.notes, "heat-weights", "no weights file: weights by heat diffusion on the surface");
    tell(model.notes, rigNotes(model.skeleton, bones, mesh));
  }
  WeightLoss loss;
  auto influences = fourLargest(weights, model.skeleton.jointCount(), &loss);
  tellWeightLoss(model.notes, loss, mesh.positions.size());
  model.skin = bindSkin(std::move(mesh), rest, std::move(influences));
  return model;
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

/// CMU's bones on Pinocchio's human where both have those names, else by equal names.
std::vector<BonePath> pathsFor(const AsfSkeleton& asf, const Skeleton& fitted) {
  std::vector<BonePath> table = cmuOnPinocchioHuman();
  const bool known = std::ranges::all_of(table, [&](const BonePath& path) {
    return std::ranges::all_of(path.bones,
                               [&](const std::string& bone) { return asf.findBone(bone).has_value(); }) &&
           std::ranges::all_of(path.joints,
                               [&](const std::string& joint) { return fitted.findJoint(joint).has_value(); });
  });
  if (known) return table;
  std::vector<BonePath> paths = bonePathsByName(asf, fitted);
  const bool fromRoot = std::ranges::any_of(paths, [&](const BonePath& path) {
    return asf.skeleton.parent(*asf.findBone(path.bones.front())) == 0;
  });
  if (!fromRoot)
    throw std::invalid_argument(
        "the fitted skeleton and the ASF skeleton have no joints of equal names from the root on: say which "
        "bones lie on which joints with --mapping");
  return paths;
}

/// The exercise sheet: the fitted skeleton on the ASF skeleton, Pinocchio's weights on its bones.
Imported exerciseSheet(const std::string& objPath, const Companions& files, const ImportOptions& options) {
  const double unit = options.metresPerUnit.value_or(1.0);  // the body's; the ASF says its own
  Mesh mesh = meshInMetres(objPath, unit);
  const Skeleton fitted = scaled(namedAsHuman(readPinocchioSkeleton(files.skeleton)), unit);
  if (files.weights.empty())
    throw std::invalid_argument(
        "laying a fitted skeleton on an ASF skeleton needs its weights: give them with --weights");
  const BoneWeights bones = readPinocchioWeights(files.weights, fitted.jointCount() - 1, mesh);
  Imported result;
  result.asf = readAsf(files.asf);
  const auto paths = files.mapping.empty() ? pathsFor(*result.asf, fitted)
                                           : parseBonePaths(readFile(files.mapping), files.mapping);
  const TransferredSkeleton transferred = transferSkeleton(*result.asf, fitted, paths);
  result.model = {.name = stem(objPath), .skeleton = transferred.skeleton};
  WeightLoss loss;
  auto influences = fourLargest(transferWeights(bones, mesh.positions, fitted, transferred),
                                transferred.skeleton.jointCount(), &loss);
  result.model.skin = bindSkin(std::move(mesh), transferred.bindFrames, std::move(influences));
  auto& notes = result.model.notes;
  tellWeightLoss(notes, loss, result.model.skin->mesh.positions.size());
  if (!transferred.unmatchedBones.empty())
    tell(notes, "unmatched-bones",
         "bones of the ASF skeleton without a fitted counterpart (they follow their parent): " +
             listed(transferred.unmatchedBones, 100));
  if (!transferred.unmatchedJoints.empty())
    tell(notes, "unmatched-joints",
         "fitted joints whose bone lies on no ASF bone: " + listed(transferred.unmatchedJoints, 100));
  if (!files.amc.empty()) {
    const MotionClip clip = readAmc(files.amc, *result.asf, options.framesPerSecond.value_or(120.0));
    result.model.clip = withScaledRoot(transferred.skeleton, clip, transferred.heightRatio);
    tellFact(notes, "path-scaled",
             fmt::format("the root's path is scaled by {:.4f}, the ratio of the root's heights",
                         transferred.heightRatio));
  }
  return result;
}

/// The only .figure in the pose's folder.
std::string figureBeside(const std::string& posePath) {
  const auto folder = std::filesystem::path(posePath).parent_path();
  std::string found;
  int count = 0;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder.empty() ? "." : folder, error))
    if (fileKind(entry.path().string()) == FileKind::TutorialSkeleton) found = entry.path().string(), ++count;
  if (count != 1)
    throw std::invalid_argument(fmt::format(
        "'{}' needs the figure it belongs to: give it with --figure ({} lie beside it)", posePath, count));
  return found;
}

/// The motion of that name, or the first one, which is told where there are others.
void chooseClip(const std::string& path, const std::string& name, Imported& imported) {
  Model& model = imported.model;
  for (const GltfClip& clip : imported.clips) model.clipNames.push_back(clip.name);
  const auto chosen =
      name.empty() ? imported.clips.begin()
                   : std::ranges::find_if(imported.clips, [&](const GltfClip& c) { return c.name == name; });
  if (!name.empty() && chosen == imported.clips.end())
    throw std::invalid_argument(imported.clips.empty()
                                    ? "'" + path + "' has no motion: --clip cannot choose one"
                                    : "'" + path + "' has no motion '" + name +
                                          "'; there are: " + listed(model.clipNames, 1000));
  if (chosen == imported.clips.end()) return;
  model.clip = chosen->clip;
  model.clipName = chosen->name;
  if (name.empty() && imported.clips.size() > 1)
    tell(model.notes, "several-motions",
         fmt::format("{} motions: {}; '{}' is taken, --clip chooses another", model.clipNames.size(),
                     listed(model.clipNames, 12), model.clipName));
}

Imported importOne(const std::string& path, FileKind kind, const Companions& files,
                   const ImportOptions& options) {
  const double unit = options.metresPerUnit.value_or(1.0);
  Imported result{.model = {.name = stem(path), .skeleton = {}}};
  Model& model = result.model;
  switch (kind) {
    case FileKind::PinocchioSkeleton:
      model.skeleton = scaled(namedAsHuman(readPinocchioSkeleton(path)), unit);
      break;
    case FileKind::DhTable: model = openDhModel(path); break;
    case FileKind::Asf:
    case FileKind::Amc: {
      const bool isMotion = kind == FileKind::Amc;
      if (isMotion && files.asf.empty())
        throw std::invalid_argument("'" + path + "' needs the skeleton it belongs to: give it with --asf");
      result.asf = readAsf(isMotion ? files.asf : path, options.metresPerUnit);
      model.skeleton = result.asf->skeleton;
      model.notes = result.asf->notes;
      if (isMotion || !files.amc.empty())
        result.model.clip =
            readAmc(isMotion ? path : files.amc, *result.asf, options.framesPerSecond.value_or(120.0));
      break;
    }
    case FileKind::Bvh: {
      BvhMotion bvh = readBvh(path, {.metresPerUnit = unit, .positions = options.bvhPositions});
      model.skeleton = std::move(bvh.skeleton);
      result.model.clip = std::move(bvh.clip);
      model.notes = bvh.notes;
      break;
    }
    case FileKind::TutorialSkeleton:
    case FileKind::TutorialPose: {
      const bool isPose = kind == FileKind::TutorialPose;
      const std::string figurePath = !isPose                 ? path
                                     : !files.figure.empty() ? files.figure
                                                             : figureBeside(path);
      if (isPose && files.figure.empty()) tellFact(model.notes, "figure", "figure: " + figurePath);
      TutorialSkeleton tutorial = readTutorialSkeleton(figurePath);
      for (auto& position : tutorial.positions) position *= unit;
      result.figure = toSkeleton(tutorial);
      result.tutorial = std::move(tutorial);
      model.skeleton = result.figure->skeleton;
      if (isPose)
        result.model.clip =
            MotionClip{.framesPerSecond = 1.0, .q = configuration(*result.figure, readTutorialPose(path))};
      break;
    }
    case FileKind::Gltf: {
      GltfModel gltf = readGltf(path, {.framesPerSecond = options.sampleAt});
      model.skeleton = std::move(gltf.skeleton);
      model.skin = std::move(gltf.skin);
      model.notes = gltf.notes;
      result.clips = std::move(gltf.clips);
      chooseClip(path, files.clip, result);
      if (options.metresPerUnit)
        throw std::invalid_argument("glTF is in metres by definition; another unit cannot be given");
      break;
    }
    case FileKind::Urdf: {
      UrdfModel urdf = openUrdf(path);
      model.skeleton = std::move(urdf.skeleton);
      model.skin = std::move(urdf.skin);
      if (urdf.masses) model.masses = std::make_shared<const Masses>(*std::move(urdf.masses));
      model.notes = urdf.notes;
      model.up = Eigen::Vector3d::UnitZ();
      break;
    }
    case FileKind::ObjMesh:
    case FileKind::Nurbs: {
      if (files.skeleton.empty())
        throw std::invalid_argument("'" + path +
                                    "' is a mesh without a skeleton: give one with --skeleton, or name the "
                                    "skeleton's file where there is no such option");
      if (!files.asf.empty()) return exerciseSheet(path, files, options);
      model = openBody(path, files.skeleton,
                       files.weights.empty() ? std::nullopt : std::optional(files.weights), unit);
      break;
    }
    case FileKind::PinocchioWeights:
      throw std::invalid_argument(
          "'" + path + "' holds weights only: give it with --weights, beside an OBJ and --skeleton");
  }
  return result;
}

/// The rest pose at the place of the motion's first frame: an ASF's own stands with its hips on the floor.
void standWhereMotionBegins(Model& model) {
  if (model.skin) return;  // bound where it stands
  Eigen::VectorXd rest = model.skeleton.rest();
  const Joint& root = model.skeleton.joint(0);
  for (std::size_t k = 0; k < root.axes.size(); ++k)
    if (root.axes[k].kind == AxisDof::Kind::Translation) rest[k] = model.clip->q(k, 0);
  model.skeleton = Skeleton(model.skeleton.joints(), rest);
}

/// What no format but glTF, URDF and DH tables says: the axis against gravity. Values stay as they are in the
/// file.
void findUp(FileKind kind, const std::string& wanted, Model& model) {
  const bool says = kind == FileKind::Gltf || kind == FileKind::Urdf || kind == FileKind::DhTable;
  if (!wanted.empty() && says)
    throw std::invalid_argument(describe(kind) + "s say which axis is up; another cannot be given");
  if (!wanted.empty() && wanted != "y" && wanted != "z")
    throw std::invalid_argument("the axis that points up is y or z, not '" + wanted + "'");
  if (!wanted.empty()) model.up = wanted == "z" ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
  if (!wanted.empty() || says || model.planar) return;
  MotionClip some{.framesPerSecond = 1.0};  // frames enough to find it standing
  if (model.clip) {
    const int frames = model.clip->frameCount(), step = std::max(1, frames / 200);
    some.q = model.clip->q(Eigen::all, Eigen::seq(0, frames - 1, step));
  }
  model.up = upOf(model.skeleton, some, standingParts(model.skeleton));
  if (model.up.z() > 0.5)
    tellFact(model.notes, "up-axis", "the body stands along z, which is taken as up; --up chooses");
}

/// Largest extent of the body (else of the joints) in the pose it stands in, metres.
double extentOf(const Model& model) {
  Eigen::AlignedBox3d box;
  const Eigen::VectorXd q = model.clip ? Eigen::VectorXd(model.clip->q.col(0)) : model.skeleton.rest();
  for (const auto& frame : forwardKinematics(model.skeleton, q)) box.extend(frame.translation());
  return box.sizes().maxCoeff();
}

}  // namespace

std::vector<Note> modelNotes(const Model& model) {
  std::vector<Note> notes;
  const double extent = extentOf(model);
  constexpr double largest = 6.0, smallest = 0.05;
  if (extent > largest || (extent > 0.0 && extent < smallest)) {
    std::string guess;
    for (const char* unit : {"dm", "cm", "mm", "in", "ft"})
      if (const double size = extent * metresPerUnit(unit); guess.empty() && size > 1.2 && size < 2.3)
        guess = fmt::format("; in {} it would be {:.3g} m", unit, size);
    tell(notes, "unit-suspect",
         fmt::format("the joints span {:.3g} m: is the unit another one{}?", extent, guess));
  }
  std::vector<std::string> locked, unmoved;
  const Skeleton& skeleton = model.skeleton;
  std::vector<bool> moved(skeleton.jointCount(), false);
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    const Joint& mover = joint.coupling ? skeleton.joint(joint.coupling->source) : joint;
    const bool own = mover.ball || std::any_of(mover.axes.begin(), mover.axes.end(),
                                               [](const AxisDof& dof) { return dof.lower < dof.upper; });
    if (!own && !joint.coupling && !joint.axes.empty() && !(joint.axes[0].lower == 0.0 && joint.axes[0].upper == 0.0))
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

Imported importFiles(const std::string& nameOrFile, const Companions& companions,
                     const ImportOptions& options) {
  const auto names = builtInModels();
  if (std::find(names.begin(), names.end(), nameOrFile) != names.end() || nameOrFile.starts_with("dh:"))
    return {.model = openModel(nameOrFile)};
  const auto kind = fileKind(nameOrFile);
  if (!kind && !std::filesystem::exists(nameOrFile))
    return {.model = openModel(nameOrFile)};  // its message lists the names
  if (!kind)
    throw std::invalid_argument("cannot tell what '" + nameOrFile +
                                "' holds; known extensions: " + knownExtensions());
  if (options.metresPerUnit && (kind == FileKind::Urdf || kind == FileKind::DhTable))
    throw std::invalid_argument(describe(*kind) +
                                "s are in metres by definition; another unit cannot be given");
  if (options.framesPerSecond && *kind != FileKind::Amc && companions.amc.empty())
    throw std::invalid_argument("'" + nameOrFile +
                                "' says its own frame rate; another one can be given for an AMC only");
  if (!companions.clip.empty() && kind != FileKind::Gltf)
    throw std::invalid_argument("'" + nameOrFile + "' does not name its motions: --clip is for glTF");
  Imported result = importOne(nameOrFile, *kind, companions, options);
  if (result.model.clip && result.asf) standWhereMotionBegins(result.model);
  findUp(*kind, companions.up, result.model);
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

Model readModel(const ModelReference& reference) {
  return withBody(importFiles(reference.nameOrFile, reference.files).model);
}

}  // namespace gelenk
