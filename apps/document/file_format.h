#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/document/model_files.h"

namespace gelenk {

/// What stands in a file of motions.
struct MotionExport {
  const Skeleton& skeleton;
  const Skin* skin = nullptr;  ///< null: none
  std::vector<GltfClip> clips = {};
  std::optional<double> metresPerUnit = {};  ///< default: the format's own
};

/// One format: how its files are told from others, read and written. A new one is a file in
/// apps/document/formats/ and a row of GELENK_FILE_FORMATS; `info`, `fk`, `solve`, `convert`, `motion`,
/// `render` and the sandbox learn it from there.
struct FileFormat {
  std::string_view description;         ///< "Pinocchio skeleton", for messages and `gelenk info`
  std::string_view endings;             ///< with their dots, lower case, blanks between
  std::string_view sharedEndings = {};  ///< that are its own only where `recognises` says so
  bool (*recognises)(std::string_view head) = nullptr;  ///< by the file's first 255 characters
  bool isMesh = false;                                  ///< nothing but a surface
  bool saysItsUnit = false;
  bool alwaysMetres = false;         ///< by definition: another unit is refused
  bool saysUp = false;               ///< which axis points up, by definition
  bool namesMotions = false;         ///< --clip chooses one
  std::string_view companions = {};  ///< it is read together with: some of companionNames, blanks between
  /// Fills in what the file holds; result.model has its name. Throws ParseError and std::invalid_argument.
  void (*read)(const std::string& path, const Companions&, const ImportOptions&, Imported& result) = nullptr;
  /// Null: written by writeMotion, or not at all. Tells in imported's notes what the format cannot hold.
  void (*write)(const std::string& path, Imported& imported, const ExportOptions&) = nullptr;
  void (*writeMotion)(const std::string& path, const MotionExport&) = nullptr;  ///< null: holds no motion
};

#define GELENK_DECLARE(Kind, format) extern const FileFormat format;
GELENK_FILE_FORMATS(GELENK_DECLARE)
#undef GELENK_DECLARE

const FileFormat& fileFormat(FileKind kind);
/// Of the formats that hold a motion: ".bvh, .glb, ...".
std::string motionEndings();

// What the formats share.

/// q of a frame of the model's motion, from 1. Throws std::invalid_argument where there is no motion or no
/// such frame.
Eigen::VectorXd motionFrame(const Model& model, int frame);
/// The pose that formats without motion get: frame 1, 2, ...; 0: a motion's only frame, else the rest pose.
/// Throws std::invalid_argument for a frame that is not there.
Eigen::VectorXd poseOf(const Imported& imported, int frame);
/// The places of the rest pose as a tree of fixed joints whose bones all have a length: what hangs on a joint
/// in its parent's place hangs on that parent. A note of the model tells what was left out.
Skeleton places(Model& model);
/// Angles and weights are of bones; two joints in one place have none between them. Throws
/// std::invalid_argument that names them.
void demandLengths(const Skeleton& skeleton);

}  // namespace gelenk
