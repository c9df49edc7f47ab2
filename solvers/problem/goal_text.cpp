#include "solvers/problem/goal_text.h"

#include <set>
#include <stdexcept>

#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

[[noreturn]] void fail(const std::string& what) { throw std::invalid_argument(what); }

std::vector<double> numbers(std::string_view text, std::string_view name) {
  std::vector<double> list;
  while (true) {
    const std::size_t comma = text.find(',');
    const std::optional<double> value = parseNumber(text.substr(0, comma));
    if (!value)
      fail(std::string(name) + " wants finite numbers separated by commas, not '" +
           std::string(text.substr(0, comma)) + "'");
    list.push_back(*value);
    if (comma == std::string_view::npos) return list;
    text.remove_prefix(comma + 1);
  }
}

Vector3d triple(std::string_view text, std::string_view name) {
  const std::vector<double> list = numbers(text, name);
  if (list.size() != 3)
    fail(std::string(name) + " wants X,Y,Z, not " + std::to_string(list.size()) + " numbers");
  return {list[0], list[1], list[2]};
}

struct Reader {
  std::string_view text, name;
  const Skeleton& skeleton;

  void operator()(int& joint) const { joint = skeleton.jointIndex(text); }
  void operator()(double& value) const {
    const std::vector<double> list = numbers(text, name);
    if (list.size() != 1) fail(std::string(name) + " wants one number");
    value = list[0];
  }
  void operator()(Vector3d& value) const { value = triple(text, name); }
  void operator()(Quaterniond& value) const {
    const std::vector<double> list = numbers(text, name);
    if (list.size() != 4) fail(std::string(name) + " wants a unit quaternion QW,QX,QY,QZ");
    value = {list[0], list[1], list[2], list[3]};
    if (!(std::abs(value.norm() - 1.0) < 1e-3))
      fail(std::string(name) + " must have length 1, not " + exactNumber(value.norm()));
    value.normalize();
  }
  void operator()(VectorXd& value) const {
    const std::vector<double> list = numbers(text, name);
    value = VectorXd::Map(list.data(), static_cast<Eigen::Index>(list.size()));
  }
  void operator()(std::vector<Vector3d>& value) const {
    value.clear();
    for (std::string_view rest = text; !rest.empty();) {
      const std::size_t end = rest.find(';');
      value.push_back(triple(rest.substr(0, end), name));
      rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    }
  }
};

struct Writer {
  const Skeleton& skeleton;

  template <typename List>
  static std::string joined(const List& list) {
    std::string text;
    for (const double value : list) text += (text.empty() ? "" : ",") + exactNumber(value);
    return text;
  }
  std::string operator()(int joint) const { return skeleton.joint(joint).name; }
  std::string operator()(double value) const { return exactNumber(value); }
  std::string operator()(const Vector3d& value) const { return joined(value); }
  std::string operator()(const Quaterniond& q) const {
    return joined(std::array{q.w(), q.x(), q.y(), q.z()});
  }
  std::string operator()(const VectorXd& value) const { return joined(value); }
  std::string operator()(const std::vector<Vector3d>& value) const {
    std::string text;
    for (const Vector3d& p : value) text += (text.empty() ? "" : ";") + joined(p);
    return text;
  }
};

constexpr std::pair<Role, const char*> roles[] = {
    {Role::Drag, "drag"}, {Role::Hold, "hold"}, {Role::Pin, "pin"}};

std::string fieldsOf(const GoalType& type) {
  std::string list;
  for (const GoalField& field : type.fields) {
    const std::string name(field.name);
    list += (list.empty() ? "" : " ") + (field.optional ? "[" + name + "]" : name);
  }
  return list;
}

}  // namespace

const char* toString(Role role) {
  for (const auto& [value, word] : roles)
    if (value == role) return word;
  return "?";
}

Role parseRole(std::string_view text) {
  std::string words;
  for (const auto& [value, word] : roles) {
    if (text == word) return value;
    words += (words.empty() ? "" : ", ") + std::string(word);
  }
  fail("a role is one of " + words + ", not '" + std::string(text) + "'");
}

namespace {

/// Fields that GoalType::capture reads off a pose.
bool isCaptured(GoalField::Meaning meaning) {
  switch (meaning) {
    case GoalField::Meaning::Target:
    case GoalField::Meaning::End:
    case GoalField::Meaning::Rotation:
    case GoalField::Meaning::Direction:
    case GoalField::Meaning::Length:
    case GoalField::Meaning::Polygon:
    case GoalField::Meaning::Posture: return true;
    default: return false;
  }
}

Goal parse(std::string_view text, const Skeleton& skeleton, std::shared_ptr<const Masses> masses,
           bool captured) {
  const auto words = splitWords(text);
  if (words.empty()) fail("a goal begins with its kind");
  const GoalType& type = goalType(words[0]);
  const std::string kind(type.name);
  Goal goal{.kind = type.kind, .masses = std::move(masses)};
  std::set<std::string_view> given;
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string_view word = words[i];
    const std::size_t equals = word.find('=');
    if (equals == std::string_view::npos)
      fail("a goal's fields are NAME=VALUE, not '" + std::string(word) + "'");
    const std::string_view name = word.substr(0, equals), value = word.substr(equals + 1);
    if (!given.insert(name).second) fail(std::string(name) + " is given twice");
    const GoalField* field = nullptr;
    for (const GoalField& candidate : type.fields)
      if (candidate.name == name) field = &candidate;
    if (field) {
      std::visit([&](auto member) { Reader{value, name, skeleton}(goal.*member); }, field->member);
    } else if (name == "name") {
      goal.name = value;
    } else if (name == "role") {
      goal.role = parseRole(value);
    } else if (name == "weight") {
      Reader{value, name, skeleton}(goal.weight);
    } else if (name == "priority") {
      double number = 0.0;
      Reader{value, name, skeleton}(number);
      if (number != std::floor(number) || std::abs(number) > 1e6) fail("priority wants a whole number");
      goal.priority = static_cast<int>(number);
    } else {
      fail(kind + " has no field '" + std::string(name) + "'; it has " + fieldsOf(type) +
           ", and name, weight, role, priority");
    }
  }
  for (const GoalField& field : type.fields) {
    if (given.count(field.name)) continue;
    if (!field.optional && !(captured && isCaptured(field.meaning)))
      fail(kind + " needs " + std::string(field.name) + ": " + std::string(field.explain));
    if (field.meaning == GoalField::Meaning::End) goal.end = goal.target;
  }
  const std::string why = captured ? whyMisplaced(goal, skeleton) : whyInvalid(goal, skeleton);
  if (!why.empty()) fail(why);
  normaliseDirections(goal);
  return goal;
}

}  // namespace

Goal goalFromText(std::string_view text, const Skeleton& skeleton, std::shared_ptr<const Masses> masses) {
  return parse(text, skeleton, std::move(masses), false);
}

Goal goalTemplateFromText(std::string_view text, const Skeleton& skeleton,
                          std::shared_ptr<const Masses> masses) {
  return parse(text, skeleton, std::move(masses), true);
}

void normaliseDirections(Goal& goal) {
  for (Vector3d* direction : {&goal.axisInJoint, &goal.direction})
    if (std::abs(direction->squaredNorm() - 1.0) > 1e-14) direction->normalize();
}

bool namesAKind(std::string_view text) {
  const auto words = splitWords(text);
  for (const GoalType* type : goalTypes())
    if (!words.empty() && words[0] == type->name) return true;
  return false;
}

std::string goalToText(const Goal& goal, const Skeleton& skeleton) {
  const GoalType& type = goalType(goal.kind);
  std::string text(type.name);
  for (const GoalField& field : type.fields)
    text += " " + std::string(field.name) + "=" +
            std::visit([&](auto member) { return Writer{skeleton}(goal.*member); }, field.member);
  if (goal.weight != 1.0) text += " weight=" + exactNumber(goal.weight);
  if (goal.role != Role::Drag) text += std::string(" role=") + toString(goal.role);
  if (goal.priority) text += " priority=" + std::to_string(*goal.priority);
  return text;
}

std::string describeGoalTypes() {
  std::string text;
  for (const GoalType* type : goalTypes())
    text +=
        "  " + std::string(type->name) + " " + fieldsOf(*type) + "\n      " + std::string(type->asks) + "\n";
  return text;
}

}  // namespace gelenk
