#include "apps/chain_models.h"

#include <fmt/format.h>

#include "apps/model_files.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/io/dh_text.h"
#include "skinning/body_around.h"
#include "skinning/io/skin_cache.h"

namespace gelenk {
namespace {

/// The body around a skeleton, kept after the first time: it depends on the rest pose, the tree and the axes alone.
Skin chainSkin(const std::string& name, const Skeleton& skeleton) {
  std::vector<double> facts{1.0};  // raise when the body around skeletons changes its form
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    facts.push_back(joint.parent);
    for (const double value : joint.parentFromZero.matrix().reshaped()) facts.push_back(value);
    for (const AxisDof& dof : joint.axes) facts.insert(facts.end(), {static_cast<double>(dof.kind), dof.axis.x(), dof.axis.y(), dof.axis.z()});
  }
  facts.insert(facts.end(), skeleton.rest().begin(), skeleton.rest().end());
  const std::string_view bytes(reinterpret_cast<const char*>(facts.data()), facts.size() * sizeof(double));
  return cachedSkin(cacheFolder(), name, checksum(bytes), [&] { return bodySkin(skeleton); });
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

Model dhModel(const DhTable& table) {
  Model model{.name = table.name, .skeleton = toSkeleton(table)};
  model.up = Eigen::Vector3d::UnitZ();
  model.handles = {"tool"};
  double size = 0.0;
  for (int i = 0; i < model.skeleton.jointCount(); ++i) size = std::max(size, chainLength(model.skeleton, i));
  if (size > 0.0)
    model.skin = chainSkin(model.name, model.skeleton);
  else
    model.notes.push_back("all frames stand at one point: there is nothing to put a body around");
  model.notes.push_back(fmt::format("{} Denavit-Hartenberg convention, {} rows, {} parameters (4 n + 3)", toString(table.convention),
                                    table.rows.size(), parameterCount(table)));
  return model;
}

Model openDhModel(const std::string& path) {
  DhTable table = readDhTable(path);
  if (table.name.empty()) table.name = stem(path);
  return dhModel(table);
}

}  // namespace gelenk
