#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/document/model.h"
#include "apps/document/model_reference.h"
#include "kinematics/io/asf_amc.h"
#include "kinematics/io/bvh.h"
#include "kinematics/io/tutorial_skeleton.h"
#include "kinematics/motion/motion_clip.h"
#include "skinning/io/gltf.h"

namespace gelenk {

/// Every kind of file that opens: its name, its FileFormat (file_format.h). The order is that of messages.
#define GELENK_FILE_FORMATS(ROW)                  \
  ROW(ObjMesh, objFormat)                         \
  ROW(Nurbs, nurbsFormat)                         \
  ROW(PinocchioSkeleton, pinocchioSkeletonFormat) \
  ROW(PinocchioWeights, pinocchioWeightsFormat)   \
  ROW(Asf, asfFormat)                             \
  ROW(Amc, amcFormat)                             \
  ROW(Bvh, bvhFormat)                             \
  ROW(TutorialSkeleton, tutorialSkeletonFormat)   \
  ROW(TutorialPose, tutorialPoseFormat)           \
  ROW(Gltf, gltfFormat)                           \
  ROW(Urdf, urdfFormat)                           \
  ROW(DhTable, dhTableFormat)

#define GELENK_ENUMERATOR(Kind, format) Kind,
/// What a file holds, told by its extension and, where several formats share one, by its first words.
enum class FileKind { GELENK_FILE_FORMATS(GELENK_ENUMERATOR) };
#undef GELENK_ENUMERATOR

/// nullopt for an extension that no format here has.
std::optional<FileKind> fileKind(const std::string& path);
/// A surface alone.
bool isMesh(std::optional<FileKind> kind);
/// The triangles of an OBJ or of a NURBS surface (12 cells a knot span, 8 to 400 in each direction). Throws
/// ParseError.
Mesh readMesh(const std::string& path, std::vector<Note>* notes = nullptr);
/// An OBJ with its .mtl beside it. Textures keep the files that they were read from; the others become PNGs
/// there.
void writeObjWithLook(const std::string& path, const Mesh& mesh, const MeshLook& look);
/// "Pinocchio skeleton" and the like, for messages and `gelenk info`.
std::string describe(FileKind kind);
/// The extensions that are known, for messages.
std::string knownExtensions();

/// What the files themselves do not say, or say wrongly.
struct ImportOptions {
  std::optional<double> metresPerUnit = {};    ///< default: what the format says, else 1
  std::optional<double> framesPerSecond = {};  ///< of an AMC; default 120
  std::optional<double> sampleAt = {};         ///< Hz: of motions that frames cannot hold (steps, splines)
  bool zUp = false;                            ///< the file has z up; turned to y up
  BvhPositions bvhPositions = BvhPositions::Automatic;
};

/// Metres in a unit: "m", "dm", "cm", "mm", "in", "ft", or a positive number of metres. Throws
/// std::invalid_argument.
double metresPerUnit(const std::string& unit);

/// A model, with its motion where the files hold one (model.clip), and what its formats know beyond it.
struct Imported {
  Model model;
  std::vector<GltfClip> clips = {};     ///< all motions of a file that names its motions
  std::optional<AsfSkeleton> asf = {};  ///< bones and their ends, where the skeleton is an ASF's
  std::optional<TutorialFigure> figure =
      {};  ///< the order of joints in the file, where the skeleton is the tutorial's
  std::optional<TutorialSkeleton> tutorial =
      {};  ///< the file itself, in metres; it and `figure` are absent once the model was turned
};

/// Everything that the files hold together. OBJ + skeleton + weights + ASF + AMC: the exercise sheet
/// (skeleton_transfer.h); what could not be matched and the root's scale are told in the notes. Throws
/// ParseError and std::invalid_argument.
Imported importFiles(const std::string& nameOrFile, const Companions& companions = {},
                     const ImportOptions& options = {});

struct MuscleSettings;

/// What a file to be written shall hold of a model.
struct ExportOptions {
  std::optional<double> metresPerUnit = {};  ///< default: the format's own
  int frame = 0;                             ///< from 1; 0: the whole motion, or the rest pose
  bool allMotions = true;                    ///< of a model that has several, where the format holds them
  std::string end = {};                      ///< last joint of the chain that a DH table shall hold
  /// Of a posed body whose skinning has layers; null: the limbs' defaults.
  std::shared_ptr<const MuscleSettings> muscles = {};
};

/// Writes the format of the path's extension; what it cannot hold is told in imported's notes. Throws
/// std::invalid_argument where that cannot be, and std::runtime_error.
void exportFile(const std::string& path, Imported& imported, const ExportOptions& options = {});
/// A motion alone, named `name` where the format names motions. Throws std::invalid_argument for a format
/// that holds none.
void exportMotion(const std::string& path, const Skeleton& skeleton, const Skin* skin,
                  const std::string& name, const MotionClip& clip);

/// What looks wrong about a model's sizes and joints: a body larger than 6 m or smaller than 5 cm
/// ("unit-suspect", with the unit that would make a person of it), joints that their limits hold in one place
/// ("joint-locked"), and, as a fact, joints that no degree of freedom moves ("joint-unmoved").
std::vector<Note> modelNotes(const Model& model);

/// The model itself, with a body of its own where it has none. Throws ParseError and std::invalid_argument.
Model readModel(const ModelReference& reference);

/// Turns a model as a whole: skeleton, skin, bind pose.
Model rotated(Model model, const Eigen::Quaterniond& worldFromOld);

/// A body with a skeleton, from an OBJ and any file that holds a skeleton; metresPerUnit is the OBJ's, and
/// the skeleton's where that says none. With a weights file (Pinocchio's attachment) the four largest weights
/// are used and what that loses is told in the notes; without one it gets heat weights. Throws ParseError and
/// std::invalid_argument.
Model openBody(const std::string& objPath, const std::string& skeletonPath,
               const std::optional<std::string>& weightsPath, double metresPerUnit = 1.0);

/// The skeleton or the whole model that one file holds. Throws std::invalid_argument for a file that holds
/// none, and ParseError.
Model openModelFile(const std::string& path);

/// A file's name without folder and extension.
std::string stem(const std::string& path);

}  // namespace gelenk
