#pragma once

#include "skinning/mesh.h"

namespace gelenk {

/// The same surface, cut where neighbouring triangles meet at more than the angle (radians), so that edges of
/// boxes, housings and flanges stay sharp in the light; with normals: of each piece about a vertex the mean
/// over its triangles, weighted by area and angle. Vertices in one place count as one where neighbours are
/// looked for, so that a mesh that was cut for its texture does not break there. Triangles keep their number
/// and order; vertices do not. from, where given: the vertex that each one was.
Mesh withCreases(const Mesh& mesh, double angle, std::vector<int>* from = nullptr);

}  // namespace gelenk
