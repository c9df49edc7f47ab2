#pragma once

#include <string>
#include <string_view>

#include "skinning/mesh.h"

namespace gelenk {

/// A triangle mesh from an STL, binary or text. Corners at exactly one place become one vertex; the file's
/// normals are passed over; triangles that repeat a corner are dropped. No unit is in the file: coordinates
/// are taken as metres. Throws ParseError: a cut-off file, a number that is none or not finite, no triangle.
Mesh readStl(const std::string& path);
Mesh parseStl(std::string_view bytes, const std::string& file);

}  // namespace gelenk
