#include <fmt/format.h>

#include "apps/commands/baked_skin.h"
#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/document/file_format.h"
#include "apps/document/model_files.h"
#include "apps/document/notes.h"
#include "apps/document/scene_file.h"
#include "apps/document/session.h"
#include "kinematics/io/text_file.h"
#include "kinematics/skeleton_transform.h"
#include "skinning/io/obj.h"

namespace gelenk {
namespace {

struct Request {
  std::string in, out;
  Companions companions;
  std::string unitIn, unitOut;
  std::string upIn = "y", upOut = "y";
  std::string bvhPositions = "auto";
  std::string end;
  double fps = 0.0;
  std::string skin;
  bool bake = false;
  int frame = 0;
};

/// ASF's bones have constant lengths; channels of position that a motion never uses are no obstacle.
void holdStillTranslations(Model& model) {
  StillTranslations held = withoutStillTranslations(model.skeleton, *model.clip);
  if (held.joints.empty()) return;
  model.skeleton = std::move(held.skeleton);
  model.clip = std::move(held.clip);
  tellFact(model.notes, "still-positions",
           fmt::format("position channels that stand still became offsets (joints: {})", held.joints.size()));
}

/// A mesh alone: another unit, another axis up.
void convertMesh(const Request& request) {
  if (request.frame > 0)
    throw std::invalid_argument("'" + request.in + "' is a mesh alone and has no motion; leave --frame away");
  std::vector<Note> notes;
  Mesh mesh = readMesh(request.in, &notes);
  std::optional<ObjLook> look;
  if (fileKind(request.in) == FileKind::ObjMesh) look = readObjLook(request.in, mesh, &notes);
  if (look) cutSurface(*look, mesh);
  if (!look || look->normals.empty()) mesh.normals.clear();
  sayNotes(request.in, notes);
  const auto unit = [](const std::string& text) { return text.empty() ? 1.0 : metresPerUnit(text); };
  const double quarterTurns = (request.upOut == "z") - (request.upIn == "z");
  const Eigen::Matrix3d newFromOld =
      unit(request.unitIn) / unit(request.unitOut) *
      Eigen::AngleAxisd(quarterTurns * M_PI / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  for (auto& p : mesh.positions) p = newFromOld * p;
  for (auto& n : mesh.normals) n = (newFromOld * n).normalized();
  if (look && !look->look.materials.empty())
    writeObjWithLook(request.out, mesh, look->look);
  else
    writeObj(request.out, mesh);
  fmt::print("{}: {}, {} vertices\n", request.out, describe(FileKind::ObjMesh), mesh.positions.size());
}

/// The model of a scene in the scene's pose, with the weights that were edited there.
Imported importScene(const Request& request, std::shared_ptr<const MuscleSettings>& muscles) {
  const Companions& files = request.companions;
  if (!request.unitIn.empty() || request.upIn != "y" || request.fps > 0.0 || request.bvhPositions != "auto" ||
      files != Companions{})
    throw std::invalid_argument(
        "a scene says itself what belongs to its model; leave the options about IN away");
  auto [model, document] = openDocument({.nameOrFile = request.in});
  const Session session(model, std::move(document));
  Imported imported{.model = *model};
  if (session.skin()) imported.model.skin = *session.skin();
  imported.model.skinning = chosenSkin(session.document());
  muscles = session.edits().muscles;
  imported.model.clip = MotionClip{.framesPerSecond = 30.0, .q = session.q()};
  return imported;
}

Imported importRequested(const Request& request, std::shared_ptr<const MuscleSettings>& muscles) {
  if (isScene(request.in)) return importScene(request, muscles);
  ImportOptions options{.zUp = request.upIn == "z"};
  if (!request.unitIn.empty()) options.metresPerUnit = metresPerUnit(request.unitIn);
  if (request.fps > 0.0) options.framesPerSecond = request.fps;
  options.bvhPositions = request.bvhPositions == "add"       ? BvhPositions::Add
                         : request.bvhPositions == "replace" ? BvhPositions::Replace
                                                             : BvhPositions::Automatic;
  return importFiles(request.in, request.companions, options);
}

void run(const Request& request) {
  const auto kind = fileKind(request.out);
  if (!kind)
    throw std::invalid_argument("cannot tell the format of '" + request.out +
                                "'; known extensions: " + knownExtensions());
  if (request.bake && request.frame > 0)
    throw std::invalid_argument("--bake-skin writes all frames; leave --frame away, or write one as .obj");
  const auto from = fileKind(request.in);
  if (kind == FileKind::ObjMesh && isMesh(from) && request.companions.skeleton.empty())
    return convertMesh(request);
  ExportOptions options{
      .frame = request.frame, .allMotions = request.companions.clip.empty(), .end = request.end};
  Imported imported = importRequested(request, options.muscles);
  if (request.frame > 0) motionFrame(imported.model, request.frame);  // also where the format holds no pose
  if (request.upOut == "z") {
    imported.model = rotated(std::move(imported.model),
                             Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX())));
    imported.figure.reset();  // its root no longer stands as in the file
    imported.tutorial.reset();
  }
  if ((kind == FileKind::Asf || kind == FileKind::Amc) && imported.model.clip)
    holdStillTranslations(imported.model);
  if (kind == FileKind::Gltf && request.companions.clip.empty() &&
      request.frame == 0)  // all of them are written
    std::erase_if(imported.model.notes, [](const Note& note) { return note.kind == "several-motions"; });
  demandNoNotes(request.in, imported.model.notes);
  if (!request.skin.empty()) imported.model.skinning = parseSkinChoice(request.skin);
  if (request.bake) {
    sayNotes(request.in, imported.model.notes);
    return writeBakedSkin(request.out, imported.model, options.muscles.get());
  }
  if (!request.unitOut.empty()) options.metresPerUnit = metresPerUnit(request.unitOut);
  exportFile(request.out, imported, options);
  sayNotes(request.in, imported.model.notes);
  fmt::print("{}: {}, from {} joints{}\n", request.out, describe(*kind), imported.model.skeleton.jointCount(),
             imported.model.clip ? fmt::format(", {} frame{} at {:.6g} Hz", imported.model.clip->frameCount(),
                                               imported.model.clip->frameCount() == 1 ? "" : "s",
                                               imported.model.clip->framesPerSecond)
                                 : "");
}

}  // namespace

void addConvertCommand(Command& app) {
  auto request = std::make_shared<Request>();
  Command command = app.command("convert", "Convert between skeletons, motions and skinned models");
  command.option("in", request->in, "A file, a scene of the sandbox (.json) or the name of a built-in model")
      .required();
  command.option("out", request->out, "The file to write; its extension is the format").required();
  Companions& files = request->companions;
  command.option("--skeleton", files.skeleton, "Skeleton of an OBJ");
  command.option("--weights", files.weights, "Weights of an OBJ");
  command.option("--asf", files.asf, "ASF skeleton of an AMC, or to lay a fitted skeleton on");
  command.option("--amc", files.amc, "Motion for the ASF skeleton");
  command.option("--mapping", files.mapping, "Bones on joints, lines 'bone ... : joint joint ...'");
  command.option("--figure", files.figure, "Figure of a tutorial pose");
  command.option("--unit-in", request->unitIn,
                 "Unit of IN: m dm cm mm in ft, or metres; default: what the format says, else m");
  command.option("--unit-out", request->unitOut, "Unit of OUT; default: m, for ASF CMU's (length 0.45)");
  command.option("--up-in", request->upIn, "The axis that points up in IN").oneOf({"y", "z"});
  command.option("--up-out", request->upOut, "The axis that shall point up in OUT").oneOf({"y", "z"});
  command
      .option("--bvh-positions", request->bvhPositions,
              "What position channels mean: stand in place of OFFSET or are added to it")
      .oneOf({"auto", "replace", "add"});
  command.option("--fps", request->fps, "Frame rate of an AMC; default 120").frameRate();
  command.option("--clip", files.clip,
                 "Which motion of a file that names several; default: all to glTF, else the first");
  command.option(
      "--skin", request->skin,
      "Skinning method of posed bodies (OBJ) and --bake-skin, such as cor+twist; otherwise the model's");
  command.flag("--bake-skin", request->bake,
               "Write the vertices of every frame to a .glb, for viewers that only know linear blending");
  command.option("--end", request->end, "Last joint of the chain that a DH table shall hold");
  command.option("--frame", request->frame, "Write only this frame, from 1").positive();
  command.run([request] { run(*request); });
}

}  // namespace gelenk
