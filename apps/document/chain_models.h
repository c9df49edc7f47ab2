#pragma once

#include <optional>
#include <string>

#include "apps/document/model.h"
#include "kinematics/notation/dh_table.h"
#include "kinematics/notation/planar_chain.h"

namespace gelenk {

/// A planar arm in the x-y plane, seen from above. Lengths as given: a unit of the slides counts as a metre.
Model planarModel(const PlanarChain& chain);

/// A planar arm from its description "planar:X,Y:L1,L2,...": the base point and the lengths. nullopt for a
/// name that does not begin so. Throws std::invalid_argument for one that does and goes on otherwise.
std::optional<PlanarChain> parsePlanarChain(const std::string& description);

/// Ball joints at the ends of links along x, from "balls:L1,L2,...": "joint1", ..., "end-effector". nullopt
/// and errors as above.
std::optional<Model> parseBallChain(const std::string& description);

/// A robot from its DH table; z points up. Notes tell the convention and the parameters counted (4 n + 3,
/// lecture 10.2).
Model dhModel(const DhTable& table);
/// "dh:" and the text of the table (docs/formats/dh.md): a robot that stands in no file.
std::string dhDescription(const DhTable& table);
/// The table of such a description or of a built-in robot's name; nullopt for another name. Throws
/// ParseError.
std::optional<DhTable> dhTableNamed(const std::string& name);
/// The same from a file (docs/formats/dh.md). Throws ParseError.
Model openDhModel(const std::string& path);

}  // namespace gelenk
