#pragma once

#include <string>

#include "skinning/muscles/nurbs_surface.h"

namespace gelenk {

/// Reads a NURBS surface in Gelenk's text form (docs/formats/nurbs.md). Throws ParseError and
/// std::runtime_error.
///     nurbs 1
///     degree 3 2                 in u and v
///     points 8 5                 how many in u and v
///     knots_u 0 0 0 0 1 ...
///     knots_v 0 0 0 1 ...
///     point x y z weight         8 x 5 lines, v runs fastest; metres
NurbsSurface readNurbs(const std::string& path);
NurbsSurface parseNurbs(std::string_view text, const std::string& name);

/// Reads back to exactly the same surface.
std::string nurbsText(const NurbsSurface& surface);

}  // namespace gelenk
