#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/document/model_files.h"
#include "apps/document/notes.h"
#include "apps/document/surface.h"
#include "kinematics/io/pinocchio_skeleton.h"
#include "skinning/io/gltf.h"
#include "skinning/io/pinocchio_weights.h"
#include "skinning/rigging/auto_rig.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using json = nlohmann::ordered_json;

struct Request {
  std::vector<std::string> bodies;
  std::string skeleton = "human", folder = ".", up = "auto", front = "auto";
  bool asJson = false;
};

/// The triangles of one file: OBJ, STL, or all meshes of a glTF where they stand.
std::optional<Vector3d> axisOf(const std::string& name) {
  if (name == "auto") return {};
  const double sign = name[0] == '-' ? -1.0 : 1.0;
  return Vector3d(sign * Vector3d::Unit(name.back() - 'x'));
}

/// "y", "-z", or "(0.50 0.87 0.00)" for a slanted one.
std::string spoken(const Vector3d& axis) {
  for (int k = 0; k < 3; ++k)
    if (std::abs(axis[k]) > std::cos(2.0 * M_PI / 180.0))
      return std::string(axis[k] < 0.0 ? "-" : "") + static_cast<char>('x' + k);
  return fmt::format("({:.2f} {:.2f} {:.2f})", axis.x(), axis.y(), axis.z());
}

void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  if (!(file << text << std::flush)) throw std::runtime_error("cannot write '" + path.string() + "'");
}

std::vector<double> numbers(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

json jsonOf(const std::string& name, const RiggedBody& body, const std::vector<Note>& notes) {
  const RigReport& report = body.report;
  json stages = json::object();
  double total = 0.0;
  for (const RigStage& stage : report.stages) {
    stages[stage.name] = stage.seconds;
    total += stage.seconds;
  }
  json confidences = json::object();
  for (int j = 0; j < body.skeleton.jointCount(); ++j)
    confidences[body.skeleton.joint(j).name] = report.jointConfidence[j];
  return {{"body", name},
          {"joints", body.skeleton.jointCount()},
          {"up", numbers(report.up)},
          {"front", numbers(report.front)},
          {"height", report.height},
          {"confidence", report.confidence},
          {"pose", report.pose},
          {"symmetric", report.symmetric},
          {"misfit", report.misfit},
          {"strain", report.strain},
          {"limbs", report.limbs},
          {"jointConfidence", confidences},
          {"lostWeight", {{"mean", report.loss.mean}, {"max", report.loss.max}}},
          {"seconds", total},
          {"stages", stages},
          {"repairs", report.repairs},
          {"doubts", report.doubts},
          {"notes", asJson(notes)}};
}

void tellReport(const std::string& name, const RiggedBody& body, const std::string& skeleton) {
  const RigReport& report = body.report;
  fmt::print("{}: {} skeleton, {} joints; up {}, front {}; pose {}{}; confidence {:.2f}\n", name, skeleton,
             body.skeleton.jointCount(), spoken(report.up), spoken(report.front), report.pose,
             report.symmetric ? ", symmetric" : "", report.confidence);
  double total = 0.0;
  std::string stages;
  for (const RigStage& stage : report.stages) {
    stages += fmt::format("{}{} {:.2f} s", stages.empty() ? "" : ", ", stage.name, stage.seconds);
    total += stage.seconds;
  }
  fmt::print("  {:.2f} s ({}); four influences lose {:.2f} % on average, {:.1f} % at most\n", total, stages,
             100.0 * report.loss.mean, 100.0 * report.loss.max);
  for (const std::string& repair : report.repairs) fmt::print("  mended for the fit: {}\n", repair);
  for (const std::string& doubt : report.doubts) fmt::print("  doubtful: {}\n", doubt);
}

/// The exit status: 1 where the file cannot be read, 2 where the body has none of the skeleton's limbs.
int rig(const std::string& path, const Request& request, json& all) {
  Surface surface;
  try {
    surface = readSurface(path, SurfaceLook::None);
  } catch (const std::exception& unreadable) {  // the other bodies are rigged all the same
    fmt::print(stderr, "gelenk: {}\n", unreadable.what());
    return 1;
  }
  const Mesh& mesh = surface.mesh;
  std::vector<Note>& notes = surface.notes;
  RigOptions options{.up = axisOf(request.up), .front = axisOf(request.front)};
  if (request.skeleton == "pinocchio")
    options.skeleton = RigTemplate::Pinocchio;
  else if (request.skeleton == "quadruped")
    options.skeleton = RigTemplate::Quadruped;
  else if (request.skeleton != "human") {
    Model own = openModelFile(request.skeleton);
    tell(notes, own.notes);
    options.own = std::move(own.skeleton);
  }
  request.asJson ? demandNoNotes(path, notes) : sayNotes(path, notes);
  RiggedBody body;
  try {
    body = rigBody(mesh, options);
  } catch (const RigRefused& refusal) {
    fmt::print(stderr, "gelenk: {}: {}; nothing was written\n", path, refusal.what());
    return 2;
  }
  const std::string name = std::filesystem::path(path).stem().string();
  const std::filesystem::path folder = request.folder;
  std::filesystem::create_directories(folder);
  const bool plainIds = options.skeleton == RigTemplate::Pinocchio;
  write(folder / (name + ".skeleton.out"),
        formatPinocchioSkeleton(body.skeleton, plainIds ? PinocchioIds::Indices : PinocchioIds::Names));
  write(folder / (name + ".attachment.out"),
        formatPinocchioWeights(boneTable(body.bones, body.skeleton.jointCount())));
  const Skin skin =
      bindSkin(mesh, restFrames(body.skeleton), fourLargest(body.weights, body.skeleton.jointCount()));
  writeGltf((folder / (name + ".glb")).string(), plainIds ? namedAsHuman(body.skeleton) : body.skeleton,
            &skin, {}, GltfJoints::AsTheyMove);
  if (request.asJson)
    all.push_back(jsonOf(name, body, notes));
  else
    tellReport(name, body, request.skeleton);
  return 0;
}

void run(const Request& request) {
  if (request.up != "auto" && request.front != "auto" && request.up.back() == request.front.back())
    throw std::invalid_argument("--up and --front must be two different axes");
  std::set<std::string> names;
  for (const std::string& body : request.bodies)
    if (const std::string name = std::filesystem::path(body).stem().string(); !names.insert(name).second)
      throw std::invalid_argument("two bodies are called '" + name +
                                  "': the second would be written over the first");
  std::set<int> statuses;
  json all = json::array();
  for (const std::string& body : request.bodies) statuses.insert(rig(body, request, all));
  if (request.asJson) fmt::print("{}\n", all.dump(2));
  for (const int failed : {1, 2})
    if (statuses.contains(failed)) throw ExitStatus{failed};
}

}  // namespace

void addRigCommand(Command& app) {
  auto request = std::make_shared<Request>();
  Command command = app.command("rig", "A skeleton and skin weights for a body that has neither");
  command.option("body", request->bodies, "Meshes: OBJ, GLB, glTF, STL").required();
  command
      .option("--skeleton", request->skeleton,
              "Which skeleton to fit: human, pinocchio (its 18 joints), quadruped, or a file with one of "
              "your own")
      .showDefault();
  command.option("-o,--out", request->folder,
                 "Folder for NAME.skeleton.out, NAME.attachment.out and NAME.glb; default: this one");
  const std::vector<std::string> axes{"auto", "x", "y", "z", "-x", "-y", "-z"};
  command.option("--up", request->up, "The axis that points up; auto: found out").oneOf(axes);
  command.option("--front", request->front, "The axis that the body faces; auto: found out").oneOf(axes);
  command.flag("--json", request->asJson, "Print the report as JSON");
  command.run([request] { run(*request); });
}

}  // namespace gelenk
