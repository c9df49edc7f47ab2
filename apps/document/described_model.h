#pragma once

#include <optional>
#include <string>

#include "apps/document/model.h"

namespace gelenk {

/// "joints:" and JSON: a model that stands in no file, joint by joint, with its skin. Every number reads back
/// as it was; motions, masses and colours are left out.
std::string jointsDescription(const Model& model);

/// The model of such a description; nullopt for a name that does not begin so. Throws ParseError naming the
/// entry, and std::invalid_argument where the joints make no skeleton.
std::optional<Model> parseJointsDescription(const std::string& description);

}  // namespace gelenk
