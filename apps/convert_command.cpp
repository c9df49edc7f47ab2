#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>

#include "apps/commands.h"
#include "apps/model_files.h"
#include "kinematics/io/dh_text.h"
#include "kinematics/io/pinocchio_skeleton.h"
#include "kinematics/io/text_file.h"
#include "kinematics/skeleton_transform.h"
#include "skinning/io/gltf.h"
#include "skinning/io/obj.h"
#include "skinning/io/pinocchio_weights.h"
#include "skinning/linear_blend.h"

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

/// "m", "cm", "mm", "in", "ft", or metres as a number.
double metres(const std::string& unit) {
  static const std::map<std::string, double> named{{"m", 1.0}, {"dm", 0.1}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}};
  if (const auto found = named.find(unit); found != named.end()) return found->second;
  const auto value = parseNumber(unit);
  if (!value || !(*value > 0.0)) throw std::invalid_argument("a unit must be m, dm, cm, mm, in, ft or a positive number of metres, not '" + unit + "'");
  return *value;
}

/// The pose that formats without motion get: the chosen frame, else the rest pose.
Eigen::VectorXd poseOf(const Imported& imported, int frame) {
  if (frame == 0) return imported.model.clip && imported.model.clip->frameCount() == 1 ? Eigen::VectorXd(imported.model.clip->q.col(0)) : imported.model.skeleton.rest();
  const int count = imported.model.clip ? imported.model.clip->frameCount() : 0;
  if (frame > count) throw std::invalid_argument(fmt::format("there are frames 1 to {}, {} was asked for", count, frame));
  return imported.model.clip->q.col(frame - 1);
}

void write(const Imported& imported, FileKind kind, const Request& request) {
  const double unit = request.unitOut.empty() ? 1.0 : metres(request.unitOut);
  const Skeleton& skeleton = imported.model.skeleton;
  const auto clipOrPose = [&] {
    if (imported.model.clip && request.frame == 0) return *imported.model.clip;
    return MotionClip{.framesPerSecond = imported.model.clip ? imported.model.clip->framesPerSecond : 30.0, .q = poseOf(imported, request.frame)};
  };
  const double asfUnit = request.unitOut.empty() ? asfMetresPerUnit(0.45) : unit;
  switch (kind) {
    case FileKind::PinocchioSkeleton:
      writeFile(request.out, formatPinocchioSkeleton(scaled(skeleton, 1.0 / unit), PinocchioIds::Names));
      return;
    case FileKind::Asf: return writeFile(request.out, formatAsf(skeleton, asfUnit));
    case FileKind::Amc: return writeFile(request.out, formatAmc(skeleton, clipOrPose(), asfUnit));
    case FileKind::Bvh: return writeFile(request.out, formatBvh(skeleton, clipOrPose(), unit));
    case FileKind::TutorialSkeleton:
      return writeFile(request.out, formatTutorialSkeleton(toTutorialSkeleton(scaled(skeleton, 1.0 / unit))));
    case FileKind::TutorialPose: {
      // Angles of the figure that toTutorialSkeleton makes of this skeleton: its frames are parallel to the world's in the bind pose.
      const TutorialFigure figure = imported.figure ? *imported.figure : toSkeleton(toTutorialSkeleton(skeleton));
      const Frames rest = restFrames(skeleton), posed = forwardKinematics(skeleton, poseOf(imported, request.frame));
      Eigen::VectorXd q = figure.skeleton.rest();
      if (imported.figure) {
        q = poseOf(imported, request.frame);
      } else {
        for (int i = 0; i < skeleton.jointCount(); ++i) {
          const auto turn = [&](int j) { return Eigen::Quaterniond(posed[j].linear() * rest[j].linear().transpose()); };
          const int parent = skeleton.parent(i);
          setJointRotation(figure.skeleton, q, figure.jointOfIndex[i], parent < 0 ? turn(i) : turn(parent).conjugate() * turn(i));
        }
      }
      return writeFile(request.out, formatTutorialPose(tutorialPose(figure, q)));
    }
    case FileKind::Gltf: {
      if (!request.unitOut.empty()) throw std::invalid_argument("glTF is in metres by definition; leave --unit-out away");
      std::vector<GltfClip> clips;
      if (imported.model.clip) clips.push_back({imported.model.name, *imported.model.clip});
      return writeGltf(request.out, skeleton, imported.model.skin ? &*imported.model.skin : nullptr, clips);
    }
    case FileKind::ObjMesh: {
      if (!imported.model.skin) throw std::invalid_argument("'" + request.in + "' has no body to write as OBJ");
      Mesh mesh = imported.model.skin->mesh;
      if (imported.model.clip || request.frame > 0)
        mesh.positions = linearBlendSkin(*imported.model.skin, forwardKinematics(skeleton, poseOf(imported, request.frame))).positions;
      for (auto& p : mesh.positions) p /= unit;
      return writeObj(request.out, mesh);
    }
    case FileKind::PinocchioWeights: {
      if (!imported.model.skin) throw std::invalid_argument("'" + request.in + "' has no body whose weights could be written");
      return writeFile(request.out, formatPinocchioWeights(boneWeights(imported.model.skin->influences, skeleton)));
    }
    case FileKind::DhTable: {
      if (!request.unitOut.empty()) throw std::invalid_argument("a Denavit-Hartenberg table is in metres; leave --unit-out away");
      DhChain chain = dhFromSkeleton(skeleton, request.end.empty() ? -1 : skeleton.jointIndex(request.end));
      chain.table.name = imported.model.name;
      for (char& c : chain.table.name)
        if (c == ' ' || c == '\t' || c == '#') c = '_';
      return writeFile(request.out, formatDhTable(chain.table));
    }
    default: throw std::invalid_argument("writing " + describe(kind) + " is not possible; read only");
  }
}

void run(const Request& request) {
  const auto kind = fileKind(request.out);
  if (!kind) throw std::invalid_argument("cannot tell the format of '" + request.out + "'; known extensions: " + knownExtensions());
  ImportOptions options{.zUp = request.upIn == "z"};
  if (!request.unitIn.empty()) options.metresPerUnit = metres(request.unitIn);
  if (request.fps > 0.0) options.framesPerSecond = request.fps;
  options.bvhPositions = request.bvhPositions == "add" ? BvhPositions::Add : request.bvhPositions == "replace" ? BvhPositions::Replace : BvhPositions::Automatic;
  Imported imported = importFiles(request.in, request.companions, options);
  if (request.upOut == "z") {
    imported.model = rotated(std::move(imported.model), Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX())));
    imported.figure.reset();  // its root no longer stands as in the file
  }
  write(imported, *kind, request);
  for (const std::string& note : imported.model.notes) fmt::print(stderr, "note: {}\n", note);
  fmt::print("{}: {}, {} joints{}\n", request.out, describe(*kind), imported.model.skeleton.jointCount(),
             imported.model.clip ? fmt::format(", {} frames at {:.6g} Hz read", imported.model.clip->frameCount(), imported.model.clip->framesPerSecond) : "");
}

}  // namespace

void addConvertCommand(CLI::App& app) {
  auto request = std::make_shared<Request>();
  CLI::App* command = app.add_subcommand("convert", "Convert between skeletons, motions and skinned models");
  command->add_option("in", request->in, "A file or the name of a built-in model")->required();
  command->add_option("out", request->out, "The file to write; its extension is the format")->required();
  Companions& files = request->companions;
  command->add_option("--skeleton", files.skeleton, "Skeleton of an OBJ");
  command->add_option("--weights", files.weights, "Weights of an OBJ");
  command->add_option("--asf", files.asf, "ASF skeleton of an AMC, or to lay a fitted skeleton on");
  command->add_option("--amc", files.amc, "Motion for the ASF skeleton");
  command->add_option("--mapping", files.mapping, "Bones on joints, lines 'bone ... : joint joint ...'");
  command->add_option("--figure", files.figure, "Figure of a tutorial pose");
  command->add_option("--unit-in", request->unitIn, "Unit of IN: m dm cm mm in ft, or metres; default: what the format says, else m");
  command->add_option("--unit-out", request->unitOut, "Unit of OUT; default: m, for ASF CMU's (length 0.45)");
  command->add_option("--up-in", request->upIn, "The axis that points up in IN")->check(CLI::IsMember({"y", "z"}));
  command->add_option("--up-out", request->upOut, "The axis that shall point up in OUT")->check(CLI::IsMember({"y", "z"}));
  command->add_option("--bvh-positions", request->bvhPositions, "What position channels mean: stand in place of OFFSET or are added to it")
      ->check(CLI::IsMember({"auto", "replace", "add"}));
  command->add_option("--fps", request->fps, "Frame rate of an AMC; default 120")->check(CLI::PositiveNumber);
  command->add_option("--end", request->end, "Last joint of the chain that a DH table shall hold");
  command->add_option("--frame", request->frame, "Write only this frame, from 1")->check(CLI::PositiveNumber);
  command->callback([request] { run(*request); });
}

}  // namespace gelenk
