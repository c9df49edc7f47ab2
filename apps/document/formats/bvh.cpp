#include "kinematics/io/bvh.h"

#include "apps/document/file_format.h"
#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

void read(const std::string& path, const Companions&, const ImportOptions& options, Imported& result) {
  BvhMotion bvh = readBvh(
      path, {.metresPerUnit = options.metresPerUnit.value_or(1.0), .positions = options.bvhPositions});
  result.model.skeleton = std::move(bvh.skeleton);
  result.model.clip = std::move(bvh.clip);
  result.model.notes = std::move(bvh.notes);
}

void write(const std::string& path, const MotionExport& motion) {
  writeFile(path, formatBvh(motion.skeleton, motion.clips.at(0).clip, motion.metresPerUnit.value_or(1.0)));
}

}  // namespace

constinit const FileFormat bvhFormat{
    .description = "Biovision motion (BVH)", .endings = ".bvh", .read = read, .writeMotion = write};

}  // namespace gelenk
