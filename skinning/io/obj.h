#pragma once

#include <string>
#include <string_view>

#include "skinning/mesh.h"

namespace gelenk {

/// A triangle mesh from a Wavefront OBJ. Coordinates are taken as metres; nothing is rescaled.
///
/// Read: `v x y z` (a fourth value must be 1; three or four more, vertex colours, are passed over) and `f` in
/// all forms (i, i/t, i//n, i/t/n, negative indices count back from the line). Polygons become fans about
/// their first corner. Vertices keep their order and number, so a weights file with one row a vertex still
/// fits. Texture coordinates, normals, groups, materials, lines and points are passed over; the mesh has no
/// normals until computeNormals.
///
/// Throws ParseError: no vertex, no face, a face with fewer than three corners or an index out of range, a
/// number that is none or not finite, an unknown keyword.
Mesh readObj(const std::string& path);
/// The same from text; file names it in messages.
Mesh parseObj(std::string_view text, const std::string& file);

/// Vertices in the shortest notation that reads back as the same bits, then triangles. Normals are not
/// written.
std::string formatObj(const Mesh& mesh);
void writeObj(const std::string& path, const Mesh& mesh);

}  // namespace gelenk
