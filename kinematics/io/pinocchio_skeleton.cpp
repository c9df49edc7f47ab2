#include "kinematics/io/pinocchio_skeleton.h"

#include <unordered_map>

#include "kinematics/forward_kinematics.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

struct JointLine {
  int line = 0;
  std::string id, parent;
  Vector3d position;
};

std::string inQuotes(std::string_view word) { return "'" + std::string(word) + "'"; }

std::vector<JointLine> splitJoints(std::string_view text, const std::string& file) {
  std::vector<JointLine> joints;
  const auto lines = splitLines(plainText(text, file));
  for (std::size_t n = 0; n < lines.size(); ++n) {
    const int line = static_cast<int>(n) + 1;
    const auto words = splitWords(lines[n]);
    if (words.empty()) continue;
    if (words.size() != 5)
      throw ParseError(file, line, "five words: id x y z parent", std::to_string(words.size()));
    JointLine joint{
        .line = line, .id = std::string(words[0]), .parent = std::string(words[4]), .position = {}};
    if (joint.id == "-1") throw ParseError(file, line, "an id other than -1, which means no parent", "'-1'");
    for (int k = 0; k < 3; ++k) {
      const auto value = parseNumber(words[k + 1]);
      if (!value) throw ParseError(file, line, "a finite number", badNumber(words[k + 1]));
      joint.position[k] = *value;
    }
    joints.push_back(joint);
  }
  if (joints.empty()) throw ParseError(file, 0, "at least one joint (a line 'id x y z parent')", "none");
  return joints;
}

using Index = std::unordered_map<std::string, int>;

Index indexById(const std::vector<JointLine>& joints, const std::string& file) {
  Index indexOf;
  for (std::size_t i = 0; i < joints.size(); ++i)
    if (!indexOf.emplace(joints[i].id, static_cast<int>(i)).second)
      throw ParseError(file, joints[i].line, "an id that is used once",
                       inQuotes(joints[i].id) + " again (first on line " +
                           std::to_string(joints[indexOf[joints[i].id]].line) + ")");
  return indexOf;
}

bool liesOnACycle(const std::vector<JointLine>& joints, const Index& indexOf, int start) {
  int at = start;
  for (std::size_t step = 0; step < joints.size(); ++step) {
    const auto up = indexOf.find(joints[at].parent);
    if (up == indexOf.end()) return false;
    at = up->second;
    if (at == start) return true;
  }
  return false;
}

int parentIndex(const std::vector<JointLine>& joints, const Index& indexOf, int i, const std::string& file) {
  const JointLine& joint = joints[i];
  if (joint.parent == "-1") {
    if (i == 0) return -1;
    throw ParseError(file, joint.line,
                     "a parent (line " + std::to_string(joints[0].line) + " already is the root)",
                     "a second root, '-1'");
  }
  const auto found = indexOf.find(joint.parent);
  if (found == indexOf.end())
    throw ParseError(file, joint.line, "the id of an earlier joint as parent", inQuotes(joint.parent));
  if (found->second < i) return found->second;
  throw ParseError(file, joint.line, "the id of an earlier joint as parent",
                   liesOnACycle(joints, indexOf, i)
                       ? inQuotes(joint.parent) + ", which makes a cycle of parents"
                       : inQuotes(joint.parent) + ", which comes only on line " +
                             std::to_string(joints[found->second].line));
}

}  // namespace

Skeleton parsePinocchioSkeleton(std::string_view text, const std::string& file) {
  const auto lines = splitJoints(text, file);
  const Index indexOf = indexById(lines, file);
  std::vector<Joint> joints;
  for (int i = 0; i < static_cast<int>(lines.size()); ++i) {
    Joint joint{.name = lines[i].id, .parent = parentIndex(lines, indexOf, i, file)};
    joint.parentFromZero.translation() = lines[i].position;
    if (joint.parent >= 0) {
      joint.parentFromZero.translation() -= lines[joint.parent].position;
      if (!joint.parentFromZero.translation().allFinite())
        throw ParseError(file, lines[i].line, "a bone of finite length", "an overflow");
      if (joint.parentFromZero.translation().norm() == 0.0)
        throw ParseError(file, lines[i].line, "a bone of positive length",
                         "the same position as its parent " + inQuotes(lines[i].parent));
      joints[joint.parent].ball = true;
    } else {
      for (int k = 0; k < 3; ++k) joint.axes.push_back({AxisDof::Kind::Translation, Vector3d::Unit(k)});
      joint.ball = true;
    }
    joints.push_back(joint);
  }
  return Skeleton(std::move(joints));
}

Skeleton readPinocchioSkeleton(const std::string& path) {
  return parsePinocchioSkeleton(readFile(path), path);
}

std::string formatPinocchioSkeleton(const Skeleton& skeleton, PinocchioIds ids) {
  const Frames frames = restFrames(skeleton);
  std::string text;
  const auto id = [&](int i) {
    if (i < 0) return std::string("-1");
    if (ids == PinocchioIds::Indices) return std::to_string(i);
    std::string word = skeleton.joint(i).name;
    for (char& c : word)
      if (c == ' ' || c == '\t') c = '_';
    return word;
  };
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    text += id(i);
    for (int k = 0; k < 3; ++k) text += ' ' + exactNumber(frames[i].translation()[k]);
    text += ' ' + id(skeleton.parent(i)) + '\n';
  }
  return text;
}

Skeleton namedAsHuman(const Skeleton& skeleton) {
  struct Named {
    const char* name;
    int parent;
  };
  static constexpr Named human[] = {{"chest", -1},         {"spine", 0},        {"pelvis", 1},
                                    {"head", 0},           {"hip_right", 2},    {"knee_right", 4},
                                    {"ankle_right", 5},    {"toe_right", 6},    {"hip_left", 2},
                                    {"knee_left", 8},      {"ankle_left", 9},   {"toe_left", 10},
                                    {"shoulder_right", 0}, {"elbow_right", 12}, {"hand_right", 13},
                                    {"shoulder_left", 0},  {"elbow_left", 15},  {"hand_left", 16}};
  if (skeleton.jointCount() != static_cast<int>(std::size(human))) return skeleton;
  std::vector<Joint> joints = skeleton.joints();
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    if (joints[i].parent != human[i].parent || joints[i].name != std::to_string(i)) return skeleton;
    joints[i].name = human[i].name;
  }
  return Skeleton(std::move(joints), skeleton.rest());
}

}  // namespace gelenk
