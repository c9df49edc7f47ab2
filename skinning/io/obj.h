#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinematics/io/note.h"
#include "skinning/mesh.h"
#include "skinning/mesh_look.h"

namespace gelenk {

/// A triangle mesh from a Wavefront OBJ. Coordinates are taken as metres; nothing is rescaled.
///
/// Read: `v x y z` (a fourth value must be 1; three or four more, vertex colours, are passed over) and `f` in
/// all forms (i, i/t, i//n, i/t/n, negative indices count back from the line). Polygons become fans about
/// their first corner where no triangle of the fan would fold over (all convex ones), else their ears are cut
/// off one by one; polygons whose edges cross have no right triangles: they become fans, and a note tells
/// ("polygon-crossing"). Vertices keep their order and number, so a weights file with one row a vertex still
/// fits. Texture coordinates, normals and materials are readObjLook's; groups, lines and points are passed
/// over. The mesh has no normals until computeNormals.
///
/// Throws ParseError: no vertex, no face, a face with fewer than three corners or an index out of range, a
/// number that is none or not finite, an unknown keyword.
Mesh readObj(const std::string& path, std::vector<Note>* notes = nullptr);
/// The same from text; file names it in messages.
Mesh parseObj(std::string_view text, const std::string& file, std::vector<Note>* notes = nullptr);

/// How an OBJ's maker made it look, by its usemtl lines and the .mtl files that it names: diffuse colour (Kd,
/// taken as white where it is 0 0 0 beside a texture) times texture (map_Kd; its options are passed over),
/// and by its normals (vn). Where faces lay different texture coordinates or normals on one vertex the
/// surface is cut: the vertex comes again, behind all others, so that those of the file keep their numbers.
struct ObjLook {
  MeshLook look;                 ///< without materials where no .mtl that the file names is there
  std::vector<int> copyOf = {};  ///< the vertex that each added one repeats
  std::vector<std::array<int, 3>> triangles;  ///< of the mesh with the added vertices
  std::vector<Eigen::Vector3d> normals = {};  ///< unit, one a vertex of that mesh; empty: the file has none
};

/// mesh: as readObj read it from that file. coordinates: also those of surfaces that have no texture of the
/// file's own. notes: textures that cannot be read, whose surfaces have one colour; normals that are none or
/// not there, whose vertices take that of their faces. nullopt where the file says nothing of all this.
std::optional<ObjLook> readObjLook(const std::string& path, const Mesh& mesh,
                                   std::vector<Note>* notes = nullptr, bool coordinates = false);
/// Cuts the mesh, and whatever else has a value a vertex. Where the file has no normals the mesh gets them
/// before, so that light does not break at a cut.
void cutSurface(const ObjLook& look, Mesh& mesh);
template <class Value>
void cutSurface(const ObjLook& look, std::vector<Value>& values) {
  for (const int v : look.copyOf) values.push_back(Value(values[v]));
}

/// Vertices in the shortest notation that reads back as the same bits, then triangles; normals where the mesh
/// has them.
std::string formatObj(const Mesh& mesh);
void writeObj(const std::string& path, const Mesh& mesh);

/// A mesh with its look: text of the .obj and of the .mtl that lies beside it as `mtlName`. pictures: the
/// name of each texture's file, as the .mtl shall call it. Vertex colours and hidden parts are written as
/// nothing and as any other.
struct ObjText {
  std::string obj, mtl;
};
ObjText formatObj(const Mesh& mesh, const MeshLook& look, const std::string& mtlName,
                  const std::vector<std::string>& pictures);

}  // namespace gelenk
