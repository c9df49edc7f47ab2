#include "kinematics/io/urdf.h"

#include <tinyxml.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "kinematics/configuration.h"
#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// The library reads elements by recursion: a limit before it begins. Comments and attributes may fool the
/// count upwards only by what they hold.
void checkNesting(std::string_view text, const std::string& file) {
  constexpr int deepest = 200;
  int depth = 0, line = 1;
  for (std::size_t i = 0; i < text.size(); ++i) {
    line += text[i] == '\n';
    if (text[i] != '<' || i + 1 == text.size()) continue;
    if (text[i + 1] == '/') {
      --depth;
    } else if (text[i + 1] != '!' && text[i + 1] != '?') {
      ++depth;
      const std::size_t end = text.find('>', i);
      if (end != std::string_view::npos && text[end - 1] == '/') --depth;
    }
    if (depth > deepest)
      throw ParseError(file, line, "elements nested at most " + std::to_string(deepest) + " deep", "more");
  }
}

/// The library reads beyond the end of a text whose last character is cut off, so only whole characters get
/// there.
void checkUtf8(std::string_view text, const std::string& file) {
  int line = 1;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i]);
    line += byte == '\n';
    const std::size_t length = byte < 0x80                   ? 1
                               : byte >= 0xc2 && byte < 0xe0 ? 2
                               : byte >= 0xe0 && byte < 0xf0 ? 3
                               : byte >= 0xf0 && byte < 0xf5 ? 4
                                                             : 0;
    bool whole = byte != 0 && length > 0 && text.size() - i >= length;
    for (std::size_t k = 1; whole && k < length; ++k)
      whole = (static_cast<unsigned char>(text[i + k]) & 0xc0) == 0x80;
    if (!whole) throw ParseError(file, line, "text in UTF-8", "byte " + std::to_string(byte));
    i += length;
  }
}

struct Link {
  int line = 0;
  std::vector<const TiXmlElement*> visuals;
  const TiXmlElement* inertial = nullptr;
  int parentJoint = -1;
};

struct JointElement {
  const TiXmlElement* element;
  std::string name, type, parent, child;
  bool placed = false;
  int index = -1;  ///< in the skeleton
};

class Reader {
 public:
  Reader(std::string_view text, const std::string& file) : file_(file) {
    checkNesting(text, file);
    checkUtf8(text, file);
    document_.Parse(std::string(text).c_str(), nullptr, TIXML_ENCODING_UTF8);
    if (document_.Error())
      throw ParseError(file, std::max(0, document_.ErrorRow()), "well-formed XML",
                       lowerFirst(document_.ErrorDesc()));
    if (!document_.RootElement()) throw ParseError(file, 0, "an element <robot>", "none");
  }

  UrdfRobot read() {
    const TiXmlElement* robot = document_.RootElement();
    if (robot->ValueStr() != "robot") fail(robot, "an element <robot>", "<" + robot->ValueStr() + ">");
    if (const char* name = robot->Attribute("name")) robot_.name = name;
    collect(robot);
    build();
    return std::move(robot_);
  }

 private:
  static std::string lowerFirst(std::string text) {
    if (!text.empty() && text[0] >= 'A' && text[0] <= 'Z') text[0] = static_cast<char>(text[0] - 'A' + 'a');
    while (!text.empty() && text.back() == '.') text.pop_back();
    return text;
  }
  [[noreturn]] void fail(const TiXmlNode* node, const std::string& expected, const std::string& found) const {
    throw ParseError(file_, node->Row(), expected, found);
  }

  std::string attribute(const TiXmlElement* element, const char* name) const {
    const char* value = element->Attribute(name);
    if (!value || !*value)
      fail(element, std::string("an attribute ") + name + " in <" + element->ValueStr() + ">", "none");
    return value;
  }
  const TiXmlElement* child(const TiXmlElement* element, const char* name) const {
    const TiXmlElement* found = element->FirstChildElement(name);
    if (!found)
      fail(element, std::string("an element <") + name + "> in <" + element->ValueStr() + ">", "none");
    return found;
  }
  double number(const TiXmlElement* element, const char* name) const {
    const std::string word = attribute(element, name);
    const auto words = splitWords(word);
    const auto value = words.size() == 1 ? parseNumber(words[0]) : std::nullopt;
    if (!value) fail(element, std::string("a finite number as ") + name, badNumber(word));
    return *value;
  }
  Vector3d triple(const TiXmlElement* element, const char* name, const Vector3d& absent) const {
    const char* text = element->Attribute(name);
    if (!text) return absent;
    const auto words = splitWords(text);
    Vector3d v;
    for (int k = 0; k < 3; ++k) {
      const auto value = words.size() == 3 ? parseNumber(words[k]) : std::nullopt;
      if (!value)
        fail(element, std::string("three finite numbers as ") + name,
             "'" + std::string(text) + "'" + (words.size() == 3 ? ", " + badNumber(words[k]) : ""));
      v[k] = *value;
    }
    return v;
  }
  Isometry3d origin(const TiXmlElement* element) const {
    Isometry3d frame = Isometry3d::Identity();
    const TiXmlElement* at = element->FirstChildElement("origin");
    if (!at) return frame;
    const Vector3d rpy = triple(at, "rpy", Vector3d::Zero());
    frame.linear() =
        (Eigen::AngleAxisd(rpy.z(), Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Vector3d::UnitY()) *
         Eigen::AngleAxisd(rpy.x(), Vector3d::UnitX()))
            .toRotationMatrix();
    frame.translation() = triple(at, "xyz", Vector3d::Zero());
    return frame;
  }

  void collect(const TiXmlElement* robot) {
    for (const TiXmlElement* e = robot->FirstChildElement("link"); e; e = e->NextSiblingElement("link")) {
      const std::string name = attribute(e, "name");
      const auto [at, isNew] = links_.emplace(
          name, Link{.line = e->Row(), .visuals = {}, .inertial = e->FirstChildElement("inertial")});
      if (!isNew) fail(e, "a link name that is used once", "'" + name + "' again");
      linkOrder_.push_back(name);
      for (const char* kind : {"visual", "collision"})
        for (const TiXmlElement* v = e->FirstChildElement(kind); v; v = v->NextSiblingElement(kind))
          at->second.visuals.push_back(v);
    }
    for (const TiXmlElement* e = robot->FirstChildElement(); e; e = e->NextSiblingElement()) {
      if (!e->ValueStr().starts_with("xacro:")) continue;
      if (links_.empty()) fail(e, "URDF", "<" + e->ValueStr() + ">, which the program xacro turns into URDF");
      tell(robot_.notes, "xacro-left",
           "elements that the program xacro did not replace are passed over: <" + e->ValueStr() + ">, line " +
               std::to_string(e->Row()));
    }
    if (links_.empty()) fail(robot, "at least one <link>", "none");
    std::set<std::string> names;
    for (const TiXmlElement* e = robot->FirstChildElement("joint"); e; e = e->NextSiblingElement("joint")) {
      JointElement joint{.element = e,
                         .name = attribute(e, "name"),
                         .type = attribute(e, "type"),
                         .parent = attribute(child(e, "parent"), "link"),
                         .child = attribute(child(e, "child"), "link")};
      if (!names.insert(joint.name).second)
        fail(e, "a joint name that is used once", "'" + joint.name + "' again");
      if (!links_.count(joint.child)) fail(e, "a link that exists", "'" + joint.child + "'");
      if (links_.emplace(joint.parent, Link{.line = e->Row(), .visuals = {}}).second) {
        linkOrder_.push_back(joint.parent);  // "world", or what a hand is made to be mounted on
        tell(robot_.notes, "link-added",
             "joint '" + joint.name + "' hangs on link '" + joint.parent +
                 "', which the file does not have: added, without a body");
      }
      Link& below = links_[joint.child];
      if (below.parentJoint >= 0) fail(e, "one parent a link", "a second one for '" + joint.child + "'");
      below.parentJoint = static_cast<int>(joints_.size());
      joints_.push_back(std::move(joint));
    }
  }

  void build() {
    std::string root;
    for (const std::string& link : linkOrder_) {
      if (links_[link].parentJoint >= 0) continue;
      if (!root.empty())
        throw ParseError(file_, links_[link].line, "one link without a parent ('" + root + "')",
                         "a second one, '" + link + "'");
      root = link;
    }
    if (root.empty())
      throw ParseError(file_, links_[linkOrder_.front()].line, "a link without a parent", "a cycle of links");
    std::multimap<std::string, int> jointsOfLink;
    for (std::size_t j = 0; j < joints_.size(); ++j)
      jointsOfLink.emplace(joints_[j].parent, static_cast<int>(j));

    std::vector<Joint> list{{.name = root}};
    std::vector<double> rest;
    std::set<std::string> names{root};
    addVisuals(links_[root], 0);
    addMass(links_[root]);
    std::vector<std::pair<std::string, int>> open{{root, 0}};
    for (std::size_t k = 0; k < open.size(); ++k) {
      const auto [link, parent] = open[k];
      const auto [from, to] = jointsOfLink.equal_range(link);
      for (auto at = from; at != to; ++at) {
        JointElement& source = joints_[at->second];
        source.placed = true;
        std::string name = source.name;
        while (!names.insert(name).second) name += "_";
        list.push_back(makeJoint(source, name, parent, rest));
        source.index = static_cast<int>(list.size()) - 1;
        addVisuals(links_[source.child], source.index);
        addMass(links_[source.child]);
        open.emplace_back(source.child, source.index);
      }
    }
    for (const JointElement& joint : joints_)
      if (!joint.placed)
        fail(joint.element, "a joint below the root link '" + root + "'",
             "'" + joint.name + "' on a cycle of links");
    couple(list);
    const Skeleton skeleton(list, Eigen::Map<const Eigen::VectorXd>(rest.data(), rest.size()));
    if (!skeleton.rest().allFinite())
      throw ParseError(file_, 0, "mimics with a finite rest pose", "an overflow");
    const bool coupled = !skeleton.followers().empty();
    robot_.skeleton =
        coupled ? Skeleton(std::move(list), projectToLimits(skeleton, skeleton.rest())) : skeleton;
    if (masses_.total() > 0.0) robot_.masses = std::move(masses_);
  }

  /// Takes the mimics into the joints, each by the joint at the end of its chain, which mimics none.
  void couple(std::vector<Joint>& list) {
    std::map<int, Coupling> written;
    std::map<int, const TiXmlElement*> elements;
    std::vector<int> followers;
    for (const JointElement& source : joints_) {
      const TiXmlElement* element = source.element->FirstChildElement("mimic");
      if (!element) continue;
      const std::string name = attribute(element, "joint");
      const auto known = std::find_if(joints_.begin(), joints_.end(),
                                      [&](const JointElement& joint) { return joint.name == name; });
      if (known == joints_.end()) fail(element, "a joint that exists", "'" + name + "'");
      if (source.type == "fixed" || known->type == "fixed") {
        tell(
            robot_.notes, "mimic-ignored",
            "joint '" + source.name + "' mimics '" + name + "', but a fixed joint has no value: passed over");
        tellIfLocked(list[source.index]);
        continue;
      }
      Coupling coupling{.source = known->index};
      for (const int joint : {source.index, coupling.source})
        if (list[joint].axes.size() != 1)
          fail(element, "a mimic between joints of one degree of freedom",
               "'" + list[joint].name + "' of " +
                   std::to_string(list[joint].axes.size() + (list[joint].ball ? 3 : 0)));
      if (element->Attribute("multiplier")) coupling.multiplier = number(element, "multiplier");
      if (element->Attribute("offset")) coupling.offset = number(element, "offset");
      written[source.index] = coupling;
      elements[source.index] = element;
      followers.push_back(source.index);
    }
    for (const int joint : followers) {
      Coupling coupling = written[joint];
      for (std::size_t steps = 0; written.count(coupling.source); ++steps) {
        if (steps > written.size())
          fail(elements[joint], "mimics that lead to a joint of its own", "a circle of them");
        const Coupling& next = written[coupling.source];
        coupling = {.source = next.source,
                    .multiplier = coupling.multiplier * next.multiplier,
                    .offset = coupling.multiplier * next.offset + coupling.offset};
      }
      if (!std::isfinite(coupling.multiplier) || !std::isfinite(coupling.offset))
        fail(elements[joint], "mimics with finite numbers", "an overflow along their chain");
      list[joint].coupling = coupling;
    }
    std::map<int, AxisDof> ranges;  // of sources, as far as followers were looked at
    for (const int joint : followers)
      fitLimits(list[joint],
                ranges.try_emplace(list[joint].coupling->source, list[list[joint].coupling->source].axes[0])
                    .first->second,
                list[list[joint].coupling->source].name);
    if (!followers.empty()) {
      std::vector<std::string> names;
      for (const int joint : followers)
        names.push_back(list[joint].name + " follows " + list[list[joint].coupling->source].name);
      tellFact(robot_.notes, "mimic", "joints that move with others: " + listed(names));
    }
  }

  /// A follower's limits hold its source too. Where they leave it no way at all (copied from the other
  /// finger, say, which turns against it), they are passed over, as other programs do with all of them.
  void fitLimits(Joint& follower, AxisDof& range, const std::string& source) {
    const Coupling& c = *follower.coupling;
    AxisDof& own = follower.axes[0];
    if (c.multiplier == 0.0) return;
    double lower = (own.lower - c.offset) / c.multiplier, upper = (own.upper - c.offset) / c.multiplier;
    if (lower > upper) std::swap(lower, upper);
    lower = std::max(lower, range.lower), upper = std::min(upper, range.upper);
    if (lower < upper || (lower == upper && range.lower == range.upper)) {
      range.lower = lower, range.upper = upper;
      return;
    }
    tell(robot_.notes, "mimic-limits",
         "joint '" + follower.name + "' mimics '" + source + "', but its own limits, " +
             exactNumber(own.lower) + " to " + exactNumber(own.upper) + ", leave that no way: passed over");
    own.lower = -unlimited, own.upper = unlimited;
  }

  void tellIfLocked(const Joint& joint) {
    if (!joint.axes.empty() && joint.axes[0].lower == 0.0 && joint.axes[0].upper == 0.0)
      tell(robot_.notes, "limits-zero", "joint '" + joint.name + "' has limits 0 to 0: it cannot move");
  }

  /// URDF demands them of revolute and prismatic joints.
  void readLimits(const JointElement& source, AxisDof& dof) {
    const TiXmlElement* limit = source.element->FirstChildElement("limit");
    if (!limit) {
      tell(robot_.notes, "limits-missing",
           "joint '" + source.name + "' is " + source.type +
               " without the <limit> that URDF demands: it moves without limits");
      return;
    }
    dof.lower = limit->Attribute("lower") ? number(limit, "lower") : 0.0;
    dof.upper = limit->Attribute("upper") ? number(limit, "upper") : 0.0;
    if (dof.lower > dof.upper) {
      tell(robot_.notes, "limits-exchanged",
           "joint '" + source.name + "' has a lower limit above its upper one, " + exactNumber(dof.lower) +
               " and " + exactNumber(dof.upper) + ": exchanged");
      std::swap(dof.lower, dof.upper);
    }
  }

  Joint makeJoint(const JointElement& source, const std::string& name, int parent,
                  std::vector<double>& rest) {
    Joint joint{.name = name, .parent = parent};
    joint.parentFromZero = origin(source.element);
    const std::string& type = source.type;
    if (type == "fixed") return joint;
    if (type == "floating") {
      for (int k = 0; k < 3; ++k) joint.axes.push_back({AxisDof::Kind::Translation, Vector3d::Unit(k)});
      joint.ball = true;
      for (const double value : {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0}) rest.push_back(value);
      return joint;
    }
    Vector3d axis = Vector3d::UnitX();
    if (const TiXmlElement* e = source.element->FirstChildElement("axis")) {
      axis = triple(e, "xyz", axis);
      if (!(axis.norm() > 1e-9) || !std::isfinite(axis.norm()))
        fail(e, "an axis of positive length", "zero or an overflow");
      axis.normalize();
    }
    if (type == "planar") {
      const Vector3d u = axis.unitOrthogonal();
      joint.axes = {{AxisDof::Kind::Translation, u},
                    {AxisDof::Kind::Translation, axis.cross(u).normalized()},
                    {AxisDof::Kind::Rotation, axis}};
      rest.insert(rest.end(), {0.0, 0.0, 0.0});
      return joint;
    }
    AxisDof dof{.kind = type == "prismatic" ? AxisDof::Kind::Translation : AxisDof::Kind::Rotation,
                .axis = axis};
    if (type == "revolute" || type == "prismatic") {
      readLimits(source, dof);
    } else if (type != "continuous") {
      fail(source.element, "a joint type revolute, continuous, prismatic, fixed, floating or planar",
           "'" + type + "'");
    }
    rest.push_back(std::clamp(0.0, dof.lower, dof.upper));
    joint.axes.push_back(dof);
    if (!source.element->FirstChildElement("mimic")) tellIfLocked(joint);
    return joint;
  }

  /// Links in the order of their joints.
  void addMass(const Link& link) {
    masses_.mass.push_back(0.0);
    masses_.centre.push_back(Vector3d::Zero());
    if (!link.inertial) return;
    const TiXmlElement* mass = child(link.inertial, "mass");
    masses_.mass.back() = number(mass, "value");
    if (masses_.mass.back() < 0.0) fail(mass, "a mass of 0 or above", exactNumber(masses_.mass.back()));
    masses_.centre.back() = origin(link.inertial).translation();
  }

  /// A material, written here or once for the whole robot; null: none.
  const TiXmlElement* materialOf(const TiXmlElement* visual) const {
    const TiXmlElement* material = visual->FirstChildElement("material");
    const char* name = material ? material->Attribute("name") : nullptr;
    if (name && !material->FirstChildElement("color") && !material->FirstChildElement("texture"))
      for (const TiXmlElement* e = document_.RootElement()->FirstChildElement("material"); e;
           e = e->NextSiblingElement("material"))
        if (e->Attribute("name") && std::string_view(e->Attribute("name")) == name) material = e;
    return material;
  }

  /// What is no colour is passed over: it changes nothing but the picture.
  std::optional<Eigen::Vector4d> colourOf(const TiXmlElement* material) {
    const TiXmlElement* colour = material ? material->FirstChildElement("color") : nullptr;
    if (!colour) return std::nullopt;
    const char* text = colour->Attribute("rgba");
    const auto words = splitWords(text ? text : "");
    Eigen::Vector4d rgba(0.0, 0.0, 0.0, 1.0);
    bool good = words.size() == 3 || words.size() == 4;
    for (std::size_t k = 0; good && k < words.size(); ++k) {
      const auto value = parseNumber(words[k]);
      good = value.has_value();
      if (good) rgba[static_cast<Eigen::Index>(k)] = std::clamp(*value, 0.0, 1.0);
    }
    if (good) return rgba;
    tell(robot_.notes, "material-colour",
         "a material's colour is no three or four numbers from 0 to 1: passed over, line " +
             std::to_string(colour->Row()));
    return std::nullopt;
  }

  void addVisuals(const Link& link, int joint) {
    for (const TiXmlElement* visual : link.visuals) {
      UrdfVisual result{.joint = joint,
                        .jointFromVisual = origin(visual),
                        .collision = visual->ValueStr() == "collision",
                        .line = visual->Row()};
      const TiXmlElement* material = materialOf(visual);
      result.colour = colourOf(material);
      if (const TiXmlElement* texture = material ? material->FirstChildElement("texture") : nullptr)
        if (const char* name = texture->Attribute("filename")) result.texture = name;
      const TiXmlElement* geometry = child(visual, "geometry");
      if (const TiXmlElement* mesh = geometry->FirstChildElement("mesh")) {
        result.fileName = attribute(mesh, "filename");
        result.size = triple(mesh, "scale", Vector3d::Ones());
      } else if (const TiXmlElement* box = geometry->FirstChildElement("box")) {
        result.shape = UrdfVisual::Shape::Box;
        attribute(box, "size");
        result.size = triple(box, "size", Vector3d::Ones());
      } else if (const TiXmlElement* cylinder = geometry->FirstChildElement("cylinder")) {
        result.shape = UrdfVisual::Shape::Cylinder;
        const double radius = number(cylinder, "radius");
        result.size = {radius, radius, number(cylinder, "length")};
      } else if (const TiXmlElement* sphere = geometry->FirstChildElement("sphere")) {
        result.shape = UrdfVisual::Shape::Sphere;
        result.size.setConstant(number(sphere, "radius"));
      } else {
        const TiXmlElement* other = geometry->FirstChildElement();
        tell(robot_.notes, "geometry-unknown",
             (other ? "<" + other->ValueStr() + ">" : "an empty <geometry>") +
                 " is no mesh, box, cylinder or sphere: passed over, line " +
                 std::to_string(geometry->Row()));
        continue;
      }
      if (result.shape != UrdfVisual::Shape::Mesh && !(result.size.minCoeff() > 0.0)) {
        tell(robot_.notes, "geometry-empty",
             "a box, cylinder or sphere whose size is not above 0 is passed over, line " +
                 std::to_string(geometry->Row()));
        continue;
      }
      robot_.visuals.push_back(std::move(result));
    }
  }

  const std::string& file_;
  TiXmlDocument document_;
  std::map<std::string, Link> links_;
  std::vector<std::string> linkOrder_;
  std::vector<JointElement> joints_;
  Masses masses_;
  UrdfRobot robot_;
};

}  // namespace

UrdfRobot parseUrdf(std::string_view text, const std::string& file) {
  return Reader(plainText(text, file), file).read();
}

UrdfRobot readUrdf(const std::string& path) { return parseUrdf(readFile(path), path); }

}  // namespace gelenk
