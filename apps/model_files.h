#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/model.h"

namespace gelenk {

/// What a file holds, told by its extension and, where several formats share one, by its first words.
enum class FileKind {
  ObjMesh,             ///< .obj
  PinocchioSkeleton,   ///< .skel, .skeleton, .skeleton.out
  PinocchioWeights,    ///< .attachment, .attachment.out, .weights
  DhTable,             ///< .dh
};

/// nullopt for an extension that no format here has.
std::optional<FileKind> fileKind(const std::string& path);
/// "Pinocchio skeleton" and the like, for messages and `gelenk info`.
std::string describe(FileKind kind);
/// The extensions that are known, for messages.
std::string knownExtensions();

/// A body with a skeleton, from an OBJ and any file that holds a skeleton. With a weights file (Pinocchio's attachment) the four
/// largest weights are used and what that loses is told in the notes. Throws ParseError and std::invalid_argument.
Model openBody(const std::string& objPath, const std::string& skeletonPath, const std::optional<std::string>& weightsPath);

/// The skeleton or the whole model that one file holds. Throws std::invalid_argument for a file that holds none, and ParseError.
Model openModelFile(const std::string& path);

/// A file's name without folder and extension.
std::string stem(const std::string& path);

}  // namespace gelenk
