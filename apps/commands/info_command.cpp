#include <fmt/format.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/document/model_files.h"
#include "apps/document/notes.h"
#include "apps/document/scene_file.h"
#include "kinematics/forward_kinematics.h"
#include "skinning/blend/linear_blend.h"
#include "skinning/io/obj.h"
#include "skinning/rigging/weight_paint.h"

namespace gelenk {
namespace {

using nlohmann::json;

struct Request {
  std::string file;
  Companions companions;
  std::string unit;
  bool asJson = false;
};

json boundsOf(const Eigen::AlignedBox3d& box) {
  return {{"lower", {box.min().x(), box.min().y(), box.min().z()}},
          {"upper", {box.max().x(), box.max().y(), box.max().z()}}};
}

std::string counted(int n, const std::string& one, const std::string& many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

/// positions: where the vertices stand, for the bounds.
void addMesh(const Mesh& mesh, const std::vector<Eigen::Vector3d>& positions, json& facts,
             std::vector<Note>& notes) {
  const MeshTopology shape = topology(mesh);
  Eigen::AlignedBox3d box;
  for (const auto& p : positions) box.extend(p);
  facts["vertices"] = shape.vertices;
  facts["triangles"] = shape.triangles;
  facts["components"] = shape.components;
  facts["closed"] = shape.closed();
  facts["manifold"] = shape.manifold();
  facts["bounds"] = boundsOf(box);
  const auto look = [&](const char* kind, int n, const std::string& one, const std::string& many) {
    if (n > 0) tellFact(notes, kind, counted(n, one, many));
  };
  look("mesh-open", shape.boundaryEdges, "edge lies on one triangle only: the surface is open",
       "edges lie on one triangle only: the surface is open");
  look("mesh-not-manifold", shape.nonManifoldEdges,
       "edge is not manifold (more than two triangles, or two that disagree on orientation)",
       "edges are not manifold (more than two triangles, or two that disagree on orientation)");
  look("mesh-not-manifold", shape.nonManifoldVertices, "vertex joins several fans of triangles",
       "vertices join several fans of triangles");
  look("mesh-loose", shape.unreferencedVertices, "vertex belongs to no triangle",
       "vertices belong to no triangle");
  look("mesh-flat", shape.degenerateTriangles, "triangle has no area", "triangles have no area");
  if (shape.closed() && shape.manifold() && enclosedVolume(mesh) < 0.0)
    tellFact(notes, "mesh-inwards", "the triangles face inwards");
}

void addSkeleton(const Skeleton& skeleton, json& facts) {
  Eigen::AlignedBox3d box;
  for (const auto& frame : restFrames(skeleton)) box.extend(frame.translation());
  facts["joints"] = skeleton.jointCount();
  facts["dofs"] = skeleton.nv();
  facts["root"] = skeleton.joint(0).name;
  facts["jointBounds"] = boundsOf(box);
  if (!facts.contains("bounds")) facts["bounds"] = facts["jointBounds"];
}

/// How long, how fast, and where the motion leaves the model's own limits: told, never clamped.
void addMotion(const Skeleton& skeleton, const MotionClip& clip, json& facts, std::vector<Note>& notes) {
  facts["frames"] = clip.frameCount();
  facts["framesPerSecond"] = clip.framesPerSecond;
  facts["seconds"] = clip.duration();
  int outside = 0, samples = 0;
  for (int f = 0; f < clip.frameCount(); ++f)
    for (int i = 0; i < skeleton.jointCount(); ++i)
      for (std::size_t k = 0; k < skeleton.joint(i).axes.size(); ++k) {
        const AxisDof& dof = skeleton.joint(i).axes[k];
        if (dof.lower == -unlimited && dof.upper == unlimited) continue;
        const double value = clip.q(skeleton.qIndex(i) + k, f);
        constexpr double rounding = 1e-9;
        outside += value < dof.lower - rounding || value > dof.upper + rounding;
        ++samples;
      }
  facts["limitedSamples"] = samples;
  facts["samplesOutsideLimits"] = outside;
  if (outside > 0)
    tellFact(
        notes, "outside-limits",
        fmt::format("{} of {} limited values ({:.1f} %) lie outside the model's own limits; playback keeps "
                    "them",
                    outside, samples, 100.0 * outside / samples));
}

/// What was done to the model in a scene.
json sceneFacts(const Document& document, const Model& model) {
  const Edits& edits = document.edits;
  int held = 0, pinned = 0, keys = 0;
  for (const SceneGoal& goal : edits.goals) {
    held += goal.state == GoalState::Held;
    pinned += goal.state == GoalState::Pinned;
  }
  int rebound = 0;
  for (int v = 0; v < edits.weights.size(); ++v) rebound += !(edits.weights[v] == model.skin->influences[v]);
  if (edits.clip)
    for (const auto& [joint, list] : edits.clip->keys) keys += static_cast<int>(list.size());
  return {{"model", document.model.nameOrFile},
          {"solver", document.solver.name},
          {"goalsHeld", held},
          {"goalsPinned", pinned},
          {"verticesRebound", rebound},
          {"muscles", edits.muscles && edits.muscles->enabled},
          {"motionEdited", edits.clip && edits.clip->base},
          {"keys", keys},
          {"lecture", document.lecture.topic}};
}

json factsOfScene(const Request& request, std::vector<Note>& notes) {
  if (!request.unit.empty()) throw std::invalid_argument("a scene is in metres; leave --unit away");
  const Opened opened = openDocument({.nameOrFile = request.file, .files = request.companions});
  const Model& model = *opened.model;
  json facts{{"file", request.file}, {"format", "Gelenk scene"}};
  notes = model.notes;
  if (model.skin) addMesh(model.skin->mesh, model.skin->mesh.positions, facts, notes);
  addSkeleton(model.skeleton, facts);
  if (model.clip) addMotion(model.skeleton, *model.clip, facts, notes);
  facts["scene"] = sceneFacts(opened.document, model);
  return facts;
}

void printScene(const json& scene) {
  fmt::print("  scene      of '{}', solver {}, {} held, {} pinned\n", scene["model"].get<std::string>(),
             scene["solver"].get<std::string>(), counted(scene["goalsHeld"].get<int>(), "goal", "goals"),
             scene["goalsPinned"].get<int>());
  std::string edits;
  if (const int n = scene["verticesRebound"].get<int>())
    edits += ", " + counted(n, "vertex", "vertices") + " bound anew";
  if (scene["muscles"].get<bool>()) edits += ", muscle layers";
  if (scene["motionEdited"].get<bool>()) edits += ", edited motion";
  if (const int n = scene["keys"].get<int>()) edits += ", " + counted(n, "key", "keys");
  if (const auto topic = scene["lecture"].get<std::string>(); !topic.empty()) edits += ", lecture:" + topic;
  if (!edits.empty()) fmt::print("  edits      {}\n", edits.substr(2));
}

json factsOf(const Request& request, std::vector<Note>& notes) {
  if (isScene(request.file)) return factsOfScene(request, notes);
  json facts{{"file", request.file}};
  const auto kind = fileKind(request.file);
  facts["format"] = kind ? describe(*kind) : "model";
  if (isMesh(kind) && request.companions.skeleton.empty()) {
    const Mesh mesh = readMesh(request.file, &notes);
    addMesh(mesh, mesh.positions, facts, notes);
    return facts;
  }
  ImportOptions options;
  if (!request.unit.empty()) options.metresPerUnit = metresPerUnit(request.unit);
  const Imported imported = importFiles(request.file, request.companions, options);
  const Model& model = imported.model;
  notes = model.notes;
  if (model.skin)
    addMesh(model.skin->mesh, linearBlendSkin(*model.skin, restFrames(model.skeleton)).positions, facts,
            notes);
  addSkeleton(model.skeleton, facts);
  if (imported.model.clip) addMotion(model.skeleton, *imported.model.clip, facts, notes);
  if (!model.clipName.empty()) facts["motion"] = model.clipName;
  for (const GltfClip& clip : imported.clips)
    facts["motions"].push_back({{"name", clip.name},
                                {"frames", clip.clip.frameCount()},
                                {"framesPerSecond", clip.clip.framesPerSecond},
                                {"seconds", clip.clip.duration()}});
  return facts;
}

std::string corner(const json& p) {
  const auto clean = [&](int k) { return std::abs(p[k].get<double>()) < 1e-9 ? 0.0 : p[k].get<double>(); };
  return fmt::format("({:.4g}, {:.4g}, {:.4g})", clean(0), clean(1), clean(2));
}

void print(const json& facts, const std::vector<Note>& notes) {
  fmt::print("{}: {}\n", facts["file"].get<std::string>(), facts["format"].get<std::string>());
  if (facts.contains("joints"))
    fmt::print("  joints     {} ({} degrees of freedom), root '{}'\n", facts["joints"].get<int>(),
               facts["dofs"].get<int>(), facts["root"].get<std::string>());
  if (facts.contains("vertices"))
    fmt::print("  mesh       {} vertices, {} triangles, {}, {}, {}\n", facts["vertices"].get<int>(),
               facts["triangles"].get<int>(),
               counted(facts["components"].get<int>(), "component", "components"),
               facts["closed"].get<bool>() ? "closed" : "open",
               facts["manifold"].get<bool>() ? "manifold" : "not manifold");
  if (facts.contains("frames"))
    fmt::print("  motion     {}{} at {:.6g} Hz, {:.3f} s\n",
               facts.contains("motion") ? "'" + facts["motion"].get<std::string>() + "', " : "",
               counted(facts["frames"].get<int>(), "frame", "frames"), facts["framesPerSecond"].get<double>(),
               facts["seconds"].get<double>());
  if (facts.contains("motions") && facts["motions"].size() > 1)
    for (const json& motion : facts["motions"])
      fmt::print("             '{}': {} at {:.6g} Hz, {:.3f} s\n", motion["name"].get<std::string>(),
                 counted(motion["frames"].get<int>(), "frame", "frames"),
                 motion["framesPerSecond"].get<double>(), motion["seconds"].get<double>());
  if (facts.contains("scene")) printScene(facts["scene"]);
  fmt::print("  bounds     {} to {} m\n", corner(facts["bounds"]["lower"]), corner(facts["bounds"]["upper"]));
  if (!notesAreQuiet())
    for (const Note& note : notes) fmt::print("  note       {}\n", note.line());
}

void run(const Request& request) {
  std::vector<Note> notes;
  json facts = factsOf(request, notes);
  demandNoNotes(request.file, notes);
  facts["notes"] = asJson(notes);
  if (request.asJson)
    fmt::print("{}\n", facts.dump(2));
  else
    print(facts, notes);
}

}  // namespace

void addInfoCommand(Command& app) {
  auto request = std::make_shared<Request>();
  Command command = app.command("info", "What is in a file or a built-in model");
  command.option("file", request->file, "A file, a scene (.json), or the name of a built-in model")
      .required();
  command.option("--skeleton", request->companions.skeleton, "Skeleton file for an OBJ");
  command.option("--weights", request->companions.weights, "Weights file for an OBJ with a skeleton");
  command.option("--asf", request->companions.asf, "ASF skeleton of an AMC, or to lay a fitted skeleton on");
  command.option("--amc", request->companions.amc, "Motion for the ASF skeleton");
  command.option("--mapping", request->companions.mapping,
                 "Bones on joints, lines 'bone ... : joint joint ...'");
  command.option("--figure", request->companions.figure, "Figure of a tutorial pose");
  command.option("--unit", request->unit,
                 "Unit of the file: m dm cm mm in ft, or metres; default: what the format says, else m");
  command.option("--clip", request->companions.clip,
                 "Which motion of a file that names several; default: the first");
  command
      .option(
          "--up", request->companions.up,
          "The axis that points up where the format does not say it; default: along which the body stands")
      .oneOf({"y", "z"});
  command.flag("--json", request->asJson, "Print JSON");
  command.run([request] { run(*request); });
}

}  // namespace gelenk
