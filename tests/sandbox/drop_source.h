#pragma once

#include <string>
#include <vector>

namespace gelenk::testing {

/// Whether this was built with X11's library; without it dropFiles throws.
bool canDropFiles();

/// Drags files over the window at that place of the X11 screen and lets go, as a file manager does: the
/// source's side of the drag and drop protocol, version 5 (freedesktop.org, XDND). Blanks and every byte that
/// is no letter, digit or ". - _ /" go as %XX. Returns when the window has taken them; throws
/// std::runtime_error where it does not within the time.
void dropFiles(const std::string& display, const std::vector<std::string>& paths, int x, int y,
               int patienceSeconds = 30);

}  // namespace gelenk::testing
