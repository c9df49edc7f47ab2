#pragma once

#include <string>

#include "kinematics/io/note.h"
#include "skinning/mesh.h"
#include "skinning/mesh_look.h"

namespace gelenk {

/// Whether this build reads Collada (with Debian's Assimp).
bool readsCollada();

/// The triangles of a Collada file (.dae) with its normals, all nodes of its scene in place, in metres by the
/// file's own unit. Its up axis is passed over, as ROS' programs do: the coordinates are the link's. look:
/// diffuse colours and textures; notes: textures that cannot be read, whose surfaces have one colour. Throws
/// ParseError: what the library finds wrong, no triangle, a coordinate that is not finite, or always where
/// the build has no Assimp.
Mesh readCollada(const std::string& path, MeshLook* look = nullptr, std::vector<Note>* notes = nullptr);

}  // namespace gelenk
