#include <fmt/format.h>

#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/document/model_files.h"
#include "apps/document/notes.h"
#include "apps/document/scene_file.h"
#include "apps/document/session.h"
#include "kinematics/io/dh_text.h"
#include "kinematics/io/pinocchio_skeleton.h"
#include "kinematics/io/text_file.h"
#include "kinematics/skeleton_transform.h"
#include "skinning/blend/linear_blend.h"
#include "skinning/io/gltf.h"
#include "skinning/io/obj.h"
#include "skinning/io/pinocchio_weights.h"

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
  int frame = 0;
};

/// The pose that formats without motion get: the chosen frame, else the rest pose.
Eigen::VectorXd poseOf(const Imported& imported, int frame) {
  if (frame == 0)
    return imported.model.clip && imported.model.clip->frameCount() == 1
               ? Eigen::VectorXd(imported.model.clip->q.col(0))
               : imported.model.skeleton.rest();
  const int count = imported.model.clip ? imported.model.clip->frameCount() : 0;
  if (frame > count)
    throw std::invalid_argument(fmt::format("there are frames 1 to {}, {} was asked for", count, frame));
  return imported.model.clip->q.col(frame - 1);
}

/// The first joint that lies in its parent's place, -1 where there is none. Skeletons of bones have no such
/// joints, ASF's and glTF's often do.
int jointOfNoLength(const Skeleton& skeleton) {
  const Frames frames = restFrames(skeleton);
  for (int i = 1; i < skeleton.jointCount(); ++i)
    if ((frames[i].translation() - frames[skeleton.parent(i)].translation()).norm() < 1e-9) return i;
  return -1;
}

/// Angles and weights are of bones; two joints in one place have none between them.
void demandLengths(const Skeleton& skeleton) {
  const int i = jointOfNoLength(skeleton);
  if (i >= 0)
    throw std::invalid_argument(fmt::format(
        "joint '{}' lies in the place of its parent '{}'; this format has bones of positive length only",
        skeleton.joint(i).name, skeleton.joint(skeleton.parent(i)).name));
}

/// The places of the rest pose as a tree of fixed joints whose bones all have a length: what hangs on a joint
/// in its parent's place hangs on that parent. A note of the model tells what was left out.
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

void write(Imported& imported, FileKind kind, const Request& request) {
  const double unit = request.unitOut.empty() ? 1.0 : metresPerUnit(request.unitOut);
  const Skeleton& skeleton = imported.model.skeleton;
  const auto clipOrPose = [&] {
    if (imported.model.clip && request.frame == 0) return *imported.model.clip;
    return MotionClip{.framesPerSecond = imported.model.clip ? imported.model.clip->framesPerSecond : 30.0,
                      .q = poseOf(imported, request.frame)};
  };
  const double asfUnit = request.unitOut.empty() ? asfMetresPerUnit(0.45) : unit;
  switch (kind) {
    case FileKind::PinocchioSkeleton:
      return writeFile(request.out, formatPinocchioSkeleton(scaled(places(imported.model), 1.0 / unit),
                                                            PinocchioIds::Names));
    case FileKind::Asf: return writeFile(request.out, formatAsf(skeleton, asfUnit));
    case FileKind::Amc: return writeFile(request.out, formatAmc(skeleton, clipOrPose(), asfUnit));
    case FileKind::Bvh: return writeFile(request.out, formatBvh(skeleton, clipOrPose(), unit));
    case FileKind::TutorialSkeleton: {
      TutorialSkeleton tutorial =
          imported.tutorial ? *imported.tutorial : toTutorialSkeleton(places(imported.model));
      for (auto& position : tutorial.positions) position /= unit;
      return writeFile(request.out, formatTutorialSkeleton(tutorial));
    }
    case FileKind::TutorialPose: {
      demandLengths(skeleton);
      // Angles of the figure that toTutorialSkeleton makes of this skeleton: its frames are parallel to the
      // world's in the bind pose.
      const TutorialFigure figure =
          imported.figure ? *imported.figure : toSkeleton(toTutorialSkeleton(skeleton));
      const Frames rest = restFrames(skeleton),
                   posed = forwardKinematics(skeleton, poseOf(imported, request.frame));
      Eigen::VectorXd q = figure.skeleton.rest();
      if (imported.figure) {
        q = poseOf(imported, request.frame);
      } else {
        for (int i = 0; i < skeleton.jointCount(); ++i) {
          const auto turn = [&](int j) {
            return Eigen::Quaterniond(posed[j].linear() * rest[j].linear().transpose());
          };
          const int parent = skeleton.parent(i);
          setJointRotation(figure.skeleton, q, figure.jointOfIndex[i],
                           parent < 0 ? turn(i) : turn(parent).conjugate() * turn(i));
        }
      }
      return writeFile(request.out, formatTutorialPose(tutorialPose(figure, q)));
    }
    case FileKind::Gltf: {
      if (!request.unitOut.empty())
        throw std::invalid_argument("glTF is in metres by definition; leave --unit-out away");
      std::vector<GltfClip> clips;
      if (request.companions.clip.empty() && request.frame == 0) clips = imported.clips;
      if (clips.empty() && imported.model.clip)
        clips.push_back({imported.model.clipName.empty() ? imported.model.name : imported.model.clipName,
                         *imported.model.clip});
      return writeGltf(request.out, skeleton, imported.model.skin ? &*imported.model.skin : nullptr, clips);
    }
    case FileKind::ObjMesh: {
      if (!imported.model.skin)
        throw std::invalid_argument("'" + request.in + "' has no body to write as OBJ");
      Mesh mesh = imported.model.skin->mesh;
      if (imported.model.clip || request.frame > 0 || !restsAsBound(imported.model))
        mesh.positions = linearBlendSkin(*imported.model.skin,
                                         forwardKinematics(skeleton, poseOf(imported, request.frame)))
                             .positions;
      for (auto& p : mesh.positions) p /= unit;
      return writeObj(request.out, mesh);
    }
    case FileKind::PinocchioWeights: {
      if (!imported.model.skin)
        throw std::invalid_argument("'" + request.in + "' has no body whose weights could be written");
      demandLengths(skeleton);
      return writeFile(request.out,
                       formatPinocchioWeights(boneWeights(imported.model.skin->influences, skeleton)));
    }
    case FileKind::DhTable: {
      if (!request.unitOut.empty())
        throw std::invalid_argument("a Denavit-Hartenberg table is in metres; leave --unit-out away");
      DhChain chain = dhFromSkeleton(skeleton, request.end.empty() ? -1 : skeleton.jointIndex(request.end));
      chain.table.name = imported.model.name;
      for (char& c : chain.table.name)
        if (c == ' ' || c == '\t' || c == '#') c = '_';
      return writeFile(request.out, formatDhTable(chain.table));
    }
    default: throw std::invalid_argument("writing " + describe(kind) + " is not possible; read only");
  }
}

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
  std::vector<Note> notes;
  Mesh mesh = readMesh(request.in, &notes);
  sayNotes(request.in, notes);
  const auto unit = [](const std::string& text) { return text.empty() ? 1.0 : metresPerUnit(text); };
  const double quarterTurns = (request.upOut == "z") - (request.upIn == "z");
  const Eigen::Matrix3d newFromOld =
      unit(request.unitIn) / unit(request.unitOut) *
      Eigen::AngleAxisd(quarterTurns * M_PI / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  for (auto& p : mesh.positions) p = newFromOld * p;
  writeObj(request.out, mesh);
  fmt::print("{}: {}, {} vertices\n", request.out, describe(FileKind::ObjMesh), mesh.positions.size());
}

/// The model of a scene in the scene's pose, with the weights that were edited there.
Imported importScene(const Request& request) {
  const Companions& files = request.companions;
  if (!request.unitIn.empty() || request.upIn != "y" || request.fps > 0.0 || request.bvhPositions != "auto" ||
      files != Companions{})
    throw std::invalid_argument(
        "a scene says itself what belongs to its model; leave the options about IN away");
  auto [model, document] = openDocument({.nameOrFile = request.in});
  const Session session(model, std::move(document));
  Imported imported{.model = *model};
  if (session.skin()) imported.model.skin = *session.skin();
  imported.model.clip = MotionClip{.framesPerSecond = 30.0, .q = session.q()};
  return imported;
}

Imported importRequested(const Request& request) {
  if (isScene(request.in)) return importScene(request);
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
  const auto from = fileKind(request.in);
  if (kind == FileKind::ObjMesh && (from == FileKind::ObjMesh || from == FileKind::Nurbs) &&
      request.companions.skeleton.empty())
    return convertMesh(request);
  Imported imported = importRequested(request);
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
  write(imported, *kind, request);
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
  command.option("--fps", request->fps, "Frame rate of an AMC; default 120").positive();
  command.option("--clip", files.clip,
                 "Which motion of a file that names several; default: all to glTF, else the first");
  command.option("--end", request->end, "Last joint of the chain that a DH table shall hold");
  command.option("--frame", request->frame, "Write only this frame, from 1").positive();
  command.run([request] { run(*request); });
}

}  // namespace gelenk
