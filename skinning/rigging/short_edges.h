#pragma once

#include <cstddef>

#include "skinning/mesh.h"

namespace gelenk {

/// The same surface without edges longer than `longest`: they are halved round by round, in all of their
/// triangles, so that no gap opens. The vertices of the input come first. A round begins only with fewer than
/// `enough` triangles, so the result has at most four times as many. Normals are dropped.
Mesh withShortEdges(const Mesh& mesh, double longest, std::size_t enough = 100000);

}  // namespace gelenk
