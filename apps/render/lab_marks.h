#pragma once

#include <vector>

#include "apps/document/session.h"
#include "apps/render/scene_label.h"

namespace gelenk {

struct Ghost;

/// The solvers' own colours, sRGB; a second solver of the same colour is darkened.
std::vector<Eigen::Vector3f> comparedColours(const LabSettings& lab);

/// Their names in plots, tables and over their ghosts, without parameters; a second of one name is "dls (2)".
std::vector<std::string> comparedNames(const LabSettings& lab);

/// The poses of the solvers that the document compares: in place only where they differ from the document's
/// own, apart always, with name and error. size: of the model, metres.
void addComparedSolvers(const Session& session, double size, std::vector<Ghost>& ghosts,
                        std::vector<SceneLabel>& labels);

}  // namespace gelenk
