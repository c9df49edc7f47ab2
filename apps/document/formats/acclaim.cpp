#include "apps/document/file_format.h"
#include "kinematics/io/asf_amc.h"
#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

const double ownUnit = asfMetresPerUnit(0.45);  // CMU's

void readSkeletonAndMotion(const std::string& asf, const std::string& amc, const ImportOptions& options,
                           Imported& result) {
  result.asf = readAsf(asf, options.metresPerUnit);
  result.model.skeleton = result.asf->skeleton;
  result.model.notes = result.asf->notes;
  if (!amc.empty()) result.model.clip = readAmc(amc, *result.asf, options.framesPerSecond.value_or(120.0));
}

void readAsfFile(const std::string& path, const Companions& files, const ImportOptions& options,
                 Imported& result) {
  readSkeletonAndMotion(path, files.amc, options, result);
}

void readAmcFile(const std::string& path, const Companions& files, const ImportOptions& options,
                 Imported& result) {
  if (files.asf.empty())
    throw std::invalid_argument("'" + path + "' needs the skeleton it belongs to: give it with --asf");
  readSkeletonAndMotion(files.asf, path, options, result);
}

void writeAsf(const std::string& path, Imported& imported, const ExportOptions& options) {
  writeFile(path, formatAsf(imported.model.skeleton, options.metresPerUnit.value_or(ownUnit)));
}

void writeAmc(const std::string& path, const MotionExport& motion) {
  writeFile(path,
            formatAmc(motion.skeleton, motion.clips.at(0).clip, motion.metresPerUnit.value_or(ownUnit)));
}

}  // namespace

constinit const FileFormat asfFormat{.description = "Acclaim skeleton (ASF)",
                                     .endings = ".asf",
                                     .saysItsUnit = true,
                                     .read = readAsfFile,
                                     .write = writeAsf};
constinit const FileFormat amcFormat{
    .description = "Acclaim motion (AMC)", .endings = ".amc", .read = readAmcFile, .writeMotion = writeAmc};

}  // namespace gelenk
