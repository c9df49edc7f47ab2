#pragma once

#include <optional>
#include <string>

#include "kinematics/io/urdf.h"
#include "skinning/mesh_look.h"
#include "skinning/skin.h"

namespace gelenk {

/// A robot with the bodies of its links as one skin, each rigid on its joint.
struct UrdfModel {
  Skeleton skeleton;
  std::optional<Skin> skin = {};
  std::string name = {};                      ///< the robot's own
  std::shared_ptr<const MeshLook> look = {};  ///< of the skin: colours of the URDF, else those of its meshes
  std::optional<Masses> masses = {};
  std::vector<Note> notes = {};
};

/// Meshes are read from STL, OBJ and Collada (collada.h); where a file is not there or is of another kind,
/// one of the same name with one of these endings is taken, else the link's collision geometry; what is
/// missing then is told in the notes. Meshes without normals get them with creases. A texture of the URDF's
/// own material lies on meshes that have texture coordinates. package://NAME/PATH is looked for as NAME/PATH
/// and PATH in the URDF's folder and all folders above it. Throws ParseError.
UrdfModel openUrdf(const std::string& path);

}  // namespace gelenk
