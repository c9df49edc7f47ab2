#pragma once

#include <string>

#include "apps/model.h"
#include "kinematics/dh_table.h"
#include "kinematics/planar_chain.h"

namespace gelenk {

/// A planar arm in the x-y plane, seen from above. Lengths as given: a unit of the slides counts as a metre.
Model planarModel(const PlanarChain& chain);

/// A robot from its DH table; z points up. Notes tell the convention and the parameters counted (4 n + 3, lecture 10.2).
Model dhModel(const DhTable& table);
/// The same from a file (docs/formats/dh.md). Throws ParseError.
Model openDhModel(const std::string& path);

}  // namespace gelenk
