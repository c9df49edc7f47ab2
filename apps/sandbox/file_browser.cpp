#include "apps/sandbox/file_browser.h"

#include <GLFW/glfw3.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "apps/document/model_files.h"
#include "apps/document/scene_file.h"
#include "apps/sandbox/sandbox_state.h"

namespace gelenk {
namespace {

namespace fs = std::filesystem;

/// Without what says nothing: "a/./b/" is "a/b".
std::string plain(const std::string& folder) {
  std::string path = fs::path(folder).lexically_normal().string();
  if (path.size() > 1 && path.back() == '/') path.pop_back();
  return path;
}

std::string home() {
  const char* folder = std::getenv("HOME");
  return folder ? plain(folder) : "";
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::vector<std::string> split(const std::string& words) {
  std::vector<std::string> parts;
  std::size_t from = 0;
  while ((from = words.find_first_not_of(' ', from)) != std::string::npos) {
    const std::size_t to = std::min(words.find(' ', from), words.size());
    parts.push_back(words.substr(from, to - from));
    from = to;
  }
  return parts;
}

struct Filter {
  const char* title;
  const char* endings;  ///< empty: everything that opens
};
constexpr std::array filters{Filter{"Everything that opens", ""}, Filter{"Scenes (.json)", ".json"},
                             Filter{"Bodies and characters", ".obj .glb .gltf .nurbs"},
                             Filter{"Robots", ".urdf .dh"},
                             Filter{"Motions and skeletons", ".bvh .amc .asf .skel .skeleton .figure .pose"}};

}  // namespace

std::string openableEndings() {
  std::string all = ".json " + knownExtensions();
  std::erase(all, ',');
  return all;
}

std::vector<BrowserEntry> folderEntries(const std::string& folder, const std::string& endings) {
  std::vector<BrowserEntry> entries;
  const std::vector<std::string> wanted = split(endings.empty() ? openableEndings() : endings);
  std::error_code error;
  for (auto it = fs::directory_iterator(folder, fs::directory_options::skip_permission_denied, error);
       !error && it != fs::directory_iterator(); it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (name.empty() || name[0] == '.') continue;
    std::error_code ignored;
    if (it->is_directory(ignored))
      entries.push_back({name, true});
    else if (std::ranges::any_of(wanted, [&](const std::string& e) { return lower(name).ends_with(e); }))
      entries.push_back({name, false});
  }
  std::ranges::sort(entries, [](const BrowserEntry& a, const BrowserEntry& b) {
    return a.isFolder != b.isFolder ? a.isFolder : lower(a.name) < lower(b.name);
  });
  return entries;
}

std::vector<BrowserPlace> browserPlaces() {
  std::vector<BrowserPlace> places;
  if (!home().empty()) places.push_back({"Home", home()});
  std::error_code error;
  const fs::path here = fs::current_path(error);
  if (!error && !fs::equivalent(here, home(), error)) places.push_back({"Here", plain(here.string())});
  return places;
}

std::string FileBrowser::whyEmpty() const {
  if (!entries_.empty()) return "";
  if (!readable_) return "This folder cannot be read.";
  if (purpose_ == Purpose::Save) return "No scenes and no folders here yet.";
  return filter_ == 0 ? "Nothing here that opens." : "Nothing of this kind here.";
}

void FileBrowser::begin(Purpose purpose, const std::string& folder, const std::string& name) {
  purpose_ = purpose;
  std::snprintf(name_, sizeof name_, "%s", name.c_str());
  filter_ = 0;
  focus_ = true;
  replaced_.clear();
  std::error_code error;
  enter(folder.empty() || !fs::is_directory(folder, error) ? fs::current_path(error).string()
                                                           : fs::absolute(folder, error).string());
}

void FileBrowser::enter(const std::string& folder) {
  folder_ = plain(folder);
  selected_.clear();
  std::error_code error;
  fs::directory_iterator(folder_, error);
  readable_ = !error;
  entries_ = folderEntries(folder_, purpose_ == Purpose::Save ? ".json" : filters[filter_].endings);
}

void FileBrowser::places(Sandbox& sandbox, float height, std::optional<std::string>& chosen) {
  Sandbox::State& s = sandbox.state();
  ImGui::BeginChild("places", {190 * s.scale, height});
  heading(s, "PLACES");
  for (const BrowserPlace& place : browserPlaces())
    if (ImGui::Selectable(place.name.c_str(), place.folder == folder_)) enter(place.folder);
  if (purpose_ == Purpose::Open) {
    if (!s.preferences.recent.empty()) heading(s, "RECENT");
    for (const std::string& path : s.preferences.recent) {
      ImGui::PushID(path.c_str());
      if (ImGui::Selectable(fs::path(path).filename().string().c_str())) chosen = path;
      tooltip(path.c_str());
      ImGui::PopID();
    }
    heading(s, "BUILT IN");
    for (const std::string& name : builtInModels())
      if (ImGui::Selectable(name.c_str())) chosen = name;
  }
  ImGui::EndChild();
}

void FileBrowser::list(Sandbox& sandbox, float height, std::optional<std::string>& chosen) {
  Sandbox::State& s = sandbox.state();
  ImGui::PushStyleVar(ImGuiStyleVar_ChildBorderSize, 1.0f);
  ImGui::BeginChild("list", {430 * s.scale, height}, true);
  ImGui::PopStyleVar();
  const fs::path folder(folder_);
  std::string into;
  if (folder.has_parent_path() && folder != folder.root_path() && ImGui::Selectable("‹ one folder up"))
    into = folder.parent_path().string();
  for (const BrowserEntry& entry : entries_) {
    ImGui::PushID(entry.name.c_str());
    if (entry.isFolder) {
      ImGui::PushStyleColor(ImGuiCol_Text, s.colours().accent);
      if (ImGui::Selectable((entry.name + " /").c_str())) into = (folder / entry.name).string();
      ImGui::PopStyleColor();
    } else if (ImGui::Selectable(entry.name.c_str(), entry.name == selected_,
                                 ImGuiSelectableFlags_AllowDoubleClick)) {
      selected_ = entry.name;
      std::snprintf(name_, sizeof name_, "%s", entry.name.c_str());
      if (ImGui::IsMouseDoubleClicked(0) && purpose_ == Purpose::Open)
        chosen = (folder / entry.name).string();
    }
    ImGui::PopID();
  }
  if (const std::string why = whyEmpty(); !why.empty())
    ImGui::TextColored(s.colours().textDim, "%s", why.c_str());
  ImGui::EndChild();
  if (!into.empty()) enter(into);
}

std::optional<std::string> FileBrowser::draw(Sandbox& sandbox) {
  Sandbox::State& s = sandbox.state();
  std::optional<std::string> chosen;
  const float height = std::min(330 * s.scale, 0.6f * s.layout.view.height);
  ImGui::PushFont(s.gui.fonts().small);
  const bool atHome = !home().empty() && (folder_ == home() || folder_.starts_with(home() + "/"));
  ImGui::TextColored(s.colours().textDim, "%s",
                     atHome ? ("~" + folder_.substr(home().size())).c_str() : folder_.c_str());
  ImGui::PopFont();
  places(sandbox, height, chosen);
  ImGui::SameLine();
  list(sandbox, height, chosen);
  if (std::exchange(focus_, false)) s.gui.focusText();
  ImGui::SetNextItemWidth((purpose_ == Purpose::Open ? 400 : 628) * s.scale);
  const bool entered = ImGui::InputText("##path", name_, sizeof name_, ImGuiInputTextFlags_EnterReturnsTrue);
  if (purpose_ == Purpose::Open) {
    ImGui::SameLine();
    ImGui::SetNextItemWidth(220 * s.scale);
    if (ImGui::BeginCombo("##filter", filters[filter_].title)) {
      for (int i = 0; i < static_cast<int>(filters.size()); ++i)
        if (ImGui::Selectable(filters[i].title, i == filter_)) filter_ = i, enter(std::string(folder_));
      ImGui::EndCombo();
    }
  }
  ImGui::PushFont(s.gui.fonts().small);
  if (!replaced_.empty())
    ImGui::TextColored(s.colours().bad, "%s is there already: its contents will be lost.",
                       fs::path(replaced_).filename().string().c_str());
  else
    ImGui::TextColored(s.colours().textDim, "%s",
                       purpose_ == Purpose::Save ? "A name in this folder, or a whole path; .json is added."
                                                 : "A file, a folder, or the name of a built-in model.");
  ImGui::PopFont();
  const bool confirmed = ImGui::Button(purpose_ == Purpose::Open ? "Open"
                                       : replaced_.empty()       ? "Save"
                                                                 : "Replace",
                                       {96 * s.scale, 0}) ||
                         entered || (!replaced_.empty() && ImGui::IsKeyPressed(GLFW_KEY_ENTER, false));
  std::error_code error;
  const fs::path typed(name_), inFolder = typed.is_absolute() ? typed : fs::path(folder_) / typed;
  const std::string scene = scenePathOf(inFolder.string());
  if (scene != replaced_) replaced_.clear();
  if (confirmed && name_[0] != '\0') {
    if (fs::is_directory(inFolder, error)) {
      enter(inFolder.string());
      name_[0] = '\0';
    } else if (purpose_ == Purpose::Save && replaced_.empty() && fs::exists(scene, error) &&
               !fs::equivalent(scene, s.scenePath, error)) {
      replaced_ = scene;
    } else if (purpose_ == Purpose::Save || fs::exists(inFolder, error)) {
      chosen = inFolder.string();
    } else {
      chosen = name_;  // relative to where the program runs, or a built-in model
    }
  }
  return chosen;
}

}  // namespace gelenk
