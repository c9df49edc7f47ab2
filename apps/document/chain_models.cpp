#include "apps/document/chain_models.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "apps/document/model_files.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/io/dh_text.h"
#include "kinematics/io/text_file.h"
#include "kinematics/notation/robots.h"
#include "skinning/bodies/body_around.h"
#include "skinning/bodies/robot_body.h"
#include "skinning/io/skin_cache.h"

namespace gelenk {
namespace {

/// The body around a skeleton, kept after the first time: it depends on the rest pose, the tree and the axes
/// alone.
Skin chainSkin(const std::string& name, const Skeleton& skeleton) {
  std::vector<double> facts{1.0};  // raise when the body around skeletons changes its form
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    facts.push_back(joint.parent);
    for (const double value : joint.parentFromZero.matrix().reshaped()) facts.push_back(value);
    for (const AxisDof& dof : joint.axes)
      facts.insert(facts.end(), {static_cast<double>(dof.kind), dof.axis.x(), dof.axis.y(), dof.axis.z()});
  }
  facts.insert(facts.end(), skeleton.rest().begin(), skeleton.rest().end());
  const std::string_view bytes(reinterpret_cast<const char*>(facts.data()), facts.size() * sizeof(double));
  return cachedSkin(cacheFolder(), name, checksum(bytes), [&] { return bodySkin(skeleton); });
}

/// "1,2:3" as {{1, 2}, {3}}; nullopt where something is no number.
std::optional<std::vector<std::vector<double>>> numberLists(std::string_view text) {
  std::vector<std::vector<double>> lists(1);
  std::size_t from = 0;
  while (from <= text.size()) {
    const std::size_t end = std::min(text.find_first_of(",:", from), text.size());
    const std::optional<double> value = parseNumber(text.substr(from, end - from));
    if (!value) return std::nullopt;
    lists.back().push_back(*value);
    if (end < text.size() && text[end] == ':') lists.emplace_back();
    from = end + 1;
  }
  return lists;
}

bool allPositive(const std::vector<double>& values) {
  return std::ranges::all_of(values, [](double value) { return value > 0.0; });
}

}  // namespace

Model planarModel(const PlanarChain& chain) {
  Model model{.name = "planar", .skeleton = toSkeleton(chain)};
  model.planar = true;
  model.up = Eigen::Vector3d::UnitZ();
  model.handles = {"end-effector"};
  model.skin = chainSkin(model.name, model.skeleton);
  return model;
}

std::optional<PlanarChain> parsePlanarChain(const std::string& description) {
  constexpr std::string_view prefix = "planar:";
  if (!description.starts_with(prefix)) return std::nullopt;
  const auto parts = numberLists(std::string_view(description).substr(prefix.size()));
  if (!parts || parts->size() != 2 || (*parts)[0].size() != 2 || !allPositive((*parts)[1]))
    throw std::invalid_argument(
        "a planar arm is described by planar:X,Y:L1,L2,... with lengths above 0, not '" + description + "'");
  return PlanarChain{.base = {(*parts)[0][0], (*parts)[0][1]}, .lengths = (*parts)[1]};
}

std::optional<Model> parseBallChain(const std::string& description) {
  constexpr std::string_view prefix = "balls:";
  if (!description.starts_with(prefix)) return std::nullopt;
  const auto parts = numberLists(std::string_view(description).substr(prefix.size()));
  if (!parts || parts->size() != 1 || !allPositive((*parts)[0]))
    throw std::invalid_argument(
        "a chain of ball joints is described by balls:L1,L2,... with lengths above 0, not '" + description +
        "'");
  std::vector<Joint> joints;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  for (const double length : (*parts)[0]) {
    Joint joint{.name = "joint" + std::to_string(joints.size() + 1),
                .parent = static_cast<int>(joints.size()) - 1};
    joint.parentFromZero.translation() = offset;
    joint.ball = true;
    joints.push_back(joint);
    offset = {length, 0.0, 0.0};
  }
  joints.push_back({.name = "end-effector",
                    .parent = static_cast<int>(joints.size()) - 1,
                    .parentFromZero = Eigen::Isometry3d(Eigen::Translation3d(offset))});
  Model model{.name = "ball chain", .skeleton = Skeleton(std::move(joints))};
  model.up = Eigen::Vector3d::UnitZ();
  model.handles = {"end-effector"};
  model.skin = chainSkin("balls", model.skeleton);
  return model;
}

Model dhModel(const DhTable& table) {
  Model model{.name = table.name, .skeleton = toSkeleton(table)};
  model.up = Eigen::Vector3d::UnitZ();
  model.handles = {"tool"};
  double size = 0.0;
  for (int i = 0; i < model.skeleton.jointCount(); ++i) size = std::max(size, chainLength(model.skeleton, i));
  if (size > 0.0) {
    RobotBody body = robotBody(model.skeleton, robotFigures(table.name));
    model.skin = std::move(body.skin);
    model.look = std::make_shared<const MeshLook>(std::move(body.look));
  } else {
    tell(model.notes, "no-body", "all frames stand at one point: there is nothing to put a body around");
  }
  tellFact(model.notes, "dh-convention",
           fmt::format("{} Denavit-Hartenberg convention, {} rows, {} parameters (4 n + 3)",
                       toString(table.convention), table.rows.size(), parameterCount(table)));
  return model;
}

namespace {
constexpr std::string_view dhPrefix = "dh:";
}
std::string dhDescription(const DhTable& table) { return std::string(dhPrefix) + formatDhTable(table); }

std::optional<DhTable> dhTableNamed(const std::string& name) {
  if (name.starts_with(dhPrefix)) return parseDhTable(name.substr(dhPrefix.size()), "the DH table");
  for (const Robot& robot : robots())
    if (robot.name == name) return robot.table();
  return std::nullopt;
}

Model openDhModel(const std::string& path) {
  DhTable table = readDhTable(path);
  if (table.name.empty()) table.name = stem(path);
  return dhModel(table);
}

}  // namespace gelenk
