#include <fmt/format.h>

#include <cmath>

#include "apps/commands/baked_skin.h"
#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/document/notes.h"
#include "apps/document/second_clip.h"
#include "kinematics/io/asf_amc.h"
#include "kinematics/io/bvh.h"
#include "kinematics/io/text_file.h"
#include "kinematics/motion/motion_edit.h"
#include "skinning/io/gltf.h"

namespace gelenk {
namespace {

struct Request {
  std::string in, out;
  Companions companions;
  std::string onto, then, layer, unit, up = "auto";
  std::vector<std::string> keep;
  double scale = 0.0;
  std::vector<std::string> bones, limbs;
  double weight = 1.0;
  bool additive = false;
  double lowPass = 0.0, rate = 0.0, fade = 0.3;
  bool footPlant = false;
  std::vector<std::string> feet;
  FootPlantOptions plant;
  bool bake = false;
  std::string skin;
};

std::vector<Foot> feetOf(const Skeleton& skeleton, const Request& request) {
  std::vector<Foot> feet;
  for (const std::string& name : request.feet) feet.push_back(footAt(skeleton, skeleton.jointIndex(name)));
  if (feet.empty()) feet = cmuFeet(skeleton);
  if (feet.empty())
    throw std::invalid_argument(
        "no joint is called ltoes or rtoes: name the joints at the balls of the feet with --feet");
  return feet;
}

void printFacts(const char* when, const FootFacts& facts, double rate) {
  fmt::print(
      "{:<7} planted feet: {:.4f} mm a frame on average ({:.4f} m/s), {:.4f} mm at most; deepest penetration "
      "{:.4f} mm\n",
      when, 1e3 * facts.meanSlide, facts.meanSlide * rate, 1e3 * facts.largestSlide,
      1e3 * facts.deepestPenetration);
}

/// Largest way that a joint outside the planted legs, and any joint, moved.
void printChange(const Skeleton& skeleton, const MotionClip& before, const MotionClip& after,
                 const std::vector<Foot>& feet) {
  double rest = 0.0, any = 0.0;
  std::string where;
  for (int f = 0; f < before.frameCount(); ++f) {
    const Frames a = forwardKinematics(skeleton, before.q.col(f)),
                 b = forwardKinematics(skeleton, after.q.col(f));
    for (int i = 0; i < skeleton.jointCount(); ++i) {
      const double way = (a[i].translation() - b[i].translation()).norm();
      const bool inLeg = std::any_of(feet.begin(), feet.end(), [&](const Foot& foot) {
        return !foot.leg.empty() && skeleton.isAncestor(foot.leg.front(), i);
      });
      if (!inLeg) rest = std::max(rest, way);
      if (way > any) any = way, where = fmt::format("{} in frame {}", skeleton.joint(i).name, f + 1);
    }
  }
  fmt::print("change  joints outside the legs: {:.4f} mm at most; legs and feet: {:.2f} mm at most ({})\n",
             1e3 * rest, 1e3 * any, where);
}

void write(const Request& request, Imported& imported, const MotionClip& clip) {
  Model& model = imported.model;
  if (request.bake) {
    model.clip = clip;
    if (!request.skin.empty()) model.skinning = parseSkinChoice(request.skin);
    return writeBakedSkin(request.out, model);
  }
  exportMotion(request.out, model.skeleton, model.skin ? &*model.skin : nullptr,
               model.clipName.empty() ? model.name : model.clipName, clip);
}

/// The motion of another file for the model at hand; what was done to it is told.
MotionClip second(const Request& request, const Imported& imported, const MotionClip& clip,
                  const std::string& path) {
  const FittedClip fitted =
      clipFor(imported.model, clip.framesPerSecond, path, request.in, request.companions);
  sayNotes(path, fitted.notes);
  return fitted.clip;
}

std::vector<int> layerJoints(const Skeleton& skeleton, const Request& request) {
  std::vector<int> joints;
  for (const std::string& name : request.bones) joints.push_back(skeleton.jointIndex(name));
  for (const std::string& name : request.limbs)
    for (const int joint : limbBelow(skeleton, skeleton.jointIndex(name))) joints.push_back(joint);
  return joints;
}

/// The model that the motion shall move in place of its own.
Imported carriedOnto(const Request& request, const Imported& from) {
  Imported target = importFiles(request.onto);
  sayNotes(request.onto, target.model.notes);
  RetargetOptions options{.targetUp = target.model.up};
  if (request.scale > 0.0) options.scale = request.scale;
  if (request.up != "auto")
    options.sourceUp = request.up == "z" ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
  for (const std::string& part : request.keep) (part == "feet" ? options.keepFeet : options.keepHands) = true;
  const RetargetedClip carried =
      retargeted(from.model.skeleton, *from.model.clip, target.model.skeleton, options);
  if (request.scale == 0.0 && (carried.scale < smallestUsualScale || carried.scale > largestUsualScale))
    throw std::invalid_argument(
        fmt::format("the path would be scaled by {:.4g}, which lies outside {:.1g} to {:.1g}: if '{}' is in "
                    "another unit, say "
                    "so with --unit; else give the factor with --scale",
                    carried.scale, smallestUsualScale, largestUsualScale, request.in));
  std::vector<Note> notes = describe(target.model.skeleton, carried, carried.clip.framesPerSecond);
  if (request.scale > 0.0) std::erase_if(notes, [](const Note& note) { return note.kind == "path-scale"; });
  sayNotes(request.in, notes);
  target.model.clip = carried.clip;
  target.clips.clear();
  return target;
}

void run(const Request& request) {
  if (request.out.empty() && !request.footPlant)
    throw std::invalid_argument("nothing would come of it: give -o FILE, or --foot-plant to see its numbers");
  ImportOptions options;
  if (request.rate > 0.0) options.sampleAt = request.rate;
  if (!request.unit.empty()) options.metresPerUnit = metresPerUnit(request.unit);
  Imported imported = importFiles(request.in, request.companions, options);
  sayNotes(request.in, imported.model.notes);
  if (!imported.model.clip) throw std::invalid_argument("'" + request.in + "' has no motion");
  if (!request.onto.empty()) imported = carriedOnto(request, imported);
  const Skeleton& skeleton = imported.model.skeleton;
  MotionClip clip = *imported.model.clip;
  if (!request.then.empty())
    clip = crossFaded(skeleton, clip, second(request, imported, clip, request.then), request.fade);
  if (!request.layer.empty())
    clip = layered(skeleton, clip,
                   {.clip = second(request, imported, clip, request.layer),
                    .kind = request.additive ? Layer::Kind::Additive : Layer::Kind::Override,
                    .weight = request.weight,
                    .joints = layerJoints(skeleton, request)});
  if (request.lowPass > 0.0) clip = lowPassed(skeleton, clip, request.lowPass);
  if (request.footPlant) {
    const std::vector<Foot> feet = feetOf(skeleton, request);
    const std::vector<Contact> contacts = footContacts(skeleton, clip, feet, request.plant);
    const MotionClip planted = footPlanted(skeleton, clip, feet, contacts, request.plant);
    fmt::print("{} contacts of {} feet in {} frames at {:.6g} Hz; floor at {:.4g} m\n", contacts.size(),
               feet.size(), clip.frameCount(), clip.framesPerSecond, request.plant.floor);
    printFacts("before", footFacts(skeleton, clip, feet, contacts, request.plant.floor),
               clip.framesPerSecond);
    printFacts("after", footFacts(skeleton, planted, feet, contacts, request.plant.floor),
               clip.framesPerSecond);
    printChange(skeleton, clip, planted, feet);
    clip = planted;
  }
  if (request.rate > 0.0 && std::abs(clip.framesPerSecond - request.rate) > 1e-9 * request.rate)
    clip = resampled(skeleton, clip, request.rate);
  if (!request.out.empty()) {
    write(request, imported, clip);
    if (!request.bake)
      fmt::print("{}: {} frames at {:.6g} Hz\n", request.out, clip.frameCount(), clip.framesPerSecond);
  }
}

}  // namespace

void addMotionCommand(Command& app) {
  auto request = std::make_shared<Request>();
  Command command = app.command(
      "motion", "Edit a motion: cross-fade, layer, smooth, plant the feet, resample, carry to another model");
  command.option("in", request->in, "A file with a motion, or an ASF with --amc").required();
  command.option("-o,--out", request->out, "The file to write: .amc, .bvh, .gltf or .glb");
  command.option("--amc", request->companions.amc, "Motion for the ASF skeleton");
  command.option("--asf", request->companions.asf, "ASF skeleton of an AMC");
  command.option("--clip", request->companions.clip,
                 "Which motion of a file that names several; default: the first");
  command.option("--then", request->then, "A second motion to fade into");
  command.option("--fade", request->fade, "Seconds of the cross-fade").positive().showDefault();
  const Option layer = command.option(
      "--layer", request->layer, "A second motion to lay over the first; it repeats where it is shorter");
  command.option("--weight", request->weight, "Share of the layer, 0 to 1 (more for an additive one)")
      .nonNegative()
      .showDefault()
      .needs(layer);
  command.option("--bones", request->bones, "Joints that take part in the layer; default: all").needs(layer);
  command.option("--limbs", request->limbs, "Joints that take part with all below them").needs(layer);
  command
      .flag("--additive", request->additive,
            "The layer's departure from the rest pose goes on top of the first motion")
      .needs(layer);
  command.option("--unit", request->unit,
                 "Unit of IN: m dm cm mm in ft, or metres; default: what the format says, else m");
  Option onto = command.option("--onto", request->onto,
                               "Carry the motion to this model, by joints of equal names: a "
                               "built-in name, or a file that holds a skeleton");
  command
      .option("--scale", request->scale, "Of the path when it is carried over; default: from the legs' bones")
      .positive()
      .needs(onto);
  command.option("--up-in", request->up, "The axis that points up in IN; auto: along which the body stands")
      .oneOf({"auto", "y", "z"})
      .showDefault()
      .needs(onto);
  command.option("--keep", request->keep, "Keep feet or hands where the motion has them, scaled")
      .oneOf({"feet", "hands"})
      .commas()
      .needs(onto);
  command.option("--low-pass", request->lowPass, "Zero-phase low-pass, cut-off in Hz").positive();
  command.flag("--foot-plant", request->footPlant,
               "Hold planted feet still and above the floor; prints before and after");
  command.option("--feet", request->feet, "Joints at the balls of the feet; default: ltoes, rtoes");
  command.option("--floor", request->plant.floor, "Height of the floor (y), metres").showDefault();
  command
      .option("--planted-below", request->plant.plantedBelow,
              "A ball of the foot slower than this stands, m/s")
      .positive()
      .showDefault();
  command.option("--fps", request->rate, "Resample to this frame rate").frameRate();
  const Option bake = command.flag(
      "--bake-skin", request->bake,
      "Write the body's vertices of every frame to a .glb, for viewers that only know linear blending");
  command.option("--skin", request->skin, "Skinning method of the vertices; default: the model's")
      .needs(bake);
  command.run([request] { run(*request); });
}

}  // namespace gelenk
