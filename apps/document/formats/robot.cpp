#include "apps/document/chain_models.h"
#include "apps/document/file_format.h"
#include "kinematics/io/dh_text.h"
#include "kinematics/io/text_file.h"
#include "skinning/io/urdf_body.h"

namespace gelenk {
namespace {

void readUrdf(const std::string& path, const Companions&, const ImportOptions&, Imported& result) {
  UrdfModel urdf = openUrdf(path);
  Model& model = result.model;
  model.skeleton = std::move(urdf.skeleton);
  model.skin = std::move(urdf.skin);
  if (urdf.masses) model.masses = std::make_shared<const Masses>(*std::move(urdf.masses));
  model.notes = std::move(urdf.notes);
  model.up = Eigen::Vector3d::UnitZ();
}

void readDhTable(const std::string& path, const Companions&, const ImportOptions&, Imported& result) {
  result.model = openDhModel(path);
}

void writeDhTable(const std::string& path, Imported& imported, const ExportOptions& options) {
  const Skeleton& skeleton = imported.model.skeleton;
  DhChain chain = dhFromSkeleton(skeleton, options.end.empty() ? -1 : skeleton.jointIndex(options.end));
  chain.table.name = imported.model.name;
  for (char& c : chain.table.name)
    if (c == ' ' || c == '\t' || c == '#') c = '_';
  writeFile(path, formatDhTable(chain.table));
}

}  // namespace

constinit const FileFormat urdfFormat{
    .description = "URDF robot", .endings = ".urdf", .alwaysMetres = true, .saysUp = true, .read = readUrdf};
constinit const FileFormat dhTableFormat{.description = "Denavit-Hartenberg table",
                                         .endings = ".dh",
                                         .alwaysMetres = true,
                                         .saysUp = true,
                                         .read = readDhTable,
                                         .write = writeDhTable};

}  // namespace gelenk
