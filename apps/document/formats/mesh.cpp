#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "apps/commands/image.h"
#include "apps/document/chosen_skin.h"
#include "apps/document/file_format.h"
#include "apps/document/model_files.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/pinocchio_skeleton.h"
#include "kinematics/io/text_file.h"
#include "kinematics/motion/skeleton_transfer.h"
#include "kinematics/skeleton_transform.h"
#include "skinning/blend/skin_choice.h"
#include "skinning/io/nurbs.h"
#include "skinning/io/obj.h"
#include "skinning/io/pinocchio_weights.h"
#include "skinning/rigging/bone_heat.h"
#include "skinning/rigging/weight_transfer.h"

namespace gelenk {
namespace {

Mesh meshInMetres(const std::string& path, double metresPerUnit, std::vector<Note>* notes) {
  Mesh mesh = readMesh(path, notes);
  for (auto& p : mesh.positions) p *= metresPerUnit;
  return mesh;
}

bool saysItsUnit(const std::string& path) {
  const auto kind = fileKind(path);
  return kind && (fileFormat(*kind).saysItsUnit || fileFormat(*kind).alwaysMetres);
}

/// Colours, textures and normals that an OBJ has.
void paint(const std::string& path, Model& model) {
  if (fileKind(path) != FileKind::ObjMesh) return;
  auto look = readObjLook(path, model.skin->mesh, &model.notes);
  if (!look) return;
  cutSurface(*look, model.skin->mesh);
  cutSurface(*look, model.skin->influences);
  if (!look->look.materials.empty()) model.look = std::make_shared<const MeshLook>(std::move(look->look));
}

void tellWeightLoss(std::vector<Note>& notes, const WeightLoss& loss, std::size_t vertices) {
  const std::string text = fmt::format(
      "four largest weights kept, bones that turn about one joint counted together: {:.2f} % of "
      "the weight lost on average, {:.1f} % at most ({} of {} vertices had more)",
      100.0 * loss.mean, 100.0 * loss.max, loss.verticesOverFour, vertices);
  loss.verticesOverFour > 0 ? tell(notes, "weights-lost", text) : tellFact(notes, "weights-lost", text);
}

/// What the .mtl beside `folder` calls a texture's file: the source's own, or a PNG that is written there.
std::string pictureFor(const Texture& texture, const std::filesystem::path& folder, const std::string& name) {
  if (!texture.file.empty()) {
    std::error_code error;
    const auto near = std::filesystem::relative(texture.file, folder, error);
    return error || near.empty() ? texture.file : near.generic_string();
  }
#ifdef GELENK_GRAPHICS
  writePng((folder / name).string(), {texture.width, texture.height, texture.rgba}, true);
  return name;
#else
  throw std::invalid_argument("this build writes no PNG, which the texture '" + name + "' needs");
#endif
}

}  // namespace

void writeObjWithLook(const std::string& path, const Mesh& mesh, const MeshLook& look) {
  const std::filesystem::path file(path);
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  const std::string name = file.stem().string(), mtl = name + ".mtl";
  std::vector<std::string> pictures;
  for (const auto& texture : look.textures)
    pictures.push_back(pictureFor(*texture, folder, fmt::format("{}_{}.png", name, pictures.size() + 1)));
  const ObjText text = formatObj(mesh, look, mtl, pictures);
  writeFile((folder / mtl).string(), text.mtl);
  writeFile(path, text.obj);
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
  paint(objPath, model);
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
  std::vector<Note> meshNotes;
  Mesh mesh = meshInMetres(objPath, unit, &meshNotes);
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
  result.model = {.name = stem(objPath), .skeleton = transferred.skeleton, .notes = result.asf->notes};
  tell(result.model.notes, meshNotes);
  WeightLoss loss;
  auto influences = fourLargest(transferWeights(bones, mesh.positions, fitted, transferred),
                                transferred.skeleton.jointCount(), &loss);
  result.model.skin = bindSkin(std::move(mesh), transferred.bindFrames, std::move(influences));
  paint(objPath, result.model);
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
    const MotionClip clip =
        readAmc(files.amc, *result.asf, options.framesPerSecond.value_or(120.0), &result.model.notes);
    result.model.clip = withScaledRoot(transferred.skeleton, clip, transferred.heightRatio);
    tellFact(notes, "path-scaled",
             fmt::format("the root's path is scaled by {:.4f}, the ratio of the root's heights",
                         transferred.heightRatio));
  }
  return result;
}

void readMeshFile(const std::string& path, const Companions& files, const ImportOptions& options,
                  Imported& result) {
  if (files.skeleton.empty())
    throw std::invalid_argument("'" + path +
                                "' is a mesh without a skeleton: give one with --skeleton, or name the "
                                "skeleton's file where there is no such option");
  if (files.asf.empty() && !(files.amc.empty() && files.mapping.empty()))
    throw std::invalid_argument(fmt::format("--{} needs --asf: it is of the bones of that skeleton",
                                            files.amc.empty() ? "mapping" : "amc"));
  if (!files.asf.empty())
    result = exerciseSheet(path, files, options);
  else
    result.model =
        openBody(path, files.skeleton, files.weights.empty() ? std::nullopt : std::optional(files.weights),
                 options.metresPerUnit.value_or(1.0));
}

void writeObjFile(const std::string& path, Imported& imported, const ExportOptions& options) {
  const Model& model = imported.model;
  if (!model.skin) throw std::invalid_argument("'" + model.name + "' has no body to write as OBJ");
  Mesh mesh = model.skin->mesh;
  if (model.clip || options.frame > 0 || !restsAsBound(model)) {
    const Eigen::VectorXd q = poseOf(imported, options.frame);
    SkinnedVertices posed;
    ChosenSkin(model, *model.skin, model.skinning, options.muscles.get())
        .pose(forwardKinematics(model.skeleton, q), &q, posed);
    mesh.positions = std::move(posed.positions);
    mesh.normals = std::move(posed.normals);
  }
  for (auto& p : mesh.positions) p /= options.metresPerUnit.value_or(1.0);
  if (model.look) return writeObjWithLook(path, mesh, *model.look);
  mesh.normals.clear();  // of the faces, as whoever reads the file finds them too
  writeObj(path, mesh);
}

}  // namespace

constexpr std::string_view companionsOfMesh = "skeleton weights asf amc mapping";

constinit const FileFormat objFormat{.description = "OBJ mesh",
                                     .endings = ".obj",
                                     .isMesh = true,
                                     .companions = companionsOfMesh,
                                     .read = readMeshFile,
                                     .write = writeObjFile};
/// A surface that is tessellated and then treated as an OBJ.
constinit const FileFormat nurbsFormat{.description = "NURBS surface",
                                       .endings = ".nurbs",
                                       .isMesh = true,
                                       .companions = companionsOfMesh,
                                       .read = readMeshFile};

}  // namespace gelenk
