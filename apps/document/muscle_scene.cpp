#include "apps/document/muscle_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace gelenk {
namespace {

using nlohmann::json;

json toJson(const MusclePlane& plane) {
  json displaced = json::array();
  for (const Eigen::Vector3d& d : plane.displacement) displaced.push_back({d.x(), d.y(), d.z()});
  return {{"stretch", {plane.stretch(0, 0), plane.stretch(0, 1), plane.stretch(1, 0), plane.stretch(1, 1)}},
          {"offset", {plane.offset.x(), plane.offset.y()}},
          {"displacement", displaced}};
}

/// Reads with the path of the entry in every message.
class Reader {
 public:
  Reader(const json& value, std::string path) : value_(value), path_(std::move(path)) {}

  Reader at(const char* key) const {
    if (!value_.is_object() || !value_.contains(key))
      throw std::runtime_error(fmt::format("{} has no entry '{}'", path_, key));
    return {value_.at(key), path_ + "." + key};
  }
  Reader at(std::size_t i) const { return {value_.at(i), fmt::format("{}[{}]", path_, i)}; }
  std::size_t size(std::size_t expected) const {
    if (!value_.is_array() || (expected != anySize && value_.size() != expected))
      throw std::runtime_error(
          fmt::format("{}: expected a list of {} entries, found {}", path_, expected,
                      value_.is_array() ? std::to_string(value_.size()) : value_.dump().substr(0, 40)));
    return value_.size();
  }
  bool flag() const {
    if (!value_.is_boolean())
      throw std::runtime_error(
          fmt::format("{}: expected true or false, found {}", path_, value_.dump().substr(0, 40)));
    return value_.get<bool>();
  }
  double number(double lower, double upper) const {
    if (!value_.is_number())
      throw std::runtime_error(
          fmt::format("{}: expected a number, found {}", path_, value_.dump().substr(0, 40)));
    const double x = value_.get<double>();
    if (!(x >= lower && x <= upper))
      throw std::runtime_error(
          fmt::format("{}: expected a number from {} to {}, found {}", path_, lower, upper, x));
    return x;
  }
  std::string text() const {
    if (!value_.is_string())
      throw std::runtime_error(
          fmt::format("{}: expected a text, found {}", path_, value_.dump().substr(0, 40)));
    return value_.get<std::string>();
  }
  const std::string& path() const { return path_; }
  static constexpr std::size_t anySize = static_cast<std::size_t>(-1);

 private:
  const json& value_;
  std::string path_;
};

MusclePlane readPlane(const Reader& from) {
  MusclePlane plane;
  const Reader stretch = from.at("stretch"), offset = from.at("offset"),
               displacement = from.at("displacement");
  stretch.size(4);
  offset.size(2);
  for (int i = 0; i < 4; ++i) plane.stretch(i / 2, i % 2) = stretch.at(i).number(-10.0, 10.0);
  for (int i = 0; i < 2; ++i) plane.offset[i] = offset.at(i).number(-10.0, 10.0);
  const std::size_t points = displacement.size(Reader::anySize);
  if (points != 0) displacement.size(16);
  for (std::size_t c = 0; c < points; ++c) {
    displacement.at(c).size(3);
    plane.displacement.emplace_back();
    for (int k = 0; k < 3; ++k) plane.displacement.back()[k] = displacement.at(c).at(k).number(-10.0, 10.0);
  }
  return plane;
}

LimbSettings readLimb(const Reader& from, std::size_t links) {
  LimbSettings settings;
  settings.jointGap = from.at("joint_gap").number(0.01, 0.35);
  settings.wedge = from.at("wedge").number(0.0, 0.49);
  settings.control.activation = from.at("activation").number(0.0, 1.0);
  settings.control.keepVolume = from.at("keep_volume").flag();
  const Reader curves = from.at("curves"), sculpted = from.at("sculpted");
  curves.size(links);
  sculpted.size(links);
  for (std::size_t i = 0; i < links; ++i) {
    const Reader curve = curves.at(i);
    settings.control.curves.push_back({.flexor = curve.at("flexor").number(-1.0, 2.0),
                                       .extensor = curve.at("extensor").number(-1.0, 2.0),
                                       .nearJoint = curve.at("near_joint").number(-1.0, 2.0),
                                       .tendon = curve.at("tendon").number(-1.0, 0.9),
                                       .fullBend = curve.at("full_bend").number(0.1, 3.2)});
    settings.control.sculpted.push_back(
        {readPlane(sculpted.at(i).at("plane2")), readPlane(sculpted.at(i).at("plane4"))});
  }
  return settings;
}

}  // namespace

LimbSettings defaultLimbSettings(const Limb& limb) {
  return {.jointGap = jointGap(limb.shape), .wedge = limb.shape.wedge, .control = defaultMuscleControl(limb)};
}

std::string muscleSettingsText(const MuscleSettings& settings) {
  json limbs = json::array();
  for (const auto& [name, limb] : settings.limbs) {
    json curves = json::array(), sculpted = json::array();
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
  return json{{"enabled", settings.enabled},
              {"lattice", settings.lattice},
              {"split", settings.split},
              {"limbs", limbs}}
      .dump();
}

MuscleSettings parseMuscleSettings(const std::string& text, const std::vector<Limb>& limbs) {
  const json root = json::parse(text, nullptr, false);
  if (root.is_discarded()) throw std::runtime_error("muscles: no valid JSON");
  const Reader from(root, "muscles");
  MuscleSettings settings{.enabled = from.at("enabled").flag(),
                          .lattice = from.at("lattice").flag(),
                          .split = from.at("split").flag(),
                          .limbs = {}};
  const Reader list = from.at("limbs");
  const std::size_t count = list.size(Reader::anySize);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string name = list.at(i).at("name").text();
    const auto known =
        std::find_if(limbs.begin(), limbs.end(), [&](const Limb& limb) { return limb.name == name; });
    if (known == limbs.end()) {
      std::string names;
      for (const Limb& limb : limbs) names += (names.empty() ? "" : ", ") + limb.name;
      throw std::runtime_error(fmt::format("{}: the model has no limb '{}'; it has: {}", list.at(i).path(),
                                           name, names.empty() ? "none" : names));
    }
    settings.limbs.emplace_back(name, readLimb(list.at(i), known->shape.links.size()));
    Limb trial = *known;
    applyProportions(trial, settings.limbs.back().second);
  }
  return settings;
}

void applyProportions(Limb& limb, const LimbSettings& settings) {
  LimbShape shape = limb.shape;
  shape.wedge = settings.wedge;
  setJointGap(shape, settings.jointGap);
  validate(shape);
  limb.shape = shape;
}

}  // namespace gelenk
