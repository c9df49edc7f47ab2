#include "skinning/io/gltf.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/document/file_format.h"

namespace gelenk {
namespace {

/// The motion of that name, or the first one, which is told where there are others.
void chooseClip(const std::string& path, const std::string& name, Imported& imported) {
  Model& model = imported.model;
  for (const GltfClip& clip : imported.clips) model.clipNames.push_back(clip.name);
  const auto chosen =
      name.empty() ? imported.clips.begin()
                   : std::ranges::find_if(imported.clips, [&](const GltfClip& c) { return c.name == name; });
  if (!name.empty() && chosen == imported.clips.end())
    throw std::invalid_argument(imported.clips.empty()
                                    ? "'" + path + "' has no motion: --clip cannot choose one"
                                    : "'" + path + "' has no motion '" + name +
                                          "'; there are: " + listed(model.clipNames, 1000));
  if (chosen == imported.clips.end()) return;
  model.clip = chosen->clip;
  model.clipName = chosen->name;
  if (name.empty() && imported.clips.size() > 1)
    tell(model.notes, "several-motions",
         fmt::format("{} motions: {}; '{}' is taken", model.clipNames.size(), listed(model.clipNames, 12),
                     model.clipName),
         1, "--clip chooses another");
}

void read(const std::string& path, const Companions& files, const ImportOptions& options, Imported& result) {
  GltfModel gltf = readGltf(path, {.framesPerSecond = options.sampleAt});
  result.model.skeleton = std::move(gltf.skeleton);
  result.model.skin = std::move(gltf.skin);
  result.model.look = std::move(gltf.look);
  result.model.notes = std::move(gltf.notes);
  result.clips = std::move(gltf.clips);
  chooseClip(path, files.clip, result);
}

void write(const std::string& path, const MotionExport& motion) {
  writeGltf(path, motion.skeleton, motion.skin, motion.clips);
}

}  // namespace

constinit const FileFormat gltfFormat{.description = "glTF 2.0",
                                      .endings = ".gltf .glb",
                                      .alwaysMetres = true,
                                      .saysUp = true,
                                      .namesMotions = true,
                                      .read = read,
                                      .writeMotion = write};

}  // namespace gelenk
