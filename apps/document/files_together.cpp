#include "apps/document/files_together.h"

#include <filesystem>
#include <map>
#include <stdexcept>

#include "apps/document/model_files.h"
#include "apps/document/scene_file.h"
#include "apps/document/surface.h"

namespace gelenk {
namespace {

using Paths = std::vector<std::string>;

std::string names(const Paths& paths) {
  std::string list;
  for (const std::string& path : paths)
    list += (list.empty() ? "" : ", ") + std::filesystem::path(path).filename().string();
  return list;
}

/// What file managers leave beside files: .DS_Store, and "._arm.urdf" that macOS puts into archives.
bool isHidden(const std::string& path) {
  return std::filesystem::path(path).filename().string().starts_with('.');
}

/// The only one of its kind; empty where there is none.
std::string theOnly(const Paths& paths, const char* what) {
  if (paths.size() > 1)
    throw std::invalid_argument(std::string("several ") + what + " came at once: " + names(paths) +
                                "; choose one of them");
  return paths.empty() ? std::string() : paths.front();
}

}  // namespace

ModelReference filesTogether(const Paths& all) {
  Paths paths = all;
  if (all.size() > 1) std::erase_if(paths, isHidden);
  if (paths.size() == 1) return {.nameOrFile = paths.front()};
  Paths scenes, surfaces, skeletons;
  std::map<FileKind, Paths> of;
  for (const std::string& path : paths) {
    const auto kind = fileKind(path);
    if (isScene(path)) scenes.push_back(path);
    if (!kind && isSurfaceFile(path)) surfaces.push_back(path);  // STL
    if (!kind) continue;
    of[*kind].push_back(path);
    if (isMesh(kind)) surfaces.push_back(path);
    if (*kind == FileKind::PinocchioSkeleton || *kind == FileKind::TutorialSkeleton)
      skeletons.push_back(path);
  }
  if (!scenes.empty()) return {.nameOrFile = theOnly(scenes, "scenes")};
  for (const FileKind whole : {FileKind::Urdf, FileKind::Gltf, FileKind::DhTable})
    if (!of[whole].empty()) return {.nameOrFile = theOnly(of[whole], "models")};
  const std::string asf = theOnly(of[FileKind::Asf], "ASF skeletons"),
                    amc = theOnly(of[FileKind::Amc], "motions");
  if (!surfaces.empty()) {
    ModelReference body{.nameOrFile = theOnly(surfaces, "surfaces"),
                        .files = {.skeleton = theOnly(skeletons, "skeletons"),
                                  .weights = theOnly(of[FileKind::PinocchioWeights], "files of weights"),
                                  .asf = asf,
                                  .amc = amc}};
    if (body.files.skeleton.empty() && !of[FileKind::Bvh].empty())
      body.files.skeleton = theOnly(of[FileKind::Bvh], "skeletons");
    return body;
  }
  if (!amc.empty()) return {.nameOrFile = amc, .files = {.asf = asf}};
  if (!of[FileKind::TutorialPose].empty())
    return {.nameOrFile = theOnly(of[FileKind::TutorialPose], "poses"),
            .files = {.figure = theOnly(skeletons, "skeletons")}};
  Paths others;
  for (const auto& [kind, files] : of) others.insert(others.end(), files.begin(), files.end());
  if (others.empty())
    throw std::invalid_argument("nothing of " + names(all) + " opens; there are: .json, " +
                                knownExtensions());
  return {.nameOrFile = theOnly(others, "files that open")};
}

}  // namespace gelenk
