#pragma once

#include <imgui.h>

#include <string>

namespace gelenk {

/// A derivation (apps/lecture/text_table.h) in the present window: formulas set, numbers of a table with
/// their points below each other, tall brackets around matrices. size: of the type in pixels. A line is
/// parted where it may be. A table that is wider than the window is drawn together, set smaller, and, where
/// it would be much smaller, parted into tables below each other; a matrix is set smaller. Columns of a table
/// keep their places while its numbers change.
void drawDerivation(const std::string& text, ImFont* font, float size);

/// A table alone, in the present font, as wide as the window: the inspectors' lists. now: rows after this one
/// are still to come, and faint.
void drawTable(const std::string& rows, int now = -1);

}  // namespace gelenk
