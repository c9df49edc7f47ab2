#include "apps/chain_models.h"

#include <fmt/format.h>

#include "apps/model_files.h"
#include "kinematics/io/dh_text.h"

namespace gelenk {

Model planarModel(const PlanarChain& chain) {
  Model model{.name = "planar", .skeleton = toSkeleton(chain)};
  model.planar = true;
  model.up = Eigen::Vector3d::UnitZ();
  model.handles = {"end-effector"};
  return model;
}

Model dhModel(const DhTable& table) {
  Model model{.name = table.name, .skeleton = toSkeleton(table)};
  model.up = Eigen::Vector3d::UnitZ();
  model.handles = {"tool"};
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
