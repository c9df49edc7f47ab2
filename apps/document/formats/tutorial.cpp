#include <fmt/format.h>

#include <filesystem>

#include "apps/document/file_format.h"
#include "kinematics/io/text_file.h"
#include "kinematics/io/tutorial_skeleton.h"

namespace gelenk {
namespace {

bool beginsWithNumJoints(std::string_view head) {
  const std::size_t at = head.find_first_not_of(" \t\r\n");
  return at != std::string_view::npos && head.substr(at).starts_with("NumJoints");
}
bool holdsAngles(std::string_view head) { return head.find("JointAngles") != std::string_view::npos; }
bool isFigure(std::string_view head) { return beginsWithNumJoints(head) && !holdsAngles(head); }
bool isPose(std::string_view head) { return beginsWithNumJoints(head) && holdsAngles(head); }

/// The only .figure in the pose's folder.
std::string figureBeside(const std::string& posePath) {
  const auto folder = std::filesystem::path(posePath).parent_path();
  std::string found;
  int count = 0;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder.empty() ? "." : folder, error))
    if (fileKind(entry.path().string()) == FileKind::TutorialSkeleton) found = entry.path().string(), ++count;
  if (count != 1)
    throw std::invalid_argument(fmt::format(
        "'{}' needs the figure it belongs to: give it with --figure ({} lie beside it)", posePath, count));
  return found;
}

void readFigure(const std::string& path, const Companions&, const ImportOptions& options, Imported& result) {
  TutorialSkeleton tutorial = readTutorialSkeleton(path);
  for (auto& position : tutorial.positions) position *= options.metresPerUnit.value_or(1.0);
  result.figure = toSkeleton(tutorial);
  result.tutorial = std::move(tutorial);
  result.model.skeleton = result.figure->skeleton;
}

void readPose(const std::string& path, const Companions& files, const ImportOptions& options,
              Imported& result) {
  const std::string figurePath = files.figure.empty() ? figureBeside(path) : files.figure;
  if (files.figure.empty()) tellFact(result.model.notes, "figure", "figure: " + figurePath);
  readFigure(figurePath, files, options, result);
  result.model.clip =
      MotionClip{.framesPerSecond = 1.0, .q = configuration(*result.figure, readTutorialPose(path))};
}

void writeFigure(const std::string& path, Imported& imported, const ExportOptions& options) {
  TutorialSkeleton tutorial =
      imported.tutorial ? *imported.tutorial : toTutorialSkeleton(places(imported.model));
  for (auto& position : tutorial.positions) position /= options.metresPerUnit.value_or(1.0);
  writeFile(path, formatTutorialSkeleton(tutorial));
}

void writePose(const std::string& path, Imported& imported, const ExportOptions& options) {
  const Skeleton& skeleton = imported.model.skeleton;
  demandLengths(skeleton);
  const Eigen::VectorXd pose = poseOf(imported, options.frame);
  if (imported.figure) return writeFile(path, formatTutorialPose(tutorialPose(*imported.figure, pose)));
  // Angles of the figure that toTutorialSkeleton makes of this skeleton: its frames are parallel to the
  // world's in the bind pose.
  const TutorialFigure figure = toSkeleton(toTutorialSkeleton(skeleton));
  const Frames rest = restFrames(skeleton), posed = forwardKinematics(skeleton, pose);
  Eigen::VectorXd q = figure.skeleton.rest();
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const auto turn = [&](int j) {
      return Eigen::Quaterniond(posed[j].linear() * rest[j].linear().transpose());
    };
    const int parent = skeleton.parent(i);
    setJointRotation(figure.skeleton, q, figure.jointOfIndex[i],
                     parent < 0 ? turn(i) : turn(parent).conjugate() * turn(i));
  }
  writeFile(path, formatTutorialPose(tutorialPose(figure, q)));
}

}  // namespace

constinit const FileFormat tutorialSkeletonFormat{.description = "tutorial skeleton",
                                                  .endings = ".figure",
                                                  .sharedEndings = ".skel .txt",
                                                  .recognises = isFigure,
                                                  .read = readFigure,
                                                  .write = writeFigure};
constinit const FileFormat tutorialPoseFormat{.description = "tutorial pose",
                                              .endings = ".pose",
                                              .sharedEndings = ".skel .txt",
                                              .recognises = isPose,
                                              .companions = "figure",
                                              .read = readPose,
                                              .write = writePose};

}  // namespace gelenk
