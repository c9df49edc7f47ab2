#include <cmath>
#include <stdexcept>

#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/io/asf_amc.h"
#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

constexpr double degreesPerRadian = 180.0 / M_PI;

/// A bone of the file: a joint's own, or a connection without dofs.
struct PlannedBone {
  std::string name;
  int joint = -1;                      ///< whose dofs it has; -1: none
  int parent = -1;                     ///< position in the plan; -1 for the root itself
  Vector3d offset = Vector3d::Zero();  ///< from its start to its end in the zero pose, world, metres
};

bool isEnd(const Skeleton& skeleton, int i) {
  return i > 0 && skeleton.qCount(i) == 0 && skeleton.children(i).empty();
}

/// Names in an ASF are words, and '#' begins a comment.
std::string word(std::string name) {
  for (char& c : name)
    if (c == ' ' || c == '\t' || c == '#' || c == '(' || c == ')' || c == ',') c = '_';
  return name;
}

/// All children start at one place: the end of the joint's bone. Else the bone has no length and connections
/// lead to the children.
std::optional<Vector3d> commonEnd(const Skeleton& skeleton, const Frames& zero, int joint) {
  std::optional<Vector3d> end;
  for (const int child : skeleton.children(joint)) {
    const Vector3d at = zero[child].translation();
    if (end && (*end - at).norm() > 1e-12) return std::nullopt;
    if (!end) end = at;
  }
  return end;
}

std::vector<PlannedBone> planBones(const Skeleton& skeleton, const Frames& zero) {
  std::vector<PlannedBone> plan{{.name = "root", .joint = 0}};
  std::vector<int> boneOfJoint(skeleton.jointCount(), 0);
  std::vector<Vector3d> endOfBone{zero[0].translation()};
  const auto add = [&](PlannedBone bone) {
    endOfBone.push_back(endOfBone[bone.parent] + bone.offset);
    plan.push_back(std::move(bone));
    return static_cast<int>(plan.size()) - 1;
  };
  for (int i = 1; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    for (const AxisDof& dof : joint.axes)
      if (dof.kind == AxisDof::Kind::Translation)
        throw std::invalid_argument("joint '" + joint.name +
                                    "' moves along an axis; ASF keeps bones of constant length");
    int parent = boneOfJoint[joint.parent];
    const Vector3d gap = zero[i].translation() - endOfBone[parent];
    const bool connected = gap.norm() <= 1e-12;
    if (isEnd(skeleton, i)) {
      boneOfJoint[i] =
          connected ? parent : add({.name = word(joint.name), .joint = -1, .parent = parent, .offset = gap});
      continue;
    }
    if (!connected)
      parent = add({.name = word(joint.name) + "_base", .joint = -1, .parent = parent, .offset = gap});
    const auto end = commonEnd(skeleton, zero, i);
    boneOfJoint[i] = add({.name = word(joint.name),
                          .joint = i,
                          .parent = parent,
                          .offset = end ? Vector3d(*end - zero[i].translation()) : Vector3d::Zero()});
  }
  return plan;
}

/// The joint's axes are coordinate axes in the order z, y, x with any of them missing: they can stay as they
/// are. kept[a]: position of axis a in joint.axes, -1 where missing.
bool keepsAxes(const Joint& joint, int (&kept)[3]) {
  kept[0] = kept[1] = kept[2] = -1;
  if (joint.ball) return false;
  int last = 3;
  for (int k = 0; k < static_cast<int>(joint.axes.size()); ++k) {
    const AxisDof& dof = joint.axes[k];
    if (dof.kind == AxisDof::Kind::Translation) continue;
    int axis = -1;
    for (int a = 0; a < 3; ++a)
      if (dof.axis == Vector3d::Unit(a)) axis = a;
    if (axis < 0 || axis >= last) return false;
    kept[axis] = k;
    last = axis;
  }
  return true;
}

std::string limitWord(double value) {
  return std::isinf(value) ? (value < 0 ? "-inf" : "inf") : exactNumber(value * degreesPerRadian);
}

std::string triple(const Vector3d& v) {
  return exactNumber(v.x()) + ' ' + exactNumber(v.y()) + ' ' + exactNumber(v.z());
}

/// Rz Ry Rx as degrees about x, y, z.
Vector3d xyzDegrees(const Eigen::Quaterniond& rotation) {
  const Vector3d zyx =
      eulerAngles(rotation, Vector3d::UnitZ(), Vector3d::UnitY(), Vector3d::UnitX(), Vector3d::Zero());
  return degreesPerRadian * Vector3d(zyx[2], zyx[1], zyx[0]);
}

std::string dofLines(const Joint& joint) {
  int kept[3];
  const bool keeps = keepsAxes(joint, kept);
  std::string dofs, limits;
  for (int a = 0; a < 3; ++a) {
    if (keeps && kept[a] < 0) continue;
    dofs += std::string(" r") + "xyz"[a];
    const AxisDof dof = keeps ? joint.axes[kept[a]] : AxisDof{};
    limits += (limits.empty() ? "    limits (" : "           (") + limitWord(dof.lower) + ' ' +
              limitWord(dof.upper) + ")\n";
  }
  return dofs.empty() ? "" : "    dof" + dofs + "\n" + limits;
}

}  // namespace

std::string formatAsf(const Skeleton& skeleton, double metresPerUnit) {
  const Frames zero = forwardKinematics(skeleton, neutral(skeleton));
  const std::vector<PlannedBone> plan = planBones(skeleton, zero);
  std::string text = "# written by gelenk\n:version 1.10\n:name " + word(skeleton.joint(0).name) +
                     "\n:units\n  mass 1.0\n  length " + exactNumber(asfMetresPerUnit(1.0) / metresPerUnit) +
                     "\n  angle deg\n:root\n  order TX TY TZ RX RY RZ\n  axis XYZ\n  position " +
                     triple(zero[0].translation() / metresPerUnit) + "\n  orientation " +
                     triple(xyzDegrees(Eigen::Quaterniond(zero[0].linear()))) + "\n:bonedata\n";
  for (std::size_t b = 1; b < plan.size(); ++b) {
    const PlannedBone& bone = plan[b];
    const double length = bone.offset.norm();
    const Vector3d direction = length > 0.0 ? Vector3d(bone.offset / length) : Vector3d::UnitY();
    const Vector3d axis =
        bone.joint < 0 ? Vector3d::Zero() : xyzDegrees(Eigen::Quaterniond(zero[bone.joint].linear()));
    text += "  begin\n    id " + std::to_string(b) + "\n    name " + bone.name + "\n    direction " +
            triple(direction) + "\n    length " + exactNumber(length / metresPerUnit) + "\n    axis " +
            triple(axis) + " XYZ\n" + (bone.joint < 0 ? "" : dofLines(skeleton.joint(bone.joint))) +
            "  end\n";
  }
  std::vector<std::string> childrenOf(plan.size());
  for (std::size_t b = 1; b < plan.size(); ++b) childrenOf[plan[b].parent] += ' ' + plan[b].name;
  text += ":hierarchy\n  begin\n";
  for (std::size_t b = 0; b < plan.size(); ++b)
    if (!childrenOf[b].empty()) text += "    " + plan[b].name + childrenOf[b] + '\n';
  return text + "  end\n";
}

std::string formatAmc(const Skeleton& skeleton, const MotionClip& clip, double metresPerUnit) {
  validate(skeleton, clip);
  const Frames zero = forwardKinematics(skeleton, neutral(skeleton));
  const std::vector<PlannedBone> plan = planBones(skeleton, zero);
  std::vector<Vector3d> lastAngles(
      plan.size(), Vector3d::Zero());  // z, y, x: the hint that keeps a bone's angles continuous
  std::string text = "# written by gelenk\n:FULLY-SPECIFIED\n:DEGREES\n:SAMPLES-PER-SECOND " +
                     exactNumber(clip.framesPerSecond) + '\n';
  for (int f = 0; f < clip.frameCount(); ++f) {
    const Eigen::VectorXd q = clip.q.col(f);
    text += std::to_string(f + 1) + '\n';
    for (std::size_t b = 0; b < plan.size(); ++b) {
      if (plan[b].joint < 0) continue;
      const Joint& joint = skeleton.joint(plan[b].joint);
      const double* value = q.data() + skeleton.qIndex(plan[b].joint);
      std::string line;
      if (b == 0) {
        const Vector3d moved = zero[0].linear() * jointMotion(skeleton, q, 0).translation();
        line += ' ' + triple(moved / metresPerUnit);
      }
      int kept[3];
      if (b > 0 && keepsAxes(joint, kept)) {
        for (int a = 0; a < 3; ++a)
          if (kept[a] >= 0) line += ' ' + exactNumber(value[kept[a]] * degreesPerRadian);
      } else {
        lastAngles[b] = eulerAngles(jointRotation(skeleton, q, plan[b].joint), Vector3d::UnitZ(),
                                    Vector3d::UnitY(), Vector3d::UnitX(), lastAngles[b]);
        line +=
            ' ' + triple(degreesPerRadian * Vector3d(lastAngles[b][2], lastAngles[b][1], lastAngles[b][0]));
      }
      if (!line.empty()) text += plan[b].name + line + '\n';
    }
  }
  return text;
}

}  // namespace gelenk
