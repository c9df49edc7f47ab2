#include "apps/model_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <stdexcept>

#include "apps/chain_models.h"
#include "kinematics/io/pinocchio_skeleton.h"
#include "kinematics/io/text_file.h"
#include "skinning/io/obj.h"
#include "skinning/io/pinocchio_weights.h"

namespace gelenk {
namespace {

struct Extension {
  std::string_view ending;
  FileKind kind;
};
/// Longer endings first where one ends like another.
constexpr std::array extensions = {
    Extension{".obj", FileKind::ObjMesh},
    Extension{".skeleton.out", FileKind::PinocchioSkeleton},
    Extension{".skeleton", FileKind::PinocchioSkeleton},
    Extension{".skel", FileKind::PinocchioSkeleton},
    Extension{".attachment.out", FileKind::PinocchioWeights},
    Extension{".attachment", FileKind::PinocchioWeights},
    Extension{".weights", FileKind::PinocchioWeights},
    Extension{".dh", FileKind::DhTable},
};

std::string lowerCase(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

}  // namespace

std::optional<FileKind> fileKind(const std::string& path) {
  const std::string name = lowerCase(path);
  for (const Extension& extension : extensions)
    if (name.ends_with(extension.ending)) return extension.kind;
  return std::nullopt;
}

std::string describe(FileKind kind) {
  switch (kind) {
    case FileKind::ObjMesh: return "OBJ mesh";
    case FileKind::PinocchioSkeleton: return "Pinocchio skeleton";
    case FileKind::PinocchioWeights: return "Pinocchio bone weights";
    case FileKind::DhTable: return "Denavit-Hartenberg table";
  }
  return "";
}

std::string knownExtensions() {
  std::string list;
  for (const Extension& extension : extensions) list += (list.empty() ? "" : ", ") + std::string(extension.ending);
  return list;
}

std::string stem(const std::string& path) {
  std::string name = std::filesystem::path(path).filename().string();
  const std::size_t dot = name.find('.', 1);
  return dot == std::string::npos ? name : name.substr(0, dot);
}

Model openBody(const std::string& objPath, const std::string& skeletonPath, const std::optional<std::string>& weightsPath) {
  Mesh mesh = readObj(objPath);
  Model model = openModelFile(skeletonPath);
  model.name = stem(objPath);
  if (!weightsPath)
    throw std::invalid_argument("a body without a weights file: give one with --weights");
  const BoneWeights bones = readPinocchioWeights(*weightsPath, model.skeleton.jointCount() - 1, mesh);
  WeightLoss loss;
  auto influences = fourLargest(jointWeights(bones, model.skeleton), model.skeleton.jointCount(), &loss);
  model.notes.push_back(fmt::format("four largest weights kept, bones that turn about one joint counted together: {:.2f} % of the weight lost on average, {:.1f} % at most ({} of {} vertices had more)",
                                    100.0 * loss.mean, 100.0 * loss.max, loss.verticesOverFour, mesh.positions.size()));
  model.skin = bindSkin(std::move(mesh), restFrames(model.skeleton), std::move(influences));
  return model;
}

Model openModelFile(const std::string& path) {
  const auto kind = fileKind(path);
  if (!kind) throw std::invalid_argument("cannot tell what '" + path + "' holds; known extensions: " + knownExtensions());
  Model model{.name = stem(path), .skeleton = {}};
  switch (*kind) {
    case FileKind::PinocchioSkeleton:
      model.skeleton = namedAsHuman(readPinocchioSkeleton(path));
      return model;
    case FileKind::DhTable: return openDhModel(path);
    case FileKind::ObjMesh:
      throw std::invalid_argument("'" + path + "' is a mesh without a skeleton: give one with --skeleton");
    case FileKind::PinocchioWeights:
      throw std::invalid_argument("'" + path + "' holds weights only: give it with --weights, beside an OBJ and --skeleton");
  }
  return model;
}

}  // namespace gelenk
