#include "kinematics/io/bvh.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>
#include <unordered_set>

#include "kinematics/forward_kinematics.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "kinematics/io/word_stream.h"
#include "kinematics/skeleton_transform.h"

namespace gelenk {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double radiansPerDegree = M_PI / 180.0;

struct Channel {
  bool rotation;
  int axis;
  bool operator==(const Channel&) const = default;
};

struct Node {
  std::string name;
  int parent = -1;
  int line = 0;
  bool root = false;
  Vector3d offset = Vector3d::Zero();  ///< file units
  std::vector<Channel> channels;
  int firstChannel = 0;  ///< in a line of the motion
};

Channel channel(WordStream& words) {
  const std::string word = lowerCase(words.peek());
  const std::string_view kind = std::string_view(word).substr(std::min<std::size_t>(1, word.size()));
  if (word.empty() || word[0] < 'x' || word[0] > 'z' || (kind != "rotation" && kind != "position"))
    words.fail("a channel such as Xposition or Zrotation");
  words.next("");
  return {kind == "rotation", word[0] - 'x'};
}

Vector3d vector3(WordStream& words) {
  const double x = words.number(), y = words.number(), z = words.number();
  return {x, y, z};
}

void parseChannels(WordStream& words, Node& node) {
  const int count = words.integer("the number of channels");
  if (count < 0 || count > 6) words.failTaken("0 to 6 channels", std::to_string(count));
  for (int k = 0; k < count; ++k) {
    const Channel next = channel(words);
    for (const Channel& other : node.channels)
      if (other == next)
        words.failTaken("each channel of a joint once", std::string("a second ") + "XYZ"[next.axis] +
                                                            (next.rotation ? "rotation" : "position"));
    node.channels.push_back(next);
  }
}

/// Without recursion: a file may nest as deeply as it likes.
std::vector<Node> parseHierarchy(WordStream& words, int& channelCount, std::vector<Note>& notes) {
  words.expect("HIERARCHY");
  std::vector<Node> nodes;
  int roots = 0;
  std::vector<int> open;  // joints whose brace is open
  std::unordered_set<std::string> names;
  std::map<std::string, int> copies;  // of names that are used twice
  const auto begin = [&](const std::string& given) {
    std::string name = given;
    if (names.count(given))
      tell(notes, "name-repeated",
           "joints of a name that another one has get a number: '" + given + "', line " +
               std::to_string(words.lineTaken()));
    while (!names.insert(name).second) name = given + '_' + std::to_string(++copies[given] + 1);
    Node node{
        .name = name, .parent = open.empty() ? -1 : open.back(), .line = words.lineTaken(), .channels = {}};
    node.root = open.empty();
    roots += node.root;
    words.expect("{");
    words.expect("OFFSET");
    node.offset = vector3(words);
    nodes.push_back(std::move(node));
    open.push_back(static_cast<int>(nodes.size()) - 1);
  };
  const auto restOfLine = [&](const std::string& expected) {  // names may hold blanks
    std::string name(words.next(expected));
    while (words.sameLine() && words.peek() != "{") name += ' ' + std::string(words.next(""));
    return name;
  };
  words.expect("ROOT");
  begin(restOfLine("the root's name"));
  while (!open.empty() || sameWord(words.peek(), "ROOT")) {
    if (open.empty()) {
      words.expect("ROOT");
      begin(restOfLine("the root's name"));
      continue;
    }
    Node& node = nodes[open.back()];
    if (words.take("CHANNELS")) {
      if (!node.channels.empty()) words.failTaken("one line CHANNELS a joint", "a second one");
      parseChannels(words, node);
      node.firstChannel = channelCount;
      channelCount += static_cast<int>(node.channels.size());
    } else if (words.take("JOINT")) {
      begin(restOfLine("the joint's name"));
    } else if (words.take("End")) {
      words.expect("Site");
      std::string name = node.name + "_end";
      if (words.sameLine() && words.peek() != "{") name = restOfLine("{");  // some programs name them
      while (names.count(name)) name += '_';
      begin(name);
      words.expect("}");
      open.pop_back();
    } else if (words.take("}")) {
      open.pop_back();
    } else {
      words.fail("CHANNELS, JOINT, End Site or }");
    }
  }
  if (roots == 1) return nodes;
  tell(notes, "several-roots", "roots hang on a joint above them that the file does not have", roots);
  std::string above = "scene";
  while (names.count(above)) above += '_';
  for (Node& node : nodes) ++node.parent;
  nodes.insert(nodes.begin(), Node{.name = above, .line = nodes[0].line, .root = true, .channels = {}});
  return nodes;
}

/// "Frames:" and its like, whose colon may stand apart or be glued to what follows.
void expectLabel(WordStream& words, std::string_view label) {
  if (!words.takePrefix(label)) words.fail("'" + std::string(label) + ":'");
  words.takePrefix(":");
}

/// frames x channels. The header's number of frames is what a program meant to write; the rows are what it
/// wrote. Where the two agree, a row may run over several lines; where they do not, each line must be a row.
std::vector<double> parseMotion(WordStream& words, int channelCount, int& frames, double& frameTime,
                                std::vector<Note>& notes) {
  words.expect("MOTION");
  expectLabel(words, "Frames");
  frames = words.integer("the number of frames");
  words.expect("Frame");
  expectLabel(words, "Time");
  frameTime = words.number("the time of a frame in seconds");
  if (!(frameTime > 0.0) || !std::isfinite(1.0 / frameTime))
    words.failTaken("a positive frame time", exactNumber(frameTime));
  std::vector<double> values;  // grows with what is there, not with what the header promises
  const std::size_t channels = channelCount;
  int wrongLine = 0;  // the first one that is no row, and how many values it has
  std::size_t wrongCount = 0, linesAfterWrong = 0;
  while (!words.atEnd()) {
    const int line = words.line();
    const std::size_t before = values.size();
    do values.push_back(words.number());
    while (words.sameLine());
    if (wrongLine > 0) {
      ++linesAfterWrong;
    } else if (values.size() - before != channels) {
      wrongLine = line;
      wrongCount = values.size() - before;
    }
  }
  if (frames > 0 && values.size() == static_cast<std::size_t>(frames) * channels) return values;
  const bool cutOff =
      wrongLine > 0 && linesAfterWrong == 0 && wrongCount < channels && values.size() > channels;
  if (wrongLine > 0 && !cutOff)
    throw ParseError(
        words.file(), wrongLine,
        std::to_string(frames) + " frames of " + std::to_string(channelCount) +
            " values, or rows of so many values each",
        std::to_string(wrongCount) + " values in this row, " + std::to_string(values.size()) + " in all");
  if (cutOff) {
    tell(notes, "frame-cut-off",
         "the last frame is cut off after " + std::to_string(wrongCount) + " of " +
             std::to_string(channelCount) + " values and left out");
    values.resize(values.size() - wrongCount);
  }
  const int rows = static_cast<int>(values.size() / channels);
  if (rows == 0) throw ParseError(words.file(), words.line(), "at least one frame", "none");
  if (rows != frames)
    tell(notes, "frame-count",
         "'Frames:' says " + std::to_string(frames) + ", there are " + std::to_string(rows) +
             " rows: they are taken");
  frames = rows;
  return values;
}

/// The offset that the position channels of a node give in one frame, before OFFSET is added; axes without a
/// channel take OFFSET.
bool hasPositions(const Node& node) {
  for (const Channel& c : node.channels)
    if (!c.rotation) return true;
  return false;
}

/// True if position channels of joints other than the root are differences from OFFSET.
bool positionsAreDifferences(const std::vector<Node>& nodes, const std::vector<double>& firstFrame) {
  double asReplaced = 0.0, asAdded = 0.0;
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    if (!hasPositions(nodes[i]) || nodes[i].root) continue;
    Vector3d replaced = nodes[i].offset, added = nodes[i].offset;
    for (std::size_t k = 0; k < nodes[i].channels.size(); ++k) {
      const Channel& c = nodes[i].channels[k];
      if (c.rotation) continue;
      replaced[c.axis] = firstFrame[nodes[i].firstChannel + k];
      added[c.axis] += firstFrame[nodes[i].firstChannel + k];
    }
    asReplaced += std::abs(replaced.norm() - nodes[i].offset.norm());
    asAdded += std::abs(added.norm() - nodes[i].offset.norm());
  }
  return asAdded < asReplaced;
}

struct Target {
  int qIndex;
  double scale;
};

}  // namespace

BvhMotion parseBvh(std::string_view text, const std::string& file, const BvhOptions& options) {
  if (!(options.metresPerUnit > 0.0)) throw std::invalid_argument("the unit's length must be positive");
  WordStream words(text, file);
  int channelCount = 0, frames = 0;
  double frameTime = 0.0;
  BvhMotion result;
  const std::vector<Node> nodes = parseHierarchy(words, channelCount, result.notes);
  if (channelCount == 0) throw ParseError(file, nodes[0].line, "at least one channel", "none");
  const std::vector<double> values = parseMotion(words, channelCount, frames, frameTime, result.notes);

  bool othersAdd = options.positions == BvhPositions::Add;
  const bool rootAdds = othersAdd;
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    if (!hasPositions(nodes[i]) || nodes[i].root) continue;
    if (options.positions == BvhPositions::Automatic) othersAdd = positionsAreDifferences(nodes, values);
    tell(result.notes, "bvh-positions",
         othersAdd ? "position channels of joints other than the root are taken as differences from OFFSET"
                   : "position channels of joints other than the root are taken in place of OFFSET");
    break;
  }

  std::vector<Joint> joints;
  std::vector<double> rest;
  std::vector<Target> targets(channelCount);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Node& node = nodes[i];
    const bool adds = nodes[i].root ? rootAdds : othersAdd;
    Joint joint{.name = node.name, .parent = node.parent};
    joint.parentFromZero.translation() = options.metresPerUnit * node.offset;
    for (const bool rotation : {false, true})
      for (std::size_t k = 0; k < node.channels.size(); ++k) {
        const Channel& c = node.channels[k];
        if (c.rotation != rotation) continue;
        joint.axes.push_back(
            {rotation ? AxisDof::Kind::Rotation : AxisDof::Kind::Translation, Vector3d::Unit(c.axis)});
        targets[node.firstChannel + k] = {static_cast<int>(rest.size()),
                                          rotation ? radiansPerDegree : options.metresPerUnit};
        const bool replaces = !rotation && !adds;
        rest.push_back(replaces ? joint.parentFromZero.translation()[c.axis] : 0.0);
        if (replaces) joint.parentFromZero.translation()[c.axis] = 0.0;
      }
    if (!joint.parentFromZero.matrix().allFinite())
      throw ParseError(file, node.line, "offsets that are finite in metres",
                       "an overflow at joint '" + node.name + "'");
    joints.push_back(std::move(joint));
  }
  result.skeleton = Skeleton(std::move(joints), Eigen::Map<const Eigen::VectorXd>(rest.data(), rest.size()));
  result.clip.framesPerSecond = 1.0 / frameTime;
  result.clip.q.resize(result.skeleton.nq(), frames);
  for (int f = 0; f < frames; ++f)
    for (int c = 0; c < channelCount; ++c)
      result.clip.q(targets[c].qIndex, f) =
          targets[c].scale * values[static_cast<std::size_t>(f) * channelCount + c];
  if (!result.clip.q.allFinite())
    throw ParseError(file, 0, "values that are finite in metres", "an overflow");
  return result;
}

BvhMotion readBvh(const std::string& path, const BvhOptions& options) {
  return parseBvh(readFile(path), path, options);
}

namespace {

/// How one joint is written.
struct Plan {
  bool end = false;
  bool positions = false;
  bool keepsAngles = false;           ///< angles of q are written as they are
  std::vector<int> axes = {2, 0, 1};  ///< of the rotation channels: 0, 1, 2 for x, y, z
  std::vector<int> qOfAngle;          ///< of the first channels; the others are zero
};

Plan planJoint(const Skeleton& skeleton, const Frames& rest, int i) {
  const Joint& joint = skeleton.joint(i);
  Plan plan;
  plan.end = i > 0 && skeleton.qCount(i) == 0 && skeleton.children(i).empty();
  plan.positions = i == 0;
  bool coordinateAxes = rest[i].linear() == Eigen::Matrix3d::Identity() && !joint.ball;
  std::vector<int> axes, qOfAngle;
  for (std::size_t k = 0; k < joint.axes.size(); ++k) {
    const AxisDof& dof = joint.axes[k];
    if (dof.kind == AxisDof::Kind::Translation) {
      plan.positions = true;
      if (!axes.empty()) coordinateAxes = false;  // a translation after a rotation
      continue;
    }
    int axis = -1;
    for (int a = 0; a < 3; ++a)
      if (dof.axis == Vector3d::Unit(a)) axis = a;
    for (const int other : axes)
      if (other == axis) axis = -1;
    if (axis < 0 || skeleton.rest()[skeleton.qIndex(i) + k] != 0.0) coordinateAxes = false;
    axes.push_back(axis);
    qOfAngle.push_back(skeleton.qIndex(i) + static_cast<int>(k));
  }
  plan.keepsAngles = coordinateAxes && !axes.empty() && axes.size() <= 3;
  if (!plan.keepsAngles) return plan;
  for (int axis = 0; axis < 3; ++axis)  // Blender reads three rotations or none
    if (std::find(axes.begin(), axes.end(), axis) == axes.end()) axes.push_back(axis);
  plan.axes = axes, plan.qOfAngle = qOfAngle;
  return plan;
}

/// Shortest text that reads back as the same double, without an exponent: not every reader knows one.
std::string plainNumber(double value) {
  char buffer[400];
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed);
  return std::string(buffer, end);
}

std::string triple(const Vector3d& v) {
  return plainNumber(v.x()) + ' ' + plainNumber(v.y()) + ' ' + plainNumber(v.z());
}

/// Names as one word each: blanks and braces, which other readers cut at, become '_'.
std::vector<std::string> wordNames(const Skeleton& skeleton) {
  std::vector<std::string> names;
  std::unordered_set<std::string> taken;
  for (const Joint& joint : skeleton.joints()) {
    std::string name = joint.name;
    for (char& c : name)
      if (std::isspace(static_cast<unsigned char>(c)) || c == '{' || c == '}') c = '_';
    while (!taken.insert(name).second) name += '_';
    names.push_back(name);
  }
  return names;
}

/// The offset from the parent's place, in the parent's bind frame turned to the world: what OFFSET and
/// position channels hold.
Vector3d localPosition(const Skeleton& skeleton, const Frames& rest, const Frames& frames, int i) {
  const int parent = skeleton.parent(i);
  if (parent < 0) return frames[i].translation();
  return rest[parent].linear() *
         (frames[parent].linear().transpose() * (frames[i].translation() - frames[parent].translation()));
}

void hierarchy(const Skeleton& skeleton, const Frames& rest, const std::vector<Plan>& plans,
               double metresPerUnit, std::string& text, std::vector<int>& order) {
  struct Step {
    int joint;
    int depth;
    bool closing;
  };
  std::vector<Step> open{{0, 0, false}};
  const std::vector<std::string> names = wordNames(skeleton);
  text += "HIERARCHY\n";
  while (!open.empty()) {
    const Step step = open.back();
    open.pop_back();
    const std::string indent(std::min(step.depth, 40), '\t');
    if (step.closing) {
      text += indent + "}\n";
      continue;
    }
    const Plan& plan = plans[step.joint];
    // Position channels replace OFFSET in some programs and are added to it in others: the same where it is
    // 0.
    const Vector3d offset =
        plan.positions ? Vector3d(Vector3d::Zero()) : localPosition(skeleton, rest, rest, step.joint);
    text += indent +
            (step.joint == 0 ? "ROOT "
             : plan.end      ? "End Site"
                             : "JOINT ") +
            (plan.end ? "" : names[step.joint]) + '\n' + indent + "{\n" + indent + "\tOFFSET " +
            triple(offset / metresPerUnit) + '\n';
    if (!plan.end) {
      order.push_back(step.joint);
      text += indent + "\tCHANNELS " + std::to_string(plan.axes.size() + (plan.positions ? 3 : 0));
      if (plan.positions) text += " Xposition Yposition Zposition";
      for (const int axis : plan.axes) text += std::string(" ") + "XYZ"[axis] + "rotation";
      text += '\n';
    }
    open.push_back({step.joint, step.depth, true});
    const auto& children = skeleton.children(step.joint);
    for (auto child = children.rbegin(); child != children.rend(); ++child)
      open.push_back({*child, step.depth + 1, false});
  }
}

}  // namespace

std::string formatBvh(const Skeleton& given, const MotionClip& givenClip, double metresPerUnit) {
  // Programs differ about position channels of inner joints: the fewer of them the better.
  const auto [skeleton, clip, still] = withoutStillTranslations(given, givenClip);
  const Frames rest = restFrames(skeleton);
  std::vector<Plan> plans;
  for (int i = 0; i < skeleton.jointCount(); ++i) plans.push_back(planJoint(skeleton, rest, i));
  std::string text;
  std::vector<int> order;
  hierarchy(skeleton, rest, plans, metresPerUnit, text, order);
  text += "MOTION\nFrames: " + std::to_string(clip.frameCount()) +
          "\nFrame Time: " + plainNumber(1.0 / clip.framesPerSecond) + '\n';

  std::vector<Vector3d> angles(skeleton.jointCount(),
                               Vector3d::Zero());  // the hint that keeps angles continuous
  Frames frames;
  for (int f = 0; f < clip.frameCount(); ++f) {
    const Eigen::VectorXd q = clip.q.col(f);
    forwardKinematics(skeleton, q, frames);
    std::string line;
    for (const int i : order) {
      const Plan& plan = plans[i];
      if (plan.positions) line += ' ' + triple(localPosition(skeleton, rest, frames, i) / metresPerUnit);
      if (plan.keepsAngles) {
        for (const int at : plan.qOfAngle) line += ' ' + plainNumber(q[at] / radiansPerDegree);
        for (std::size_t k = plan.qOfAngle.size(); k < 3; ++k) line += " 0";
        continue;
      }
      // worldTurn = worldFromJoint restFromWorld: the turn from the bind pose, in the world; BVH wants it
      // relative to the parent's.
      const Quaterniond turn(frames[i].linear() * rest[i].linear().transpose());
      const int parent = skeleton.parent(i);
      const Quaterniond parentTurn =
          parent < 0 ? Quaterniond::Identity()
                     : Quaterniond(frames[parent].linear() * rest[parent].linear().transpose());
      angles[i] = eulerAngles(parentTurn.conjugate() * turn, Vector3d::Unit(plan.axes[0]),
                              Vector3d::Unit(plan.axes[1]), Vector3d::Unit(plan.axes[2]), angles[i]);
      line += ' ' + triple(angles[i] / radiansPerDegree);
    }
    text.append(line, 1).push_back('\n');
  }
  return text;
}

}  // namespace gelenk
