#include "apps/sandbox/preferences.h"

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {
namespace fs = std::filesystem;
constexpr std::size_t mostRecent = 12;
}  // namespace

void Preferences::opened(const std::string& path) {
  std::error_code error;
  const std::string whole = fs::absolute(path, error).lexically_normal().string();
  if (error || !fs::is_regular_file(whole, error)) return;  // built-in models are found without it
  std::erase(recent, whole);
  recent.insert(recent.begin(), whole);
  if (recent.size() > mostRecent) recent.resize(mostRecent);
}

std::string preferencesFile() {
  if (const char* config = std::getenv("XDG_CONFIG_HOME"); config && *config)
    return std::string(config) + "/gelenk/sandbox.json";
  if (const char* home = std::getenv("HOME"); home && *home)
    return std::string(home) + "/.config/gelenk/sandbox.json";
  return {};
}

Preferences readPreferences(const std::string& path) {
  std::error_code error;
  if (path.empty() || !fs::is_regular_file(path, error)) return {};
  try {
    const auto json = nlohmann::json::parse(readFile(path));
    Preferences preferences{.inspector = json.value("inspector", 0.0),
                            .strip = json.value("strip", 0.0),
                            .recent = json.value("recent", std::vector<std::string>{}),
                            .folder = json.value("folder", std::string())};
    preferences.inspector = std::clamp(preferences.inspector, 0.0, 4000.0);
    preferences.strip = std::clamp(preferences.strip, 0.0, 4000.0);
    if (preferences.recent.size() > mostRecent) preferences.recent.resize(mostRecent);
    return preferences;
  } catch (const std::exception&) {
    return {};
  }
}

void writePreferences(const std::string& path, const Preferences& preferences) {
  if (path.empty()) return;
  try {
    fs::create_directories(fs::path(path).parent_path());
    const nlohmann::ordered_json json{{"inspector", preferences.inspector},
                                      {"strip", preferences.strip},
                                      {"recent", preferences.recent},
                                      {"folder", preferences.folder}};
    writeFile(path, json.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
  } catch (const std::exception&) {  // the window works without
  }
}

}  // namespace gelenk
