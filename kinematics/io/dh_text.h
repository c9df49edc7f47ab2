#pragma once

#include <string>
#include <string_view>

#include "kinematics/notation/dh_table.h"

namespace gelenk {

/// Reads a Denavit-Hartenberg table from text (docs/formats/dh.md); file is the name that errors carry.
/// Throws ParseError: file, line, what was expected, what was found.
DhTable parseDhTable(std::string_view text, const std::string& file);
DhTable readDhTable(const std::string& path);

/// The table as text that reads back as exactly the same values.
std::string formatDhTable(const DhTable& table);

}  // namespace gelenk
