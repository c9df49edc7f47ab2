#include "kinematics/io/tutorial_skeleton.h"

#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>

#include "kinematics/forward_kinematics.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "kinematics/io/word_stream.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

constexpr std::string_view groupPrefix = "NumJoints-";

bool isNumberStart(std::string_view word) {
  return !word.empty() &&
         (word[0] == '-' || word[0] == '+' || word[0] == '.' || (word[0] >= '0' && word[0] <= '9'));
}

/// Keywords end in a colon, which may stand apart from them.
bool takeKeyword(WordStream& words, std::string_view keyword) {
  if (words.take(std::string(keyword) + ":")) return true;
  if (!sameWord(words.peek(), keyword)) return false;
  words.next("");
  words.expect(":");
  return true;
}

bool isKeyword(std::string_view word) {
  const std::string w = lowerCase(word);
  return w.starts_with("num") || w.starts_with("nonanimated") || w.starts_with("jointangles");
}

/// Triples up to the next keyword: the list grows with the text, never with what a header promises.
std::vector<Vector3d> triples(WordStream& words) {
  std::vector<Vector3d> list;
  while (!words.atEnd() && !isKeyword(words.peek())) {
    const double x = words.number("a number or the next section"), y = words.number(), z = words.number();
    list.emplace_back(x, y, z);
  }
  return list;
}

int count(WordStream& words, const std::string& what) {
  const int n = words.integer("the number of " + what);
  if (n < 1) words.failTaken("at least one of the " + what, std::to_string(n));
  return n;
}

std::string plural(int n, const std::string& what) { return std::to_string(n) + " " + what; }

/// A section's value and the line where it stood first; a repetition must say the same.
template <class T>
struct Section {
  std::optional<T> value;
  int line = 0;
  void set(WordStream& words, int lineOfSection, const std::string& name, T newValue) {
    if (value && *value != newValue)
      throw ParseError(words.file(), lineOfSection,
                       "the same " + name + " as in the section on line " + std::to_string(line), "others");
    if (!value) line = lineOfSection;
    value = std::move(newValue);
  }
};

struct BoneLine {
  std::array<int, 2> joints;
  int line;
  bool operator==(const BoneLine& other) const { return joints == other.joints; }
};
struct GroupLine {
  TutorialSkeleton::Group group;
  int line;
  bool operator==(const GroupLine& other) const { return group == other.group; }
};

std::vector<BoneLine> parseBones(WordStream& words) {
  const int n = count(words, "bones");
  const int line = words.lineTaken();
  std::vector<BoneLine> bones;
  while (isNumberStart(words.peek())) {
    const int from = words.integer("the index of a joint");
    bones.push_back({{from, words.integer("the index of the bone's end joint")}, words.lineTaken()});
  }
  if (static_cast<int>(bones.size()) != n)
    throw ParseError(words.file(), line, plural(n, "bones"), std::to_string(bones.size()));
  return bones;
}

std::vector<GroupLine> parseGroups(WordStream& words) {
  const int n = count(words, "joint hierarchies");
  const int line = words.lineTaken();
  std::vector<GroupLine> groups;
  while (words.peek().starts_with(groupPrefix)) {
    std::string name(words.next(""));
    while (name.back() != ':' && words.sameLine() && !isNumberStart(words.peek()))
      name += ' ' + std::string(words.next(""));
    if (name.back() != ':') words.fail("a colon after the group's name");
    name = name.substr(groupPrefix.size(), name.size() - groupPrefix.size() - 1);
    if (name.empty()) words.failTaken("a name after NumJoints-", "none");
    GroupLine group{{.name = name, .joints = {}}, words.lineTaken()};
    const int joints = count(words, "joints of the group");
    while (isNumberStart(words.peek())) group.group.joints.push_back(words.integer("the index of a joint"));
    if (static_cast<int>(group.group.joints.size()) != joints)
      throw ParseError(words.file(), group.line, plural(joints, "joints in the group '" + name + "'"),
                       std::to_string(group.group.joints.size()));
    if (joints < 2)
      throw ParseError(words.file(), group.line, "at least two joints in a group", std::to_string(joints));
    groups.push_back(std::move(group));
  }
  if (static_cast<int>(groups.size()) != n)
    throw ParseError(words.file(), line, plural(n, "joint hierarchies"), std::to_string(groups.size()));
  return groups;
}

/// parents[j]: the joint that bends the bone to j, -1 for the root.
std::vector<int> checkBones(const std::string& file, const std::vector<Vector3d>& positions,
                            const std::vector<BoneLine>& bones, int bonesLine) {
  const int joints = static_cast<int>(positions.size());
  std::vector<int> parents(joints, -1), lineOf(joints, 0);
  for (const BoneLine& bone : bones) {
    for (const int j : bone.joints)
      if (j < 0 || j >= joints)
        throw ParseError(file, bone.line, "a joint from 0 to " + std::to_string(joints - 1),
                         std::to_string(j));
    const auto [from, to] = bone.joints;
    if (lineOf[to])
      throw ParseError(
          file, bone.line,
          "one bone that ends at joint " + std::to_string(to) + " (line " + std::to_string(lineOf[to]) + ")",
          "a second one");
    if (!((positions[from] - positions[to]).norm() > 0.0) || !(positions[from] - positions[to]).allFinite())
      throw ParseError(file, bone.line, "a bone of positive, finite length",
                       "joints " + std::to_string(from) + " and " + std::to_string(to) + " in one place");
    parents[to] = from;
    lineOf[to] = bone.line;
  }
  if (static_cast<int>(bones.size()) != joints - 1)
    throw ParseError(file, bonesLine,
                     std::to_string(joints - 1) + " bones for " + std::to_string(joints) + " joints (a tree)",
                     std::to_string(bones.size()));
  // n - 1 bones with different ends: exactly one joint is no end. A joint that does not lead up to it lies on
  // a cycle.
  std::vector<char> reached(joints, 0);
  for (int j = 0; j < joints; ++j) {
    std::vector<int> path;
    int at = j;
    while (at >= 0 && !reached[at]) {
      reached[at] = 2;
      path.push_back(at);
      at = parents[at];
    }
    if (at >= 0 && reached[at] == 2)
      throw ParseError(file, lineOf[at], "bones without a cycle",
                       "joint " + std::to_string(at) + " below itself");
    for (const int p : path) reached[p] = 1;
  }
  return parents;
}

void checkGroups(const std::string& file, const std::vector<int>& parents,
                 const std::vector<GroupLine>& groups, int groupsLine) {
  const int joints = static_cast<int>(parents.size());
  std::vector<char> inGroup(joints, 0);
  int steps = 0;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const auto& [group, line] = groups[g];
    for (std::size_t k = 0; k < group.joints.size(); ++k) {
      const int j = group.joints[k];
      if (j < 0 || j >= joints)
        throw ParseError(file, line, "joints from 0 to " + std::to_string(joints - 1), std::to_string(j));
      if (k == 0) {
        if (g > 0 && !inGroup[j])
          throw ParseError(file, line, "a group that hangs on a joint of an earlier group",
                           "joint " + std::to_string(j));
        if (g == 0 && parents[j] >= 0)
          throw ParseError(file, line, "the root at the top of the first group",
                           "joint " + std::to_string(j));
        inGroup[j] = 1;
        continue;
      }
      if (parents[j] != group.joints[k - 1])
        throw ParseError(file, line, "a bone between joints that follow each other",
                         std::to_string(group.joints[k - 1]) + ", " + std::to_string(j));
      if (inGroup[j])
        throw ParseError(file, line, "each bone in one group", "joint " + std::to_string(j) + " again");
      inGroup[j] = 1;
      ++steps;
    }
  }
  if (steps != joints - 1)
    throw ParseError(file, groupsLine, "every one of the " + std::to_string(joints - 1) + " bones in a group",
                     std::to_string(steps));
}

/// Six decimals if they say it all.
std::string number(double value) {
  char buffer[400];
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, 6);
  const std::string text = error == std::errc() ? std::string(buffer, end) : "";
  const auto back = parseNumber(text);
  return back && *back == value && std::signbit(*back) == std::signbit(value) ? text : exactNumber(value);
}

std::string lineOf(const Vector3d& v) {
  return number(v.x()) + ", " + number(v.y()) + ", " + number(v.z()) + ",\n";
}

}  // namespace

TutorialSkeleton parseTutorialSkeleton(std::string_view text, const std::string& file) {
  WordStream words(text, file, ",");
  Section<int> jointCount;
  Section<std::vector<Vector3d>> positions;
  Section<std::vector<BoneLine>> bones;
  Section<std::vector<GroupLine>> groups;
  while (!words.atEnd()) {
    const int line = words.line();
    if (takeKeyword(words, "NumJoints"))
      jointCount.set(words, line, "number of joints", count(words, "joints"));
    else if (takeKeyword(words, "NonAnimatedJointPositions"))
      positions.set(words, line, "positions", triples(words));
    else if (takeKeyword(words, "NumBones"))
      bones.set(words, line, "bones", parseBones(words));
    else if (takeKeyword(words, "NumJointHierarchies"))
      groups.set(words, line, "groups", parseGroups(words));
    else
      words.fail("NumJoints:, NonAnimatedJointPositions:, NumBones: or NumJointHierarchies:");
  }
  if (!jointCount.value) throw ParseError(file, 0, "a line NumJoints:", "none");
  if (!positions.value) throw ParseError(file, 0, "a section NonAnimatedJointPositions:", "none");
  if (!bones.value) throw ParseError(file, 0, "a section NumBones:", "none");
  if (!groups.value) throw ParseError(file, 0, "a section NumJointHierarchies:", "none");
  if (static_cast<int>(positions.value->size()) != *jointCount.value)
    throw ParseError(file, positions.line, plural(*jointCount.value, "positions, one a joint"),
                     std::to_string(positions.value->size()));
  const std::vector<int> parents = checkBones(file, *positions.value, *bones.value, bones.line);
  checkGroups(file, parents, *groups.value, groups.line);

  TutorialSkeleton skeleton{.positions = *positions.value, .bones = {}, .groups = {}};
  for (const BoneLine& bone : *bones.value) skeleton.bones.push_back(bone.joints);
  for (const GroupLine& group : *groups.value) skeleton.groups.push_back(group.group);
  return skeleton;
}

TutorialSkeleton readTutorialSkeleton(const std::string& path) {
  return parseTutorialSkeleton(readFile(path), path);
}

std::string formatTutorialSkeleton(const TutorialSkeleton& skeleton) {
  std::string text =
      "NumJoints: " + std::to_string(skeleton.positions.size()) + "\nNonAnimatedJointPositions:\n";
  for (const Vector3d& p : skeleton.positions) text += lineOf(p);
  text += "NumBones: " + std::to_string(skeleton.bones.size()) + '\n';
  for (const auto& [from, to] : skeleton.bones)
    text += std::to_string(from) + ", " + std::to_string(to) + ",\n";
  text += "NumJointHierarchies: " + std::to_string(skeleton.groups.size()) + '\n';
  for (const TutorialSkeleton::Group& group : skeleton.groups) {
    text += std::string(groupPrefix) + group.name + ": " + std::to_string(group.joints.size()) + '\n';
    for (std::size_t k = 0; k < group.joints.size(); ++k)
      text += (k ? " " : "") + std::to_string(group.joints[k]) + ',';
    text += '\n';
  }
  return text;
}

TutorialPose parseTutorialPose(std::string_view text, const std::string& file) {
  WordStream words(text, file, ",");
  Section<int> jointCount;
  Section<TutorialPose> angles;
  while (!words.atEnd()) {
    const int line = words.line();
    if (takeKeyword(words, "NumJoints"))
      jointCount.set(words, line, "number of joints", count(words, "joints"));
    else if (takeKeyword(words, "JointAngles"))
      angles.set(words, line, "angles", triples(words));
    else
      words.fail("NumJoints: or JointAngles:");
  }
  if (!jointCount.value) throw ParseError(file, 0, "a line NumJoints:", "none");
  if (!angles.value) throw ParseError(file, 0, "a section JointAngles:", "none");
  if (static_cast<int>(angles.value->size()) != *jointCount.value)
    throw ParseError(file, angles.line, plural(*jointCount.value, "triples of angles, one a joint"),
                     std::to_string(angles.value->size()));
  return *angles.value;
}

TutorialPose readTutorialPose(const std::string& path) { return parseTutorialPose(readFile(path), path); }

std::string formatTutorialPose(const TutorialPose& pose) {
  std::string text = "NumJoints: " + std::to_string(pose.size()) + "\nJointAngles:\n";
  for (const Vector3d& angles : pose) text += lineOf(angles);
  return text;
}

TutorialFigure toSkeleton(const TutorialSkeleton& tutorial) {
  const int count = static_cast<int>(tutorial.positions.size());
  std::vector<std::vector<int>> children(count);
  std::vector<char> isEnd(count, 0);
  for (const auto& [from, to] : tutorial.bones) {
    if (from < 0 || to < 0 || from >= count || to >= count)
      throw std::invalid_argument("a bone refers to a joint that does not exist");
    children[from].push_back(to);
    isEnd[to] = 1;
  }
  TutorialFigure figure;
  figure.jointOfIndex.assign(count, -1);
  std::vector<Joint> joints;
  std::vector<std::pair<int, int>> open;  // index of the file, joint of its parent
  for (int j = 0; j < count; ++j)
    if (!isEnd[j]) open.emplace_back(j, -1);
  while (!open.empty()) {
    const auto [index, parent] = open.back();
    open.pop_back();
    if (figure.jointOfIndex[index] >= 0) throw std::invalid_argument("a joint ends two bones");
    figure.jointOfIndex[index] = static_cast<int>(joints.size());
    Joint joint{.name = "joint" + std::to_string(index), .parent = parent};
    joint.parentFromZero.translation() = tutorial.positions[index];
    for (const auto& [from, to] : tutorial.bones)
      if (to == index) joint.parentFromZero.translation() -= tutorial.positions[from];
    for (const int axis : {2, 1, 0}) joint.axes.push_back({AxisDof::Kind::Rotation, Vector3d::Unit(axis)});
    joints.push_back(std::move(joint));
    for (auto child = children[index].rbegin(); child != children[index].rend(); ++child)
      open.emplace_back(*child, figure.jointOfIndex[index]);
  }
  if (static_cast<int>(joints.size()) != count)
    throw std::invalid_argument("the bones are no tree over all joints");
  figure.skeleton = Skeleton(std::move(joints));
  return figure;
}

Eigen::VectorXd configuration(const TutorialFigure& figure, const TutorialPose& pose) {
  if (pose.size() != figure.jointOfIndex.size())
    throw std::invalid_argument("the pose has " + std::to_string(pose.size()) + " joints, the figure " +
                                std::to_string(figure.jointOfIndex.size()));
  Eigen::VectorXd q = Eigen::VectorXd::Zero(figure.skeleton.nq());
  for (std::size_t j = 0; j < pose.size(); ++j)
    q.segment<3>(figure.skeleton.qIndex(figure.jointOfIndex[j])) = pose[j].reverse();
  return q;
}

TutorialPose tutorialPose(const TutorialFigure& figure, const Eigen::VectorXd& q) {
  if (q.size() != figure.skeleton.nq())
    throw std::invalid_argument("the configuration does not fit the figure");
  TutorialPose pose(figure.jointOfIndex.size());
  for (std::size_t j = 0; j < pose.size(); ++j)
    pose[j] = q.segment<3>(figure.skeleton.qIndex(figure.jointOfIndex[j])).reverse();
  return pose;
}

TutorialSkeleton toTutorialSkeleton(const Skeleton& skeleton) {
  const Frames rest = restFrames(skeleton);
  TutorialSkeleton tutorial;
  for (const auto& frame : rest) tutorial.positions.push_back(frame.translation());
  for (int i = 1; i < skeleton.jointCount(); ++i) tutorial.bones.push_back({skeleton.parent(i), i});
  // A group runs down the first children; every further child begins another one, tops first.
  std::vector<std::array<int, 2>> open;
  const auto runDown = [&](int top, int next) {
    TutorialSkeleton::Group group{.name = skeleton.joint(next).name, .joints = {top}};
    for (int at = next; at >= 0; at = skeleton.children(at).empty() ? -1 : skeleton.children(at).front()) {
      group.joints.push_back(at);
      for (std::size_t k = 1; k < skeleton.children(at).size(); ++k)
        open.push_back({at, skeleton.children(at)[k]});
    }
    for (char& c : group.name)
      if (c == ' ' || c == ',' || c == ':') c = '_';
    tutorial.groups.push_back(std::move(group));
  };
  for (const int child : skeleton.children(0)) open.push_back({0, child});
  for (std::size_t k = 0; k < open.size(); ++k) runDown(open[k][0], open[k][1]);
  return tutorial;
}

}  // namespace gelenk
