#include "apps/commands/motion_table.h"

#include <fmt/format.h>

#include "apps/commands/command_line.h"
#include "apps/commands/model_options.h"
#include "apps/document/file_format.h"
#include "apps/document/model_files.h"
#include "apps/document/notes.h"
#include "kinematics/forward_kinematics.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

void printRow(const std::string& frame, const std::string& name, const Vector3d& start, const Vector3d& end) {
  fmt::print("{},{},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}\n", frame, name, start.x(), start.y(),
             start.z(), end.x(), end.y(), end.z());
}

void printFrame(const std::string& frame, const Imported& imported, const Frames& frames) {
  const auto place = [&](int joint) { return Vector3d(frames[joint].translation()); };
  if (imported.asf) {
    for (const AsfSkeleton::Bone& bone : imported.asf->bones)
      printRow(frame, bone.name, place(bone.joint), place(bone.endJoint));
    return;
  }
  const Skeleton& skeleton = imported.model.skeleton;
  for (int i = 0; i < skeleton.jointCount(); ++i)
    printRow(frame, skeleton.joint(i).name, place(std::max(0, skeleton.parent(i))), place(i));
}

}  // namespace

std::shared_ptr<MotionTableRequest> addMotionTableOptions(Command& command) {
  auto request = std::make_shared<MotionTableRequest>();
  command.option("--amc", request->files.amc,
                 "Motion for an ASF skeleton: prints every bone of every frame as CSV");
  command.option("--asf", request->files.asf, "Skeleton of an AMC");
  command.option("--clip", request->files.clip,
                 "Which motion of a file that names several; default: the first");
  addModelOptions(command, request->files);
  command.option("--frame", request->frame, "Only this frame of the motion, from 1").positive();
  command.option("--unit", request->unit,
                 "Unit of the file: m dm cm mm in ft, or metres; default: what the format says, else m");
  command.flag("--csv", request->csv, "Print CSV: frame, bone or joint, start and end position in metres");
  return request;
}

void printMotionTable(const std::string& nameOrFile, const MotionTableRequest& request) {
  ImportOptions options;
  if (!request.unit.empty()) options.metresPerUnit = metresPerUnit(request.unit);
  const Imported imported = importFiles(nameOrFile, request.files, options);
  sayNotes(nameOrFile, imported.model.notes);
  const Skeleton& skeleton = imported.model.skeleton;
  if (request.frame > 0) motionFrame(imported.model, request.frame);
  fmt::print("frame,{},start_x,start_y,start_z,end_x,end_y,end_z\n", imported.asf ? "bone" : "joint");
  if (!imported.model.clip) return printFrame("rest", imported, restFrames(skeleton));
  Frames frames;
  for (int f = 0; f < imported.model.clip->frameCount(); ++f) {
    if (request.frame > 0 && f + 1 != request.frame) continue;
    forwardKinematics(skeleton, imported.model.clip->q.col(f), frames);
    printFrame(std::to_string(f + 1), imported, frames);
  }
}

}  // namespace gelenk
