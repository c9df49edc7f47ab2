#include "apps/document/model.h"

#include <fmt/format.h>

#include <cctype>
#include <filesystem>
#include <functional>
#include <stdexcept>

#include "apps/document/chain_models.h"
#include "apps/document/described_model.h"
#include "apps/document/model_files.h"
#include "apps/lecture/lecture_model.h"
#include "kinematics/notation/mannequin.h"
#include "kinematics/notation/robots.h"
#include "skinning/blend/weight_smoothing.h"
#include "skinning/bodies/body_around.h"
#include "skinning/bodies/mannequin_body.h"
#include "skinning/io/skin_cache.h"

namespace gelenk {
namespace {

struct BuiltIn {
  std::string name;
  std::function<Model()> make;
};

Model figureModel() {
  Model model{.name = "figure", .skeleton = mannequin()};
  model.skinning = {.method = SkinMethodKind::Cor, .twist = true, .smoothing = defaultSmoothing};
  model.skin = cachedSkin(cacheFolder(), "figure", mannequinSkinKey(model.skeleton),
                          [&] { return makeMannequinSkin(model.skeleton); });
  model.masses = std::make_shared<const Masses>(mannequinMasses(model.skeleton));
  model.soles = mannequinSoles(model.skeleton);
  model.handles = mannequinHandles();
  model.pins = {"foot_l", "foot_r"};
  return model;
}

const std::vector<BuiltIn>& builtIns() {
  static const std::vector<BuiltIn> table = [] {
    std::vector<BuiltIn> entries{{"figure", figureModel}};
    entries.push_back({"planar", [] { return planarModel(lecturePlanarChain()); }});
    for (const Robot& robot : robots())
      entries.push_back({std::string(robot.name), [table = robot.table] { return dhModel(table()); }});
    return entries;
  }();
  return table;
}

}  // namespace

Model withBody(Model model) {
  if (model.skin) return model;
  std::string name = "body-" + model.name;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '-';
  try {
    model.skin = cachedSkin(cacheFolder(), name, bodySkinKey(model.skeleton),
                            [&] { return bodySkin(model.skeleton); });
  } catch (const std::exception& error) {
    tell(model.notes, "no-body", fmt::format("no body around the bones: {}", error.what()));
  }
  return model;
}

std::vector<std::string> builtInModels() {
  std::vector<std::string> names;
  for (const BuiltIn& entry : builtIns()) names.push_back(entry.name);
  return names;
}

Frames bindFrames(const Model& model) {
  const Frames rest = restFrames(model.skeleton);
  if (restsAsBound(model)) return rest;
  Frames bound(rest.size());
  for (std::size_t i = 0; i < bound.size(); ++i)
    bound[i] = model.skin->jointFromRestWorld[i].inverse(Eigen::Isometry);
  return bound;
}

bool restsAsBound(const Model& model) {
  if (!model.skin) return true;
  const Frames rest = restFrames(model.skeleton);
  for (std::size_t i = 0; i < rest.size(); ++i)
    if (!((model.skin->jointFromRestWorld[i] * rest[i]).matrix().isIdentity(1e-6))) return false;
  return true;
}

bool standsInNoFile(const std::string& nameOrFile) {
  for (const BuiltIn& entry : builtIns())
    if (entry.name == nameOrFile) return true;
  for (const char* description : {"planar:", "balls:", "dh:", "joints:", "lecture:"})
    if (nameOrFile.starts_with(description)) return true;
  return false;
}

Model openModel(const std::string& nameOrFile) {
  for (const BuiltIn& entry : builtIns())
    if (entry.name == nameOrFile) return entry.make();
  if (const auto chain = parsePlanarChain(nameOrFile)) return planarModel(*chain);
  if (auto balls = parseBallChain(nameOrFile)) return *std::move(balls);
  if (const auto table = dhTableNamed(nameOrFile)) return dhModel(*table);
  if (auto joints = parseJointsDescription(nameOrFile)) return *std::move(joints);
  if (constexpr std::string_view lecture = "lecture:"; nameOrFile.starts_with(lecture))
    return lectureModel(std::string_view(nameOrFile).substr(lecture.size()));
  if (fileKind(nameOrFile) || std::filesystem::exists(nameOrFile)) return openModelFile(nameOrFile);
  std::string known;
  for (const std::string& name : builtInModels()) known += (known.empty() ? "" : ", ") + name;
  throw std::invalid_argument(
      fmt::format("no model is called '{}'; there are: {}, planar:X,Y:L1,L2,..., balls:L1,L2,..., "
                  "lecture:EXAMPLE, files ending in {} and scenes (.json)",
                  nameOrFile, known, knownExtensions()));
}

}  // namespace gelenk
