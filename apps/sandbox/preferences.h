#pragma once

#include <string>
#include <vector>

namespace gelenk {

/// What the window remembers from one start to the next. Nothing of it changes a result.
struct Preferences {
  double inspector = 0.0, strip = 0.0;   ///< width and height at scale 1, pixels; 0: by the window's size
  std::vector<std::string> recent = {};  ///< files that were opened, newest first
  std::string folder = {};               ///< that the browser showed last

  void opened(const std::string& path);
  bool operator==(const Preferences&) const = default;
};

/// $XDG_CONFIG_HOME/gelenk/sandbox.json, by default in ~/.config; empty where neither is known.
std::string preferencesFile();
/// A file that is missing or damaged counts as none: nothing depends on it.
Preferences readPreferences(const std::string& path);
/// Does nothing where it cannot be written.
void writePreferences(const std::string& path, const Preferences& preferences);

}  // namespace gelenk
