#pragma once

#include <optional>
#include <string>
#include <vector>

namespace gelenk {

class Sandbox;

/// What a folder holds for the browser.
struct BrowserEntry {
  std::string name;
  bool isFolder = false;
};
/// Folders first, then the files that the program opens (or those whose name ends with one of the endings,
/// blanks between), each by name without regard to capitals; hidden ones are left out. A folder that cannot
/// be read is empty.
std::vector<BrowserEntry> folderEntries(const std::string& folder, const std::string& endings);
/// Endings of everything that opens: models, motions, scenes.
std::string openableEndings();

/// Folders to begin at: Home, and Here, where the program runs, if that is another.
struct BrowserPlace {
  std::string name, folder;
};
std::vector<BrowserPlace> browserPlaces();

/// Folders, files and what was opened lately, as a dialog in the window.
class FileBrowser {
 public:
  enum class Purpose { Open, Save };
  void begin(Purpose purpose, const std::string& folder, const std::string& name);
  /// Inside a popup. The path or the built-in model's name that was chosen; nullopt: nothing yet.
  std::optional<std::string> draw(Sandbox& sandbox);
  const std::string& folder() const { return folder_; }
  /// Why the folder's list is empty; "": it is not.
  std::string whyEmpty() const;

 private:
  void enter(const std::string& folder);
  void places(Sandbox& sandbox, float height, std::optional<std::string>& chosen);
  void list(Sandbox& sandbox, float height, std::optional<std::string>& chosen);

  Purpose purpose_ = Purpose::Open;
  std::string folder_, selected_;
  std::vector<BrowserEntry> entries_;
  bool readable_ = true;
  int filter_ = 0;
  char name_[1024] = "";
  bool focus_ = true;
  std::string replaced_;  ///< a file in whose place it would be saved; asked once
};

}  // namespace gelenk
