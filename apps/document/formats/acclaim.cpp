#include <filesystem>

#include "apps/document/file_format.h"
#include "kinematics/io/asf_amc.h"
#include "kinematics/io/text_file.h"
#include "kinematics/io/word_stream.h"

namespace gelenk {
namespace {

const double ownUnit = asfMetresPerUnit(0.45);  // CMU's

void readSkeletonAndMotion(const std::string& asf, const std::string& amc, const ImportOptions& options,
                           Imported& result) {
  result.asf = readAsf(asf, options.metresPerUnit);
  result.model.skeleton = result.asf->skeleton;
  result.model.notes = result.asf->notes;
  if (!amc.empty())
    result.model.clip =
        readAmc(amc, *result.asf, options.framesPerSecond.value_or(120.0), &result.model.notes);
}

void readAsfFile(const std::string& path, const Companions& files, const ImportOptions& options,
                 Imported& result) {
  readSkeletonAndMotion(path, files.amc, options, result);
}

/// The ASF in a motion's folder that goes with it: 02_01.asf or 02.asf beside 02_01.amc, else the only one.
std::string asfBeside(const std::string& amcPath) {
  namespace fs = std::filesystem;
  const fs::path path(amcPath), folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const std::string name = lowerCase(path.stem().string());
  std::vector<std::string> all;
  std::string found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (lowerCase(entry.path().extension().string()) != ".asf") continue;
    all.push_back(entry.path().string());
    const std::string other = lowerCase(entry.path().stem().string());
    if (other == name || (found.empty() && other == name.substr(0, name.find('_')))) found = all.back();
  }
  if (!found.empty()) return found;
  if (all.size() == 1) return all.front();
  throw std::invalid_argument("'" + amcPath + "' needs the skeleton it belongs to, an .asf file: " +
                              (all.empty()
                                   ? "none lies beside it"
                                   : std::to_string(all.size()) + " lie beside it, none of its name") +
                              "; open the .asf first, or name it with --asf");
}

void readAmcFile(const std::string& path, const Companions& files, const ImportOptions& options,
                 Imported& result) {
  const std::string asf = files.asf.empty() ? asfBeside(path) : files.asf;
  if (files.asf.empty()) tellFact(result.model.notes, "skeleton", "skeleton: " + asf);
  readSkeletonAndMotion(asf, path, options, result);
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
                                     .companions = "amc",
                                     .read = readAsfFile,
                                     .write = writeAsf};
constinit const FileFormat amcFormat{.description = "Acclaim motion (AMC)",
                                     .endings = ".amc",
                                     .companions = "asf",
                                     .read = readAmcFile,
                                     .writeMotion = writeAmc};

}  // namespace gelenk
