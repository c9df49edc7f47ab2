#include "apps/document/file_format.h"
#include "kinematics/io/pinocchio_skeleton.h"
#include "kinematics/io/text_file.h"
#include "kinematics/skeleton_transform.h"
#include "skinning/io/pinocchio_weights.h"

namespace gelenk {
namespace {

void readSkeleton(const std::string& path, const Companions&, const ImportOptions& options,
                  Imported& result) {
  result.model.skeleton =
      scaled(namedAsHuman(readPinocchioSkeleton(path)), options.metresPerUnit.value_or(1.0));
}

void writeSkeleton(const std::string& path, Imported& imported, const ExportOptions& options) {
  writeFile(path,
            formatPinocchioSkeleton(scaled(places(imported.model), 1.0 / options.metresPerUnit.value_or(1.0)),
                                    PinocchioIds::Names));
}

[[noreturn]] void refuseWeights(const std::string& path, const Companions&, const ImportOptions&, Imported&) {
  throw std::invalid_argument("'" + path +
                              "' holds weights only: give it with --weights, beside an OBJ and --skeleton");
}

void writeWeights(const std::string& path, Imported& imported, const ExportOptions&) {
  const Model& model = imported.model;
  if (!model.skin)
    throw std::invalid_argument("'" + model.name + "' has no body whose weights could be written");
  demandLengths(model.skeleton);
  writeFile(path, formatPinocchioWeights(boneWeights(model.skin->influences, model.skeleton)));
}

}  // namespace

constinit const FileFormat pinocchioSkeletonFormat{.description = "Pinocchio skeleton",
                                                   .endings = ".skel .skeleton .skeleton.out",
                                                   .read = readSkeleton,
                                                   .write = writeSkeleton};
constinit const FileFormat pinocchioWeightsFormat{.description = "Pinocchio bone weights",
                                                  .endings = ".attachment .attachment.out .weights",
                                                  .read = refuseWeights,
                                                  .write = writeWeights};

}  // namespace gelenk
