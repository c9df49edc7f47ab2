#include "skinning/rigging/fit/rig_skeleton.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/notation/mannequin.h"
#include "skinning/rigging/fit/fingers.h"

namespace gelenk {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

/// A joint of a rig: one of the template's, or a place between two.
struct LayoutRow {
  const char *name, *parent, *first, *second = "";
  double share = 0.5;  ///< of the second
};

// The bones that carry the trunk come before those of the neck: the first child's column in Pinocchio's
// format takes the parent joint's weight.
constexpr LayoutRow humanLayout[] = {
    {"pelvis", "", "pelvis"},
    {"hip_l", "pelvis", "thigh_l"},
    {"knee_l", "hip_l", "calf_l"},
    {"ankle_l", "knee_l", "foot_l"},
    {"toe_l", "ankle_l", "ball_l"},
    {"toe_end_l", "toe_l", "ball_l", "toe_end_l", 0.8},
    {"hip_r", "pelvis", "thigh_r"},
    {"knee_r", "hip_r", "calf_r"},
    {"ankle_r", "knee_r", "foot_r"},
    {"toe_r", "ankle_r", "ball_r"},
    {"toe_end_r", "toe_r", "ball_r", "toe_end_r", 0.8},
    {"spine_01", "pelvis", "spine_01"},
    {"spine_02", "spine_01", "spine_02"},
    {"spine_03", "spine_02", "spine_03"},
    {"chest", "spine_03", "upperarm_l", "upperarm_r"},
    {"clavicle_l", "spine_03", "clavicle_l"},
    {"shoulder_l", "clavicle_l", "upperarm_l"},
    {"elbow_l", "shoulder_l", "lowerarm_l"},
    {"wrist_l", "elbow_l", "hand_l"},
    {"hand_l", "wrist_l", "middle_01_l"},
    {"clavicle_r", "spine_03", "clavicle_r"},
    {"shoulder_r", "clavicle_r", "upperarm_r"},
    {"elbow_r", "shoulder_r", "lowerarm_r"},
    {"wrist_r", "elbow_r", "hand_r"},
    {"hand_r", "wrist_r", "middle_01_r"},
    {"neck", "spine_03", "neck_01"},
    {"headbase", "neck", "head"},
    {"head_end", "headbase", "head", "head_end", 0.9},
};

// Pinocchio's own order; its right and left are the body's here.
constexpr LayoutRow pinocchioLayout[] = {
    {"0", "", "upperarm_l", "upperarm_r"},
    {"1", "0", "spine_02"},
    {"2", "1", "thigh_l", "thigh_r"},
    {"3", "0", "head", "head_end"},
    {"4", "2", "thigh_r"},
    {"5", "4", "calf_r"},
    {"6", "5", "foot_r"},
    {"7", "6", "ball_r"},
    {"8", "2", "thigh_l"},
    {"9", "8", "calf_l"},
    {"10", "9", "foot_l"},
    {"11", "10", "ball_l"},
    {"12", "0", "upperarm_r"},
    {"13", "12", "lowerarm_r"},
    {"14", "13", "hand_r", "middle_01_r"},
    {"15", "0", "upperarm_l"},
    {"16", "15", "lowerarm_l"},
    {"17", "16", "hand_l", "middle_01_l"},
};

constexpr LayoutRow quadrupedLayout[] = {
    {"pelvis", "", "hip_l", "hip_r"},
    {"spine", "pelvis", "spine"},
    {"chest", "spine", "fshoulder_l", "fshoulder_r"},
    {"withers", "chest", "withers"},
    {"fshoulder_l", "chest", "fshoulder_l"},
    {"felbow_l", "fshoulder_l", "felbow_l"},
    {"fankle_l", "felbow_l", "fankle_l"},
    {"ffoot_l", "fankle_l", "ffoot_l"},
    {"fshoulder_r", "chest", "fshoulder_r"},
    {"felbow_r", "fshoulder_r", "felbow_r"},
    {"fankle_r", "felbow_r", "fankle_r"},
    {"ffoot_r", "fankle_r", "ffoot_r"},
    {"hip_l", "pelvis", "hip_l"},
    {"knee_l", "hip_l", "knee_l"},
    {"hock_l", "knee_l", "hock_l"},
    {"hankle_l", "hock_l", "hankle_l"},
    {"hfoot_l", "hankle_l", "hfoot_l"},
    {"hip_r", "pelvis", "hip_r"},
    {"knee_r", "hip_r", "knee_r"},
    {"hock_r", "knee_r", "hock_r"},
    {"hankle_r", "hock_r", "hankle_r"},
    {"hfoot_r", "hankle_r", "hfoot_r"},
    {"tail_root", "pelvis", "tail_root"},
    {"tail", "tail_root", "tail"},
    {"neck", "chest", "neck"},
    {"headbase", "neck", "head"},
    {"head", "headbase", "head", "nose", 0.9},
};

Matrix3d rotationOf(const Matrix3d& linear) {
  Eigen::JacobiSVD<Matrix3d> svd(linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d flip = Matrix3d::Identity();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) flip(2, 2) = -1.0;
  return svd.matrixU() * flip * svd.matrixV().transpose();
}

/// The angle about the unit axis that brings a rotation nearest to `turn`.
double angleAbout(const Vector3d& axis, const Matrix3d& turn) {
  const Quaterniond q(turn);
  return 2.0 * std::atan2(q.vec().dot(axis), q.w());
}

double wrapped(double angle) { return std::remainder(angle, 2.0 * M_PI); }

}  // namespace

std::vector<RigJoint> rigJoints(const TemplateBody& body, RigTemplate skeleton, const Placement& placement,
                                const std::vector<Vector3d>& positions) {
  const Skeleton figure = mannequin();
  const auto find = [&](const std::string& name) {
    for (std::size_t k = 0; k < body.joints.size(); ++k)
      if (body.joints[k].name == name) return static_cast<int>(k);
    throw std::logic_error("the template has no joint '" + name + "'");
  };
  std::vector<RigJoint> joints;
  const auto add = [&](const LayoutRow& row) {
    RigJoint joint{.name = row.name};
    for (std::size_t k = 0; k < joints.size(); ++k)
      if (joints[k].name == row.parent) joint.parent = static_cast<int>(k);
    const int first = find(row.first), second = *row.second ? find(row.second) : first;
    joint.position =
        placement.frame.toWorld(positions[first] + row.share * (positions[second] - positions[first]));
    const Matrix3d& axes = placement.frame.axes;
    joint.piece = body.joints[first].piece;
    joint.turn = axes * rotationOf(placement.maps[joint.piece].linear);
    if (skeleton == RigTemplate::Human) joint.figureJoint = figure.jointIndex(row.first);
    joints.push_back(joint);
  };
  if (skeleton == RigTemplate::Pinocchio)
    for (const LayoutRow& row : pinocchioLayout) add(row);
  else if (skeleton == RigTemplate::Quadruped)
    for (const LayoutRow& row : quadrupedLayout) add(row);
  else
    for (const LayoutRow& row : humanLayout) add(row);
  return joints;
}

void addFingers(std::vector<RigJoint>& joints, const Mesh& mesh, const Placement& placement) {
  const auto find = [&](const std::string& name) {
    for (std::size_t k = 0; k < joints.size(); ++k)
      if (joints[k].name == name) return static_cast<int>(k);
    return -1;
  };
  std::vector<FingerJoints> hands[2];
  for (int side = 0; side < 2; ++side) {
    const std::string suffix = side == 0 ? "_l" : "_r";
    const int elbow = find("elbow" + suffix), wrist = find("wrist" + suffix),
              knuckles = find("hand" + suffix);
    if (std::min({elbow, wrist, knuckles}) < 0) return;
    if (side == 1 && placement.symmetric)
      for (FingerJoints finger : hands[0]) {
        for (Vector3d& p : finger) {
          Vector3d image = placement.frame.toBody(p);
          image.x() = -image.x();
          p = placement.frame.toWorld(image);
        }
        hands[1].push_back(finger);
      }
    else
      hands[side] =
          findFingers(mesh, {joints[elbow].position, joints[wrist].position, joints[knuckles].position});
  }
  if (hands[0].size() != hands[1].size()) return;

  const Skeleton figure = mannequin();
  const Frames rest = restFrames(figure);
  for (int side = 0; side < 2; ++side) {
    const std::string suffix = side == 0 ? "_l" : "_r";
    const RigJoint wrist = joints[find("wrist" + suffix)];
    for (std::size_t f = 0; f < hands[side].size(); ++f) {
      constexpr const char* fingers[] = {"thumb", "index", "middle", "ring", "pinky"};
      constexpr const char* parts[] = {"_01", "_02", "_03", "_end"};
      int parent = find("wrist" + suffix);
      Matrix3d turn = wrist.turn;
      for (int k = 0; k < 4; ++k) {
        const std::string name = fingers[f] + std::string(parts[k]) + suffix;
        RigJoint joint{.name = name, .parent = parent, .position = hands[side][f][k]};
        joint.piece = wrist.piece;
        joint.figureJoint = figure.jointIndex(name);
        if (k < 3) {  // the hinge goes along with its bone
          const std::string next = fingers[f] + std::string(parts[k + 1]) + suffix;
          const Vector3d was = wrist.turn * (rest[figure.jointIndex(next)].translation() -
                                             rest[joint.figureJoint].translation());
          turn =
              Quaterniond::FromTwoVectors(was, hands[side][f][k + 1] - hands[side][f][k]).toRotationMatrix() *
              wrist.turn;
        }
        joint.turn = turn;
        parent = static_cast<int>(joints.size());
        joints.push_back(std::move(joint));
      }
    }
  }
}

Skeleton rigSkeleton(const std::vector<RigJoint>& joints) {
  const Skeleton figure = mannequin();
  const Frames figureRest = restFrames(figure);
  std::vector<char> hasChild(joints.size(), 0);
  for (const RigJoint& joint : joints)
    if (joint.parent >= 0) hasChild[joint.parent] = 1;

  std::vector<Joint> out;
  std::vector<double> rest;
  Frames frames;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const RigJoint& from = joints[i];
    Joint joint{.name = from.name, .parent = from.parent};
    Isometry3d frame = Isometry3d::Identity();
    frame.translation() = from.position;
    if (from.figureJoint >= 0) frame.linear() = from.turn * figureRest[from.figureJoint].linear();
    const Isometry3d parent = from.parent < 0 ? Isometry3d::Identity() : frames[from.parent];
    const Isometry3d parentFromRest = parent.inverse() * frame;
    joint.parentFromZero = parentFromRest;
    if (from.parent < 0) {
      for (int k = 0; k < 3; ++k) joint.axes.push_back({AxisDof::Kind::Translation, Vector3d::Unit(k)});
      joint.ball = true;
      rest.insert(rest.end(), {0, 0, 0, 1, 0, 0, 0});
    } else if (!hasChild[i]) {
      // a fixed frame: where a bone ends
    } else if (from.figureJoint < 0) {
      joint.ball = true;
      rest.insert(rest.end(), {1, 0, 0, 0});
    } else {
      const Joint& model = figure.joint(from.figureJoint);
      joint.axes = model.axes;
      joint.ball = model.ball;
      joint.ballLimit = model.ballLimit;
      Matrix3d motion = model.parentFromZero.linear().transpose() * parentFromRest.linear();
      Matrix3d done = Matrix3d::Identity();
      for (const AxisDof& dof : joint.axes) {
        const double angle =
            std::clamp(wrapped(angleAbout(dof.axis, done.transpose() * motion)), dof.lower, dof.upper);
        rest.push_back(angle);
        done = done * Eigen::AngleAxisd(angle, dof.axis).toRotationMatrix();
      }
      if (joint.ball) {
        const Quaterniond q(motion);
        rest.insert(rest.end(), {q.w(), q.x(), q.y(), q.z()});
        done = motion;
      }
      joint.parentFromZero.linear() = parentFromRest.linear() * done.transpose();
    }
    const Eigen::Quaterniond clean(joint.parentFromZero.linear());
    joint.parentFromZero.linear() = clean.normalized().toRotationMatrix();
    frames.push_back(frame);
    out.push_back(std::move(joint));
  }
  return Skeleton(std::move(out),
                  Eigen::Map<Eigen::VectorXd>(rest.data(), static_cast<Eigen::Index>(rest.size())));
}

}  // namespace gelenk
