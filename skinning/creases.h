#pragma once

#include "skinning/mesh.h"

namespace gelenk {

/// The same surface, cut where neighbouring triangles meet at more than the angle (radians), so that edges of
/// boxes, housings and flanges stay sharp in the light; with normals: of each piece about a vertex the mean
/// over its triangles, weighted by area and angle. Triangles keep their number and order; vertices do not.
Mesh withCreases(const Mesh& mesh, double angle);

}  // namespace gelenk
