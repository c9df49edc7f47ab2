#include "apps/document/surface.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "apps/document/model_files.h"
#include "kinematics/io/text_file.h"
#include "kinematics/io/word_stream.h"
#include "skinning/io/obj.h"
#include "skinning/io/stl.h"

namespace gelenk {
namespace {

using nlohmann::json;

bool isStl(const std::string& path) { return lowerCase(path).ends_with(".stl"); }

/// The JSON of a .gltf, or the first chunk of a .glb: 12 bytes of the file, 4 with the chunk's length, 4 with
/// its kind, then the text.
json contentsOf(const std::string& path) {
  const std::string bytes = readFile(path);
  if (!bytes.starts_with("glTF")) return json::parse(bytes);
  std::size_t length = 0;
  for (const int k : {15, 14, 13, 12}) length = 256 * length + static_cast<unsigned char>(bytes.at(k));
  return json::parse(bytes.substr(20, length));
}

/// A mesh below another one.
bool hangsTogether(const json& nodes, std::size_t node, bool below, std::size_t depth) {
  const json& n = nodes.at(node);
  const bool mesh = n.contains("mesh");
  if (mesh && below) return true;
  if (depth > nodes.size()) return true;  // a cycle: readGltf says so
  if (n.contains("children"))
    for (const json& child : n["children"])
      if (hangsTogether(nodes, child.get<std::size_t>(), below || mesh, depth + 1)) return true;
  return false;
}

bool isLoose(const json& file) {
  if (!file.contains("meshes") || !file.contains("nodes")) return false;
  if (file.contains("skins") || file.contains("animations")) return false;
  for (std::size_t node = 0; node < file["nodes"].size(); ++node)
    if (hangsTogether(file["nodes"], node, false, 0)) return false;
  return true;
}

}  // namespace

bool isSurfaceFile(const std::string& path) {
  if (isStl(path)) return true;
  const auto kind = fileKind(path);
  if (kind != FileKind::Gltf) return isMesh(kind);
  try {
    return isLoose(contentsOf(path));
  } catch (const std::exception&) {
    return false;
  }
}

Surface readSurface(const std::string& path, SurfaceLook looks) {
  if (isStl(path)) return {.mesh = readStl(path)};
  Surface surface;
  if (fileKind(path) == FileKind::Gltf) {
    GltfModel model = readGltf(path);
    if (!model.skin) throw std::invalid_argument("'" + path + "' holds no mesh");
    return {std::move(model.skin->mesh), std::move(model.look), std::move(model.notes)};
  }
  surface.mesh = readMesh(path, &surface.notes);
  if (looks == SurfaceLook::None || fileKind(path) != FileKind::ObjMesh) return surface;
  if (auto look = readObjLook(path, surface.mesh, &surface.notes)) {
    cutSurface(*look, surface.mesh);
    if (!look->look.materials.empty()) surface.look = std::make_shared<const MeshLook>(std::move(look->look));
  }
  return surface;
}

}  // namespace gelenk
