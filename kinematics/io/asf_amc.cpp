#include "kinematics/io/asf_amc.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <stdexcept>

#include "kinematics/forward_kinematics.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "kinematics/io/word_stream.h"

namespace gelenk {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double metresPerInch = 0.0254;

/// One dof of a bone: r/t and the coordinate axis 0, 1, 2.
struct DofName {
  bool rotation;
  int axis;  ///< -1: the length, dof l
  bool isLength() const { return axis < 0; }
};

/// A bone as the file describes it, in file units.
struct BoneBlock {
  std::string name;
  int line = 0;
  std::optional<Vector3d> direction;
  std::optional<double> length;
  Vector3d axis = Vector3d::Zero();
  std::string order = "xyz";
  std::vector<DofName> dofs;
  std::vector<double> limits;  ///< lower and upper of each dof; none: unlimited
};

struct AsfFile {
  double lengthUnit = 1.0;
  double radiansPerUnit = M_PI / 180.0;
  std::string name;
  BoneBlock root;
  Vector3d rootPosition = Vector3d::Zero();
  bool hasRoot = false, hasBones = false, hasHierarchy = false;
  std::vector<BoneBlock> bones;
  std::map<std::string, int> boneByName;   ///< lower case; -1 is the root
  std::vector<std::vector<int>> children;  ///< of bone i at i + 1; of the root at 0
  std::vector<bool> hasParent;
  std::vector<Note> notes;
};

Vector3d vector3(WordStream& words) {
  const double x = words.number(), y = words.number(), z = words.number();
  return {x, y, z};
}

/// "XYZ" and the like: which axis is turned about first, second, third.
std::string rotationOrder(WordStream& words) {
  const std::string order = lowerCase(words.peek());
  std::string sorted = order;
  std::sort(sorted.begin(), sorted.end());
  if (sorted != "xyz") words.fail("an order of the axes such as XYZ");
  words.next("");
  return order;
}

DofName dofName(WordStream& words) {
  const std::string word = lowerCase(words.peek());
  if (word == "l") {
    words.next("");
    return {false, -1};
  }
  if (word.size() != 2 || (word[0] != 'r' && word[0] != 't') || word[1] < 'x' || word[1] > 'z')
    words.fail("a degree of freedom among rx ry rz tx ty tz");
  words.next("");
  return {word[0] == 'r', word[1] - 'x'};
}

bool isDofName(std::string_view word) {
  const std::string w = lowerCase(word);
  return w == "l" || (w.size() == 2 && (w[0] == 'r' || w[0] == 't') && w[1] >= 'x' && w[1] <= 'z');
}

std::vector<DofName> dofList(WordStream& words) {
  std::vector<DofName> dofs;
  while (isDofName(words.peek())) {
    const DofName dof = dofName(words);
    for (const DofName& other : dofs)
      if (other.rotation == dof.rotation && other.axis == dof.axis)
        words.failTaken("each degree of freedom once",
                        dof.isLength()
                            ? std::string("a second l")
                            : std::string("a second ") + (dof.rotation ? "r" : "t") + "xyz"[dof.axis]);
    dofs.push_back(dof);
  }
  return dofs;
}

/// A limit, which may be infinite.
double limit(WordStream& words) {
  const std::string word = lowerCase(words.peek());
  if (word == "inf" || word == "+inf") return words.next(""), unlimited;
  if (word == "-inf") return words.next(""), -unlimited;
  return words.number("a limit, a number or inf");
}

/// True where a number or an infinity comes next; letters begin the block's next entry.
bool isLimit(std::string_view word) {
  return !word.empty() &&
         (sameWord(word, "inf") || word.find_first_of("0123456789+-") == 0 || word.front() == '.');
}

void parseUnits(WordStream& words, AsfFile& file) {
  while (!words.atEnd() && words.peek().front() != ':') {
    if (words.take("mass")) {
      words.number();
    } else if (words.take("length")) {
      file.lengthUnit = words.number();
      if (!(file.lengthUnit > 0.0)) words.failTaken("a length unit above 0", exactNumber(file.lengthUnit));
    } else if (words.take("angle")) {
      if (words.take("deg"))
        file.radiansPerUnit = M_PI / 180.0;
      else if (words.take("rad"))
        file.radiansPerUnit = 1.0;
      else
        words.fail("the angle unit deg or rad");
    } else {
      words.fail("mass, length or angle");
    }
  }
}

void parseRoot(WordStream& words, AsfFile& file) {
  file.root.name = "root";
  file.root.line = words.lineTaken();
  file.hasRoot = true;
  while (!words.atEnd() && words.peek().front() != ':') {
    if (words.take("order"))
      file.root.dofs = dofList(words);
    else if (words.take("axis"))
      file.root.order = rotationOrder(words);
    else if (words.take("position"))
      file.rootPosition = vector3(words);
    else if (words.take("orientation"))
      file.root.axis = vector3(words);
    else
      words.fail("order, axis, position or orientation");
  }
}

BoneBlock parseBone(WordStream& words, std::vector<Note>& notes) {
  BoneBlock bone;
  bone.line = words.lineTaken();
  while (!words.take("end")) {
    if (words.take("id")) {
      words.next("the bone's id");
    } else if (words.take("name")) {
      bone.name = std::string(words.next("the bone's name"));
      bone.line = words.lineTaken();
    } else if (words.take("direction")) {
      bone.direction = vector3(words);
      const double length = bone.direction->norm();
      if (length != 0.0 && std::abs(length - 1.0) > 0.01)
        words.failTaken("a direction of unit length", "length " + exactNumber(length));
    } else if (words.take("length")) {
      bone.length = words.number();
      if (!(*bone.length >= 0.0)) words.failTaken("a length of at least 0", exactNumber(*bone.length));
    } else if (words.take("axis")) {
      bone.axis = vector3(words);
      bone.order = rotationOrder(words);
    } else if (words.take("dof")) {
      bone.dofs = dofList(words);
      if (bone.dofs.empty()) words.fail("degrees of freedom after dof");
    } else if (words.take("limits")) {
      while (isLimit(words.peek())) {
        const double lower = limit(words), upper = limit(words);
        if (lower > upper)
          words.failTaken("limits with lower <= upper", exactNumber(lower) + " and " + exactNumber(upper));
        bone.limits.insert(bone.limits.end(), {lower, upper});
      }
    } else if (words.take("bodymass") || words.take("cofmass")) {
      words.number();
    } else {
      words.fail("id, name, direction, length, axis, dof, limits or end");
    }
  }
  if (bone.name.empty()) words.failTaken("a name in the bone's block", "none");
  if (!bone.direction) words.failTaken("a direction in the block of '" + bone.name + "'", "none");
  if (!bone.length) words.failTaken("a length in the block of '" + bone.name + "'", "none");
  if (bone.direction->norm() == 0.0 && *bone.length > 0.0)
    words.failTaken("a direction for the bone '" + bone.name + "' of positive length", "0 0 0");
  if (!bone.limits.empty() && bone.limits.size() != 2 * bone.dofs.size()) {
    tell(notes, "limits-count",
         "bone '" + bone.name + "' has " + std::to_string(bone.limits.size() / 2) + " limits for " +
             std::to_string(bone.dofs.size()) + " degrees of freedom: passed over");
    bone.limits.clear();
  }
  return bone;
}

void parseBones(WordStream& words, AsfFile& file) {
  file.hasBones = true;
  while (!words.atEnd() && words.peek().front() != ':') {
    words.expect("begin");
    BoneBlock bone = parseBone(words, file.notes);
    const auto [at, isNew] =
        file.boneByName.emplace(lowerCase(bone.name), static_cast<int>(file.bones.size()));
    if (!isNew)
      throw ParseError(words.file(), bone.line, "a bone name that is used once", "'" + bone.name + "' again");
    file.bones.push_back(std::move(bone));
  }
  file.children.resize(file.bones.size() + 1);
  file.hasParent.resize(file.bones.size(), false);
}

void parseHierarchy(WordStream& words, AsfFile& file) {
  if (!file.hasBones) words.failTaken(":bonedata before :hierarchy", "none");
  file.hasHierarchy = true;
  words.expect("begin");
  while (!words.take("end")) {
    const auto bone = [&](const std::string& what) {
      const auto found = file.boneByName.find(lowerCase(words.peek()));
      if (found == file.boneByName.end()) words.fail(what);
      words.next("");
      return found->second;
    };
    const int parent = bone("the name of a bone, root or end");
    while (words.sameLine()) {
      const int child =
          bone("the name of a bone that hangs on '" + (parent < 0 ? "root" : file.bones[parent].name) + "'");
      if (child < 0) words.failTaken("a bone as child", "the root");
      if (file.hasParent[child])
        words.failTaken("one parent a bone", "a second one for '" + file.bones[child].name + "'");
      file.hasParent[child] = true;
      file.children[parent + 1].push_back(child);
    }
  }
}

AsfFile parseSections(std::string_view text, const std::string& fileName) {
  WordStream words(text, fileName, "(),", '#');
  AsfFile file;
  file.boneByName["root"] = -1;
  while (!words.atEnd()) {
    if (words.take(":version") || words.take(":skin") || words.take(":documentation")) {
      while (!words.atEnd() && words.peek().front() != ':') words.skipLine();
    } else if (words.take(":name")) {
      while (words.sameLine()) file.name += (file.name.empty() ? "" : " ") + std::string(words.next(""));
    } else if (words.take(":units")) {
      parseUnits(words, file);
    } else if (words.take(":root")) {
      parseRoot(words, file);
    } else if (words.take(":bonedata")) {
      if (file.hasBones) words.failTaken("one section :bonedata", "a second one");
      parseBones(words, file);
    } else if (words.take(":hierarchy")) {
      if (file.hasHierarchy) words.failTaken("one section :hierarchy", "a second one");
      parseHierarchy(words, file);
    } else {
      words.fail("a section such as :units, :root, :bonedata or :hierarchy");
    }
  }
  if (!file.hasRoot) throw ParseError(fileName, 0, "a section :root", "none");
  if (!file.hasBones || file.bones.empty())
    throw ParseError(fileName, 0, "a section :bonedata with bones", "none");
  if (!file.hasHierarchy) throw ParseError(fileName, 0, "a section :hierarchy", "none");
  return file;
}

/// Rotation by `angles` (radians) about x, y, z in the named order, the first letter innermost: for "xyz" Rz
/// Ry Rx.
Quaterniond eulerRotation(const Vector3d& angles, const std::string& order) {
  Quaterniond rotation = Quaterniond::Identity();
  for (const char letter : order)
    rotation = Quaterniond(Eigen::AngleAxisd(angles[letter - 'x'], Vector3d::Unit(letter - 'x'))) * rotation;
  return rotation;
}

/// The joint's axes for a block's dofs: translations first, along the axes of the parent's world; then the
/// rotations about fixed axes in the order of the dofs, so that the last is outermost. from[k]: which dof of
/// the block axis k is.
void addAxes(const BoneBlock& block, const Matrix3d& axesOfTranslation, double metresPerUnit,
             double radiansPerUnit, Joint& joint, std::vector<int>& from) {
  const auto add = [&](int d) {
    const DofName dof = block.dofs[d];
    const double scale = dof.rotation ? radiansPerUnit : metresPerUnit;
    AxisDof axis{.kind = dof.rotation ? AxisDof::Kind::Rotation : AxisDof::Kind::Translation,
                 .axis = dof.rotation ? Vector3d(Vector3d::Unit(dof.axis))
                                      : Vector3d(axesOfTranslation.col(dof.axis).normalized())};
    if (!block.limits.empty())
      axis.lower = scale * block.limits[2 * d], axis.upper = scale * block.limits[2 * d + 1];
    joint.axes.push_back(axis);
    from.push_back(d);
  };
  const int count = static_cast<int>(block.dofs.size());
  for (int d = 0; d < count; ++d)
    if (!block.dofs[d].rotation && !block.dofs[d].isLength()) add(d);
  for (int d = count - 1; d >= 0; --d)
    if (block.dofs[d].rotation) add(d);
}

/// True where the dofs turn in another order than the letters after `axis` name.
bool turnsInOwnOrder(const BoneBlock& block) {
  std::size_t last = 0;
  for (const DofName& dof : block.dofs) {
    if (!dof.rotation) continue;
    const std::size_t place = block.order.find(static_cast<char>('x' + dof.axis));
    if (place < last) return true;
    last = place;
  }
  return false;
}

class Builder {
 public:
  Builder(const AsfFile& file, const std::string& fileName, double metresPerUnit)
      : file_(file), fileName_(fileName) {
    result_.metresPerUnit = metresPerUnit;
    result_.radiansPerUnit = file.radiansPerUnit;
    result_.name = file.name;
  }

  AsfSkeleton build() {
    addBone(file_.root, -1);
    joints_[0].parentFromZero.translation() = result_.metresPerUnit * file_.rootPosition;
    // Depth first, children in the file's order.
    std::vector<std::pair<int, int>> open;  // bone of the file, joint of its parent
    const auto push = [&](int bone, int joint) {
      const auto& list = file_.children[bone + 1];
      for (auto child = list.rbegin(); child != list.rend(); ++child) open.emplace_back(*child, joint);
    };
    push(-1, 0);
    while (!open.empty()) {
      const auto [bone, parent] = open.back();
      open.pop_back();
      push(bone, addBone(file_.bones[bone], parent));
    }
    if (joints_.size() != file_.bones.size() + 1) rejectUnconnected();
    addEnds();
    result_.skeleton = Skeleton(std::move(joints_));
    result_.notes = file_.notes;
    std::vector<std::string> ownOrder;
    for (AsfSkeleton::Bone& bone : result_.bones) {
      const BoneBlock& block = *blocks_[bone.joint];
      if (turnsInOwnOrder(block)) ownOrder.push_back(bone.name);
      bone.channels.resize(block.dofs.size(), {.qIndex = -1, .scale = 0.0, .rotation = false});
      if (std::any_of(block.dofs.begin(), block.dofs.end(), [](const DofName& d) { return d.isLength(); }))
        tell(result_.notes, "length-dof",
             "bone '" + bone.name + "' changes its length (dof l), which is passed over");
      for (std::size_t k = 0; k < dofOfAxis_[bone.joint].size(); ++k) {
        const int d = dofOfAxis_[bone.joint][k];
        bone.channels[d] = {result_.skeleton.qIndex(bone.joint) + static_cast<int>(k),
                            block.dofs[d].rotation ? file_.radiansPerUnit : result_.metresPerUnit,
                            block.dofs[d].rotation};
      }
    }
    if (!ownOrder.empty())
      tellFact(result_.notes, "rotation-order",
               "bones turn in the order of their dofs, which is not that of the letters after 'axis': " +
                   listed(ownOrder));
    return std::move(result_);
  }

 private:
  int addBone(const BoneBlock& block, int parent) {
    const int index = static_cast<int>(joints_.size());
    AsfSkeleton::Bone bone{.name = block.name, .joint = index, .endJoint = index, .channels = {}};
    bone.axis = eulerRotation(file_.radiansPerUnit * block.axis, block.order);
    if (parent >= 0) {
      bone.length = result_.metresPerUnit * *block.length;
      bone.direction = *block.direction;
    }
    Joint joint{.name = block.name, .parent = parent};
    Quaterniond parentFromWorld = Quaterniond::Identity();
    if (parent >= 0) {
      const AsfSkeleton::Bone& above = result_.bones[parent];
      parentFromWorld = above.axis.conjugate();
      joint.parentFromZero.translation() = parentFromWorld * (above.length * above.direction);
    }
    joint.parentFromZero.linear() = (parentFromWorld * bone.axis).normalized().toRotationMatrix();
    if (!joint.parentFromZero.matrix().allFinite())
      throw ParseError(fileName_, block.line, "finite lengths and angles",
                       "an overflow at bone '" + block.name + "'");
    std::vector<int> from;
    addAxes(block, bone.axis.toRotationMatrix().transpose(), result_.metresPerUnit, file_.radiansPerUnit,
            joint, from);
    joints_.push_back(std::move(joint));
    result_.bones.push_back(std::move(bone));
    blocks_.push_back(&block);
    dofOfAxis_.push_back(std::move(from));
    return index;
  }

  /// Leaf bones get a fixed joint at their end.
  void addEnds() {
    const int boneCount = static_cast<int>(joints_.size());
    std::vector<int> firstChild(boneCount, -1);
    for (int i = boneCount - 1; i > 0; --i) firstChild[joints_[i].parent] = i;
    for (int i = 1; i < boneCount; ++i) {
      AsfSkeleton::Bone& bone = result_.bones[i];
      bone.endJoint = firstChild[i];
      if (bone.endJoint >= 0) continue;
      std::string name = bone.name + "_end";
      while (file_.boneByName.count(lowerCase(name))) name += "_";
      Joint end{.name = name, .parent = i};
      end.parentFromZero.translation() = bone.axis.conjugate() * (bone.length * bone.direction);
      if (!end.parentFromZero.matrix().allFinite())
        throw ParseError(fileName_, blocks_[i]->line, "a finite length",
                         "an overflow at bone '" + bone.name + "'");
      bone.endJoint = static_cast<int>(joints_.size());
      joints_.push_back(std::move(end));
    }
  }

  [[noreturn]] void rejectUnconnected() const {
    for (std::size_t i = 0; i < file_.bones.size(); ++i)
      if (!file_.hasParent[i])
        throw ParseError(fileName_, file_.bones[i].line, "a parent in :hierarchy for every bone",
                         "none for '" + file_.bones[i].name + "'");
    std::vector<bool> reached(file_.bones.size(), false);
    for (const BoneBlock* block : blocks_)
      if (block != &file_.root) reached[block - file_.bones.data()] = true;
    const auto lost = std::find(reached.begin(), reached.end(), false) - reached.begin();
    throw ParseError(fileName_, file_.bones[lost].line, "a bone that hangs on the root",
                     "'" + file_.bones[lost].name + "' in a cycle of :hierarchy");
  }

  const AsfFile& file_;
  const std::string& fileName_;
  AsfSkeleton result_;
  std::vector<Joint> joints_;
  std::vector<const BoneBlock*> blocks_;
  std::vector<std::vector<int>> dofOfAxis_;
};

}  // namespace

double asfMetresPerUnit(double lengthUnit) { return metresPerInch / lengthUnit; }

std::optional<int> AsfSkeleton::findBone(std::string_view boneName) const {
  for (std::size_t b = 0; b < bones.size(); ++b)
    if (sameWord(bones[b].name, boneName)) return static_cast<int>(b);
  return std::nullopt;
}

AsfSkeleton parseAsf(std::string_view text, const std::string& file, std::optional<double> metresPerUnit) {
  const AsfFile sections = parseSections(text, file);
  return Builder(sections, file, metresPerUnit ? *metresPerUnit : asfMetresPerUnit(sections.lengthUnit))
      .build();
}

AsfSkeleton readAsf(const std::string& path, std::optional<double> metresPerUnit) {
  return parseAsf(readFile(path), path, metresPerUnit);
}

namespace {

/// Reads frames straight from the characters: an AMC is read at about the speed of from_chars.
class AmcReader {
 public:
  AmcReader(std::string_view text, const std::string& file, const AsfSkeleton& asf)
      : rest_(plainText(text, file)), file_(file), asf_(asf) {
    for (std::size_t b = 0; b < asf.bones.size(); ++b) {
      boneByName_[lowerCase(asf.bones[b].name)] = static_cast<int>(b);
      expectedBones_ += !asf.bones[b].channels.empty();
    }
    lastFrameOfBone_.assign(asf.bones.size(), -1);
  }

  /// Notes of bones that only the skeleton, or only the motion has go to `notes`, where that is not null.
  MotionClip read(double framesPerSecond, std::vector<Note>* notes) {
    notes_ = notes;
    while (nextLine()) {
      const std::string_view first = nextWord();
      if (first.empty()) continue;
      if (first.front() == ':')
        header(first, framesPerSecond);
      else if (const auto number = parseInteger(first); number && nextWord().empty())
        beginFrame(*number);
      else
        boneLine(first);
    }
    if (frames_ == 0) throw ParseError(file_, 0, "at least one frame", "none");
    endFrame();
    tellOtherBones();
    MotionClip clip{.framesPerSecond = framesPerSecond, .q = {}};
    clip.q = Eigen::Map<const Eigen::MatrixXd>(values_.data(), asf_.skeleton.nq(), frames_);
    return clip;
  }

 private:
  [[noreturn]] void fail(const std::string& expected, const std::string& found) const {
    throw ParseError(file_, line_, expected, found);
  }

  static bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v'; }

  bool nextLine() {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find('\n');
    lineRest_ = rest_.substr(0, end);
    for (std::size_t at = lineRest_.find('#'); at != std::string_view::npos; at = lineRest_.find('#', at + 1))
      if (at == 0 || isBlank(lineRest_[at - 1])) lineRest_ = lineRest_.substr(0, at);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    ++line_;
    wholeLine_ = lineRest_;
    return true;
  }

  std::string_view nextWord() {
    std::size_t at = 0;
    while (at < lineRest_.size() && isBlank(lineRest_[at])) ++at;
    std::size_t end = at;
    while (end < lineRest_.size() && !isBlank(lineRest_[end])) ++end;
    const std::string_view word = lineRest_.substr(at, end - at);
    lineRest_.remove_prefix(end);
    return word;
  }

  void header(std::string_view keyword, double& framesPerSecond) {
    if (sameWord(keyword, ":DEGREES")) {
      radiansPerUnit_ = M_PI / 180.0;
    } else if (sameWord(keyword, ":RADIANS")) {
      radiansPerUnit_ = 1.0;
    } else if (sameWord(keyword, ":SAMPLES-PER-SECOND")) {
      const std::string_view word = nextWord();
      const auto rate = parseNumber(word);
      if (!rate || !(*rate > 0.0)) fail("a positive rate", "'" + std::string(word) + "'");
      framesPerSecond = *rate;
    } else if (!sameWord(keyword, ":FULLY-SPECIFIED")) {
      fail(":FULLY-SPECIFIED, :DEGREES or :RADIANS", "'" + std::string(keyword) + "'");
    }
    if (frames_ > 0) fail("header lines before the first frame", "'" + std::string(keyword) + "'");
  }

  void beginFrame(int number) {
    if (frames_ > 0) {
      endFrame();
      if (number != frameNumber_ + 1)
        fail("frame " + std::to_string(frameNumber_ + 1), std::to_string(number));
    }
    frameNumber_ = number;
    ++frames_;
    bonesInFrame_ = 0;
    const std::size_t nq = asf_.skeleton.nq();
    values_.resize(nq * frames_, 0.0);
    frame_ = values_.data() + nq * (frames_ - 1);
  }

  /// The first frame says which bones the motion has.
  void endFrame() {
    if (frames_ == 1 && lastFrameOfBone_[0] == 1 && bonesInFrame_ < expectedBones_) {
      if (!strangers_.empty()) failStranger(strangers_.begin()->second, strangers_.begin()->first);
      absent_.resize(asf_.bones.size());
      for (std::size_t b = 0; b < absent_.size(); ++b)
        absent_[b] = !asf_.bones[b].channels.empty() && lastFrameOfBone_[b] != 1;
      expectedBones_ = bonesInFrame_;
    }
    if (bonesInFrame_ == expectedBones_) return;
    for (std::size_t b = 0; b < asf_.bones.size(); ++b)
      if (!asf_.bones[b].channels.empty() && lastFrameOfBone_[b] != frames_ && !isAbsent(b))
        fail("a line for each bone with degrees of freedom",
             "no '" + asf_.bones[b].name + "' in frame " + std::to_string(frameNumber_));
  }

  bool isAbsent(std::size_t bone) const { return bone < absent_.size() && absent_[bone]; }

  void tellOtherBones() {
    if (!notes_) return;
    std::vector<std::string> words;
    for (std::size_t b = 0; b < absent_.size(); ++b)
      if (absent_[b]) words.push_back(asf_.bones[b].name);
    if (!words.empty())
      tell(*notes_, "bones-missing",
           "bones that the motion does not have stay in their zero pose: " + listed(words),
           static_cast<int>(words.size()));
    words.clear();
    for (const auto& [name, line] : strangers_) words.push_back(name);
    if (!words.empty())
      tell(*notes_, "bones-unknown",
           "bones that the skeleton does not have are passed over: " + listed(words),
           static_cast<int>(words.size()));
  }

  [[noreturn]] void failStranger(int line, const std::string& name) const {
    throw ParseError(file_, line, "the name of a bone of the skeleton or a frame number", "'" + name + "'");
  }

  /// A bone that the skeleton does not have: passed over where the first frame has it, which needs all of the
  /// skeleton's too, or the motion is another skeleton's.
  void strangerLine(std::string_view name) {
    const std::string word(name);
    if (frames_ == 1)
      strangers_.try_emplace(word, line_);
    else if (!strangers_.contains(word))
      failStranger(line_, word);
    std::string_view value = nextWord();
    if (value.empty()) failStranger(line_, word);
    for (; !value.empty(); value = nextWord())
      if (!parseNumber(value)) fail("a finite number", badNumber(value));
  }

  /// Bones mostly come in the same order in every frame: the guess is the bone that followed last time.
  /// -1: the skeleton has no such bone.
  int boneIndex(std::string_view name) {
    if (guess_ < sequence_.size() && asf_.bones[sequence_[guess_]].name == name) return sequence_[guess_++];
    const auto found = boneByName_.find(lowerCase(name));
    if (found == boneByName_.end()) return -1;
    if (frames_ == 1) sequence_.push_back(found->second), guess_ = sequence_.size();
    for (std::size_t k = 0; k < sequence_.size(); ++k)
      if (sequence_[k] == found->second) guess_ = k + 1;
    return found->second;
  }

  void boneLine(std::string_view name) {
    if (frames_ == 0) fail("a frame number before the first bone", "'" + std::string(name) + "'");
    if (bonesInFrame_ == 0) guess_ = 0;
    lineRest_ = wholeLine_;
    nextWord();
    const int index = boneIndex(name);
    if (index < 0) return strangerLine(name);
    const AsfSkeleton::Bone& bone = asf_.bones[index];
    if (isAbsent(index))
      fail("the bones that the first frame has",
           "'" + bone.name + "' in frame " + std::to_string(frameNumber_));
    if (lastFrameOfBone_[index] == frames_) fail("each bone once in a frame", "'" + bone.name + "' again");
    lastFrameOfBone_[index] = frames_;
    bonesInFrame_ += !bone.channels.empty();
    for (std::size_t k = 0;; ++k) {
      const std::string_view word = nextWord();
      if (word.empty() != (k == bone.channels.size()))
        fail(std::to_string(bone.channels.size()) + " values for bone '" + bone.name + "'",
             word.empty() ? std::to_string(k) : "more");
      if (word.empty()) return;
      const auto value = parseNumber(word);
      if (!value) fail("a finite number", badNumber(word));
      const AsfSkeleton::Channel& channel = bone.channels[k];
      if (channel.qIndex < 0) continue;
      frame_[channel.qIndex] =
          (channel.rotation && radiansPerUnit_ ? *radiansPerUnit_ : channel.scale) * *value;
      if (!std::isfinite(frame_[channel.qIndex]))
        fail("a value that is finite in metres", "'" + std::string(word) + "'");
    }
  }

  std::string_view rest_, lineRest_, wholeLine_;
  const std::string& file_;
  const AsfSkeleton& asf_;
  std::map<std::string, int> boneByName_;
  std::vector<int> lastFrameOfBone_, sequence_;
  std::vector<char> absent_;              ///< bones that the first frame lacks
  std::map<std::string, int> strangers_;  ///< names that the skeleton lacks, and their first lines
  std::vector<Note>* notes_ = nullptr;
  std::size_t guess_ = 0;
  std::optional<double> radiansPerUnit_;
  std::vector<double> values_;
  double* frame_ = nullptr;
  int line_ = 0, frames_ = 0, frameNumber_ = 0, bonesInFrame_ = 0, expectedBones_ = 0;
};

}  // namespace

MotionClip parseAmc(std::string_view text, const std::string& file, const AsfSkeleton& asf,
                    double framesPerSecond, std::vector<Note>* notes) {
  return AmcReader(text, file, asf).read(framesPerSecond, notes);
}

MotionClip readAmc(const std::string& path, const AsfSkeleton& asf, double framesPerSecond,
                   std::vector<Note>* notes) {
  return parseAmc(readFile(path), path, asf, framesPerSecond, notes);
}

}  // namespace gelenk
