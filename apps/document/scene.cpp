#include "apps/document/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/document/model_files.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

using json = nlohmann::ordered_json;

constexpr const char* formatName = "gelenk-scene";
constexpr int formatVersion = 1;
constexpr int deepestNesting = 200;

constexpr std::array<std::pair<GoalState, const char*>, 4> stateNames{{{GoalState::Free, "free"},
                                                                       {GoalState::Held, "held"},
                                                                       {GoalState::Dragged, "dragged"},
                                                                       {GoalState::Pinned, "pinned"}}};
constexpr std::array<std::pair<GoalKind, const char*>, 6> kindNames{{{GoalKind::Position, "position"},
                                                                     {GoalKind::Orientation, "orientation"},
                                                                     {GoalKind::Pose, "pose"},
                                                                     {GoalKind::Aim, "aim"},
                                                                     {GoalKind::Pole, "pole"},
                                                                     {GoalKind::Posture, "posture"}}};
constexpr std::array<std::pair<bool ViewOptions::*, const char*>, 9> optionNames{
    {{&ViewOptions::skin, "skin"},
     {&ViewOptions::wireframe, "wireframe"},
     {&ViewOptions::skeleton, "skeleton"},
     {&ViewOptions::weights, "weights"},
     {&ViewOptions::jointFrames, "joint_frames"},
     {&ViewOptions::limits, "limits"},
     {&ViewOptions::handles, "handles"},
     {&ViewOptions::ground, "ground"},
     {&ViewOptions::shadow, "shadow"}}};

template <typename Table, typename Value>
const char* nameIn(const Table& table, Value value) {
  for (const auto& [entry, name] : table)
    if (entry == value) return name;
  return "?";
}

template <typename Vector>
json numbers(const Vector& v) {
  json list = json::array();
  for (Eigen::Index i = 0; i < v.size(); ++i) list.push_back(v[i]);
  return list;
}
json quaternion(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

/// A place in the file's tree, able to say what is wrong with it.
class Entry {
 public:
  Entry(const std::string& file, const json& value, std::string path)
      : file_(file), value_(value), path_(std::move(path)) {}

  [[noreturn]] void fail(const std::string& expected, const std::string& found) const {
    throw ParseError(file_, 0, (path_.empty() ? "" : path_ + ": ") + expected, found);
  }
  [[noreturn]] void fail(const std::string& expected) const { fail(expected, shown()); }

  std::optional<Entry> find(const char* key) const {
    if (!value_.is_object()) fail("an object {...}");
    const auto it = value_.find(key);
    if (it == value_.end()) return std::nullopt;
    return Entry(file_, *it, path_.empty() ? key : path_ + "." + key);
  }
  Entry at(const char* key) const {
    if (const auto entry = find(key)) return *entry;
    fail(fmt::format("an entry \"{}\"", key), "none");
  }
  std::vector<Entry> list() const {
    if (!value_.is_array()) fail("a list [...]");
    std::vector<Entry> entries;
    for (std::size_t i = 0; i < value_.size(); ++i)
      entries.emplace_back(file_, value_[i], fmt::format("{}[{}]", path_, i));
    return entries;
  }
  double number() const {
    if (!value_.is_number()) fail("a number");
    const double x = value_.get<double>();
    if (!std::isfinite(x)) fail("a finite number");
    return x;
  }
  int integer() const {
    if (!value_.is_number_integer() || value_.get<double>() < -2147483648.0 ||
        value_.get<double>() > 2147483647.0)
      fail("an integer of 32 bits");
    return value_.get<int>();
  }
  bool boolean() const {
    if (!value_.is_boolean()) fail("true or false");
    return value_.get<bool>();
  }
  std::string text() const {
    if (!value_.is_string()) fail("a text");
    return value_.get<std::string>();
  }
  Eigen::VectorXd vector(Eigen::Index size) const {
    const std::vector<Entry> entries = list();
    if (static_cast<Eigen::Index>(entries.size()) != size)
      fail(fmt::format("{} numbers", size), fmt::format("{}", entries.size()));
    Eigen::VectorXd v(size);
    for (Eigen::Index i = 0; i < size; ++i) v[i] = entries[i].number();
    return v;
  }
  Eigen::Vector3d point() const { return vector(3); }
  Eigen::Quaterniond unitQuaternion() const {
    const Eigen::VectorXd v = vector(4);
    if (std::abs(v.norm() - 1.0) > 1e-9)
      fail("a unit quaternion (w, x, y, z)", fmt::format("length {}", v.norm()));
    return {v[0], v[1], v[2], v[3]};
  }
  template <typename Table>
  auto oneOf(const Table& table) const {
    const std::string word = text();
    std::string known;
    for (const auto& [value, name] : table) {
      if (word == name) return value;
      known += (known.empty() ? "" : ", ") + std::string(name);
    }
    fail("one of " + known, "'" + word + "'");
  }
  const json& value() const { return value_; }

 private:
  std::string shown() const {
    std::string text = value_.dump(-1, ' ', false, json::error_handler_t::replace);
    return text.size() > 40 ? text.substr(0, 37) + "..." : text;
  }
  const std::string& file_;
  const json& value_;
  std::string path_;
};

json parseText(std::string_view text, const std::string& path) {
  try {
    json tree =
        json::parse(text, [&](int depth, json::parse_event_t, json&) {  // writing and telling a tree recurse
          if (depth > deepestNesting)
            throw ParseError(path, 0, fmt::format("entries nested at most {} deep", deepestNesting), "more");
          return true;
        });
    const Entry root(path, tree, "");
    if (!tree.is_object()) root.fail("a Gelenk scene {\"format\": \"gelenk-scene\", ...}");
    if (root.at("format").text() != formatName)
      root.fail("\"format\": \"gelenk-scene\"", root.at("format").text());
    if (root.at("version").integer() != formatVersion)
      root.fail(fmt::format("version {}", formatVersion), std::to_string(root.at("version").integer()));
    return tree;
  } catch (const json::parse_error& error) {
    const int line = 1 + static_cast<int>(std::count(text.begin(),
                                                     text.begin() + std::min(error.byte, text.size()), '\n'));
    throw ParseError(
        path, line, "JSON",
        error.byte >= text.size() ? "the end of the file" : "a character that does not belong there");
  } catch (const json::out_of_range&) {  // thrown for nothing else while reading
    throw ParseError(path, 0, "numbers that a double can hold", "a larger one");
  }
}

json toJson(const SceneGoal& sceneGoal, const Skeleton& skeleton) {
  const Goal& goal = sceneGoal.goal;
  const GoalState state = sceneGoal.state == GoalState::Dragged ? GoalState::Held : sceneGoal.state;
  json entry{{"name", goal.name},
             {"kind", nameIn(kindNames, goal.kind)},
             {"joint", skeleton.joint(goal.joint).name},
             {"point", numbers(goal.pointInJoint)},
             {"target", numbers(goal.target)},
             {"state", nameIn(stateNames, state)},
             {"handle", sceneGoal.handle}};
  if (goal.kind == GoalKind::Orientation || goal.kind == GoalKind::Pose)
    entry["orientation"] = quaternion(goal.orientation);
  if (goal.kind == GoalKind::Aim) entry["axis"] = numbers(goal.axisInJoint);
  if (goal.kind == GoalKind::Posture) entry["posture"] = numbers(goal.posture);
  if (sceneGoal.surface.triangle >= 0)
    entry["surface"] = {{"triangle", sceneGoal.surface.triangle},
                        {"barycentric", numbers(sceneGoal.surface.barycentric)}};
  return entry;
}

SceneGoal readGoal(const Entry& entry, const Skeleton& skeleton) {
  SceneGoal out;
  Goal& goal = out.goal;
  goal.name = entry.at("name").text();
  goal.kind = entry.at("kind").oneOf(kindNames);
  const Entry joint = entry.at("joint");
  const std::optional<int> index = skeleton.findJoint(joint.text());
  if (!index) joint.fail("a joint of the model", "'" + joint.text() + "'");
  goal.joint = *index;
  goal.pointInJoint = entry.at("point").point();
  goal.target = entry.at("target").point();
  out.state = entry.at("state").oneOf(stateNames);
  if (out.state == GoalState::Dragged) out.state = GoalState::Held;
  out.handle = entry.at("handle").boolean();
  if (const auto e = entry.find("orientation")) goal.orientation = e->unitQuaternion();
  if (const auto e = entry.find("axis")) goal.axisInJoint = e->point().normalized();
  if (const auto e = entry.find("posture")) goal.posture = e->vector(skeleton.nq());
  if (const auto e = entry.find("surface")) {
    out.surface.triangle = e->at("triangle").integer();
    out.surface.barycentric = e->at("barycentric").point();
  }
  return out;
}

Camera readCamera(const Entry& entry) {
  Camera camera;
  camera.target = entry.at("target").point();
  camera.up = entry.at("up").point();
  if (std::abs(camera.up.norm() - 1.0) > 1e-9) entry.at("up").fail("a vector of unit length");
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

json toJson(const Camera& camera) {
  return {{"target", numbers(camera.target)},   {"up", numbers(camera.up)},
          {"distance", camera.distance},        {"azimuth", camera.azimuth},
          {"elevation", camera.elevation},      {"vertical_field_of_view", camera.verticalFieldOfView},
          {"orthographic", camera.orthographic}};
}

ModelReference readReference(const Entry& root) {
  const Entry model = root.at("model");
  ModelReference reference{.nameOrFile = model.at("name").text()};
  if (const auto e = model.find("skeleton")) reference.skeletonFile = e->text();
  if (const auto e = model.find("weights")) reference.weightsFile = e->text();
  if (const auto e = model.find("asf")) reference.asfFile = e->text();
  if (const auto e = model.find("amc")) reference.amcFile = e->text();
  if (const auto e = model.find("mapping")) reference.mappingFile = e->text();
  return reference;
}

}  // namespace

const char* toString(GoalState state) { return nameIn(stateNames, state); }

void saveScene(const std::string& path, const Scene& scene, const Skeleton& skeleton) {
  json model{{"name", scene.model.nameOrFile}};
  if (!scene.model.skeletonFile.empty()) model["skeleton"] = scene.model.skeletonFile;
  if (!scene.model.weightsFile.empty()) model["weights"] = scene.model.weightsFile;
  if (!scene.model.asfFile.empty()) model["asf"] = scene.model.asfFile;
  if (!scene.model.amcFile.empty()) model["amc"] = scene.model.amcFile;
  if (!scene.model.mappingFile.empty()) model["mapping"] = scene.model.mappingFile;
  json goals = json::array();
  for (const SceneGoal& goal : scene.goals) goals.push_back(toJson(goal, skeleton));
  json options = json::object();
  for (const auto& [member, name] : optionNames) options[name] = scene.options.*member;
  json panels = json::object();
  for (const auto& [name, text] : scene.panels) panels[name] = json::parse(text);
  const json tree{{"format", formatName},
                  {"version", formatVersion},
                  {"model", model},
                  {"q", numbers(scene.q)},
                  {"goals", goals},
                  {"solver", scene.solver},
                  {"camera", toJson(scene.camera)},
                  {"show", options},
                  {"theme", scene.theme == Theme::Light ? "light" : "dark"},
                  {"selected", scene.selectedJoint},
                  {"panels", panels}};
  writeFile(path, tree.dump(1) + "\n");
}

ModelReference parseModelReference(std::string_view text, const std::string& file) {
  const json tree = parseText(text, file);
  return readReference(Entry(file, tree, ""));
}

ModelReference readModelReference(const std::string& path) {
  return parseModelReference(readFile(path), path);
}

Model readModel(const ModelReference& reference) {
  return withBody(importFiles(reference.nameOrFile, {.skeleton = reference.skeletonFile,
                                                     .weights = reference.weightsFile,
                                                     .asf = reference.asfFile,
                                                     .amc = reference.amcFile,
                                                     .mapping = reference.mappingFile,
                                                     .figure = {}})
                      .model);
}

Scene loadScene(const std::string& path, const Skeleton& skeleton) {
  return parseScene(readFile(path), path, skeleton);
}

Scene parseScene(std::string_view text, const std::string& file, const Skeleton& skeleton) {
  const json tree = parseText(text, file);
  const Entry root(file, tree, "");
  Scene scene;
  scene.model = readReference(root);
  scene.q = root.at("q").vector(skeleton.nq());
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    if (!skeleton.joint(i).ball) continue;
    const int at = skeleton.qIndex(i) + static_cast<int>(skeleton.joint(i).axes.size());
    if (const double length = scene.q.segment<4>(at).norm(); std::abs(length - 1.0) > 1e-9)
      root.at("q").fail(fmt::format("a unit quaternion for joint {} at entries {} to {}",
                                    skeleton.joint(i).name, at, at + 3),
                        fmt::format("length {}", length));
  }
  for (const Entry& entry : root.at("goals").list()) scene.goals.push_back(readGoal(entry, skeleton));
  scene.solver = root.at("solver").text();
  scene.camera = readCamera(root.at("camera"));
  if (const auto show = root.find("show"))
    for (const auto& [member, name] : optionNames)
      if (const auto e = show->find(name)) scene.options.*member = e->boolean();
  if (const auto e = root.find("theme"))
    scene.theme = e->oneOf(
        std::array<std::pair<Theme, const char*>, 2>{{{Theme::Light, "light"}, {Theme::Dark, "dark"}}});
  if (const auto e = root.find("selected")) scene.selectedJoint = e->text();
  if (const auto panels = root.find("panels")) {
    if (!panels->value().is_object()) panels->fail("an object {...}");
    for (const auto& [name, value] : panels->value().items()) scene.panels[name] = value.dump();
  }
  return scene;
}

}  // namespace gelenk
