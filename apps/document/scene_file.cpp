#include "apps/document/scene_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/document/json_entry.h"
#include "apps/document/model_files.h"
#include "apps/document/pick.h"
#include "apps/document/scene_v1.h"
#include "apps/document/session.h"
#include "apps/lecture/example.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "kinematics/io/word_stream.h"
#include "solvers/problem/goal_text.h"

namespace gelenk {
namespace {

using gelenk::toJson;  // of vectors and quaternions

constexpr const char* formatName = "gelenk-scene";
constexpr int formatVersion = 2;

constexpr std::array<std::pair<GoalState, const char*>, 4> stateNames{{{GoalState::Free, "free"},
                                                                       {GoalState::Held, "held"},
                                                                       {GoalState::Dragged, "dragged"},
                                                                       {GoalState::Pinned, "pinned"}}};
constexpr std::array<std::pair<Theme, const char*>, 2> themeNames{
    {{Theme::Light, "light"}, {Theme::Dark, "dark"}}};

constexpr std::array<std::pair<bool Playback::*, const char*>, 7> playbackNames{
    {{&Playback::loop, "loop"},
     {&Playback::follow, "follow"},
     {&Playback::showing, "showing"},
     {&Playback::goalsOnTop, "goals_on_top"},
     {&Playback::trails, "trails"},
     {&Playback::contacts, "contacts"},
     {&Playback::limits, "limits"}}};

template <typename Table, typename Value>
const char* nameIn(const Table& table, Value value) {
  for (const auto& [entry, name] : table)
    if (entry == value) return name;
  return "?";
}

int readJoint(const JsonEntry& entry, const Skeleton& skeleton) {
  const std::optional<int> joint = skeleton.findJoint(entry.text());
  if (!joint) entry.fail("a joint of the model", "'" + entry.text() + "'");
  return *joint;
}

void requireSolver(const JsonEntry& entry, const std::string& name) {
  const auto known = frameSolverNames();
  if (std::ranges::count(known, name.substr(0, name.find('[')))) {
    try {
      makeSolver(name);
    } catch (const std::invalid_argument& error) {
      entry.fail("a solver and values of its parameters",
                 std::string("one that is refused: ") + error.what());
    }
    return;
  }
  std::string list;
  for (const std::string& solver : known) list += (list.empty() ? "" : ", ") + solver;
  entry.fail("one of the solvers " + list, "'" + name + "'");
}

// --- model and pose

Json toJson(const ModelReference& reference) {
  Json model{{"name", reference.nameOrFile}};
  for (const auto& [file, name] : companionNames)
    if (!(reference.files.*file).empty()) model[name] = reference.files.*file;
  return model;
}

ModelReference readReference(const JsonEntry& model) {
  ModelReference reference{.nameOrFile = model.at("name").text()};
  for (const auto& [file, name] : companionNames)
    if (const auto entry = model.find(name)) reference.files.*file = entry->text();
  return reference;
}

Eigen::VectorXd readPose(const JsonEntry& entry, const Skeleton& skeleton) {
  Eigen::VectorXd q = entry.vector(skeleton.nq());
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    if (!skeleton.joint(i).ball) continue;
    const int at = skeleton.qIndex(i) + static_cast<int>(skeleton.joint(i).axes.size());
    if (const double length = q.segment<4>(at).norm(); std::abs(length - 1.0) > 1e-9)
      entry.fail(fmt::format("a unit quaternion for joint {} at entries {} to {}", skeleton.joint(i).name, at,
                             at + 3),
                 fmt::format("length {}", length));
  }
  skeleton.couple(q);
  return q;
}

// --- goals

Json fieldToJson(int joint, const Skeleton& skeleton) { return skeleton.joint(joint).name; }
Json fieldToJson(double value, const Skeleton&) { return value; }
Json fieldToJson(const Eigen::Vector3d& value, const Skeleton&) { return toJson(value); }
Json fieldToJson(const Eigen::Quaterniond& value, const Skeleton&) { return toJson(value); }
Json fieldToJson(const Eigen::VectorXd& value, const Skeleton&) { return toJson(value); }
Json fieldToJson(const std::vector<Eigen::Vector3d>& value, const Skeleton&) {
  Json list = Json::array();
  for (const Eigen::Vector3d& p : value) list.push_back(toJson(p));
  return list;
}

void readField(const JsonEntry& entry, const Skeleton& skeleton, int& joint) {
  joint = readJoint(entry, skeleton);
}
void readField(const JsonEntry& entry, const Skeleton&, double& value) { value = entry.number(); }
void readField(const JsonEntry& entry, const Skeleton&, Eigen::Vector3d& value) { value = entry.point(); }
void readField(const JsonEntry& entry, const Skeleton&, Eigen::Quaterniond& value) {
  value = entry.unitQuaternion();
}
void readField(const JsonEntry& entry, const Skeleton& skeleton, Eigen::VectorXd& value) {
  value = entry.vector(skeleton.nq());
}
void readField(const JsonEntry& entry, const Skeleton&, std::vector<Eigen::Vector3d>& value) {
  value.clear();
  for (const JsonEntry& p : entry.list()) value.push_back(p.point());
}

GoalKind readKind(const JsonEntry& entry) {
  std::string known;
  for (const GoalType* type : goalTypes()) {
    if (entry.text() == type->name) return type->kind;
    known += (known.empty() ? "" : ", ") + std::string(type->name);
  }
  entry.fail("one of " + known, "'" + entry.text() + "'");
}

Json toJson(const SceneGoal& sceneGoal, const Skeleton& skeleton) {
  const Goal& goal = sceneGoal.goal;
  const GoalState state = sceneGoal.state == GoalState::Dragged ? GoalState::Held : sceneGoal.state;
  Json entry{{"id", static_cast<int>(sceneGoal.id)},
             {"name", goal.name},
             {"kind", goalType(goal.kind).name},
             {"state", nameIn(stateNames, state)},
             {"handle", sceneGoal.handle}};
  if (sceneGoal.weight != 1.0) entry["weight"] = sceneGoal.weight;
  for (const GoalField& field : goalType(goal.kind).fields)
    entry[std::string(field.name)] =
        std::visit([&](auto member) { return fieldToJson(goal.*member, skeleton); }, field.member);
  if (sceneGoal.surface.triangle >= 0)
    entry["surface"] = {{"triangle", sceneGoal.surface.triangle},
                        {"barycentric", toJson(sceneGoal.surface.barycentric)}};
  return entry;
}

SceneGoal readGoal(const JsonEntry& entry, const Model& model) {
  SceneGoal out;
  Goal& goal = out.goal;
  out.id = GoalId{entry.at("id").integer(1, 1'000'000'000)};
  goal.name = entry.at("name").text();
  goal.kind = readKind(entry.at("kind"));
  goal.masses = model.masses;
  for (const GoalField& field : goalType(goal.kind).fields) {
    const std::string name(field.name);
    if (const auto e = entry.find(name.c_str()))
      std::visit([&](auto member) { readField(*e, model.skeleton, goal.*member); }, field.member);
    else if (!field.optional)
      entry.at(name.c_str());  // says that it is missing
    else if (field.meaning == GoalField::Meaning::End)
      goal.end = goal.target;
  }
  if (const std::string why = whyInvalid(goal, model.skeleton); !why.empty())
    entry.fail("a goal that can be asked of the model", why);
  normaliseDirections(goal);
  out.state = entry.at("state").oneOf(stateNames);
  if (out.state == GoalState::Dragged) out.state = GoalState::Held;
  out.handle = entry.at("handle").boolean();
  if (const auto weight = entry.find("weight")) {
    out.weight = weight->number();
    if (!(out.weight > 0.0 && out.weight <= 1e6)) weight->fail("a weight above 0, at most 1e6");
  }
  if (const auto e = entry.find("surface")) {
    const int triangles = model.skin ? static_cast<int>(model.skin->mesh.triangles.size()) : 0;
    out.surface.triangle = e->at("triangle").integer(0, triangles - 1);
    out.surface.barycentric = e->at("barycentric").point();
  }
  return out;
}

std::vector<SceneGoal> readGoals(const JsonEntry& list, const Model& model) {
  std::vector<SceneGoal> goals;
  for (const JsonEntry& entry : list.list()) {
    goals.push_back(readGoal(entry, model));
    for (std::size_t i = 0; i + 1 < goals.size(); ++i)
      if (goals[i].id == goals.back().id) entry.at("id").fail("an id that no other goal has");
  }
  return goals;
}

// --- weights that differ from the model's own

Json weightsToJson(const SharedRows<Influences>& weights, const Model& model) {
  std::vector<int> listed(model.skeleton.jointCount(), -1);
  Json names = Json::array(), rows = Json::array();
  for (int vertex = 0; vertex < weights.size(); ++vertex) {
    const Influences& influences = weights[vertex];
    if (influences == model.skin->influences[vertex]) continue;
    Json row = Json::array({vertex});
    for (int k = 0; k < 4; ++k) {
      if (influences.weights[k] <= 0.0) continue;
      int& index = listed[influences.joints[k]];
      if (index < 0) {
        index = static_cast<int>(names.size());
        names.push_back(model.skeleton.joint(influences.joints[k]).name);
      }
      row.push_back(index);
      row.push_back(influences.weights[k]);
    }
    rows.push_back(std::move(row));
  }
  if (rows.empty()) return {};
  return {{"vertices", weights.size()}, {"joints", names}, {"changed", rows}};
}

/// [vertex, joint, weight, joint, weight, ...], joints as indices into weights.joints.
std::pair<int, Influences> readRow(const JsonEntry& entry, int vertexCount, const std::vector<int>& joints) {
  const std::vector<JsonEntry> row = entry.list();
  if (row.size() < 3 || row.size() > 9 || row.size() % 2 == 0)
    entry.fail("a vertex and one to four pairs of joint and weight");
  const int vertex = row[0].integer(0, vertexCount - 1);
  Influences influences;
  influences.weights = {0.0, 0.0, 0.0, 0.0};
  double sum = 0.0;
  for (std::size_t k = 0; 2 * k + 1 < row.size(); ++k) {
    influences.joints[k] = joints[row[2 * k + 1].integer(0, static_cast<int>(joints.size()) - 1)];
    influences.weights[k] = row[2 * k + 2].number();
    if (!(influences.weights[k] > 0.0 && influences.weights[k] <= 1.0))
      row[2 * k + 2].fail("a weight in (0, 1]");
    sum += influences.weights[k];
  }
  if (std::abs(sum - 1.0) > 1e-9) entry.fail("weights that sum to 1", fmt::format("{}", sum));
  return {vertex, influences};
}

void readWeights(const JsonEntry& entry, const Model& model, SharedRows<Influences>& weights) {
  if (!model.skin) entry.fail("no weights for a model without a body");
  if (entry.at("changed").list().empty()) return;  // older files say so of whatever body they had
  const int vertexCount = weights.size();
  if (entry.at("vertices").integer() != vertexCount)
    entry.at("vertices").fail(fmt::format("the body's {} vertices", vertexCount));
  std::vector<int> joints;
  for (const JsonEntry& name : entry.at("joints").list()) joints.push_back(readJoint(name, model.skeleton));
  int last = -1;
  for (const JsonEntry& rowEntry : entry.at("changed").list()) {
    const auto [vertex, influences] = readRow(rowEntry, vertexCount, joints);
    if (vertex <= last) rowEntry.fail("vertices in ascending order", fmt::format("{}", vertex));
    last = vertex;
    weights.set(vertex, influences);
  }
}

// --- muscles

Json toJson(const MusclePlane& plane) {
  Json displaced = Json::array();
  for (const Eigen::Vector3d& d : plane.displacement) displaced.push_back(toJson(d));
  return {{"stretch", {plane.stretch(0, 0), plane.stretch(0, 1), plane.stretch(1, 0), plane.stretch(1, 1)}},
          {"offset", {plane.offset.x(), plane.offset.y()}},
          {"displacement", displaced}};
}

Json toJson(const MuscleSettings& settings) {
  Json limbs = Json::array();
  for (const auto& [name, limb] : settings.limbs) {
    Json curves = Json::array(), sculpted = Json::array();
    for (const MuscleCurve& curve : limb.control.curves)
      curves.push_back({{"flexor", curve.flexor},
                        {"extensor", curve.extensor},
                        {"near_joint", curve.nearJoint},
                        {"tendon", curve.tendon},
                        {"full_bend", curve.fullBend}});
    for (const MuscleState& state : limb.control.sculpted)
      sculpted.push_back({{"plane2", toJson(state.plane2)}, {"plane4", toJson(state.plane4)}});
    limbs.push_back({{"name", name},
                     {"joint_gap", limb.jointGap},
                     {"wedge", limb.wedge},
                     {"activation", limb.control.activation},
                     {"keep_volume", limb.control.keepVolume},
                     {"curves", curves},
                     {"sculpted", sculpted}});
  }
  return {{"enabled", settings.enabled}, {"lattice", settings.lattice}, {"split", settings.split},
          {"alone", settings.alone},     {"shown", settings.shownLimb}, {"limbs", limbs}};
}

MusclePlane readPlane(const JsonEntry& from) {
  MusclePlane plane;
  const auto stretch = from.at("stretch").list(4), offset = from.at("offset").list(2);
  for (int i = 0; i < 4; ++i) plane.stretch(i / 2, i % 2) = stretch[i].number(-10.0, 10.0);
  for (int i = 0; i < 2; ++i) plane.offset[i] = offset[i].number(-10.0, 10.0);
  const JsonEntry displacement = from.at("displacement");
  if (displacement.list().empty()) return plane;
  for (const JsonEntry& point : displacement.list(16)) {
    const auto xyz = point.list(3);
    plane.displacement.emplace_back(xyz[0].number(-10.0, 10.0), xyz[1].number(-10.0, 10.0),
                                    xyz[2].number(-10.0, 10.0));
  }
  return plane;
}

LimbSettings readLimb(const JsonEntry& from, std::size_t links) {
  LimbSettings settings;
  settings.jointGap = from.at("joint_gap").number(0.01, 0.35);
  settings.wedge = from.at("wedge").number(0.0, 0.49);
  settings.control.activation = from.at("activation").number(0.0, 1.0);
  settings.control.keepVolume = from.at("keep_volume").boolean();
  const auto curves = from.at("curves").list(links), sculpted = from.at("sculpted").list(links);
  for (std::size_t i = 0; i < links; ++i) {
    const JsonEntry& curve = curves[i];
    settings.control.curves.push_back({.flexor = curve.at("flexor").number(-1.0, 2.0),
                                       .extensor = curve.at("extensor").number(-1.0, 2.0),
                                       .nearJoint = curve.at("near_joint").number(-1.0, 2.0),
                                       .tendon = curve.at("tendon").number(-1.0, 0.9),
                                       .fullBend = curve.at("full_bend").number(0.1, 3.2)});
    settings.control.sculpted.push_back(
        {readPlane(sculpted[i].at("plane2")), readPlane(sculpted[i].at("plane4"))});
  }
  return settings;
}

/// Limbs that the file does not mention keep their defaults.
MuscleSettings readMuscles(const JsonEntry& from, const std::vector<Limb>& limbs) {
  MuscleSettings settings = defaultMuscleSettings(limbs);
  settings.enabled = from.at("enabled").boolean();
  settings.lattice = from.at("lattice").boolean();
  settings.split = from.at("split").boolean();
  if (const auto alone = from.find("alone")) settings.alone = alone->boolean();
  const auto limbNamed = [&](const JsonEntry& name) {
    const auto found = std::ranges::find(limbs, name.text(), &Limb::name);
    if (found != limbs.end()) return found - limbs.begin();
    std::string known;
    for (const Limb& limb : limbs) known += (known.empty() ? "" : ", ") + limb.name;
    name.fail("a limb of the model: " + (known.empty() ? "it has none" : known), "'" + name.text() + "'");
  };
  for (const JsonEntry& entry : from.at("limbs").list()) {
    const auto l = limbNamed(entry.at("name"));
    settings.limbs[l].second = readLimb(entry, limbs[l].shape.links.size());
    Limb trial = limbs[l];
    try {
      applyProportions(trial, settings.limbs[l].second);
    } catch (const std::invalid_argument& error) {
      entry.fail("planes that do not cross", error.what());
    }
  }
  if (const auto shown = from.find("shown"))
    settings.shownLimb = shown->text().empty() ? "" : limbs[limbNamed(*shown)].name;
  return settings;
}

// --- motion

Json toJson(const ClipEdits& clip, const Skeleton& skeleton) {
  Json entry{{"falloff", clip.falloff}};
  if (clip.framesPerSecond > 0.0) entry["frames_per_second"] = clip.framesPerSecond;
  if (clip.base) {
    Json frames = Json::array();
    for (Eigen::Index f = 0; f < clip.base->q.cols(); ++f) frames.push_back(toJson(clip.base->q.col(f)));
    entry["base"] = {{"frames_per_second", clip.base->framesPerSecond}, {"q", frames}};
  }
  Json keys = Json::array();
  for (const auto& [joint, list] : clip.keys)
    for (const JointKey& key : list)
      keys.push_back({{"joint", skeleton.joint(joint).name},
                      {"frame", key.frame + 1},
                      {"q", toJson(key.q.segment(skeleton.qIndex(joint), skeleton.qCount(joint)))}});
  entry["keys"] = keys;
  return entry;
}

double readRate(const JsonEntry& entry) {
  const double rate = entry.number();
  if (!(rate > 0.0)) entry.fail("frames a second, above 0");
  return rate;
}

ClipEdits readClip(const JsonEntry& from, const Model& model) {
  if (!model.clip) from.fail("no edits of a motion for a model without one");
  const Skeleton& skeleton = model.skeleton;
  ClipEdits clip{.falloff = from.at("falloff").number(0.0, 1e6)};
  if (const auto entry = from.find("frames_per_second")) clip.framesPerSecond = readRate(*entry);
  int frameCount = model.clip->frameCount();
  if (const auto base = from.find("base")) {
    const auto frames = base->at("q").list();
    frameCount = static_cast<int>(frames.size());
    if (frames.empty()) base->at("q").fail("one frame or more");
    MotionClip motion{.framesPerSecond = readRate(base->at("frames_per_second")),
                      .q = Eigen::MatrixXd(skeleton.nq(), frameCount)};
    for (int f = 0; f < frameCount; ++f) motion.q.col(f) = readPose(frames[f], skeleton);
    clip.base = std::make_shared<const MotionClip>(std::move(motion));
  }
  for (const JsonEntry& entry : from.at("keys").list()) {
    const int joint = readJoint(entry.at("joint"), skeleton);
    JointKey key{.frame = entry.at("frame").integer(1, frameCount) - 1, .q = skeleton.rest()};
    key.q.segment(skeleton.qIndex(joint), skeleton.qCount(joint)) =
        entry.at("q").vector(skeleton.qCount(joint));
    if (skeleton.joint(joint).ball &&
        std::abs(key.q.segment(skeleton.qIndex(joint) + skeleton.qCount(joint) - 4, 4).norm() - 1.0) > 1e-9)
      entry.at("q").fail("a quaternion of unit length at the end");
    auto& keys = clip.keys[joint];
    if (!keys.empty() && key.frame <= keys.back().frame)
      entry.at("frame").fail("frames of a joint in ascending order");
    keys.push_back(std::move(key));
  }
  return clip;
}

// --- solver, view and the rest

Json toJson(const SolverChoice& solver) {
  Json parameters = Json::object();
  for (const auto& [method, values] : solver.parameters)
    for (const auto& [name, value] : values) parameters[method][name] = value;
  return {{"name", solver.name}, {"parameters", parameters}, {"balance", solver.balance}};
}

SolverChoice readSolver(const JsonEntry& from) {
  SolverChoice solver{.name = std::string(presentName(from.at("name").text()))};
  if (const auto balance = from.find("balance")) solver.balance = balance->boolean();
  requireSolver(from.at("name"), solver.name);
  if (const auto parameters = from.find("parameters"))
    for (const auto& [method, values] : parameters->members()) {
      const std::string solverName(presentName(method));
      requireSolver(*parameters, solverName);
      for (const auto& [name, value] : values.members()) solver.parameters[solverName][name] = value.number();
      try {
        validate(solverName, solverEntry(solverName).parameters, solver.parameters[solverName]);
      } catch (const std::invalid_argument& error) {
        values.fail("values of parameters", std::string("some that are refused: ") + error.what());
      }
    }
  return solver;
}

Json toJson(const View& view, Theme theme) {
  const Camera& camera = view.camera;
  Json show = Json::object();
  for (const ViewOptionName& shown : viewOptionNames())
    show[std::string(shown.name)] = view.show.*shown.option;
  Json tree{{"camera",
             {{"target", toJson(camera.target)},
              {"up", toJson(camera.up)},
              {"distance", camera.distance},
              {"azimuth", camera.azimuth},
              {"elevation", camera.elevation},
              {"vertical_field_of_view", camera.verticalFieldOfView},
              {"orthographic", camera.orthographic}}},
            {"show", show},
            {"hidden", view.hidden},
            {"theme", nameIn(themeNames, theme)},
            {"selected", view.selectedJoint}};
  if (camera.distance == 0.0) tree.erase("camera");
  return tree;
}

Camera readCamera(const JsonEntry& entry) {
  Camera camera;
  camera.target = entry.at("target").point();
  camera.up = entry.at("up").direction();
  camera.distance = entry.at("distance").number();
  if (!(camera.distance > 0.0)) entry.at("distance").fail("a distance above 0");
  camera.azimuth = entry.at("azimuth").number();
  camera.elevation = entry.at("elevation").number();
  camera.verticalFieldOfView = entry.at("vertical_field_of_view").number();
  if (!(camera.verticalFieldOfView > 0.0 && camera.verticalFieldOfView < 3.0))
    entry.at("vertical_field_of_view").fail("an angle between 0 and 3 rad");
  camera.orthographic = entry.at("orthographic").boolean();
  return camera;
}

void readView(const JsonEntry& from, const Skeleton& skeleton, Document& document) {
  if (const auto camera = from.find("camera"))
    document.view.camera = readCamera(*camera);
  else
    document.view.camera.distance = 0.0;  // whoever shows it moves it to where the whole is seen
  if (const auto show = from.find("show"))
    for (const ViewOptionName& shown : viewOptionNames())
      if (const auto entry = show->find(std::string(shown.name).c_str()))
        document.view.show.*shown.option = entry->boolean();
  if (const auto hidden = from.find("hidden"))
    for (const JsonEntry& part : hidden->list()) document.view.hidden.insert(part.text());
  if (const auto theme = from.find("theme")) document.theme = theme->oneOf(themeNames);
  if (const auto selected = from.find("selected"); selected && !selected->text().empty())
    document.view.selectedJoint = skeleton.joint(readJoint(*selected, skeleton)).name;
}

Json toJson(const Playback& playback, double seconds) {
  Json entry{{"seconds", seconds}, {"speed", playback.speed}};
  for (const auto& [flag, name] : playbackNames) entry[name] = playback.*flag;
  return entry;
}

Playback readPlayback(const JsonEntry& from, double& seconds) {
  Playback playback;
  if (const auto entry = from.find("seconds")) seconds = entry->number();
  if (const auto entry = from.find("speed")) playback.speed = entry->number(-100.0, 100.0);
  for (const auto& [flag, name] : playbackNames)
    if (const auto entry = from.find(name)) playback.*flag = entry->boolean();
  return playback;
}

SkinChoice readSkin(const JsonEntry& from) {
  try {
    return parseSkinChoice(from.text());
  } catch (const std::invalid_argument& error) {
    from.fail("a skinning method, such as cor+twist+smooth", error.what());
  }
}

LabSettings readLab(const JsonEntry& from, const Skeleton& skeleton) {
  LabSettings lab;
  lab.compare = from.at("compare").boolean();
  lab.sideBySide = from.at("side_by_side").boolean();
  if (const auto skins = from.find("skins"))
    for (const JsonEntry& entry : skins->list()) lab.skins.push_back(readSkin(entry));
  if (lab.skins.size() > LabSettings::mostSkins) from.at("skins").fail("up to three skins");
  lab.solvers.clear();
  for (const JsonEntry& entry : from.at("solvers").list()) {
    lab.solvers.emplace_back(presentName(entry.text()));
    requireSolver(entry, lab.solvers.back());
  }
  if (lab.solvers.empty() || lab.solvers.size() > LabSettings::mostSolvers)
    from.at("solvers").fail("one to four solvers");
  if (const auto poses = from.find("poses"))
    for (const JsonEntry& entry : poses->list())
      lab.poses.push_back(entry.list().empty() ? Eigen::VectorXd() : readPose(entry, skeleton));
  if (!lab.poses.empty() && lab.poses.size() != lab.solvers.size())
    from.at("poses").fail("a pose for each of the solvers");
  return lab;
}

LectureState readLecture(const JsonEntry& from) {
  const LectureState lecture{.topic = from.at("topic").text(), .state = from.at("state").text()};
  std::string known;
  for (const LectureTopic& topic : lectureTopics()) {
    if (topic.id == lecture.topic) return lecture;
    known += (known.empty() ? "" : ", ") + topic.id;
  }
  from.at("topic").fail("one of " + known, "'" + lecture.topic + "'");
}

/// A file in today's format.
struct Tree {
  Json json;
  bool wasVersion1 = false;
};
Tree readTree(std::string_view text, const std::string& file) {
  Json tree = parseJson(plainText(text, file), file);
  const JsonEntry root(file, tree, "");
  if (!tree.is_object()) root.fail("a Gelenk scene {\"format\": \"gelenk-scene\", ...}");
  if (root.at("format").text() != formatName)
    root.fail("\"format\": \"gelenk-scene\"", root.at("format").text());
  const int version = root.at("version").integer();
  if (version == 1) return {fromVersion1(std::move(tree), file), true};
  if (version != formatVersion)
    root.fail(fmt::format("version 1 or {}", formatVersion), std::to_string(version));
  return {std::move(tree)};
}

}  // namespace

std::string formatScene(const Document& document, const Model& model) {
  const Edits& edits = document.edits;
  Json goals = Json::array();
  for (const SceneGoal& goal : edits.goals) goals.push_back(toJson(goal, model.skeleton));
  Json tree{{"format", formatName},
            {"version", formatVersion},
            {"model", toJson(document.model)},
            {"q", toJson(edits.q)},
            {"goals", goals},
            {"solver", toJson(document.solver)},
            {"skin", toString(document.skin)},
            {"view", toJson(document.view, document.theme)}};
  if (Json weights = weightsToJson(edits.weights, model); !weights.is_null())
    tree["weights"] = std::move(weights);
  if (edits.muscles) tree["muscles"] = toJson(*edits.muscles);
  if (edits.clip) tree["clip"] = toJson(*edits.clip, model.skeleton);
  if (model.clip) tree["playback"] = toJson(document.playback, edits.seconds);
  Json skins = Json::array();
  for (const SkinChoice& skin : document.lab.skins) skins.push_back(toString(skin));
  tree["lab"] = {{"compare", document.lab.compare},
                 {"skins", skins},
                 {"side_by_side", document.lab.sideBySide},
                 {"solvers", document.lab.solvers}};
  for (const Eigen::VectorXd& q : document.lab.poses) tree["lab"]["poses"].push_back(toJson(q));
  if (!document.lecture.topic.empty())
    tree["lecture"] = {{"topic", document.lecture.topic}, {"state", document.lecture.state}};
  return formatJson(tree);
}

void writeScene(const std::string& path, const Document& document, const Model& model) {
  writeFile(path, formatScene(document, model));
}

ModelReference parseModelReference(std::string_view text, const std::string& file) {
  const Tree tree = readTree(text, file);
  return readReference(JsonEntry(file, tree.json, "").at("model"));
}
ModelReference readModelReference(const std::string& path) {
  return parseModelReference(readFile(path), path);
}

Document parseScene(std::string_view text, const std::string& file, const Model& model) {
  const Tree tree = readTree(text, file);
  const JsonEntry root(file, tree.json, "");
  Document document = newDocument(model, readReference(root.at("model")));
  Edits& edits = document.edits;
  edits.q = readPose(root.at("q"), model.skeleton);
  edits.goals = readGoals(root.at("goals"), model);
  document.solver = readSolver(root.at("solver"));
  document.skin = {};  // what every scene showed before it said so
  if (const auto entry = root.find("skin")) document.skin = readSkin(*entry);
  readView(root.at("view"), model.skeleton, document);
  if (tree.wasVersion1 && model.planar) document.view.show.ground = false;  // it was never drawn there
  if (const auto entry = root.find("weights")) readWeights(*entry, model, edits.weights);
  if (const auto entry = root.find("muscles"))
    edits.muscles = std::make_shared<MuscleSettings>(readMuscles(*entry, limbsOf(model)));
  if (document.skin.layers != SkinLayers::None) chooseSkin(document, model, document.skin);
  if (const auto entry = root.find("clip")) edits.clip = std::make_shared<ClipEdits>(readClip(*entry, model));
  if (const auto entry = root.find("playback")) document.playback = readPlayback(*entry, edits.seconds);
  if (const auto entry = root.find("lab")) document.lab = readLab(*entry, model.skeleton);
  if (const auto entry = root.find("lecture")) document.lecture = readLecture(*entry);
  return document;
}
Document readScene(const std::string& path, const Model& model) {
  return parseScene(readFile(path), path, model);
}

namespace {

/// A goal's point of the skin lies where its joint's point does, as far as the skin follows. Where it does
/// not, the body has other triangles than when the scene was saved: then the joint's point is what is left.
void leaveStrangeTriangles(Edits& edits, Model& model) {
  constexpr double most = 0.03;  // of the body's size
  const auto onSkin = [](const SceneGoal& goal) { return goal.surface.triangle >= 0; };
  if (std::ranges::none_of(edits.goals, onSkin)) return;
  Skin skin = *model.skin;
  for (int v = 0; v < edits.weights.size(); ++v) skin.influences[v] = edits.weights[v];
  const Frames frames = forwardKinematics(model.skeleton, edits.q);
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : skin.mesh.positions) box.extend(p);
  for (SceneGoal& goal : edits.goals) {
    if (!onSkin(goal)) continue;
    const Eigen::Vector3d there = linearBlendPoint(skin, frames, goal.surface),
                          wanted = frames[goal.goal.joint] * goal.goal.pointInJoint;
    if ((there - wanted).norm() <= most * box.diagonal().norm()) continue;
    goal.surface = {};
    tell(model.notes, "skin-point",
         fmt::format(
             "goal '{}': the body's triangles are others than when the scene was saved; a point of joint {} "
             "takes the place of its point of the skin",
             goal.goal.name, model.skeleton.joint(goal.goal.joint).name));
  }
}

}  // namespace

bool isScene(const std::string& nameOrFile) { return lowerCase(nameOrFile).ends_with(".json"); }

std::string scenePathOf(const std::string& name) { return isScene(name) ? name : name + ".json"; }

Opened openDocument(const ModelReference& reference, Body body) {
  if (!isScene(reference.nameOrFile)) {
    auto model = std::make_shared<const Model>(
        body == Body::Wanted ? readModel(reference)
                             : importFiles(reference.nameOrFile, reference.files).model);
    Document document = newDocument(*model, reference);
    return {std::move(model), std::move(document)};
  }
  if (reference.files != Companions{})
    throw std::invalid_argument("a scene says itself what belongs to its model; leave the other files away");
  auto model = std::make_shared<Model>(readModel(readModelReference(reference.nameOrFile)));
  Document document = readScene(reference.nameOrFile, *model);
  leaveStrangeTriangles(document.edits, *model);
  return {std::move(model), std::move(document)};
}

}  // namespace gelenk
