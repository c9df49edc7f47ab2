#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/commands/motion_table.h"
#include "apps/document/configuration_input.h"
#include "apps/document/model.h"
#include "apps/document/notes.h"
#include "apps/document/scene_file.h"
#include "kinematics/configuration.h"
#include "kinematics/rotation.h"

namespace gelenk {
namespace {

using Eigen::VectorXd;
using json = nlohmann::ordered_json;

struct Request {
  std::string model;
  std::vector<double> q;
  bool degrees = false;
  bool asJson = false;
};

constexpr double degree = M_PI / 180.0;

/// What the entries of q mean, in order: "joint1 [rad]", ..., for the complaint about a wrong number of them.
std::string entriesOf(const Skeleton& skeleton) {
  std::string list;
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    std::string kinds;
    for (const AxisDof& dof : joint.axes) kinds += dof.kind == AxisDof::Kind::Rotation ? " angle" : " length";
    if (joint.ball) kinds += " w x y z";
    if (joint.coupling)
      kinds += " (or left away: it follows " + skeleton.joint(joint.coupling->source).name + ")";
    if (!kinds.empty()) list += (list.empty() ? "" : ", ") + joint.name + ":" + kinds;
  }
  return list;
}

/// Quaternions are normalised when they are nearly of unit length; anything else is the user's mistake.
VectorXd configurationOf(const Skeleton& skeleton, const Request& request, const VectorXd& otherwise) {
  if (request.q.empty()) return otherwise;
  const std::optional<VectorXd> given = configurationFrom(skeleton, request.q);
  if (!given)
    throw std::invalid_argument(fmt::format("'{}' needs {} values after --q ({}), {} given", request.model,
                                            skeleton.nq(), entriesOf(skeleton), request.q.size()));
  VectorXd q = *given;
  for (int i = 0; i < skeleton.jointCount(); ++i)
    for (int k = 0; k < static_cast<int>(skeleton.joint(i).axes.size()); ++k)
      if (request.degrees && skeleton.joint(i).axes[k].kind == AxisDof::Kind::Rotation)
        q[skeleton.qIndex(i) + k] *= degree;
  return checkedConfiguration(skeleton, std::move(q), "the values after --q");
}

/// Joints outside their limits are posed all the same; the user is told.
std::vector<Note> notesOf(const Model& model, const VectorXd& q) {
  std::vector<Note> notes = model.notes;
  const Skeleton& skeleton = model.skeleton;
  for (int i = 0; i < skeleton.jointCount(); ++i)
    if (const double excess = limitViolation(skeleton, q, i); excess > 1e-12)
      tell(notes, "outside-limits",
           fmt::format("'{}' lies {:.6g} outside its limits (radians or metres)", skeleton.joint(i).name,
                       excess));
  return notes;
}

void printJson(const Model& model, const VectorXd& q, const Frames& frames) {
  json joints = json::array();
  for (int i = 0; i < model.skeleton.jointCount(); ++i) {
    const auto& p = frames[i].translation();
    const Eigen::Quaterniond r(frames[i].linear());
    joints.push_back(
        {{"name", model.skeleton.joint(i).name},
         {"parent",
          model.skeleton.parent(i) < 0 ? json() : json(model.skeleton.joint(model.skeleton.parent(i)).name)},
         {"position", {p.x(), p.y(), p.z()}},
         {"orientation", {r.w(), r.x(), r.y(), r.z()}}});
  }
  const json out{{"model", model.name},
                 {"q", std::vector<double>(q.begin(), q.end())},
                 {"joints", joints},
                 {"notes", asJson(notesOf(model, q))}};
  fmt::print("{}\n", out.dump(2));
}

void printTable(const Model& model, const Frames& frames) {
  std::size_t width = 5;
  for (const Joint& joint : model.skeleton.joints()) width = std::max(width, joint.name.size());
  fmt::print("{:<{}}  {:>37}   {}\n", "joint", width, "position x y z [m]",
             "orientation: quaternion w x y z, rotation vector [degrees]");
  const auto clean = [](double value) { return std::abs(value) < 5e-10 ? 0.0 : value; };  // no "-0.000000"
  for (int i = 0; i < model.skeleton.jointCount(); ++i) {
    const auto& p = frames[i].translation();
    Eigen::Quaterniond r(frames[i].linear());
    if (r.w() < 0.0) r.coeffs() = -r.coeffs();
    const Eigen::Vector3d turn = logRotation(r) / degree;
    fmt::print(
        "{:<{}}  {:12.6f} {:12.6f} {:12.6f}  {:9.6f} {:9.6f} {:9.6f} {:9.6f}  {:9.3f} {:9.3f} {:9.3f}\n",
        model.skeleton.joint(i).name, width, clean(p.x()), clean(p.y()), clean(p.z()), clean(r.w()),
        clean(r.x()), clean(r.y()), clean(r.z()), clean(turn.x()), clean(turn.y()), clean(turn.z()));
  }
}

void run(const Request& request, const Companions& files) {
  const Opened opened = openDocument({.nameOrFile = request.model, .files = files}, Body::AsItComes);
  const Model& model = *opened.model;
  const VectorXd q = configurationOf(model.skeleton, request, opened.document.edits.q);
  const Frames frames = forwardKinematics(model.skeleton, q);
  if (request.asJson)
    demandNoNotes(request.model, notesOf(model, q));
  else
    sayNotes(request.model, notesOf(model, q));
  request.asJson ? printJson(model, q, frames) : printTable(model, frames);
}

}  // namespace

void addFkCommand(Command& app) {
  auto request = std::make_shared<Request>();
  Command command = app.command("fk", "Forward kinematics: world position and orientation of every joint");
  command
      .option("model", request->model,
              "Name of a built-in model, lecture:EXAMPLE, a file, or a scene (.json)")
      .required();
  command.option("--q", request->q,
                 "Configuration: angles in radians, lengths in metres, ball joints as w x y z; default: the "
                 "rest pose, of a "
                 "scene its own");
  command.flag("--degrees", request->degrees, "Angles after --q are in degrees");
  command.flag("--json", request->asJson, "Print JSON (metres, radians, quaternions w x y z)");
  const auto motion = addMotionTableOptions(command);
  command.run([request, motion] {
    if (motion->wanted() && (!request->q.empty() || request->asJson))
      throw std::invalid_argument(
          "--q and --json are of one pose; they do not go with --csv, --amc, --asf, --frame and --unit");
    if (motion->wanted() && isScene(request->model))
      throw std::invalid_argument(
          "a scene is one pose: --csv, --amc, --asf, --clip, --frame and --unit are for files");
    motion->wanted() ? printMotionTable(request->model, *motion) : run(*request, motion->files);
  });
}

}  // namespace gelenk
