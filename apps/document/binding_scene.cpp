#include "apps/document/binding_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace gelenk {
namespace {

using nlohmann::json;

[[noreturn]] void fail(const std::string& entry, const std::string& expected, const json& found) {
  throw std::runtime_error(
      fmt::format("{}: expected {}, found {}", entry, expected,
                  found.dump(-1, ' ', false, json::error_handler_t::replace).substr(0, 60)));
}

const json& entryOf(const json& root, const char* key) {
  if (!root.is_object() || !root.contains(key))
    throw std::runtime_error(fmt::format("binding has no entry '{}'", key));
  return root.at(key);
}

std::vector<int> readJoints(const json& names, const Skeleton& skeleton) {
  if (!names.is_array()) fail("binding.joints", "a list of joint names", names);
  std::vector<int> joints;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto joint = names[i].is_string() ? skeleton.findJoint(names[i].get<std::string>()) : std::nullopt;
    if (!joint) fail(fmt::format("binding.joints[{}]", i), "a joint of the model", names[i]);
    joints.push_back(*joint);
  }
  return joints;
}

/// [vertex, joint, weight, joint, weight, ...], joints as indices into binding.joints.
std::pair<int, Influences> readRow(const std::string& entry, const json& row, int vertexCount,
                                   const std::vector<int>& joints) {
  if (!row.is_array() || row.size() < 3 || row.size() > 9 || row.size() % 2 == 0)
    fail(entry, "a vertex and one to four pairs of joint and weight", row);
  if (!row[0].is_number_integer() || row[0].get<long>() < 0 || row[0].get<long>() >= vertexCount)
    fail(entry, fmt::format("a vertex from 0 to {}", vertexCount - 1), row[0]);
  Influences influences;
  influences.weights = {0.0, 0.0, 0.0, 0.0};
  double sum = 0.0;
  for (std::size_t k = 0; 2 * k + 1 < row.size(); ++k) {
    const json &joint = row[2 * k + 1], &weight = row[2 * k + 2];
    if (!joint.is_number_integer() || joint.get<long>() < 0 ||
        joint.get<long>() >= static_cast<long>(joints.size()))
      fail(entry, fmt::format("an index into the list of {} joints", joints.size()), joint);
    if (!weight.is_number() || !(weight.get<double>() > 0.0 && weight.get<double>() <= 1.0))
      fail(entry, "a weight in (0, 1]", weight);
    influences.joints[k] = joints[joint.get<std::size_t>()];
    influences.weights[k] = weight.get<double>();
    sum += influences.weights[k];
  }
  if (std::abs(sum - 1.0) > 1e-9) fail(entry, "weights that sum to 1", sum);
  return {row[0].get<int>(), influences};
}

}  // namespace

std::string bindingText(const WeightChange& changed, int vertexCount, const Skeleton& skeleton) {
  std::vector<int> listed(skeleton.jointCount(), -1);
  json names = json::array(), rows = json::array();
  for (const auto& [vertex, influences] : changed) {
    json row = json::array({vertex});
    for (int k = 0; k < 4; ++k) {
      if (influences.weights[k] <= 0.0) continue;
      int& index = listed[influences.joints[k]];
      if (index < 0) {
        index = static_cast<int>(names.size());
        names.push_back(skeleton.joint(influences.joints[k]).name);
      }
      row.push_back(index);
      row.push_back(influences.weights[k]);
    }
    rows.push_back(std::move(row));
  }
  return json{{"vertices", vertexCount}, {"joints", names}, {"changed", rows}}.dump();
}

WeightChange parseBinding(const std::string& text, int vertexCount, const Skeleton& skeleton) {
  const json root = json::parse(text, nullptr, false);
  if (root.is_discarded()) throw std::runtime_error("binding: no valid JSON");
  if (const json& vertices = entryOf(root, "vertices"); vertices != vertexCount)
    fail("binding.vertices", fmt::format("the body's {} vertices", vertexCount), vertices);
  const std::vector<int> joints = readJoints(entryOf(root, "joints"), skeleton);
  const json& rows = entryOf(root, "changed");
  if (!rows.is_array()) fail("binding.changed", "a list", rows);
  WeightChange change;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string entry = fmt::format("binding.changed[{}]", i);
    change.push_back(readRow(entry, rows[i], vertexCount, joints));
    if (i > 0 && change[i].first <= change[i - 1].first)
      fail(entry, "vertices in ascending order", rows[i][0]);
  }
  return change;
}

void applyBinding(const Scene& scene, Model& model) {
  const auto saved = scene.panels.find("Binding");
  if (saved == scene.panels.end() || !model.skin) return;
  for (const auto& [vertex, influences] :
       parseBinding(saved->second, static_cast<int>(model.skin->influences.size()), model.skeleton))
    model.skin->influences[vertex] = influences;
}

}  // namespace gelenk
