#include <fmt/format.h>

#include <algorithm>

#include "apps/python/goal_value.h"
#include "solvers/problem/goal_text.h"

// Goals as values: one class for every kind, made from the table of goal types.

namespace gelenk::python {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;
using namespace py::literals;

std::string fieldsOf(const GoalType& type) {
  std::string list;
  for (const GoalField& field : type.fields)
    list += (list.empty() ? "" : ", ") +
            (field.optional ? "[" + std::string(field.name) + "]" : std::string(field.name));
  return list;
}

/// Puts a value into a goal's field.
struct FieldReader {
  GoalValue& out;
  const GoalField& field;
  py::handle value;
  std::string name = std::string(field.name);

  void operator()(int Goal::*member) const {
    const bool first = member == &Goal::joint;
    (first ? out.hasJoint : out.hasOther) = true;
    if (py::isinstance<py::str>(value)) {
      const std::string joint = value.cast<std::string>();
      if (joint.empty()) throw std::invalid_argument(name + ": a joint's name is not empty");
      (first ? out.joint : out.other) = joint;
      return;
    }
    if (!PyIndex_Check(value.ptr()) || PyBool_Check(value.ptr()))
      throw std::invalid_argument(name + ": expected a joint's name or index");
    const py::ssize_t index = PyNumber_AsSsize_t(value.ptr(), nullptr);
    out.goal.*member = static_cast<int>(std::clamp<py::ssize_t>(index, -1, 1 << 30));
  }
  void operator()(double Goal::*member) const {
    out.goal.*member = vectorOf(py::make_tuple(value), 1, name.c_str())[0];
  }
  void operator()(Vector3d Goal::*member) const {
    const bool unit =
        field.meaning == GoalField::Meaning::AxisInJoint || field.meaning == GoalField::Meaning::Direction;
    out.goal.*member = unit ? direction(value, name.c_str()) : point(value, name.c_str());
  }
  void operator()(Quaterniond Goal::*member) const { out.goal.*member = rotation(value, name.c_str()); }
  void operator()(VectorXd Goal::*member) const { out.goal.*member = vectorOf(value, -1, name.c_str()); }
  void operator()(std::vector<Vector3d> Goal::*member) const {
    out.goal.*member = points(value, name.c_str());
  }
};

GoalValue makeGoal(const std::string& kind, const py::kwargs& fields) {
  const GoalType& type = goalType(kind);
  GoalValue out;
  out.goal.kind = type.kind;
  std::vector<std::string_view> given;
  for (const auto& [key, value] : fields) {
    const std::string name = py::str(key);
    const auto field = std::find_if(type.fields.begin(), type.fields.end(),
                                    [&](const GoalField& f) { return f.name == name; });
    if (field != type.fields.end()) {
      if (value.is_none()) continue;
      given.push_back(field->name);
      const FieldReader reader{out, *field, value};
      std::visit(reader, field->member);
    } else if (name == "name") {
      out.goal.name = py::str(value);
    } else if (name == "role") {
      out.goal.role = parseRole(std::string(py::str(value)));
    } else if (name == "weight") {
      out.goal.weight = vectorOf(py::make_tuple(value), 1, "weight")[0];
      if (!(out.goal.weight > 0.0)) throw std::invalid_argument("weight must be above 0");
    } else if (name == "priority") {
      if (!value.is_none()) {
        if (!PyIndex_Check(value.ptr())) throw std::invalid_argument("priority wants a whole number");
        out.goal.priority = value.cast<int>();
      }
    } else {
      throw std::invalid_argument(
          fmt::format("{} has no field '{}'; it has {}, and name, weight, role, priority", type.name, name,
                      fieldsOf(type)));
    }
  }
  for (const GoalField& field : type.fields) {
    if (std::find(given.begin(), given.end(), field.name) != given.end()) continue;
    if (!field.optional)
      throw std::invalid_argument(fmt::format("{} needs {}: {}", type.name, field.name, field.explain));
    if (field.meaning == GoalField::Meaning::End) out.goal.end = out.goal.target;
  }
  normaliseDirections(out.goal);
  return out;
}

py::list goalTypesTable() {
  py::list table;
  for (const GoalType* type : goalTypes()) {
    py::list fields;
    for (const GoalField& field : type->fields)
      fields.append(py::make_tuple(field.name, field.explain, field.optional));
    table.append(py::dict("kind"_a = type->name, "title"_a = type->title, "asks"_a = type->asks,
                          "fields"_a = fields, "needs_masses"_a = type->needsMasses));
  }
  return table;
}

std::string describeGoal(const GoalValue& value) {
  const GoalType& type = goalType(value.goal.kind);
  std::string text = fmt::format("<gelenk.Goal {}", type.name);
  if (!value.joint.empty()) text += " joint=" + value.joint;
  if (!value.other.empty()) text += " other=" + value.other;
  return text + ">";
}

bool isSequence(py::handle value) {
  return py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value);
}

/// A list of goals rather than of numbers.
bool holdsGoals(py::handle value) {
  if (!isSequence(value)) return false;
  for (const py::handle& one : value)
    if (py::isinstance<GoalValue>(one) || py::isinstance<py::str>(one) || py::isinstance<py::dict>(one))
      return true;
  return false;
}

}  // namespace

Goal GoalValue::on(const Skeleton& skeleton, const std::shared_ptr<const Masses>& masses) const {
  Goal out = goal;
  if (!joint.empty()) out.joint = skeleton.jointIndex(joint);
  if (!other.empty()) out.otherJoint = skeleton.jointIndex(other);
  if (goalType(out.kind).needsMasses) out.masses = masses;
  if (const std::string why = whyInvalid(out, skeleton); !why.empty()) throw std::invalid_argument(why);
  return out;
}

Goal targetGoalOf(int joint, py::handle value) {
  const Array array = numbers(value, "target");
  Goal goal{.joint = joint};
  if (array.ndim() == 1 && array.shape(0) == 3) {
    goal.target = point(array, "target");
  } else if ((array.ndim() == 1 && array.shape(0) == 4) ||
             (array.ndim() == 2 && array.shape(0) == 3 && array.shape(1) == 3)) {
    goal.kind = GoalKind::Orientation;
    goal.orientation = rotation(array, "target");
  } else if (array.ndim() == 1 && array.shape(0) == 7) {
    goal.kind = GoalKind::Pose;
    const VectorXd v = vectorOf(array, 7, "target");
    goal.target = v.head<3>();
    goal.orientation = rotation(py::array_t<double>(4, v.data() + 3), "target");
  } else if (array.ndim() == 2 && array.shape(0) == 4 && array.shape(1) == 4) {
    goal.kind = GoalKind::Pose;
    const Eigen::Isometry3d T = pose(array, "target");
    goal.target = T.translation();
    goal.orientation = Quaterniond(T.linear()).normalized();
  } else {
    throw std::invalid_argument(
        "target: expected 3 numbers (a position), 4 or 3 x 3 (an orientation), 7 or 4 x 4 (a pose); many at "
        "once: "
        "solve_batch");
  }
  return goal;
}

std::vector<Goal> goalsFrom(const SharedModel& model, py::handle value, py::handle joint,
                            const std::shared_ptr<const Masses>& masses) {
  const Skeleton& skeleton = model.skeleton();
  if (py::isinstance<GoalValue>(value)) return {value.cast<const GoalValue&>().on(skeleton, masses)};
  if (py::isinstance<py::str>(value)) return {goalFromText(value.cast<std::string>(), skeleton, masses)};
  std::vector<Goal> goals;
  if (py::isinstance<py::dict>(value)) {
    for (const auto& [key, target] : py::reinterpret_borrow<py::dict>(value))
      goals.push_back(targetGoalOf(jointOf(skeleton, key), target));
  } else if (holdsGoals(value)) {
    for (const py::handle& one : value)
      for (Goal& goal : goalsFrom(model, one, joint, masses)) goals.push_back(std::move(goal));
  } else if (!isSequence(value) || py::len(value) > 0) {
    goals.push_back(targetGoalOf(effector(model, joint), value));
  }
  return goals;
}

void addGoals(py::module_& m) {
  py::class_<GoalValue>(
      m, "Goal",
      "What a model shall do: a kind and its fields (goal_types(), docs/goals.md), and for every\n"
      "kind weight (on the squared residual), role ('drag', 'hold', 'pin'), priority, name.\n"
      "Joints by name or index; metres, radians, world frame; rotations as w, x, y, z or 3 x 3.")
      .def(py::init(&makeGoal), "kind"_a)
      .def_property_readonly(
          "kind", [](const GoalValue& g) { return goalType(g.goal.kind).name; }, "As goal_types() names it.")
      .def_property_readonly(
          "weight", [](const GoalValue& g) { return g.goal.weight; }, "On the squared residual.")
      .def_property_readonly(
          "role", [](const GoalValue& g) { return toString(g.goal.role); }, "drag, hold or pin.")
      .def(
          "text",
          [](const GoalValue& g, const SharedModel& model) {
            return goalToText(g.on(model.skeleton(), model.model().masses), model.skeleton());
          },
          modelArgument(), "As `gelenk solve --goal` takes it; numbers exact.")
      .def("__repr__", &describeGoal);
  m.def(
      "goal_types", &goalTypesTable,
      "Every kind of goal: dicts of kind, title, asks, fields (name, explanation, optional), needs_masses.");
}

}  // namespace gelenk::python
