#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/document/notes.h"
#include "skinning/mesh.h"
#include "skinning/mesh_look.h"

namespace gelenk {

/// A body that no skeleton came with.
struct Surface {
  Mesh mesh;
  std::shared_ptr<const MeshLook> look = {};  ///< null: clay
  std::vector<Note> notes = {};
};

/// Whether the file holds a surface alone: OBJ, NURBS, STL, or a glTF without skins and motions whose meshes
/// lie beside each other (a mesh that hangs on another one is a joint's). A glTF is looked into; one that
/// cannot be read is none.
bool isSurfaceFile(const std::string& path);
enum class SurfaceLook { Read, None };
/// All meshes of the file, where they stand; of any glTF. Throws ParseError, std::system_error and
/// std::invalid_argument.
Surface readSurface(const std::string& path, SurfaceLook look = SurfaceLook::Read);

}  // namespace gelenk
