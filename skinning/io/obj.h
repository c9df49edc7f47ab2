#pragma once

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
/// fits. Texture coordinates, normals, groups, materials, lines and points are passed over; the mesh has no
/// normals until computeNormals.
///
/// Throws ParseError: no vertex, no face, a face with fewer than three corners or an index out of range, a
/// number that is none or not finite, an unknown keyword.
Mesh readObj(const std::string& path, std::vector<Note>* notes = nullptr);
/// The same from text; file names it in messages.
Mesh parseObj(std::string_view text, const std::string& file, std::vector<Note>* notes = nullptr);

/// Colours of an OBJ that was read as this mesh: diffuse colours (Kd) of the .mtl files that it names, by its
/// usemtl lines. Textures are passed over; the vertices stay those of the file, one place for all corners.
/// nullopt where it names no file that is there.
std::optional<MeshLook> readObjLook(const std::string& path, const Mesh& mesh);

/// Vertices in the shortest notation that reads back as the same bits, then triangles. Normals are not
/// written.
std::string formatObj(const Mesh& mesh);
void writeObj(const std::string& path, const Mesh& mesh);

}  // namespace gelenk
