#pragma once

#include <string>

#include "apps/document/json_entry.h"

namespace gelenk {

/// A scene file of version 1 as one of version 2. There, what is now muscles, weights, playback, lab and
/// lecture stood as "panels" under the titles of the window's tabs, and goals had no ids. Throws ParseError
/// where an entry has not the form that is needed for that.
Json fromVersion1(Json tree, const std::string& file);

}  // namespace gelenk
